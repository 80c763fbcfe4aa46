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
    std::ostringstream out;
    CLI::detail::format_help(out, command->get_name(), summary_of(*command), 16);
    return out.str();
}

std::string summary_of(const CLI::App& command)
{
    std::string summary = command.get_description();
    summary.resize(std::min(summary.size(), summary.find_first_of(".:(")));
    std::replace(summary.begin(), summary.end(), '\n', ' ');
    CLI::detail::rtrim(summary);
    return summary;
}

std::vector<OptionSection> option_sections(const CLI::App& command)
{
    std::vector<OptionSection> sections;
    const auto add = [&](const std::string& title, const CLI::App& app, const auto& belongs) {
        const std::vector<const CLI::Option*> options = app.get_options(
            [&](const CLI::Option* option) { return option->nonpositional() && belongs(*option); });
        if (!options.empty())
            sections.push_back({title, options});
    };
    for (const CLI::App* part : command.get_subcommands({}))
        if (part->get_name().empty())
            add(part->get_group() + " (" + part->get_description() + ")", *part,
                [part](const CLI::Option& option) { return &option != part->get_help_ptr(); });
    for (const std::string& group : command.get_groups())
        if (!group.empty())
            add(group, command,
                [&](const CLI::Option& option) { return option.get_group() == group; });
    return sections;
}

std::vector<const CLI::Option*> positionals_of(const CLI::App& command)
{
    return command.get_options([](const CLI::Option* option) { return option->get_positional(); });
}

std::string value_name(const CLI::Option& option)
{
    if (!option.get_option_text().empty() || !takes_value(option))
        return option.get_option_text();
    return option.get_type_name();
}

std::vector<std::string> choices_of(const CLI::Option& option)
{
    const std::string& text = option.get_option_text();
    const auto is_of_words = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '|';
    };
    if (text.find('|') == std::string::npos || !std::all_of(text.begin(), text.end(), is_of_words))
        return {};
    return CLI::detail::split(text, '|');
}

bool takes_value(const CLI::Option& option)
{
    return option.get_items_expected_min() > 0;
}

} // namespace shape::tools
