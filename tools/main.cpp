// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/version.h"
#include "libshape/io/hdf5/untrusted_files.h"
#include "libshape/io/model_file.h"
#include "libshape/mesh/coincident_vertices.h"
#include "tools/commands.h"
#include "tools/program/arguments.h"
#include "tools/program/explained.h"
#include "tools/program/help.h"
#include "tools/program/interrupt.h"
#include "tools/program/library_start.h"
#include "tools/program/manual.h"
#include "tools/program/memory.h"
#include "tools/program/ranks.h"
#include "tools/program/report.h"
#include "tools/program/session.h"
#include "tools/program/spelling.h"
#include "tools/program/standard_streams.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Command
{
    const char* name;
    Run (*set_up)(CLI::App&);
    const char* ending;     ///< What `-o -` prints ends in this.
    bool is_shared = false; ///< Processes that mpirun starts share its work.
};

/// In the order of the work: put together, look, model, compare, make, draw.
constexpr Command commands[] = {
    {"fit", set_up_fit, ".h5", true},
    {"collect", set_up_collect, ".h5"},
    {"check", set_up_check, ""},
    {"info", set_up_info, ""},
    {"stats", set_up_stats, ".h5", true},
    {"project", set_up_project, ".csv", true},
    {"distance", set_up_distance, ".csv", true},
    {"quality", set_up_quality, ".csv", true},
    {"generate", set_up_generate, ".ply", true},
    {"groups", set_up_groups, ".csv"},
    {"classify", set_up_classify, ".csv"},
    {"regress", set_up_regress, ".csv"},
    {"remove", set_up_remove, ".h5"},
    {"difference", set_up_difference, ".h5"},
    {"interpolate", set_up_interpolate, ".ply", true},
    {"reconstruct", set_up_reconstruct, ".ply"},
    {"conformal", set_up_conformal, ".ply"},
    {"merge", set_up_merge, ""},
    {"draw", set_up_draw, ".svg"},
    {"explore", set_up_explore, ".html"},
    {"report", set_up_explore, ".html"},
    {"export", set_up_export, ".h5"},
    {"synth", set_up_synth, ".ply"},
};

enum ExitCode
{
    Done = 0,
    InternalError = 1,
    UsageFailure = 2,
    BadInput = 3,
    NumericalFailure = 4,
    InputOutputFailure = 5,
    OverLimit = 6,
    Stopped = 130, // 128 + SIGINT, as shells report it
};

constexpr const char* program_footer =
    "MESHES is any mix of mesh files (.obj .ply .off .stl .vtk .vtp .glb), directories (their\n"
    "mesh files in natural name order) and collection files (.h5). Lengths have the\n"
    "unit of the input. `-` is standard input, and after -o standard output.\n"
    "Exit codes: 0 done, 1 internal error, 2 usage, 3 bad input, 4 numerical failure,\n"
    "5 input/output, 6 over a limit, 130 interrupted.\n"
    "`shape COMMAND --help` explains a command and gives an example; `shape help --write DIR` "
    "writes\n"
    "manual pages, and completions of bash, zsh and fish, into DIR/man, DIR/bash-completion, ...";

void add_common_options(CLI::App& command, Session& session)
{
    const std::string group = "Options of every command";
    command.add_flag("--quiet", session.quiet, "Nothing on stderr but errors")->group(group);
    command.add_flag("--json", session.json, "Print one JSON object with the figures of the run")
        ->group(group);
    command
        .add_flag("--force", session.force, "Overwrite existing outputs; write-protected ones stay")
        ->group(group);
    add_integer(command, "--threads", session.threads,
                "Number of threads [1, 1024] (default: all processors); changes no result", 1, 1024)
        ->group(group);
    add_integer(command, "--seed", session.seed, "Seed of random numbers, >= 0 (default: 1)", 0)
        ->group(group);
}

/// Pipes and devices are read by nobody; to say so at once saves the work done before it shows.
void refuse_pipes(const CLI::App& command)
{
    for (const CLI::Option* option : command.get_options())
        for (const std::string& value : option->results()) {
            std::error_code ignored; // most values are not paths
            const std::filesystem::file_status status = std::filesystem::status(value, ignored);
            if (std::filesystem::exists(status) && std::filesystem::is_other(status))
                throw FileError(join(value, ": is not a regular file"));
        }
}

/// A variable of the shell that is not set leaves an empty argument; nothing is found under that name.
void refuse_empty(const CLI::App& command)
{
    for (const CLI::Option* option : command.get_options())
        for (const std::string& value : option->results())
            if (option->get_positional() && value.empty()) {
                const std::string name = option->get_single_name();
                throw UsageError(join(name, name == "NAME" ? ": the name" : ": a path",
                                      " is empty (''); is a variable of the shell not set?"));
            }
}

std::vector<std::string> command_names()
{
    std::vector<std::string> names{"help"};
    for (const Command& entry : commands)
        names.emplace_back(entry.name);
    return names;
}

std::vector<std::string> option_names(const CLI::App& app)
{
    std::vector<std::string> names;
    for (const OptionSection& section : option_sections(app))
        for (const CLI::Option* option : section.options)
            for (const std::string& name : option->get_lnames())
                names.push_back("--" + name);
    return names;
}

/// What stands before the command: `-V`, `help COMMAND`, and words that are neither option nor
/// command.
void read_first_words(const CLI::App& program, std::vector<std::string>& arguments)
{
    if (arguments.empty())
        throw UsageError("name a command; `shape --help` lists them");
    std::string& first = arguments.front();
    const std::vector<std::string> names = command_names();
    if (first == "help") {
        if (arguments.size() == 1) {
            first = "--help";
            return;
        }
        arguments = {arguments[1], "--help"};
        return read_first_words(program, arguments);
    }
    if (first == "-V")
        first = "--version";
    const std::vector<std::string> options = option_names(program);
    const bool is_option = first.starts_with('-');
    if (is_option && (first == "-h" || std::ranges::find(options, first) != options.end()))
        return;
    if (is_option)
        throw UsageError(join("no option '", first, "'", did_you_mean(first, options),
                              "; `shape --help` lists the commands"));
    if (std::ranges::find(names, first) == names.end())
        throw UsageError(join("no command '", first, "'", did_you_mean(first, names),
                              "; `shape --help` lists them"));
}

/// Whether an argument is not a long option, or is one of the command.
bool is_known(const CLI::App& command, const std::string& argument)
{
    const std::vector<std::string> options = option_names(command);
    return !argument.starts_with("--") || argument == "--" ||
           std::ranges::find(options, argument.substr(0, argument.find('='))) != options.end();
}

/// What is wrong with arguments that do not go together: first of all an option that does not exist,
/// for then the one that was meant is missing.
std::string explain(const CLI::ParseError& error, const CLI::App& command,
                    const std::vector<std::string>& arguments)
{
    for (const std::string& argument : arguments)
        if (!is_known(command, argument)) {
            const std::string option = argument.substr(0, argument.find('='));
            const std::string hint = did_you_mean(option, option_names(command));
            return join("no option '", option, "'",
                        hint.empty()
                            ? join("; `shape ", command.get_name(), " --help` explains its options")
                            : hint);
        }
    constexpr std::string_view twice = ": At Most 1 required but received ";
    std::string text = error.what();
    if (const std::size_t at = text.find(twice); at != text.npos)
        return join(text.substr(0, at), " is given ", text.substr(at + twice.size()),
                    " times; give it once");
    return text;
}

/// `shape help --write DIR`; other words after help are commands.
std::optional<std::filesystem::path> place_of_manual(const std::vector<std::string>& arguments)
{
    if (arguments.size() < 2 || arguments[0] != "help" || arguments[1] != "--write")
        return std::nullopt;
    if (arguments.size() != 3 || arguments[2].empty())
        throw UsageError("`shape help --write` takes the directory to write to");
    return arguments[2];
}

void run(std::vector<std::string> arguments, std::optional<StandardStreams>& streams,
         Session& session)
{
    CLI::App program("Statistical shape analysis of triangle meshes in edge-length space.",
                     "shape");
    program.set_version_flag("--version", join("shape ", version()));
    program.footer(program_footer);
    program.formatter(std::make_shared<HelpFormatter>()); // subcommands inherit it
    program.require_subcommand(1);
    std::map<const CLI::App*, Run> runs;
    for (const Command& entry : commands) {
        CLI::App* command = program.add_subcommand(entry.name);
        runs[command] = entry.set_up(*command);
        add_common_options(*command, session);
    }
    try {
        if (const auto directory = place_of_manual(arguments))
            return write_manual(program, *directory);
        read_first_words(program, arguments);
        const auto command = std::ranges::find_if(
            commands, [&](const Command& entry) { return entry.name == arguments.front(); });
        if (command != std::end(commands))
            session.command = command->name;
        streams.emplace(std::move(arguments), command == std::end(commands) ? "" : command->ending);
        session.readable = [&streams](const std::string& text) { return streams->readable(text); };
        std::vector<std::string> reversed(streams->arguments().rbegin(),
                                          streams->arguments().rend());
        try {
            program.parse(reversed);
        } catch (const CLI::Success&) {
            throw; // help and version
        } catch (const CLI::ParseError& error) {
            if (command == std::end(commands))
                throw;
            throw UsageError(
                explain(error, *program.get_subcommand(command->name), streams->arguments()));
        }
        if (session.threads > 0)
            set_thread_count(static_cast<int>(session.threads));
        const CLI::App* chosen = program.get_subcommands().front();
        if (ranks().count > 1 && !command->is_shared)
            throw UsageError(join("`shape ", session.command,
                                  "` runs in one process; mpirun is for stats, project, distance, "
                                  "generate, interpolate and fit"));
        if (!ranks().is_root()) {
            session.quiet = true;
            session.json = false;
        }
        refuse_empty(*chosen);
        refuse_pipes(*chosen);
        runs.at(chosen)(session);
        if (const std::string output = streams->output(); !output.empty() && ranks().is_root())
            session.print(output);
    } catch (const CLI::CallForVersion& version) {
        session.json = false;
        session.print(std::string(version.what()) + "\n");
    } catch (const CLI::CallForHelp&) {
        session.json = false;
        const std::vector<CLI::App*> chosen = program.get_subcommands();
        session.print(chosen.empty() ? program.help() : chosen.front()->help("shape"));
    }
}

struct Failure
{
    ExitCode code;
    std::string message;
};

/// The commands that make the files that are wanted: the library knows none.
std::string makers_of(std::optional<FileKind> wanted)
{
    if (!wanted)
        return " (`shape collect` makes a collection, `shape stats` a model)";
    switch (*wanted) {
        case FileKind::Collection:
            return " (`shape collect` makes a collection)";
        case FileKind::Model:
            return " (`shape stats` makes a model)";
        case FileKind::Difference:
            return " (`shape difference` makes a difference)";
    }
    return {};
}

/// What the work throws as one of the exit codes.
template <class Work>
std::optional<Failure> failure_of(const Work& work)
{
    try {
        work();
        return std::nullopt;
    } catch (const UsageError& error) {
        return Failure{UsageFailure, error.what()};
    } catch (const CLI::ParseError& error) {
        return Failure{UsageFailure, error.what()};
    } catch (const SplitSurface& error) {
        return Failure{BadInput, join(error.what(), " `shape check --fix DIR` welds them")};
    } catch (const WrongFileKind& error) {
        return Failure{BadInput, join(error.what(), makers_of(error.wanted))};
    } catch (const InvalidInput& error) {
        return Failure{BadInput, error.what()};
    } catch (const NumericalError& error) {
        return Failure{NumericalFailure, error.what()};
    } catch (const FileError& error) {
        return Failure{InputOutputFailure, error.what()};
    } catch (const std::filesystem::filesystem_error& error) {
        return Failure{InputOutputFailure, explained(error)};
    } catch (const LimitExceeded& error) {
        return Failure{OverLimit, error.what()};
    } catch (const std::bad_alloc&) {
        return Failure{OverLimit, "out of memory"};
    } catch (const Interrupted& error) {
        return Failure{Stopped, error.what()};
    } catch (const std::exception& error) {
        return Failure{InternalError, std::string("internal error: ") + error.what()};
    }
}

/// The word of --json for an exit code.
const char* kind_of(ExitCode code)
{
    switch (code) {
        case UsageFailure:
            return "usage";
        case BadInput:
            return "input";
        case NumericalFailure:
            return "numerical";
        case InputOutputFailure:
            return "file";
        case OverLimit:
            return "limit";
        case Stopped:
            return "interrupted";
        default:
            return "internal";
    }
}

/// Runs the program and turns what it throws into one line on stderr, the `error` of --json and an exit
/// code.
int guarded_run(std::vector<std::string> arguments)
{
    std::optional<StandardStreams> streams;
    Session session;
    // Arguments that cannot be read are reported in the form that they ask for.
    const auto files = std::ranges::find(arguments, "--");
    session.json = std::find(arguments.begin(), files, "--json") != files;
    std::optional<Failure> failure = failure_of([&] {
        join_ranks();
        run(std::move(arguments), streams, session);
    });
    if (failure && is_to_speak(failure->code == Stopped))
        report_error(session.readable(failure->message));
    const std::optional<Failure> unprinted = failure_of([&] {
        print_report(session, failure ? Json{{"kind", kind_of(failure->code)},
                                             {"exit_code", static_cast<int>(failure->code)},
                                             {"message", failure->message}}
                                      : Json());
    });
    if (unprinted && !failure) {
        report_error(unprinted->message);
        failure = unprinted;
    }
    return failure ? failure->code : Done;
}

} // namespace
} // namespace shape::tools

int main(int argc, char** argv)
{
    shape::tools::use_all_processors();
    shape::isolate_hdf5_files(true);
    shape::tools::return_large_arrays();
    shape::tools::catch_signals();
    return shape::tools::leave_ranks(
        shape::tools::guarded_run({argv + std::min(argc, 1), argv + argc}));
}
