// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <map>
#include <new>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/version.h"
#include "tools/commands.h"
#include "tools/program/arguments.h"
#include "tools/program/help.h"
#include "tools/program/interrupt.h"
#include "tools/program/memory.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Command
{
    const char* name;
    Run (*set_up)(CLI::App&);
};

/// In the order of the work: put together, look, model, compare, make, draw.
constexpr Command commands[] = {
    {"collect", set_up_collect},
    {"check", set_up_check},
    {"info", set_up_info},
    {"stats", set_up_stats},
    {"project", set_up_project},
    {"distance", set_up_distance},
    {"quality", set_up_quality},
    {"generate", set_up_generate},
    {"groups", set_up_groups},
    {"classify", set_up_classify},
    {"regress", set_up_regress},
    {"remove", set_up_remove},
    {"difference", set_up_difference},
    {"interpolate", set_up_interpolate},
    {"reconstruct", set_up_reconstruct},
    {"conformal", set_up_conformal},
    {"draw", set_up_draw},
    {"report", set_up_report},
    {"synth", set_up_synth},
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
    "MESHES is any mix of mesh files (.obj .ply .off), directories (their mesh files in natural\n"
    "name order) and collection files (.h5). Lengths have the unit of the input.\n"
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

int run(int argc, char** argv)
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
        if (argc < 2)
            throw UsageError("name a command; `shape --help` lists them");
        const std::string first = argv[1];
        const auto is_first = [&](const Command& entry) { return entry.name == first; };
        if (!first.starts_with('-') && std::ranges::none_of(commands, is_first))
            throw UsageError(join("no command '", first, "'; `shape --help` lists them"));
        program.parse(argc, argv);
        if (session.threads > 0)
            set_thread_count(static_cast<int>(session.threads));
        const CLI::App* chosen = program.get_subcommands().front();
        session.command = chosen->get_name();
        runs.at(chosen)(session);
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
int guarded_run(int argc, char** argv)
{
    try {
        return run(argc, argv);
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
    shape::tools::return_large_arrays();
    shape::tools::catch_signals();
    return shape::tools::guarded_run(argc, argv);
}
