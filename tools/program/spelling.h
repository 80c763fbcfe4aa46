// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

namespace shape::tools {

/// "; did you mean '--output'?": the known word that takes the fewest letters put in, taken out, changed
/// or swapped, at most a third of the word (at least two); empty if none is that near.
[[nodiscard]] std::string did_you_mean(const std::string& word,
                                       const std::vector<std::string>& known);

} // namespace shape::tools
