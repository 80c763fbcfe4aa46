// SPDX-License-Identifier: MIT

#pragma once

// The version of the headers (semantic versioning), stated here alone: CMake reads these lines.
#define SHAPE_VERSION_MAJOR 0
#define SHAPE_VERSION_MINOR 1
#define SHAPE_VERSION_PATCH 0

/// The same as one number that can be compared, as in `#if SHAPE_VERSION >= 10203` for 1.2.3.
#define SHAPE_VERSION \
    (10000 * SHAPE_VERSION_MAJOR + 100 * SHAPE_VERSION_MINOR + SHAPE_VERSION_PATCH)

namespace shape {

/// The version of the library that is linked, "major.minor.patch".
[[nodiscard]] const char* version();

} // namespace shape
