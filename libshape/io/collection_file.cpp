// SPDX-License-Identifier: MIT

#include "libshape/io/collection_file.h"

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/io/hdf5_parts.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
namespace {

/// Runs body(i) for every mesh.
void for_each_mesh(std::size_t count, const std::function<void(Eigen::Index)>& body)
{
    parallel_for(count, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            body(static_cast<Eigen::Index>(i));
    });
}

} // namespace

void write_collection(const std::filesystem::path& path, const Collection& collection)
{
    const Topology& topology = collection.topology;
    const auto count = static_cast<Eigen::Index>(collection.size());
    RowMatrix points(count, 3 * topology.vertex_count());
    RowMatrix lengths(count, topology.edge_count());
    RowMatrix angles(count, topology.edge_count());
    for_each_mesh(collection.size(), [&](Eigen::Index i) {
        const Points& mesh = collection.points[static_cast<std::size_t>(i)];
        lengths.row(i) = edge_lengths(topology, mesh).transpose();
        angles.row(i) = dihedral_angles(topology, mesh).transpose();
        points.row(i) = mesh.reshaped<Eigen::RowMajor>().transpose();
        if (!mesh.allFinite() || !(lengths.row(i).minCoeff() > 0.0))
            throw InvalidInput(join("mesh ", i,
                                    " of the collection has a coordinate that is not "
                                    "finite or an edge of length 0"));
    });
    Hdf5Content content = begin_content(FileKind::Collection);
    add_topology(content, topology);
    add_numbers(content, "/points", {count, topology.vertex_count(), 3}, points);
    add_numbers(content, "/edge_lengths", {count, topology.edge_count()}, lengths);
    add_numbers(content, "/dihedral_angles", {count, topology.edge_count()}, angles);
    add_names(content, count, collection.names);
    add_labels(content, count, collection.labels);
    write_hdf5(path, content);
}

Collection read_collection(const std::filesystem::path& path)
{
    const Hdf5File file(path);
    check_kind(file, FileKind::Collection);
    const RowMatrix points = file.numbers("/points", {any_length, any_length, 3});
    const Eigen::Index count = points.rows();
    const Eigen::Index vertex_count = points.cols() / 3;
    Collection collection{
        read_topology(file, vertex_count), read_names(file, count), {}, read_labels(file, count)};
    const Topology& topology = collection.topology;
    const RowMatrix lengths = file.numbers("/edge_lengths", {count, topology.edge_count()});
    (void)file.numbers("/dihedral_angles", {count, topology.edge_count()});
    collection.points.resize(static_cast<std::size_t>(count));
    for_each_mesh(collection.size(), [&](Eigen::Index i) {
        Points& mesh = collection.points[static_cast<std::size_t>(i)];
        mesh = Eigen::Map<const Points>(points.row(i).data(), vertex_count, 3);
        const Eigen::VectorXd measured = edge_lengths(topology, mesh);
        for (Eigen::Index e = 0; e < measured.size(); ++e)
            if (!(measured[e] > 0.0) ||
                !(std::abs(lengths(i, e) - measured[e]) <= 1e-9 * measured[e]))
                file.fail("/edge_lengths",
                          join("value (", i, ", ", e, ") is ", lengths(i, e),
                               ", must be > 0 and the distance ", measured[e], " of the points"));
    });
    return collection;
}

} // namespace shape
