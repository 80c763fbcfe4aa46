// SPDX-License-Identifier: MIT
//
// replay DIRECTORY: runs every file DIRECTORY/TARGET/* through its target. A finding ends the process.
// replay --random TARGET RUNS SEED [FILE]: runs random inputs instead, without Clang: random bytes, for targets of which
// every input means something, such as collection_content; or a file with some bytes changed. The last input lies in
// ./last_input until the next one is tried.
// replay --random-alone ...: the same, each input in a process of its own, as a user's file is: HDF5 leaves its memory
// in disorder after some damaged files, and a million in one process would try nothing else.

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>
#include <string>

#include "tests/fuzz/targets.h"

namespace {

/// Up to eight changes of a file (stored_file.h), often small numbers, which are places and sizes.
std::string random_input(std::mt19937_64& random)
{
    std::string bytes(1 + 12 * (1 + random() % 8), '\0');
    for (char& byte : bytes)
        byte = static_cast<char>(random() % 2 == 0 ? random() % 8 : random() % 256);
    return bytes;
}

/// Up to eight changes of a byte, or of a few side by side.
std::string changed(std::string bytes, std::mt19937_64& random)
{
    for (std::size_t k = 1 + random() % 8; k-- > 0 && !bytes.empty();) {
        const std::size_t begin = random() % bytes.size();
        const std::size_t size = std::size_t{1} << random() % 4;
        for (std::size_t i = begin; i < std::min(begin + size, bytes.size()); ++i)
            bytes[i] = static_cast<char>(random() % 2 == 0 ? random() % 8 : random() % 256);
    }
    return bytes;
}

/// Overwritten in place: a file that is emptied and closed is written to the disc at once by some file systems, which takes
/// ten times as long as a run.
class LastInput
{
public:
    LastInput() : file_(std::fopen(name, "wb"))
    {
        if (file_ == nullptr)
            throw std::runtime_error("cannot write ./last_input");
    }
    ~LastInput() { std::fclose(file_); }
    LastInput(const LastInput&) = delete;
    LastInput& operator=(const LastInput&) = delete;

    void set(const std::string& bytes)
    {
        std::rewind(file_);
        std::fwrite(bytes.data(), 1, bytes.size(), file_);
        std::fflush(file_);
        std::filesystem::resize_file(name, bytes.size());
    }

    static constexpr const char* name = "last_input";

private:
    std::FILE* file_;
};

std::string read_file(const std::filesystem::path& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// How the process ended; empty if as it should.
std::string run_alone(const shape::fuzz::Target& target, const std::string& input)
{
    const pid_t child = fork();
    if (child < 0)
        throw std::runtime_error("cannot fork");
    if (child == 0) {
        int code = 0;
        try {
            target.run(input);
        } catch (...) {
            code = 1;
        }
        _exit(code);
    }
    int status = 0;
    if (waitpid(child, &status, 0) == child && status == 0)
        return {};
    return WIFSIGNALED(status) ? "signal " + std::to_string(WTERMSIG(status))
                               : "exit code " + std::to_string(WEXITSTATUS(status));
}

/// @param file  Empty: there is none.
int run_random(const shape::fuzz::Target& target, long runs, unsigned long seed,
               const std::string& file, bool alone)
{
    std::mt19937_64 random(seed);
    LastInput last;
    for (long i = 0; i < runs; ++i) {
        const std::string input = file.empty() ? random_input(random) : changed(file, random);
        last.set(input);
        if (!alone)
            target.run(input);
        else if (const std::string end = run_alone(target, input); !end.empty()) {
            std::fprintf(stderr, "input %ld: %s; it lies in ./%s\n", i + 1, end.c_str(),
                         LastInput::name);
            return 1;
        }
    }
    std::filesystem::remove(LastInput::name);
    std::printf("%ld random inputs of %s\n", runs, target.name.c_str());
    return 0;
}

} // namespace

int main(int argc, char** argv)
try {
    const std::string task = argc > 1 ? argv[1] : "";
    if ((argc == 5 || argc == 6) && (task == "--random" || task == "--random-alone"))
        return run_random(shape::fuzz::find_target(argv[2]), std::atol(argv[3]),
                          std::strtoul(argv[4], nullptr, 10),
                          argc == 6 ? read_file(argv[5]) : std::string(), task == "--random-alone");
    std::size_t count = 0;
    for (int i = 1; i < argc; ++i)
        for (const auto& directory : std::filesystem::directory_iterator(argv[i])) {
            const shape::fuzz::Target& target =
                shape::fuzz::find_target(directory.path().filename().string());
            for (const auto& entry : std::filesystem::directory_iterator(directory)) {
                std::printf("%s\n", entry.path().c_str());
                std::fflush(stdout); // the last line tells what crashed
                target.run(read_file(entry.path()));
                ++count;
            }
        }
    std::printf("%zu inputs replayed\n", count);
    return count > 0 ? 0 : 1;
} catch (const std::exception& error) {
    std::fprintf(stderr, "replay: %s\n", error.what());
    return 1;
}
