// SPDX-License-Identifier: MIT

#include "tests/fuzz/targets.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/embedder.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/collection_stream.h"
#include "libshape/io/hdf5/untrusted_files.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/model_file.h"
#include "libshape/io/table_file.h"
#include "libshape/model/difference.h"
#include "libshape/model/shape_model.h"
#include "libshape/synthetic/synthetic.h"
#include "tests/fuzz/stored_file.h"
#include "tools/input/path_file.h"
#include "tools/output/frame_store.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::fuzz {
using namespace internal;
namespace {

namespace fs = std::filesystem;

/// A folder of this process in memory, removed at its end.
const fs::path& folder()
{
    struct Folder
    {
        fs::path path = fs::path(fs::is_directory("/dev/shm") ? "/dev/shm" : "/tmp") /
                        join("shape-fuzz-", ::getpid());
        Folder() { fs::create_directory(path); }
        ~Folder() { fs::remove_all(path); }
    };
    static const Folder one;
    return one.path;
}

fs::path file(const std::string& name, std::string_view bytes)
{
    const fs::path path = folder() / name;
    std::ofstream(path, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path;
}

/// Runs what may fail in the documented ways.
template <class Run>
void allow_errors(const Run& run)
{
    try {
        run();
    } catch (const InvalidInput&) {
    } catch (const NumericalError&) {
    } catch (const FileError&) {
    } catch (const LimitExceeded&) {
    } catch (const tools::UsageError&) {
    }
}

/// Reads a file of this name with these bytes.
template <class Read>
Target reading(const std::string& name, const std::string& file_name, const Read& read)
{
    return {name, [=](std::string_view bytes) {
                const fs::path path = file(file_name, bytes);
                allow_errors([&] { (void)read(path); });
            }};
}

MeshFileContent read_any_mesh(const fs::path& path)
{
    return read_mesh_members(path, {.triangulate = true});
}

/// What costs more than reading a small file does: waking threads for four meshes, and new memory for each file.
void make_hdf5_files_cheap()
{
    set_thread_count(1);
    keep_memory_of_hdf5();
}

/// HDF5 itself is known to crash; what is looked for is whether that harms us. Wrong checksums it refuses at once
/// (tests/campaigns/bit_flips), so they are made right.
template <class Read>
Target reading_hdf5(const std::string& name, const Read& read)
{
    return {name, [=](std::string_view bytes) {
                make_hdf5_files_cheap();
                isolate_hdf5_files(true);
                std::string mended(bytes);
                mend_checksums(mended);
                const fs::path path = file(name + ".h5", mended);
                allow_errors([&] { (void)read(path); });
            }};
}

/// Four tetrahedra, two of each side.
Collection tetrahedra()
{
    Faces faces(4, 3);
    faces << 0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0;
    Collection meshes{Topology(faces, 4),
                      {},
                      {},
                      {{"side", {"l", "r", "l", "r"}}, {"who", {"a", "a", "b", "b"}}}};
    for (int i = 0; i < 4; ++i) {
        Points points(4, 3);
        points << 0, 0, 0, 2 + 0.1 * i, 0, 0, 0, 2, 0.3 * (i % 2), 0.2, 0.1 * i * i, 1.5;
        meshes.points.push_back(points);
        meshes.names.push_back(join("m", i));
    }
    return meshes;
}

/// Files that libshape wrote, of every kind that differs in what it holds.
std::vector<StoredFile> stored_files(const std::string& kind)
{
    const Collection meshes = tetrahedra();
    const fs::path path = folder() / "whole.h5";
    std::vector<StoredFile> all;
    if (kind == "collection")
        for (const CollectionFileOptions& options :
             {CollectionFileOptions{}, {.derived = true}, {.compress = true}}) {
            write_collection(path, meshes, options);
            all.emplace_back(path);
        }
    if (kind == "model")
        for (const SpaceOptions& space : {SpaceOptions{},
                                          {.kind = SpaceKind::Procrustes},
                                          {.dihedral_weight = 0.3},
                                          {.position_weight = 3.0},
                                          {.scale = Scale::None,
                                          .coordinates = LengthCoordinates::Log,
                                          .weighting = EdgeWeighting::Area}}) {
            write_model(path, fit_model(meshes, {.space = space}));
            all.emplace_back(path);
        }
    if (kind == "difference")
        for (const char* pair_by : {"", "who"}) {
            const DifferenceOptions options{.pair_by = pair_by,
                                            .from_label = "side",
                                            .from_value = "l",
                                            .to_label = "side",
                                            .to_value = "r"};
            write_difference(path, mean_difference(meshes, options));
            all.emplace_back(path);
        }
    return all;
}

/// A file whose content the bytes change: the first chooses the file, the others are StoredFile::change()'s.
/// is_sound() says of what was read whether it keeps its rules.
template <class Read, class IsSound>
Target reading_content(const std::string& kind, const Read& read, const IsSound& is_sound)
{
    return {kind + "_content", [=](std::string_view bytes) {
                make_hdf5_files_cheap();
                static const std::vector<StoredFile> whole = [&] {
                    std::vector<StoredFile> files = stored_files(kind);
                    for (const StoredFile& unchanged :
                         files) // else it would be refusals that are tried
                        if (!unchanged.write(folder() / "same.h5") ||
                            !is_sound(read(folder() / "same.h5")))
                            std::abort();
                    return files;
                }();
                if (bytes.empty())
                    return;
                isolate_hdf5_files(false);
                StoredFile changed = whole[static_cast<unsigned char>(bytes[0]) % whole.size()];
                changed.change(bytes.substr(1));
                const fs::path path = folder() / "changed.h5";
                if (!changed.write(path))
                    return;
                allow_errors([&] {
                    if (!is_sound(read(path)))
                        std::abort();
                });
            }};
}

/// Read whole, and in passes, which must agree.
Collection read_both_ways(const fs::path& path)
{
    Collection whole = read_collection(path);
    const MeshStream stream = open_collection(path);
    for_each_block(stream, 0, stream.size(), 3, [&](Eigen::Index first, const Collection& block) {
        for (std::size_t i = 0; i < block.size(); ++i)
            if (block.points[i] != whole.points[to_size(first) + i])
                std::abort();
    });
    return whole;
}

bool is_sound(const Collection& meshes)
{
    return meshes.names.size() == meshes.size() &&
           std::ranges::all_of(meshes.points, [&](const Points& points) {
               return points.rows() == meshes.topology.vertex_count() && points.allFinite();
           });
}

bool is_sound(const ShapeModel& model)
{
    return model.mean.allFinite() && model.modes.allFinite() && model.scores.allFinite() &&
           model.mode_dihedral_angles.allFinite() && model.mean_dihedral_angles.allFinite() &&
           model.modes.cols() == model.mean.size() &&
           model.modes.rows() == model.variances.size() &&
           model.scores.rows() == static_cast<Eigen::Index>(model.names.size()) &&
           model.variances.allFinite() && model.variances.minCoeff() > 0.0;
}

bool is_sound(const DifferenceVector& difference)
{
    const Eigen::Index edges = difference.topology.edge_count();
    return difference.edge_lengths.size() == edges && difference.dihedral_angles.size() == edges &&
           difference.edge_lengths.allFinite() && difference.dihedral_angles.allFinite() &&
           difference.mean_edge_lengths.minCoeff() > 0.0 && difference.from_size > 0.0;
}

void resume(std::string_view bytes)
{
    const fs::path output = folder() / "frames";
    const fs::path unfinished = folder() / "frames.unfinished";
    fs::create_directory(unfinished);
    (void)file("frames.unfinished/manifest.json", bytes);
    (void)file("frames.unfinished/0.mesh", bytes);
    allow_errors([&] {
        const tools::Json identity{{"program", "1"}, {"--seed", "1"}};
        tools::FrameStore store(tools::Session(), output.string(), identity, true);
        (void)store.read(0);
    });
    // The mesh by itself, beside a manifest that agrees.
    fs::create_directory(unfinished);
    (void)file("frames.unfinished/manifest.json", "{\"program\": \"1\"}");
    (void)file("frames.unfinished/0.mesh", bytes);
    allow_errors([&] {
        tools::FrameStore store(tools::Session(), output.string(), {{"program", "1"}}, true);
        (void)store.read(0);
    });
}

/// The first byte chooses the method, the others are lengths and angles of an octahedron.
void embed(std::string_view bytes)
{
    static const auto octahedron = [] {
        Faces faces(8, 3);
        faces << 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5;
        Points points(6, 3);
        points << 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
        return std::pair(Topology(faces, 6), points);
    }();
    const Topology& topology = octahedron.first;
    const Points& reference = octahedron.second;
    if (bytes.empty())
        return;
    set_thread_count(1);
    EmbeddingOptions options;
    options.method = static_cast<EmbeddingMethod>(static_cast<unsigned char>(bytes[0]) % 3);
    options.quality = EmbeddingQuality::Preview;
    bytes.remove_prefix(1);
    const Eigen::Index edges = topology.edge_count();
    ShapePoint point{Eigen::VectorXd::Constant(edges, 1.4142135623730951),
                     Eigen::VectorXd::Constant(edges, 1.2309594173407747)};
    for (Eigen::VectorXd* values : {&point.edge_lengths, &point.dihedral_angles}) {
        const std::size_t size = std::min(bytes.size(), 8 * to_size(edges));
        std::memcpy(values->data(), bytes.data(), size / 8 * 8);
        bytes.remove_prefix(size);
    }
    allow_errors([&] {
        const Embedding made = Embedder(topology, {reference}, options).embed(point);
        if (!made.points.allFinite())
            std::abort();
    });
}

} // namespace

const std::vector<Target>& targets()
{
    static const std::vector<Target> all{
        reading("obj", "x.obj", &read_any_mesh),
        reading("off", "x.off", &read_any_mesh),
        reading("ply", "x.ply", &read_any_mesh),
        reading("stl", "x.stl", &read_any_mesh),
        reading("vtk", "x.vtk", &read_any_mesh),
        reading("vtp", "x.vtp", &read_any_mesh),
        reading("glb", "x.glb", &read_any_mesh),
        reading("csv", "x.csv", [](const fs::path& path) { return read_table(path); }),
        reading("path", "path.json",
                [](const fs::path& path) {
                    tools::PathDescription description;
                    tools::read_path_file(path.string(), description);
                    return 0;
                }),
        {"resume", resume},
        reading_hdf5("collection", [](const fs::path& path) { return read_collection(path); }),
        reading_hdf5("model", [](const fs::path& path) { return read_model(path); }),
        reading_hdf5("difference", [](const fs::path& path) { return read_difference(path); }),
        reading_content("collection", &read_both_ways,
                        [](const Collection& read) { return is_sound(read); }),
        reading_content("model", &read_model,
                        [](const ShapeModel& read) { return is_sound(read); }),
        reading_content("difference", &read_difference,
                        [](const DifferenceVector& read) { return is_sound(read); }),
        {"lengths", embed},
    };
    return all;
}

const Target& find_target(std::string_view name)
{
    std::string known;
    for (const Target& target : targets()) {
        if (target.name == name)
            return target;
        known += " " + target.name;
    }
    throw std::invalid_argument(join("no target '", name, "'; there are", known));
}

} // namespace shape::fuzz
