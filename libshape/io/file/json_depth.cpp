// SPDX-License-Identifier: MIT

#include "libshape/io/file/json_depth.h"

#include <cstddef>

namespace shape::internal {

bool is_shallow_json(std::string_view text)
{
    int depth = 0;
    bool is_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '"')
            is_string = !is_string;
        else if (is_string)
            i += c == '\\' ? 1 : 0;
        else if (c == '[' || c == '{') {
            if (++depth > deepest_json)
                return false;
        } else if (c == ']' || c == '}')
            --depth;
    }
    return true;
}

} // namespace shape::internal
