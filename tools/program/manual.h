// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>

namespace CLI {
class App;
}

namespace shape::tools {

/// The page shape(1), or shape-COMMAND(1), in the language of man (man(7)): what --help says. No date, so
/// that the same program makes the same pages.
/// @param command  nullptr: of the program.
[[nodiscard]] std::string man_page(const CLI::App& program, const CLI::App* command);

/// Writes the pages of the program and its commands, and the completions of the shells, as they lie
/// below /usr/share: man/man1, bash-completion/completions, zsh/site-functions, fish/vendor_completions.d.
/// Directories are made, files replaced.
/// @throws FileError if one cannot be.
void write_manual(const CLI::App& program, const std::filesystem::path& directory);

} // namespace shape::tools
