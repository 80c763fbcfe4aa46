// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <string_view>

#include "libshape/base/format.h"

namespace shape::internal {

/// A count and what is counted, for messages: counted(1, "mesh", "meshes") == "1 mesh",
/// counted(0, "mesh", "meshes") == "0 meshes".
template <class Count>
[[nodiscard]] std::string counted(Count count, std::string_view one, std::string_view several)
{
    return join(count, " ", count == Count{1} ? one : several);
}

/// The same for nouns whose plural has an s: counted(2, "face") == "2 faces".
template <class Count>
[[nodiscard]] std::string counted(Count count, std::string_view one)
{
    return counted(count, one, join(one, "s"));
}

} // namespace shape::internal
