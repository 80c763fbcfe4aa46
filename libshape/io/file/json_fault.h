// SPDX-License-Identifier: MIT

#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace shape::internal {

/// What nlohmann::json::exception::what() says, for people: "line 1, column 2: is not JSON (syntax
/// error ...)" of a text that cannot be parsed, else the sentence without the number of the exception.
[[nodiscard]] inline std::string json_fault(std::string_view what)
{
    if (what.starts_with("[json.exception."))
        what.remove_prefix(std::min(what.find("] ") + 2, what.size()));
    constexpr std::string_view parse_error = "parse error at ";
    const std::size_t colon = what.find(": ");
    if (!what.starts_with(parse_error) || colon == std::string_view::npos)
        return std::string(what);
    return std::string(what.substr(parse_error.size(), colon - parse_error.size())) +
           ": is not JSON (" + std::string(what.substr(colon + 2)) + ")";
}

} // namespace shape::internal
