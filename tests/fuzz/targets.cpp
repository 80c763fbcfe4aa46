// SPDX-License-Identifier: MIT

#include "tests/fuzz/targets.h"

#include <unistd.h>

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
#include "libshape/io/hdf5/untrusted_files.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/model_file.h"
#include "libshape/io/table_file.h"
#include "libshape/synthetic/synthetic.h"
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

/// HDF5 itself is known to crash; what is looked for is whether that harms us.
template <class Read>
Target reading_hdf5(const std::string& name, const Read& read)
{
    return reading(name, name + ".h5", [=](const fs::path& path) {
        rehearse_hdf5_files(true);
        return read(path);
    });
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
