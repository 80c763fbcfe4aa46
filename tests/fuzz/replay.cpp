// SPDX-License-Identifier: MIT
//
// replay DIRECTORY: runs every file DIRECTORY/TARGET/* through its target. A finding ends the process.
// replay --random TARGET RUNS SEED: runs random bytes instead, without Clang: for targets of which every input means
// something, such as collection_content. The last input lies in ./last_input until the next one is tried.

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
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

int run_random(const shape::fuzz::Target& target, long runs, unsigned long seed)
{
    std::mt19937_64 random(seed);
    for (long i = 0; i < runs; ++i) {
        const std::string input = random_input(random);
        std::ofstream("last_input", std::ios::binary) << input;
        target.run(input);
    }
    std::filesystem::remove("last_input");
    std::printf("%ld random inputs of %s\n", runs, target.name.c_str());
    return 0;
}

} // namespace

int main(int argc, char** argv)
try {
    if (argc == 5 && std::string(argv[1]) == "--random")
        return run_random(shape::fuzz::find_target(argv[2]), std::atol(argv[3]),
                          std::strtoul(argv[4], nullptr, 10));
    std::size_t count = 0;
    for (int i = 1; i < argc; ++i)
        for (const auto& directory : std::filesystem::directory_iterator(argv[i])) {
            const shape::fuzz::Target& target =
                shape::fuzz::find_target(directory.path().filename().string());
            for (const auto& entry : std::filesystem::directory_iterator(directory)) {
                std::printf("%s\n", entry.path().c_str());
                std::fflush(stdout); // the last line tells what crashed
                std::ifstream in(entry.path(), std::ios::binary);
                target.run(std::string(std::istreambuf_iterator<char>(in), {}));
                ++count;
            }
        }
    std::printf("%zu inputs replayed\n", count);
    return count > 0 ? 0 : 1;
} catch (const std::exception& error) {
    std::fprintf(stderr, "replay: %s\n", error.what());
    return 1;
}
