// SPDX-License-Identifier: MIT

#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace shape::fuzz {

/// Something that reads bytes of strangers. Every documented error is caught; anything else, a
/// result that is not finite for one, is a finding.
struct Target
{
    std::string name;
    std::function<void(std::string_view bytes)> run;
};

[[nodiscard]] const std::vector<Target>& targets();

/// @throws std::invalid_argument listing the names if this is not one of them.
[[nodiscard]] const Target& find_target(std::string_view name);

} // namespace shape::fuzz
