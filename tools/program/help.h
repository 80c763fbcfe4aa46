// SPDX-License-Identifier: MIT

#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace shape::tools {

/// Prints --help: one line a command for the program; for a command its text, the options that
/// exclude each other, the others, and the example.
class HelpFormatter : public CLI::Formatter
{
public:
    std::string make_help(const CLI::App* app, std::string name,
                          CLI::AppFormatMode mode) const override;
    std::string make_subcommand(const CLI::App* command) const override;

    /// Without what a flag stands for alone.
    std::string make_option_name(const CLI::Option* option, bool is_positional) const override;
};

/// What a command does, in a line: its description up to the first mark that ends a thought.
[[nodiscard]] std::string summary_of(const CLI::App& command);

/// Options that stand together in --help.
struct OptionSection
{
    std::string title;
    std::vector<const CLI::Option*> options; ///< No positionals.
};

/// In the order of --help: the options that exclude each other first.
[[nodiscard]] std::vector<OptionSection> option_sections(const CLI::App& command);

/// In the order of --help.
[[nodiscard]] std::vector<const CLI::Option*> positionals_of(const CLI::App& command);

/// What an option takes, as --help names it: "FILE", "edge|procrustes"; empty for a flag.
[[nodiscard]] std::string value_name(const CLI::Option& option);

/// The values of an option that takes one of several words.
[[nodiscard]] std::vector<std::string> choices_of(const CLI::Option& option);

/// Whether an argument that follows the option belongs to it.
[[nodiscard]] bool takes_value(const CLI::Option& option);

} // namespace shape::tools
