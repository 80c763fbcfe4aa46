// SPDX-License-Identifier: MIT

#include "tools/program/help.h"

#include <algorithm>

namespace shape::tools {

std::string HelpFormatter::make_help(const CLI::App* app, std::string name,
                                     CLI::AppFormatMode mode) const
{
    std::string help = make_description(app) + "\n" + make_usage(app, name) + make_positionals(app);
    for (const CLI::App* part : app->get_subcommands({})) {
        const auto is_own_option = [part](const CLI::Option* option) {
            return option->nonpositional() && option != part->get_help_ptr();
        };
        if (part->get_name().empty()) // options that exclude each other, see CLI::Option_group
            help += make_group(part->get_group() + " (" + part->get_description() + ")", false,
                               part->get_options(is_own_option));
    }
    help += make_groups(app, mode);
    if (app->get_parent() == nullptr)
        help += make_subcommands(app, mode);
    return help + "\n" + make_footer(app);
}

std::string HelpFormatter::make_option_name(const CLI::Option* option, bool is_positional) const
{
    const std::string name = CLI::Formatter::make_option_name(option, is_positional);
    return name.substr(0, name.find('{'));
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const
{
    std::string summary = command->get_description();
    summary.resize(std::min(summary.size(), summary.find_first_of(".:(")));
    std::replace(summary.begin(), summary.end(), '\n', ' ');
    CLI::detail::rtrim(summary);
    std::ostringstream out;
    CLI::detail::format_help(out, command->get_name(), summary, 16);
    return out.str();
}

} // namespace shape::tools
