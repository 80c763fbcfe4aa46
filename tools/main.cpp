// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/version.h"
#include "libshape/io/hdf5/untrusted_files.h"
#include "tools/commands.h"
#include "tools/program/arguments.h"
#include "tools/program/help.h"
#include "tools/program/interrupt.h"
#include "tools/program/library_start.h"
#include "tools/program/memory.h"
#include "tools/program/ranks.h"
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
    {"fit", set_up_fit, ".h5"},
    {"collect", set_up_collect, ".h5"},
    {"check", set_up_check, ""},
    {"info", set_up_info, ""},
    {"stats", set_up_stats, ".h5", true},
    {"project", set_up_project, ".csv", true},
    {"distance", set_up_distance, ".csv", true},
    {"quality", set_up_quality, ".csv"},
    {"generate", set_up_generate, ".ply"},
    {"groups", set_up_groups, ".csv"},
    {"classify", set_up_classify, ".csv"},
    {"regress", set_up_regress, ".csv"},
    {"remove", set_up_remove, ".h5"},
    {"difference", set_up_difference, ".h5"},
    {"interpolate", set_up_interpolate, ".ply"},
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
    "mesh files in natural name order) and collection files (.h5). Lengths have the unit of the "
    "input. `-` is standard\n"
    "input, and after -o standard output.\n"
    "Exit codes: 0 done, 1 internal error, 2 usage, 3 bad input, 4 numerical failure,\n"
    "5 input/output, 6 over a limit, 130 interrupted.\n"
    "`shape COMMAND --help` explains a command and gives an example.";

void add_common_options(CLI::App& command, Session& session)
{
    const std::string group = "Options of every command";
    command.add_flag("--quiet", session.quiet, "Nothing on stderr but errors")->group(group);
    command.add_flag("--json", session.json, "Print one JSON object with the figures of the run")
        ->group(group);
    command.add_flag("--force", session.force, "Overwrite existing outputs")->group(group);
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
            std::error_code ignored; // most values are no paths
            const std::filesystem::file_status status = std::filesystem::status(value, ignored);
            if (std::filesystem::exists(status) && std::filesystem::is_other(status))
                throw FileError(join(value, ": is not a regular file"));
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
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames())
            names.push_back("--" + name);
    const auto is_group = [](const CLI::App* part) { return part->get_name().empty(); };
    for (const CLI::App* group : app.get_subcommands(is_group)) // of which one is to be given
        for (std::string& name : option_names(*group))
            names.push_back(std::move(name));
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

/// Whether an argument is no long option, or one of the command.
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
    return error.what();
}

int run(std::vector<std::string> arguments, std::optional<StandardStreams>& streams)
{
    Session session;
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
        read_first_words(program, arguments);
        const auto command = std::ranges::find_if(
            commands, [&](const Command& entry) { return entry.name == arguments.front(); });
        streams.emplace(std::move(arguments), command == std::end(commands) ? "" : command->ending);
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
        session.readable = [&streams](const std::string& text) { return streams->readable(text); };
        if (session.threads > 0)
            set_thread_count(static_cast<int>(session.threads));
        const CLI::App* chosen = program.get_subcommands().front();
        session.command = chosen->get_name();
        if (ranks().count > 1 && !command->is_shared)
            throw UsageError(join("`shape ", session.command,
                                  "` runs in one process; mpirun is for "
                                  "stats, project and distance"));
        if (!ranks().speaks()) {
            session.quiet = true;
            session.json = false;
        }
        refuse_pipes(*chosen);
        runs.at(chosen)(session);
        if (const std::string output = streams->output(); !output.empty() && ranks().speaks())
            session.print(output);
        return Done;
    } catch (const CLI::CallForVersion& version) {
        session.print(std::string(version.what()) + "\n");
        return Done;
    } catch (const CLI::CallForHelp&) {
        const std::vector<CLI::App*> chosen = program.get_subcommands();
        session.print(chosen.empty() ? program.help() : chosen.front()->help("shape"));
        return Done;
    }
}

/// Runs the program and turns what it throws into one line on stderr and an exit code.
int guarded_run(std::vector<std::string> arguments)
{
    std::optional<StandardStreams> streams;
    const auto report_error = [&](const std::string& text) {
        let_first_rank_speak();
        tools::report_error(streams ? streams->readable(text) : text);
    };
    try {
        join_ranks();
        return run(std::move(arguments), streams);
    } catch (const UsageError& error) {
        return report_error(error.what()), UsageFailure;
    } catch (const CLI::ParseError& error) {
        return report_error(error.what()), UsageFailure;
    } catch (const InvalidInput& error) {
        return report_error(error.what()), BadInput;
    } catch (const NumericalError& error) {
        return report_error(error.what()), NumericalFailure;
    } catch (const FileError& error) {
        return report_error(error.what()), InputOutputFailure;
    } catch (const std::filesystem::filesystem_error& error) {
        return report_error(error.what()), InputOutputFailure;
    } catch (const LimitExceeded& error) {
        return report_error(error.what()), OverLimit;
    } catch (const std::bad_alloc&) {
        return report_error("out of memory"), OverLimit;
    } catch (const Interrupted& error) {
        return report_error(error.what()), Stopped;
    } catch (const std::exception& error) {
        return report_error(std::string("internal error: ") + error.what()), InternalError;
    }
}

} // namespace
} // namespace shape::tools

int main(int argc, char** argv)
{
    shape::tools::use_all_processors();
    shape::rehearse_hdf5_files(true);
    shape::tools::return_large_arrays();
    shape::tools::catch_signals();
    return shape::tools::leave_ranks(
        shape::tools::guarded_run({argv + std::min(argc, 1), argv + argc}));
}
