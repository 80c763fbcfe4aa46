// SPDX-License-Identifier: MIT

#include "tools/output/plot_output.h"

#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/file/output_file.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;
namespace {

constexpr const char* converter = "rsvg-convert";

/// A file without a name, for what a process reads and writes.
using TemporaryFile = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

TemporaryFile temporary_file()
{
    TemporaryFile file(std::tmpfile(), std::fclose);
    if (file == nullptr)
        throw FileError(join("no temporary file can be made: ", std::strerror(errno)));
    return file;
}

std::string read_all(std::FILE* file)
{
    std::rewind(file);
    std::string content;
    std::array<char, 1 << 16> block;
    while (const std::size_t got = std::fread(block.data(), 1, block.size(), file))
        content.append(block.data(), got);
    return content;
}

/// Runs the converter on a drawing; its messages are not of interest.
std::string png_of(const std::filesystem::path& path, const std::string& svg)
{
    const TemporaryFile in = temporary_file();
    const TemporaryFile out = temporary_file();
    const TemporaryFile messages = temporary_file();
    if (std::fwrite(svg.data(), 1, svg.size(), in.get()) != svg.size() ||
        std::fflush(in.get()) != 0)
        throw FileError(join(path.string(), ": ", std::strerror(errno)));
    std::rewind(in.get());
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, fileno(in.get()), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, fileno(out.get()), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, fileno(messages.get()), STDERR_FILENO);
    std::array<std::string, 3> words{converter, "--zoom=2", "--format=png"};
    std::array<char*, 4> arguments{words[0].data(), words[1].data(), words[2].data(), nullptr};
    pid_t process = 0;
    const int error = posix_spawnp(&process, converter, &files, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    if (error != 0)
        throw FileError(join(path.string(), ": ", converter,
                             ", which draws PNG, cannot be started: ", std::strerror(error),
                             "; install it (Debian: librsvg2-bin) or name a .svg file"));
    int status = 0;
    while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
    }
    std::string png = read_all(out.get());
    if (status == 0 && png.starts_with("\x89PNG"))
        return png;
    rlimit space{};
    if (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY)
        throw LimitExceeded(
            join(path.string(), ": ", converter, ", which draws PNG, failed where ",
                 space.rlim_cur >> 20,
                 " MiB of address space are allowed; allow more, or name a .svg file"));
    const std::string said = read_all(messages.get());
    throw FileError(
        join(path.string(), ": ", converter, " failed: ", said.substr(0, said.find('\n'))));
}

} // namespace

void check_picture(const std::string& option, const std::filesystem::path& path)
{
    if (!has_ending(path, ".svg") && !has_ending(path, ".png"))
        throw UsageError(join(option, " is '", path.string(), "', must end in .svg or .png"));
}

void write_picture(const std::filesystem::path& path, const std::string& svg)
{
    write_file_atomically(path, has_ending(path, ".png") ? png_of(path, svg) : svg);
}

void add_point_plot(CLI::App& command, PointPlotArguments& arguments, CLI::Option* plot)
{
    command
        .add_flag("--label", arguments.names,
                  "Write the names of the meshes beside their points, as far as there is room")
        ->needs(plot);
    add_choice(command, "--outline", arguments.outline,
               "What is drawn around the points of each group: hull, their convex hull; ellipse,\n"
               "where 95 % of a normal distribution with their mean and covariance lie; none\n"
               "(default)",
               {{"none", GroupOutline::None},
                {"hull", GroupOutline::Hull},
                {"ellipse", GroupOutline::Ellipse}})
        ->needs(plot);
}

std::vector<std::string> colouring_values(const PointPlotArguments& arguments, const Labels& labels)
{
    if (!arguments.color_by.empty())
        return find_label(labels, arguments.color_by).values;
    if (arguments.outline != GroupOutline::None)
        throw UsageError("--outline needs --color-by, which says what the groups are");
    return {};
}

ScorePlotOptions score_plot_options(const PointPlotArguments& arguments)
{
    return {
        .names = arguments.names, .outline = arguments.outline, .label_name = arguments.color_by};
}

} // namespace shape::tools
