// SPDX-License-Identifier: MIT

#include "tools/program/standard_streams.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>

#include "libshape/base/clean_up.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/output_file.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

/// Options that name an output, and what they write; -o depends on the command.
constexpr std::array<std::pair<std::string_view, std::string_view>, 10> outputs = {
    {{"-o", ""},
     {"--output", ""},
     {"--plot", ".svg"},
     {"--heat-map", ".svg"},
     {"--predictions", ".csv"},
     {"--mds", ".csv"},
     {"--cluster", ".csv"},
     {"--mesh", ".ply"},
     {"--effects", ".ply"},
     {"--tree", ".svg"}}};

/// Options that name a folder.
constexpr std::array<std::string_view, 4> folders = {"--fix", "--means", "--expected",
                                                     "--corrected"};

/// Whether the content is that of a binary STL file, whose head may say anything: its length tells, or, where that is
/// not right, a byte that no text has; UTF-16 is text all the same.
bool is_binary_stl(std::string_view content)
{
    constexpr std::size_t head = 84; // [byte]
    if (content.size() < head)
        return false;
    std::uint32_t count = 0;
    std::memcpy(&count, content.data() + head - sizeof count, sizeof count);
    if (content.size() == head + 50 * std::size_t{count})
        return true;
    const bool is_utf16 = content.starts_with("\xFF\xFE") || content.starts_with("\xFE\xFF") ||
                          (content[0] == '\0') != (content[1] == '\0');
    return !is_utf16 && content.substr(0, head).find('\0') != content.npos;
}

/// Which ending the content of a file asks for; tables are read whatever their name.
std::string ending_of(std::string_view content)
{
    if (content.starts_with("\xEF\xBB\xBF"))
        content.remove_prefix(3);
    const std::string_view line =
        content.substr(0, std::min<std::size_t>(content.find('\n'), 4096));
    if (content.starts_with("\x89HDF"))
        return ".h5";
    if (content.starts_with("ply"))
        return ".ply";
    if (content.starts_with("glTF"))
        return ".glb";
    if (content.starts_with("solid") || is_binary_stl(content))
        return ".stl";
    if (content.starts_with("# vtk"))
        return ".vtk";
    if (content.starts_with("<"))
        return ".vtp";
    if (line.substr(0, line.find_first_of(" \t\r0123456789")).ends_with("OFF"))
        return ".off";
    if (content.starts_with("{") || content.starts_with("["))
        return ".json";
    return line.find(',') != std::string_view::npos && !line.starts_with('#') ? ".csv" : ".obj";
}

std::string read_standard_input()
{
    constexpr std::size_t limit = std::size_t{2} << 30;
    std::string content;
    std::array<char, 1 << 16> block;
    for (;;) {
        throw_if_stop_requested();
        const ssize_t got = ::read(STDIN_FILENO, block.data(), block.size());
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            throw FileError(join("standard input: ", std::strerror(errno)));
        if (got == 0)
            return content;
        content.append(block.data(), to_size(got));
        if (content.size() > limit)
            throw LimitExceeded(join("standard input: more than ", limit, " bytes"));
    }
}

} // namespace

StandardStreams::StandardStreams(std::vector<std::string> arguments,
                                 const std::string& command_ending)
    : arguments_(std::move(arguments))
{
    std::string format;
    bool prints_figures = false;
    for (std::size_t i = 0; i < arguments_.size(); ++i) {
        prints_figures = prints_figures || arguments_[i] == "--json";
        if (arguments_[i].starts_with("--format="))
            format = "." + arguments_[i].substr(9);
        else if (arguments_[i] == "--format" && i + 1 < arguments_.size())
            format = "." + arguments_[i + 1];
    }
    std::string option;
    for (std::string& argument : arguments_) {
        const std::size_t sign = argument.find('=');
        const bool is_assigned = argument.starts_with("--") && sign != std::string::npos;
        if (is_assigned)
            option = argument.substr(0, sign);
        const bool is_joined = argument == "-o-";
        const bool is_stream =
            argument == "-" || is_joined || (is_assigned && argument.substr(sign + 1) == "-");
        if (!is_stream) {
            option = argument.starts_with("-") && !is_assigned ? argument : "";
            continue;
        }
        if (is_joined)
            option = "-o";
        const auto output =
            std::ranges::find_if(outputs, [&](const auto& known) { return known.first == option; });
        if (std::ranges::find(folders, option) != folders.end())
            throw UsageError(join(option, " -: several files come out; name a folder for them"));
        fs::path place;
        if (output != outputs.end()) {
            if (!output_.empty())
                throw UsageError("two outputs cannot both be '-', standard output");
            if (prints_figures)
                throw UsageError(join(option,
                                      " -: --json prints to standard output as well; name a "
                                      "file for one of them"));
            const std::string ending =
                output->second.empty() ? command_ending : std::string(output->second);
            place = output_ =
                file("stdout" + (ending == ".ply" && !format.empty() ? format : ending));
        } else {
            if (!input_.empty())
                throw UsageError("'-', standard input, can be read only once");
            const std::string content = read_standard_input();
            place = input_ = file("stdin" + ending_of(content));
            write_file_atomically(input_, content);
        }
        argument = is_joined     ? "-o" + place.string()
                   : is_assigned ? option + "=" + place.string()
                                 : place.string();
        option.clear();
    }
}

StandardStreams::~StandardStreams()
{
    clean_up([&] {
        std::error_code ignored; // nothing can be done about it, and the run has its own result
        if (!directory_.empty())
            fs::remove_all(directory_, ignored);
    });
}

fs::path StandardStreams::file(const std::string& name)
{
    if (directory_.empty()) {
        std::error_code error;
        fs::path place = fs::temp_directory_path(error);
        if (error)
            place = "/tmp";
        std::string pattern = (place / "shape-XXXXXX").string();
        if (::mkdtemp(pattern.data()) == nullptr)
            throw FileError(join("cannot make a directory for '-' in ", place.string(), ": ",
                                 std::strerror(errno), "; set TMPDIR"));
        directory_ = pattern;
    }
    return directory_ / name;
}

std::string StandardStreams::output() const
{
    if (output_.empty() || !fs::exists(output_))
        return {};
    return read_file(output_, std::numeric_limits<std::uint64_t>::max());
}

std::string StandardStreams::readable(std::string text) const
{
    for (const fs::path& path : {input_, output_})
        if (!path.empty())
            for (std::size_t at = text.find(path.string()); at != std::string::npos;
                 at = text.find(path.string(), at + 1))
                text.replace(at, path.string().size(), "-");
    return text;
}

} // namespace shape::tools
