// SPDX-License-Identifier: MIT

#pragma once

#include <string>

namespace CLI {
class App;
}

namespace shape::tools {

// Scripts by which shells complete commands, options and, where an option takes one of several words,
// these; anything else is the name of a file. Made from what --help prints.

[[nodiscard]] std::string bash_completion(const CLI::App& program);
[[nodiscard]] std::string zsh_completion(const CLI::App& program);
[[nodiscard]] std::string fish_completion(const CLI::App& program);

} // namespace shape::tools
