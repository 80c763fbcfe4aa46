// SPDX-License-Identifier: MIT

#include "libshape/embedding/start/edge_laplacian.h"

#include <array>
#include <cmath>
#include <utility>

#include "libshape/base/blocks.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vectorised.h"

namespace shape::internal {
namespace {

using Eigen::VectorXd;

VectorXd weights_of(const VectorXd& lengths)
{
    // Of the mean length. Weights then span 1e6, of which a factor in single precision keeps a digit;
    // shorter edges are as good as points in the start, and the descent gives them their length.
    constexpr double shortest = 1e-3;
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

/// Faces as they are laid out: u and v of their sides, what these weigh, and their frames.
struct FaceBlock
{
    Row first_u, second_u, third_u, second_v; // third_v is -second_v
    Row first_weight, second_weight, third_weight;
    Row w, x, y, z;
};

/// What a block of faces pulls its corners by: x, y, z of the first, of the second, of the third.
using Pulls = std::array<Row, 9>;

/// The weighted side that comes in at a corner less that which goes out: with R the frame of the face,
///
///     pull_1 = w_3 R s_3 - w_1 R s_1,      pull_2 = w_1 R s_1 - w_2 R s_2,      pull_3 = w_2 R s_2 - w_3 R s_3,
///
///     s_1 = (u_1, 0),  s_2 = (u_2, v_2),  s_3 = (u_3, -v_2)     in the plane of the face.
///
/// In memory a number of 128 faces is a row, first_u: u0 u1 .. u127; pulls[3 (k - 1) + c] is coordinate c of
/// pull_k. The plain loop would build a matrix of three by three for each face and add to vertices as it
/// goes; here nothing but two columns of R is needed, coordinate by coordinate, and a lane is a face.
SHAPE_VECTORISED void find_pulls(int count, const FaceBlock& of, Pulls& __restrict pulls)
{
    for (int i = 0; i < count; ++i) {
        const double w = of.w[i], x = of.x[i], y = of.y[i], z = of.z[i];
        const double first_u = of.first_weight[i] * of.first_u[i];
        const double second_u = of.second_weight[i] * of.second_u[i];
        const double second_v = of.second_weight[i] * of.second_v[i];
        const double third_u = of.third_weight[i] * of.third_u[i];
        const double third_v = of.third_weight[i] * -of.second_v[i];
        const auto along = [&](double u, double v, double& first, double& second, double& third) {
            const double a = first_u * u;
            const double b = second_u * u + second_v * v;
            const double c = third_u * u + third_v * v;
            first = c - a;
            second = a - b;
            third = b - c;
        };
        along(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), pulls[0][i], pulls[3][i],
              pulls[6][i]);
        along(2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), pulls[1][i], pulls[4][i],
              pulls[7][i]);
        along(2.0 * (x * z - w * y), 2.0 * (y * z + w * x), pulls[2][i], pulls[5][i], pulls[8][i]);
    }
}

/// Calls take(h, x, y, z) for every half-edge: what its face pulls its source by.
template <class Take>
void for_pulls(const Topology& topology, const VectorXd& weights, const FaceLayout& layout,
               const Rotations& frames, const Take& take)
{
    for_blocks(topology.face_count(), [&](int first, int count) {
        FaceBlock of{};
        Pulls pulls;
        for (int i = 0; i < count; ++i) {
            const int f = first + i;
            const double* const side = layout.sides.data() + 4 * f;
            of.first_u[i] = side[0];
            of.second_u[i] = side[1];
            of.third_u[i] = side[2];
            of.second_v[i] = side[3];
            const int* const edges = topology.face_edges().data() + 3 * f;
            of.first_weight[i] = weights[edges[0]];
            of.second_weight[i] = weights[edges[1]];
            of.third_weight[i] = weights[edges[2]];
            const Eigen::Quaterniond& frame = frames[to_size(f)];
            of.w[i] = frame.w();
            of.x[i] = frame.x();
            of.y[i] = frame.y();
            of.z[i] = frame.z();
        }
        find_pulls(count, of, pulls);
        for (int i = 0; i < count; ++i)
            for (int c = 0; c < 3; ++c) {
                const Row* const pull = pulls.data() + 3 * c;
                take(3 * (first + i) + c, pull[0][i], pull[1][i], pull[2][i]);
            }
    });
}

template <class Work>
void for_vertices(const Topology& topology, const Work& work)
{
    parallel_for(to_size(topology.vertex_count()), 2048, [&](std::size_t begin, std::size_t end) {
        for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v)
            work(v);
    });
}

} // namespace

EdgeLaplacian::EdgeLaplacian(const Topology& topology, const VectorXd& lengths)
    : topology_(topology),
      weights_(weights_of(lengths)),
      matrix_(laplacian(topology, weights_)),
      exact_(std::in_place, matrix_),
      factor_(*exact_)
{
}

EdgeLaplacian::EdgeLaplacian(const Topology& topology, const VectorXd& lengths,
                             SinglePrecisionSolve factor)
    : topology_(topology),
      weights_(weights_of(lengths)),
      matrix_(laplacian(topology, weights_)),
      factor_(std::move(factor))
{
    if (factor_.size() != topology.vertex_count())
        throw InvalidInput(join("the factor is of a mesh of ", factor_.size(),
                                " vertices, this one has ", topology.vertex_count()));
}

Points EdgeLaplacian::solve(const Points& rhs) const
{
    if (exact_)
        return exact_->solve(rhs);
    return solve_by_conjugate_gradients(rhs);
}

Points EdgeLaplacian::solve_by_conjugate_gradients(const Points& rhs) const
{
    // A bound for weights so far apart that the factor in single precision is no help; else a few do.
    constexpr int most_steps = 60;
    constexpr double rounding = 1e-15; // of the right-hand side, in the norm of the factor
    Points solution = Points::Zero(rhs.rows(), 3);
    Points residual = rhs;
    Points direction = Points::Zero(rhs.rows(), 3);
    Eigen::Array3d square = Eigen::Array3d::Ones();
    Eigen::Array3d first = Eigen::Array3d::Zero();
    LaneVectors single, preconditioned, workspace;
    for (int step = 0; step < most_steps; ++step) {
        const double size = residual.cwiseAbs().maxCoeff();
        if (!(size > 0.0))
            break;
        const double scale = weights_.maxCoeff() / size; // solutions of about 1
        to_lanes(residual.data(), residual.rows(), scale, single);
        factor_.solve(single, preconditioned, workspace);
        const Points next = (preconditioned.topRows<3>().cast<double>() / scale).transpose();
        const Eigen::Array3d last = square;
        square = residual.cwiseProduct(next).colwise().sum().transpose();
        if (step == 0)
            first = square;
        if (!(square > rounding * rounding * first).any())
            break;
        const Eigen::Array3d along = (last > 0.0).select(square / last, 0.0);
        direction = next + direction * along.matrix().asDiagonal();
        const Points image = matrix_.selfadjointView<Eigen::Lower>() * direction;
        const Eigen::Array3d curvature = direction.cwiseProduct(image).colwise().sum().transpose();
        const Eigen::Array3d length = (curvature > 0.0).select(square / curvature, 0.0);
        solution += direction * length.matrix().asDiagonal();
        residual -= image * length.matrix().asDiagonal();
    }
    return solution;
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

} // namespace shape::internal
