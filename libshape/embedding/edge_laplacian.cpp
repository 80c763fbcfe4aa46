// SPDX-License-Identifier: MIT

#include "libshape/embedding/edge_laplacian.h"

#include <array>
#include <cmath>

#include "libshape/base/blocks.h"
#include "libshape/base/threads.h"
#include "libshape/base/vectorised.h"

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

/// Sides of faces, u and v in their planes, and what they weigh.
struct Sides
{
    Row first_u, second_u, third_u, second_v; // third_v is -second_v
    Row first_weight, second_weight, third_weight;
};

/// The first two axes of frames.
struct Axes
{
    std::array<Row, 3> u, v;
};

/// What the faces pull their corners by, along one axis: the weighted side that comes in less that
/// which goes out.
SHAPE_VECTORISED void pulls_of(int count, const Sides& sides, const Row& u, const Row& v,
                               Row& __restrict first, Row& __restrict second, Row& __restrict third)
{
    for (int i = 0; i < count; ++i) {
        const double a = sides.first_weight[i] * (sides.first_u[i] * u[i]);
        const double b =
            sides.second_weight[i] * (sides.second_u[i] * u[i] + sides.second_v[i] * v[i]);
        const double c =
            sides.third_weight[i] * (sides.third_u[i] * u[i] - sides.second_v[i] * v[i]);
        first[i] = c - a;
        second[i] = a - b;
        third[i] = b - c;
    }
}

/// Calls take(h, x, y, z) for every half-edge: what its face pulls its source by.
template <class Take>
void for_pulls(const Topology& topology, const VectorXd& weights, const FaceLayout& layout,
               const Rotations& frames, const Take& take)
{
    for_blocks(topology.face_count(), [&](int first, int count) {
        Sides sides;
        Axes axes;
        for (int i = 0; i < count; ++i) {
            const int f = first + i;
            const auto side = layout.sides.col(f);
            sides.first_u[i] = side[0];
            sides.second_u[i] = side[1];
            sides.third_u[i] = side[2];
            sides.second_v[i] = side[3];
            sides.first_weight[i] = weights[topology.face_edges()(f, 0)];
            sides.second_weight[i] = weights[topology.face_edges()(f, 1)];
            sides.third_weight[i] = weights[topology.face_edges()(f, 2)];
            const Eigen::Matrix3d frame = frames[static_cast<std::size_t>(f)].toRotationMatrix();
            for (int k = 0; k < 3; ++k) {
                axes.u[static_cast<std::size_t>(k)][i] = frame(k, 0);
                axes.v[static_cast<std::size_t>(k)][i] = frame(k, 1);
            }
        }
        std::array<std::array<Row, 3>, 3> pulls; // of every corner, along every axis
        for (std::size_t k = 0; k < 3; ++k)
            pulls_of(count, sides, axes.u[k], axes.v[k], pulls[0][k], pulls[1][k], pulls[2][k]);
        for (int i = 0; i < count; ++i)
            for (int c = 0; c < 3; ++c) {
                const auto& [x, y, z] = pulls[static_cast<std::size_t>(c)];
                take(3 * (first + i) + c, x[i], y[i], z[i]);
            }
    });
}

template <class Work>
void for_vertices(const Topology& topology, const Work& work)
{
    parallel_for(static_cast<std::size_t>(topology.vertex_count()), 2048,
                 [&](std::size_t begin, std::size_t end) {
                     for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v)
                         work(v);
                 });
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

Points EdgeLaplacian::positions(const FaceLayout& layout, const Rotations& frames) const
{
    Points pulls(topology_.halfedge_count(), 3);
    for_pulls(topology_, weights_, layout, frames,
              [&](int h, double x, double y, double z) { pulls.row(h) << x, y, z; });
    Points rhs(topology_.vertex_count(), 3);
    for_vertices(topology_, [&](int v) {
        rhs.row(v).setZero();
        for (const int h : topology_.outgoing(v))
            rhs.row(v) += pulls.row(h);
    });
    return solve(rhs);
}

void EdgeLaplacian::positions(const FaceLayout& layout, const Rotations& frames,
                              const SinglePrecisionSolve& solve, Memory& memory,
                              Points& points) const
{
    // Vectors of about the size of edges: neither large nor small numbers leave float's range.
    const double unit = 1.0 / std::sqrt(weights_.maxCoeff());
    memory.pulls.resize(4, topology_.halfedge_count());
    for_pulls(topology_, weights_, layout, frames, [&](int h, double x, double y, double z) {
        lanes(memory.pulls)[h] = Lanes{static_cast<float>(unit * x), static_cast<float>(unit * y),
                                       static_cast<float>(unit * z), 0.0F};
    });
    memory.rhs.resize(4, topology_.vertex_count());
    for_vertices(topology_, [&](int v) {
        Lanes sum{};
        for (const int h : topology_.outgoing(v))
            sum += lanes(memory.pulls)[h];
        lanes(memory.rhs)[v] = sum;
    });
    solve.solve(memory.rhs, memory.solution, memory.workspace);
    points.resize(topology_.vertex_count(), 3);
    for_vertices(topology_, [&](int v) {
        points.row(v) = memory.solution.col(v).head<3>().cast<double>() / unit;
    });
}

} // namespace shape
