// SPDX-License-Identifier: MIT

#pragma once

#include <CLI/CLI.hpp>

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

} // namespace shape::tools
