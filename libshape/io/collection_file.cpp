// SPDX-License-Identifier: MIT

#include "libshape/io/collection_file.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/io/collection_stream.h"
#include "libshape/io/file/watched_file.h"
#include "libshape/io/file_parts.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
namespace {

/// Runs body(i) for every mesh.
void for_each_mesh(std::size_t count, const std::function<void(Eigen::Index)>& body)
{
    parallel_for(count, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            body(static_cast<Eigen::Index>(i));
    });
}

/// The meshes of a stream one after the other, fetched some at a time.
class InOrder
{
public:
    explicit InOrder(const MeshStream& meshes)
        : meshes_(meshes),
          block_(std::clamp<Eigen::Index>(
              (Eigen::Index{16} << 20) /
                  (24 * static_cast<Eigen::Index>(meshes.topology.vertex_count())),
              1, 256))
    {
    }

    [[nodiscard]] const Points& operator[](Eigen::Index mesh)
    {
        if (mesh < first_ || mesh >= first_ + static_cast<Eigen::Index>(points_.size())) {
            std::vector<Eigen::Index> wanted(to_size(std::min(block_, meshes_.size() - mesh)));
            std::iota(wanted.begin(), wanted.end(), mesh);
            points_.resize(wanted.size(), Points(meshes_.topology.vertex_count(), 3));
            meshes_.fetch(std::move(wanted))(points_);
            first_ = mesh;
        }
        return points_[to_size(mesh - first_)];
    }

private:
    const MeshStream& meshes_;
    Eigen::Index block_;
    Eigen::Index first_ = 0;
    std::vector<Points> points_;
};

/// @param before_renaming  As of write_hdf5().
void write_stream(const std::filesystem::path& path, const MeshStream& meshes,
                  const CollectionFileOptions& options, const Progress& progress,
                  const std::function<void()>& before_renaming)
{
    const Topology& topology = meshes.topology;
    const Eigen::Index count = meshes.size();
    Hdf5Content content = begin_content(FileKind::Collection);
    add_topology(content, topology);
    InOrder in_order(meshes);
    // One mesh at a time: together they would take as much memory as the file.
    const auto add = [&](const char* name, Extents extents, const auto& measure) {
        content.datasets.push_back(
            {name, std::move(extents),
             Hdf5Rows([&in_order, measure](Eigen::Index i, std::span<double> numbers) {
                 const Eigen::VectorXd values = measure(i, in_order[i]);
                 std::copy(values.begin(), values.end(), numbers.begin());
             }),
             options.compress});
    };
    add("/points", {count, topology.vertex_count(), 3}, [&](Eigen::Index i, const Points& points) {
        if (!points.allFinite() || !(edge_lengths(topology, points).minCoeff() > 0.0))
            throw InvalidInput(join("mesh ", i,
                                    " of the collection has a coordinate that is not "
                                    "finite or an edge of length 0"));
        if (progress)
            progress("writing", to_size(i) + 1, to_size(count));
        return Eigen::VectorXd(points.reshaped<Eigen::RowMajor>());
    });
    if (options.derived) {
        add("/edge_lengths", {count, topology.edge_count()},
            [&](Eigen::Index, const Points& points) { return edge_lengths(topology, points); });
        add("/dihedral_angles", {count, topology.edge_count()},
            [&](Eigen::Index, const Points& points) { return dihedral_angles(topology, points); });
    }
    add_names(content, count, meshes.names);
    add_labels(content, count, meshes.labels);
    write_hdf5(path, content, before_renaming);
}

} // namespace

void write_collection(const std::filesystem::path& path, const Collection& collection,
                      const CollectionFileOptions& options)
{
    const MeshStream meshes = stream_of(collection);
    if (meshes.names.size() != collection.size())
        throw InvalidInput(join("/names: has ", meshes.names.size(), " values, must have ",
                                collection.size(), " and at least 1"));
    write_collection(path, meshes, options);
}

void write_collection(const std::filesystem::path& path, const MeshStream& meshes,
                      const CollectionFileOptions& options, const Progress& progress)
{
    write_stream(path, meshes, options, progress, {});
}

namespace {

/// With which options a file was written that has been read without an error.
CollectionFileOptions options_of(const std::filesystem::path& path)
{
    const Hdf5File file(path);
    return {.derived = file.has("/edge_lengths") || file.has("/dihedral_angles"),
            .compress = file.is_compressed("/points")};
}

} // namespace

Eigen::Index append_to_collection(const std::filesystem::path& path, const MeshStream& added,
                                  const CollectionFileOptions& options, const Progress& progress)
{
    WatchedFile file(path);
    const MeshStream all = joined(open_collection(path), added);
    CollectionFileOptions kept = options_of(path);
    kept.derived = kept.derived || options.derived;
    kept.compress = kept.compress || options.compress;
    write_stream(path, all, kept, progress, [&] {
        file.lock_folder();
        if (!file.is_as_it_was())
            throw FileError(
                join(path.string(), " changed while meshes were appended to it; append again"));
    });
    return all.size();
}

Collection read_collection(const std::filesystem::path& path)
{
    const Hdf5File file(path);
    check_kind(file, FileKind::Collection);
    RowMatrix points = file.numbers("/points", {any_length, any_length, 3});
    const Eigen::Index count = points.rows();
    const Eigen::Index vertex_count = points.cols() / 3;
    Collection collection{
        read_topology(file, vertex_count), read_names(file, count), {}, read_labels(file, count)};
    const Topology& topology = collection.topology;
    // One dataset at a time in memory beside the meshes.
    collection.points.resize(to_size(count));
    for_each_mesh(collection.size(), [&](Eigen::Index i) {
        collection.points[to_size(i)] =
            Eigen::Map<const Points>(points.row(i).data(), vertex_count, 3);
    });
    points.resize(0, 0);
    if (file.has("/edge_lengths")) {
        const RowMatrix lengths = file.numbers("/edge_lengths", {count, topology.edge_count()});
        for_each_mesh(collection.size(), [&](Eigen::Index i) {
            const Eigen::VectorXd measured = edge_lengths(topology, collection.points[to_size(i)]);
            for (Eigen::Index e = 0; e < measured.size(); ++e)
                if (!(measured[e] > 0.0) ||
                    !(std::abs(lengths(i, e) - measured[e]) <= 1e-9 * measured[e]))
                    file.fail("/edge_lengths", join("value (", i, ", ", e, ") is ", lengths(i, e),
                                                    ", must be > 0 and the distance ", measured[e],
                                                    " of the points"));
        });
    } else {
        for_each_mesh(collection.size(), [&](Eigen::Index i) {
            Eigen::Index edge = 0;
            if (!(edge_lengths(topology, collection.points[to_size(i)]).minCoeff(&edge) > 0.0))
                file.fail("/points",
                          join("mesh ", i, " has an edge of length 0 (edge ", edge, ")"));
        });
    }
    if (!file.has("/dihedral_angles"))
        return collection;
    const RowMatrix angles = file.numbers("/dihedral_angles", {count, topology.edge_count()});
    for_each_mesh(collection.size(), [&](Eigen::Index i) {
        const Eigen::VectorXd measured = dihedral_angles(topology, collection.points[to_size(i)]);
        for (Eigen::Index e = 0; e < measured.size(); ++e)
            if (!(std::abs(wrapped_angle(angles(i, e) - measured[e])) <= 1e-6))
                file.fail("/dihedral_angles",
                          join("value (", i, ", ", e, ") is ", angles(i, e),
                               ", the points and /topology/faces give ", measured[e]));
    });
    return collection;
}

} // namespace shape
