// SPDX-License-Identifier: MIT

#include "libshape/embedding/closure/vertex_positions.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/sparse_cholesky.h"

namespace shape::internal {

Points vertex_positions(const Topology& topology, const Eigen::VectorXd& lengths,
                        const std::vector<Eigen::Matrix3d>& local_frames,
                        const std::vector<Eigen::Matrix3d>& frames)
{
    const int vertex_count = topology.vertex_count();
    const int edge_count = topology.edge_count();
    const int halfedge_count = topology.halfedge_count();
    if (lengths.size() != edge_count)
        throw InvalidInput(
            join("lengths has ", lengths.size(), " entries, the topology ", edge_count, " edges"));
    if (local_frames.size() != to_size(halfedge_count))
        throw InvalidInput(join("local_frames has ", local_frames.size(), " entries, the topology ",
                                halfedge_count, " half-edges"));
    if (frames.size() != to_size(vertex_count))
        throw InvalidInput(join("frames has ", frames.size(), " entries, the topology ",
                                vertex_count, " vertices"));

    Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(vertex_count, 3);
    for (int h = 0; h < halfedge_count; ++h) {
        const int v = topology.source(h);
        const int u = topology.target(h);
        const Eigen::RowVector3d step =
            lengths[topology.edge(h)] *
            (frames[to_size(v)] * local_frames[to_size(h)].col(0)).transpose();
        rhs.row(u) += step;
        rhs.row(v) -= step;
    }
    // The normal matrix is a Laplacian of the graph: weight 2 on interior edges, 1 on the boundary.
    Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(vertex_count);
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(to_size(vertex_count + edge_count));
    for (int e = 0; e < edge_count; ++e) {
        const int v = topology.edges()(e, 0);
        const int u = topology.edges()(e, 1);
        const double weight = topology.is_boundary_edge(e) ? 1.0 : 2.0;
        diagonal[v] += weight;
        diagonal[u] += weight;
        if (v > 0) // vertex 0 is at the origin
            entries.emplace_back(u - 1, v - 1, -weight);
    }
    for (int v = 1; v < vertex_count; ++v)
        entries.emplace_back(v - 1, v - 1, diagonal[v]);
    SparseMatrix normal(vertex_count - 1, vertex_count - 1); // lower triangle
    normal.setFromTriplets(entries.begin(), entries.end());

    Points points = Points::Zero(vertex_count, 3);
    points.bottomRows(vertex_count - 1) =
        SparseCholesky(normal, Ordering::MinimumDegree).solve(rhs.bottomRows(vertex_count - 1));
    points.rowwise() -= points.colwise().mean().eval();
    return points;
}

} // namespace shape::internal
