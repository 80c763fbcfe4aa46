// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>

#include "libshape/base/format.h"

namespace shape::tools {

/// The path and the cause, as of a FileError; the call that failed says nothing to a user.
inline std::string explained(const std::filesystem::filesystem_error& error)
{
    const std::string from = error.path1().string();
    const std::string to = error.path2().string();
    return internal::join(from, from.empty() || to.empty() ? "" : " -> ", to,
                          from.empty() && to.empty() ? "" : ": ", error.code().message());
}

} // namespace shape::tools
