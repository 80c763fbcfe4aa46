// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace shape::internal {

/// Paths where a run has found nothing, so that it has not been allowed to replace anything there. While this object is
/// there, write_file_atomically() and move_into_place() leave what has got there meanwhile, by another run say, as it
/// is and throw. A path that has been written is the run's own: it may be written again.
class FreePlaces
{
public:
    FreePlaces() = default;
    ~FreePlaces();
    FreePlaces(const FreePlaces&) = delete;
    FreePlaces& operator=(const FreePlaces&) = delete;

    void add(const std::filesystem::path& path);

    /// Whether one of the objects of the process has the path.
    [[nodiscard]] static bool contain(const std::filesystem::path& path);
    /// It has been written.
    static void remove(const std::filesystem::path& path);

private:
    std::vector<std::string> paths_;
};

} // namespace shape::internal
