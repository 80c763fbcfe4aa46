// SPDX-License-Identifier: MIT

#include "tools/input/mesh_stream_input.h"

#include <CLI/CLI.hpp>
#include <atomic>
#include <cmath>
#include <memory>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/io/collection_stream.h"
#include "libshape/mesh/defects.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

/// "500M", "500 MB", "1.5GiB" or "500000000" in bytes.
std::uint64_t read_bytes(const std::string& text)
{
    std::string number = lower_case(text);
    const auto drops = [&number](std::string_view ending) {
        const bool is_there = number.ends_with(ending);
        if (is_there)
            number.resize(number.size() - ending.size());
        return is_there;
    };
    const bool is_binary = drops("ib");
    const bool is_decimal =
        !is_binary && drops("b"); // as the International System has it: MB as 10^6
    constexpr std::string_view letters = "kmgt";
    const std::size_t letter = number.empty() ? std::string::npos : letters.find(number.back());
    const bool has_letter = letter != std::string::npos;
    if (has_letter)
        number.pop_back();
    number.erase(number.find_last_not_of(" \t") + 1);
    double bytes = 0.0;
    try {
        bytes = read_number(is_binary && !has_letter ? text : number, "--memory");
    } catch (const UsageError&) {
        throw UsageError(
            join("--memory: '", text,
                 "' is no size such as 500M, 1.5GiB or 500000000: a number of bytes, or one and "
                 "K, M, G or T, as powers of 1024 (KiB, MiB, ... are the same; KB, MB, ... are "
                 "powers of 1000)"));
    }
    if (has_letter)
        bytes *= std::pow(is_decimal ? 1000.0 : 1024.0, static_cast<double>(letter + 1));
    constexpr double least = 16.0 * (1 << 20);
    constexpr double most = 1e18;
    if (!(bytes >= least && bytes <= most))
        throw UsageError(join("--memory: ", text, " must be at ",
                              bytes > most ? "most 900000TiB" : "least 16MiB"));
    return static_cast<std::uint64_t>(bytes);
}

/// The same meshes; one with a face without area is refused when it is first read.
MeshStream without_degenerate_meshes(MeshStream stream, const std::string& path)
{
    const auto seen = std::make_shared<std::vector<std::atomic<bool>>>(stream.names.size());
    auto fetch = std::move(stream.fetch);
    stream.fetch = [fetch = std::move(fetch), faces = stream.topology, names = stream.names, path,
                    seen](std::vector<Eigen::Index> meshes) -> MeshStream::Unpack {
        return
            [unpack = fetch(meshes), meshes, faces, names, path, seen](std::span<Points> points) {
                unpack(points);
                parallel_for(points.size(), 1, [&](std::size_t i, std::size_t) {
                    const auto mesh = to_size(meshes[i]);
                    if ((*seen)[mesh])
                        return;
                    const auto defects = find_degenerate_geometry(faces.faces(), points[i], 1);
                    if (!defects.empty())
                        throw InvalidInput(
                            join(path, ": mesh ", names[mesh], ": ", defects.front().message));
                    (*seen)[mesh] = true;
                });
            };
    };
    return stream;
}

} // namespace

CLI::Option* add_memory(CLI::App& command, MemoryArgument& memory)
{
    return command
        .add_option_function<std::string>(
            "--memory",
            [&memory](const std::string& text) {
                memory.text = text;
                memory.bytes = read_bytes(text);
            },
            "What a large collection may take in memory, such as 500M or 1.5G (powers of 1024, as\n"
            "MiB and GiB; MB and GB are powers of 1000) or in bytes (default: a quarter of the\n"
            "machine's): it is read in passes, more of them the less of it fits")
        ->option_text("SIZE");
}

std::optional<MeshStream> open_labelled(const Session& session, const LabelledInput& input,
                                        bool always)
{
    constexpr std::uint64_t small = std::uint64_t{32} << 20;
    const std::vector<std::filesystem::path> files = mesh_files(input.meshes);
    if (files.size() != 1 || !is_collection_file(files.front()))
        return std::nullopt;
    if (!always && std::filesystem::file_size(files.front()) <= small)
        return std::nullopt;
    MeshStream stream = open_collection(files.front());
    const auto positions = 3 * sizeof(double) *
                           static_cast<std::uint64_t>(stream.topology.vertex_count()) *
                           static_cast<std::uint64_t>(stream.size());
    if (!always && positions <= small)
        return std::nullopt;
    if (!input.meshes.labels.empty())
        stream.labels = labels_of(notices_of(session), input.meshes.labels, stream.names);
    stream = without_degenerate_meshes(std::move(stream), files.front().string());
    if (input.only.empty())
        return stream;
    return subset(stream, chosen_meshes(input.only, stream.labels, stream.names.size()));
}

std::optional<MeshStream> open_for_passes(const Session& session, const LabelledInput& input,
                                          const SpaceOptions& space, const MemoryArgument& memory,
                                          bool shares)
{
    const bool asks = memory.bytes > 0 || shares;
    if (space.kind == SpaceKind::Edge)
        if (auto meshes = open_labelled(session, input, asks))
            return meshes;
    if (asks)
        throw UsageError(
            "--memory and mpirun are for one collection file (.h5) in edge space; "
            "`shape collect` makes one");
    return std::nullopt;
}

} // namespace shape::tools
