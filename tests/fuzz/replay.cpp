// SPDX-License-Identifier: MIT
//
// replay DIRECTORY: runs every file DIRECTORY/TARGET/* through its target. A finding ends the process.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/fuzz/targets.h"

int main(int argc, char** argv)
try {
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
