// SPDX-License-Identifier: MIT

#include "tools/program/manual.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <set>
#include <sstream>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/base/version.h"
#include "libshape/io/file/output_file.h"
#include "tools/program/completion.h"
#include "tools/program/help.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

/// Text that man prints as it is: its own signs are escaped, a line cannot be taken for a request, and
/// hyphens stay the hyphens that people type.
std::string escaped(const std::string& text)
{
    std::string result;
    for (const char c : text) {
        if ((c == '.' || c == '\'') && (result.empty() || result.back() == '\n'))
            result += "\\&";
        result += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
    }
    return result;
}

/// Words of several lines in one, for man fills lines itself.
std::string flowing(std::string text)
{
    std::replace(text.begin(), text.end(), '\n', ' ');
    return escaped(text);
}

std::string section(const std::string& title)
{
    return ".SH \"" + escaped(upper_case(title)) + "\"\n";
}

/// A term and what it is.
std::string entry(const std::string& term, const std::string& text)
{
    return ".TP\n" + term + "\n" + flowing(text) + "\n";
}

std::string bold(const std::string& text)
{
    return "\\fB" + escaped(text) + "\\fR";
}

std::string term_of(const CLI::Option& option)
{
    const std::string name =
        option.get_positional() ? option.get_name(true) : option.get_name(false, true);
    const std::string bare = name.substr(0, name.find('{'));
    std::string value = value_name(option); // without REQUIRED, which the conditions say
    if (const std::size_t at = value.find("REQUIRED"); at != std::string::npos)
        value.resize(at > 0 ? at - 1 : 0);
    return bold(bare) + (value.empty() ? "" : " \\fI" + escaped(value) + "\\fR");
}

/// " (required)", " (needs --mesh)" and the like; names in order, for CLI11 keeps them by address.
std::string conditions_of(const CLI::Option& option)
{
    std::vector<std::string> conditions;
    if (option.get_required())
        conditions.emplace_back("required");
    const auto add = [&](const char* word, const std::set<CLI::Option*>& others) {
        std::set<std::string> names;
        for (const CLI::Option* other : others)
            names.insert(escaped(other->get_name()));
        for (const std::string& name : names)
            conditions.push_back(word + name);
    };
    add("needs ", option.get_needs());
    add("excludes ", option.get_excludes());
    return conditions.empty() ? "" : " (" + CLI::detail::join(conditions, ", ") + ")";
}

/// "Example:" and lines with two blanks before them.
std::string examples(const std::string& footer)
{
    const std::size_t first = footer.find('\n');
    if (first == std::string::npos)
        return "";
    return section(footer.substr(0, footer.find(':'))) + ".nf\n" +
           escaped(footer.substr(first + 1)) + "\n.fi\n";
}

/// The sentence of the program's last words on exit codes, as a list.
std::string exit_status(const CLI::App& program)
{
    const std::string footer = program.get_footer();
    const std::string start = "Exit codes: ";
    const std::size_t begin = footer.find(start);
    if (begin == std::string::npos)
        return "";
    std::string sentence = footer.substr(begin + start.size());
    sentence.resize(std::min(sentence.size(), sentence.find('.')));
    std::replace(sentence.begin(), sentence.end(), '\n', ' ');
    std::string list;
    for (const std::string& code : CLI::detail::split(sentence, ',')) {
        const std::string trimmed = CLI::detail::trim_copy(code);
        const std::size_t blank = trimmed.find(' ');
        list += entry(bold(trimmed.substr(0, blank)), trimmed.substr(blank + 1));
    }
    return section("exit status") + list;
}

std::string page_name(const CLI::App& command)
{
    return "shape-" + command.get_name();
}

} // namespace

std::string man_page(const CLI::App& program, const CLI::App* command)
{
    const CLI::App& app = command != nullptr ? *command : program;
    const std::string name = command != nullptr ? page_name(app) : "shape";
    std::ostringstream page;
    page << ".TH \"" << escaped(upper_case(name)) << "\" 1 \"\" \"shape " << version()
         << "\" \"libshape\"\n";
    page << ".SH NAME\n" << escaped(name) << " \\- " << flowing(summary_of(app)) << "\n";
    page << ".SH SYNOPSIS\n"
         << bold(command != nullptr ? "shape " + app.get_name() : "shape")
         << (command != nullptr ? " [\\fIOPTIONS\\fR]" : " \\fICOMMAND\\fR [\\fIOPTIONS\\fR] ...");
    for (const CLI::Option* positional : positionals_of(app))
        page << " \\fI" << escaped(positional->get_name(true))
             << (positional->get_items_expected_max() > 1 ? "...\\fR" : "\\fR");
    page << "\n.SH DESCRIPTION\n" << flowing(app.get_description()) << "\n";
    const std::vector<const CLI::Option*> positionals = positionals_of(app);
    if (!positionals.empty())
        page << ".SH ARGUMENTS\n";
    for (const CLI::Option* positional : positionals)
        page << entry(term_of(*positional) + conditions_of(*positional),
                      positional->get_description());
    for (const OptionSection& part : option_sections(app)) {
        page << section(part.title);
        for (const CLI::Option* option : part.options)
            page << entry(term_of(*option) + conditions_of(*option), option->get_description());
    }
    if (command != nullptr) {
        page << exit_status(program) << examples(app.get_footer());
        page << ".SH SEE ALSO\n.BR shape (1)\n";
        return page.str();
    }
    page << ".SH COMMANDS\n";
    for (const CLI::App* each : program.get_subcommands({}))
        page << entry("\\fB" + escaped(page_name(*each)) + "\\fR(1)", summary_of(*each));
    page << exit_status(program) << ".SH NOTES\n" << flowing(program.get_footer()) << "\n";
    return page.str();
}

void write_manual(const CLI::App& program, const fs::path& directory)
{
    const auto write = [&](const fs::path& name, const std::string& text) {
        const fs::path path = directory / name;
        std::error_code error;
        fs::create_directories(path.parent_path(), error);
        if (error)
            throw FileError(join(path.parent_path().string(), ": ", error.message()));
        write_file_atomically(path, text);
    };
    const fs::path pages = "man/man1";
    write(pages / "shape.1", man_page(program, nullptr));
    for (const CLI::App* command : program.get_subcommands({}))
        write(pages / (page_name(*command) + ".1"), man_page(program, command));
    write("bash-completion/completions/shape", bash_completion(program));
    write("zsh/site-functions/_shape", zsh_completion(program));
    write("fish/vendor_completions.d/shape.fish", fish_completion(program));
}

} // namespace shape::tools
