// SPDX-License-Identifier: MIT

#pragma once

namespace shape {

/// The version of the library, "major.minor.patch" (semantic versioning); stated once, in the
/// project() line of CMakeLists.txt.
[[nodiscard]] const char* version();

} // namespace shape
