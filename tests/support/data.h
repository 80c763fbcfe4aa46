// SPDX-License-Identifier: MIT

#pragma once

#include <cstdlib>
#include <filesystem>

namespace shape::test {

/// Folder of the real datasets: the environment's SHAPE_DATA_DIR, by default ../shared/data beside
/// the source. It may be missing: a test that needs it skips then.
[[nodiscard]] inline std::filesystem::path data_dir()
{
    const char* chosen = std::getenv("SHAPE_DATA_DIR");
    return chosen ? chosen : SHAPE_DEFAULT_DATA_DIR;
}

} // namespace shape::test
