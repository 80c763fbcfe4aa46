// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>

namespace shape::test {

/// Folder of the real datasets: the environment's SHAPE_DATA_DIR, by default ../shared/data beside
/// the source. It may be missing: a test that needs it skips then.
[[nodiscard]] std::filesystem::path data_dir();

} // namespace shape::test
