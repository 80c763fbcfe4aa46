// SPDX-License-Identifier: MIT

#include "libshape/embedding/edge_laplacian.h"

#include <cmath>
#include <utility>

#include "libshape/base/threads.h"

namespace shape {
namespace {

using Eigen::VectorXd;

VectorXd weights_of(const VectorXd& lengths)
{
    constexpr double shortest = 1e-3; // of the mean: more would cost the factor its digits
    return lengths.cwiseMax(shortest * lengths.mean()).array().square().inverse();
}

/// Lower triangle. Edges are sorted by their lower vertex, then by their higher one: column v holds
/// its diagonal and then its edges, in order.
SparseMatrix laplacian(const Topology& topology, const VectorXd& weights)
{
    const int vertices = topology.vertex_count();
    VectorXd diagonal = VectorXd::Zero(vertices);
    VectorXd doubled(topology.edge_count());
    for (int e = 0; e < topology.edge_count(); ++e) {
        doubled[e] = topology.is_boundary_edge(e) ? weights[e] : 2.0 * weights[e];
        diagonal[topology.edges()(e, 0)] += doubled[e];
        diagonal[topology.edges()(e, 1)] += doubled[e];
    }
    diagonal[0] += weights.mean();
    SparseMatrix matrix(vertices, vertices);
    matrix.resizeNonZeros(vertices + topology.edge_count());
    int entry = 0;
    int e = 0;
    for (int v = 0; v < vertices; ++v) {
        matrix.outerIndexPtr()[v] = entry;
        matrix.innerIndexPtr()[entry] = v;
        matrix.valuePtr()[entry++] = diagonal[v];
        for (; e < topology.edge_count() && topology.edges()(e, 0) == v; ++e) {
            matrix.innerIndexPtr()[entry] = topology.edges()(e, 1);
            matrix.valuePtr()[entry++] = -doubled[e];
        }
    }
    matrix.outerIndexPtr()[vertices] = entry;
    return matrix;
}

} // namespace

EdgeLaplacian::EdgeLaplacian(const Topology& topology, const VectorXd& lengths)
    : topology_(topology), weights_(weights_of(lengths)), factor_(laplacian(topology, weights_))
{
}

Points EdgeLaplacian::solve(const Points& rhs) const
{
    return factor_.solve(rhs);
}

Points EdgeLaplacian::divergence(const std::vector<Eigen::Matrix3d>& frames,
                                 const Points& halfedges) const
{
    Points rhs(topology_.vertex_count(), 3);
    parallel_for(static_cast<std::size_t>(topology_.vertex_count()), 1024,
                 [&](std::size_t begin, std::size_t end) {
                     for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
                         Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
                         for (const int out : topology_.outgoing(v)) {
                             const int in = Topology::previous(out);
                             sum += (weights_[topology_.edge(in)] * halfedges.row(in) -
                                     weights_[topology_.edge(out)] * halfedges.row(out)) *
                                    frames[static_cast<std::size_t>(out / 3)].transpose();
                         }
                         rhs.row(v) = sum;
                     }
                 });
    return rhs;
}

Points EdgeLaplacian::positions(const std::vector<Eigen::Matrix3d>& frames,
                                const Points& halfedges) const
{
    return solve(divergence(frames, halfedges));
}

Points EdgeLaplacian::positions(const std::vector<Eigen::Matrix3d>& frames, const Points& halfedges,
                                const SinglePrecisionSolve& solve) const
{
    const Points rhs = divergence(frames, halfedges);
    // Vectors of about the size of edges: neither large nor small numbers leave float's range.
    const double unit = 1.0 / std::sqrt(weights_.maxCoeff());
    LaneVectors scaled;
    LaneVectors solution;
    LaneVectors workspace;
    to_lanes(rhs.data(), rhs.rows(), unit, scaled);
    solve.solve(scaled, solution, workspace);
    return solution.topRows<3>().transpose().cast<double>() / unit;
}

} // namespace shape
