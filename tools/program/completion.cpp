// SPDX-License-Identifier: MIT

#include "tools/program/completion.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>

#include "tools/program/help.h"

namespace shape::tools {
namespace {

std::vector<const CLI::Option*> options_of(const CLI::App& app)
{
    std::vector<const CLI::Option*> options;
    for (const OptionSection& section : option_sections(app))
        options.insert(options.end(), section.options.begin(), section.options.end());
    return options;
}

/// All spellings: "-o", "--output".
std::vector<std::string> spellings(const CLI::Option& option)
{
    std::vector<std::string> names;
    for (const std::string& name : option.get_snames())
        names.push_back("-" + name);
    for (const std::string& name : option.get_lnames())
        names.push_back("--" + name);
    return names;
}

std::string words(const std::vector<std::string>& list)
{
    return CLI::detail::join(list, " ");
}

/// `text` with a backslash before each of these characters.
std::string shielded(const std::string& text, const std::string& characters)
{
    std::string result;
    for (const char c : text) {
        if (characters.find(c) != std::string::npos)
            result += '\\';
        result += c;
    }
    return result;
}

/// Within single quotes of bash and zsh, where a quote can be had outside of them alone.
std::string quoted(const std::string& text)
{
    std::string result = "'";
    for (const char c : text)
        result += c == '\'' ? "'\\''" : std::string(1, c);
    return result + "'";
}

/// The description up to its first mark, in one line.
std::string short_text(const CLI::Option& option)
{
    std::string text = option.get_description();
    text.resize(std::min({text.size(), text.find(". "), text.find(".\n"), text.find(" (default")}));
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

/// `shape help` completes a command too; it is not one of CLI11's.
constexpr const char* help_summary = "Explain a command";

} // namespace

std::string bash_completion(const CLI::App& program)
{
    std::ostringstream options;
    std::ostringstream values;
    std::vector<std::string> names;
    const auto add = [&](const std::string& command, const CLI::App& app) {
        std::vector<std::string> all;
        for (const CLI::Option* option : options_of(app))
            for (const std::string& name : spellings(*option)) {
                all.push_back(name);
                if (takes_value(*option)) // "": a file
                    values << "        ['" << command << ' ' << name
                           << "']=" << quoted(words(choices_of(*option))) << '\n';
            }
        options << "        [" << command << "]=" << quoted(words(all)) << '\n';
    };
    for (const CLI::App* command : program.get_subcommands({})) {
        names.push_back(command->get_name());
        add(command->get_name(), *command);
    }
    names.emplace_back("help");
    add("shape", program);
    std::ostringstream script;
    script << "# Completion of `shape` in bash; made by `shape help --write`.\n"
              "_shape()\n{\n"
              "    local -A options=(\n"
           << options.str()
           << "    )\n"
              "    local -A values=(\n"
           << values.str()
           << "    )\n"
              "    local commands="
           << quoted(words(names))
           << "\n"
              "    local current=$2 previous=$3 command=${COMP_WORDS[1]} words=\n"
              "    if [[ $current == = ]]; then\n"
              "        current=\n"
              "    elif [[ $previous == = ]]; then\n"
              "        previous=${COMP_WORDS[COMP_CWORD - 2]}\n"
              "    fi\n"
              "    if [[ $COMP_CWORD -eq 1 ]]; then\n"
              "        words=\"$commands ${options[shape]}\"\n"
              "    elif [[ $command == help ]]; then\n"
              "        words=$commands\n"
              "    elif [[ -v \"values[$command $previous]\" ]]; then\n"
              "        words=${values[\"$command $previous\"]}\n"
              "    elif [[ $current == -* && -n $command ]]; then\n"
              "        words=${options[$command]}\n"
              "    fi\n"
              "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
              "}\n"
              "complete -o default -F _shape shape\n";
    return script.str();
}

std::string zsh_completion(const CLI::App& program)
{
    std::ostringstream commands;
    std::ostringstream cases;
    const auto specification = [](const CLI::Option& option, const std::string& name) {
        std::string text = name + "[" + shielded(short_text(option), "[]\\:") + "]";
        if (takes_value(option)) {
            const std::vector<std::string> choices = choices_of(option);
            text += ":" + shielded(value_name(option), "[]\\:") + ":";
            text += choices.empty() ? "_files" : "(" + words(choices) + ")";
        }
        return (option.get_items_expected_max() > 1 ? "*" : "") + text;
    };
    for (const CLI::App* command : program.get_subcommands({})) {
        commands << "        "
                 << quoted(command->get_name() + ":" + shielded(summary_of(*command), "\\:"))
                 << '\n';
        cases << "            " << command->get_name() << ")\n                _arguments -S";
        for (const CLI::Option* option : options_of(*command))
            for (const std::string& name : spellings(*option))
                cases << " \\\n                    " << quoted(specification(*option, name));
        cases << " \\\n                    '*:file:_files'\n                ;;\n";
    }
    std::ostringstream script;
    script << "#compdef shape\n"
              "# Completion of `shape` in zsh; made by `shape help --write`.\n"
              "_shape()\n{\n"
              "    local curcontext=$curcontext state line\n"
              "    local -a commands\n"
              "    commands=(\n"
           << commands.str() << "        " << quoted(std::string("help:") + help_summary)
           << "\n    )\n"
              "    _arguments -C";
    for (const CLI::Option* option : options_of(program))
        for (const std::string& name : spellings(*option))
            script << " \\\n        " << quoted(specification(*option, name));
    script << " \\\n"
              "        '1:command:->command' '*::argument:->argument'\n"
              "    case $state in\n"
              "    command)\n"
              "        _describe command commands\n"
              "        ;;\n"
              "    argument)\n"
              "        case $words[1] in\n"
           << cases.str()
           << "            help)\n                _describe command commands\n                ;;\n"
              "        esac\n"
              "        ;;\n"
              "    esac\n"
              "}\n"
              "_shape \"$@\"\n";
    return script.str();
}

std::string fish_completion(const CLI::App& program)
{
    const auto text = [](const std::string& plain) { return "'" + shielded(plain, "\\'") + "'"; };
    const std::string no_command = "-n '__fish_use_subcommand'";
    std::ostringstream script;
    script << "# Completion of `shape` in fish; made by `shape help --write`.\n";
    const auto add_options = [&](const CLI::App& app, const std::string& condition) {
        for (const CLI::Option* option : options_of(app)) {
            script << "complete -c shape " << condition;
            for (const std::string& name : option->get_snames())
                script << " -s " << name;
            for (const std::string& name : option->get_lnames())
                script << " -l " << name;
            const std::vector<std::string> choices = choices_of(*option);
            if (!choices.empty())
                script << " -x -a " << text(words(choices));
            else if (takes_value(*option))
                script << " -r -F";
            script << " -d " << text(short_text(*option)) << '\n';
        }
    };
    std::vector<std::string> names;
    add_options(program, no_command);
    for (const CLI::App* command : program.get_subcommands({})) {
        names.push_back(command->get_name());
        script << "complete -c shape " << no_command << " -f -a " << command->get_name() << " -d "
               << text(summary_of(*command)) << '\n';
    }
    script << "complete -c shape " << no_command << " -f -a help -d " << text(help_summary) << '\n'
           << "complete -c shape -n '__fish_seen_subcommand_from help' -f -a " << text(words(names))
           << '\n';
    for (const CLI::App* command : program.get_subcommands({}))
        add_options(*command, "-n '__fish_seen_subcommand_from " + command->get_name() + "'");
    return script.str();
}

} // namespace shape::tools
