// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/gauss_newton.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/energy/stretch_term.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/hinge.h"

namespace shape::internal {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// The step s = (J^T J + D)^-1 J^T r solves a sparse system of size 3 #unknowns. Each residual of a hinge
// moves at most four vertices, so J^T J is made of blocks of 3 by 3, one for every two unknowns that
// share a hinge; in memory the lower triangle by columns, as CHOLMOD reads it, where the three columns of
// a block column have the same rows:
//
//     block column j:   | b0 b1 b2 ..|     values   column 3 j      b0: xx xy xz   b1: xx xy xz   ...
//     (its blocks are   |            |              column 3 j + 1  b0: yx yy yz   ...
//     block_begin_[j]..)|            |              column 3 j + 2  b0: zx zy zz   ...
//
// Filled from a list of triplets, a matrix of 9 entries for each of up to 10 pairs a hinge would be sorted
// at every iteration; the pattern is the same in all of them and found once.

Vector3d eigen(const Vector3<double>& v)
{
    return {v.x, v.y, v.z};
}

/// The damping of the first step, relative to the diagonal, and the least of any. Where lengths range over
/// ten orders of magnitude, more would hold fine regions fast: their unknowns are relative to coarse
/// ones (graded_unknowns.h). Less than 1e-13 is lost in rounding: the factorisation would break down
/// on the rigid motions that nothing else holds.
constexpr double first_damping = 1e-10;
constexpr double least_damping = 1e-13;
/// Beyond this a step is a millionth of one down the gradient: E is at a minimum up to rounding.
constexpr double most_damping = 1e6;
/// Times that a step is halved if E does not fall, before it is damped: an evaluation costs
/// far less than the factorisation that more damping asks for.
constexpr int halvings = 3;
/// Unknowns from which nested dissection, slower to find, saves more in the factorisations.
constexpr std::size_t many_unknowns = 4000;

} // namespace

/// Gradient and Gauss-Newton matrix J^T J (the factor 2 of both left out).
struct GaussNewton::Linearisation
{
    SparseMatrix matrix;
    VectorXd gradient;
};

GaussNewton::GaussNewton(const Topology& topology, const GradedUnknowns& unknowns)
    : topology_(topology), vertices_(unknowns.vertices)
{
    find_pattern(unknowns.rows);
}

/// @param rows  Per vertex, the unknown translations that move it.
void GaussNewton::find_pattern(const std::vector<std::vector<int>>& rows)
{
    const auto size = static_cast<int>(vertices_.size());
    carried_begin_.assign(to_size(size) + 1, 0);
    for (const std::vector<int>& of_vertex : rows)
        for (const int r : of_vertex)
            ++carried_begin_[to_size(r) + 1];
    for (std::size_t r = 0; r < to_size(size); ++r)
        carried_begin_[r + 1] += carried_begin_[r];
    carried_.resize(to_size(carried_begin_.back()));
    std::vector<int> next = carried_begin_;
    for (std::size_t v = 0; v < rows.size(); ++v)
        for (const int r : rows[v])
            carried_[to_size(next[to_size(r)]++)] = static_cast<int>(v);

    for (const int v : vertices_)
        for (const int h : topology_.outgoing(v))
            for (const int side : {h, Topology::next(h), Topology::previous(h)})
                edges_.push_back(topology_.edge(side));
    std::sort(edges_.begin(), edges_.end());
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());

    std::vector<std::pair<int, int>> blocks; // column, row
    for (const int e : edges_) {
        part_begin_.push_back(static_cast<int>(parts_.size()));
        const std::array<int, 4> hinge = hinge_corners(topology_, e);
        std::map<int, unsigned> moved;
        for (std::size_t a = 0; a < 4; ++a)
            if (hinge[a] >= 0)
                for (const int r : rows[to_size(hinge[a])])
                    moved[r] |= 1u << a;
        const unsigned all = hinge[3] < 0 ? 7u : 15u;
        for (const auto& [r, bits] : moved)
            if (bits != all) // a translation of the whole hinge changes nothing
                parts_.push_back({r, bits});
        for (auto j = to_size(part_begin_.back()); j < parts_.size(); ++j)
            for (std::size_t i = j; i < parts_.size(); ++i)
                blocks.emplace_back(parts_[j].row, parts_[i].row);
    }
    part_begin_.push_back(static_cast<int>(parts_.size()));
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());

    block_begin_.assign(to_size(size) + 1, 0);
    for (const auto& [column, block_row] : blocks) {
        ++block_begin_[to_size(column) + 1];
        block_row_.push_back(block_row);
    }
    for (std::size_t j = 0; j < to_size(size); ++j)
        block_begin_[j + 1] += block_begin_[j];

    pattern_.resize(3 * size, 3 * size);
    pattern_.resizeNonZeros(9 * static_cast<Eigen::Index>(blocks.size()));
    int entry = 0;
    for (int j = 0; j < size; ++j)
        for (int c = 0; c < 3; ++c) {
            pattern_.outerIndexPtr()[3 * j + c] = entry;
            for (int k = block_begin_[to_size(j)]; k < block_begin_[to_size(j) + 1]; ++k)
                for (int r = 0; r < 3; ++r)
                    pattern_.innerIndexPtr()[entry++] = 3 * block_row_[to_size(k)] + r;
        }
    pattern_.outerIndexPtr()[3 * size] = entry;
    std::fill_n(pattern_.valuePtr(), entry, 0.0);
}

double GaussNewton::evaluate(const LengthDihedralEnergy& energy, const VectorXd& points,
                             double stiffness, Linearisation* linearisation) const
{
    const ShapePoint& target = energy.target();
    const auto point = [&](int v) { return vector3(points.data() + 3 * v); };
    // Adds J^T J of one residual of a hinge whose derivatives by the hinge's vertices are g.
    std::vector<Vector3d> by_part;
    const auto add = [&](std::size_t i, const std::array<Vector3d, 4>& g, double weight,
                         double residual) {
        const Part* const parts = parts_.data() + part_begin_[i];
        const auto count = to_size(part_begin_[i + 1] - part_begin_[i]);
        by_part.assign(count, Vector3d::Zero());
        for (std::size_t p = 0; p < count; ++p)
            for (std::size_t a = 0; a < 4; ++a)
                if ((parts[p].moved & 1u << a) != 0)
                    by_part[p] += g[a];
        for (std::size_t q = 0; q < count; ++q) {
            const int column = parts[q].row;
            linearisation->gradient.segment<3>(3 * column) += weight * residual * by_part[q];
            const auto begin = block_begin_[to_size(column)];
            const auto end = block_begin_[to_size(column) + 1];
            for (std::size_t p = q; p < count; ++p) {
                const auto k = std::lower_bound(block_row_.begin() + begin,
                                                block_row_.begin() + end, parts[p].row) -
                               block_row_.begin();
                double* values = linearisation->matrix.valuePtr() + 9 * begin + 3 * (k - begin);
                for (int c = 0; c < 3; ++c, values += 3 * (end - begin))
                    for (int r = 0; r < 3; ++r)
                        values[r] += weight * by_part[p][r] * by_part[q][c];
            }
        }
    };
    if (linearisation != nullptr) {
        linearisation->matrix = pattern_;
        linearisation->gradient = VectorXd::Zero(pattern_.rows());
    }
    double sum = 0.0;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
        const int e = edges_[i];
        const std::array<int, 4> hinge = hinge_corners(topology_, e);
        const Vector3<double> a = point(hinge[0]);
        const Vector3<double> edge = point(hinge[1]) - a;
        const double length = std::sqrt(dot(edge, edge));
        const double strain = length / target.edge_lengths[e] - 1.0;
        const auto [value, weight] = stretch_term(stiffness * strain);
        sum += value / (stiffness * stiffness);
        const Vector3d along =
            length > 0.0 ? Vector3d(eigen(edge) / length) : Vector3d(Vector3d::Zero());
        if (linearisation != nullptr) {
            const Vector3d pull = along / target.edge_lengths[e];
            add(i, {-pull, pull, Vector3d::Zero(), Vector3d::Zero()}, weight, strain);
        }
        if (hinge[3] < 0)
            continue;
        const Vector3<double> c = point(hinge[2]) - a;
        const Vector3<double> d = point(hinge[3]) - a;
        const HingeNormals<double> normals = hinge_normals(edge, c, d);
        const double angle = angle_of(hinge_angle(edge, length, normals.left, normals.right));
        const double bend = wrapped_angle(angle - target.dihedral_angles[e]);
        const double bend_weight = energy.bend_weights()[e];
        sum += bend_weight * bend * bend;
        Vector3d left = eigen(normals.left);
        Vector3d right = eigen(normals.right);
        if (linearisation == nullptr || left.squaredNorm() == 0.0 || right.squaredNorm() == 0.0)
            continue;
        left /= left.squaredNorm();
        right /= right.squaredNorm();
        const HingeShares<double> of_left = hinge_shares(length, eigen(c).dot(along));
        const HingeShares<double> of_right = hinge_shares(length, eigen(d).dot(along));
        add(i,
            {of_left.a * left + of_right.a * right, of_left.b * left + of_right.b * right,
             of_left.c * left, of_right.c * right},
            bend_weight, bend);
    }
    return sum;
}

void check(const GaussNewtonOptions& options)
{
    require_at_least(0, options.max_iterations, "GaussNewtonOptions.max_iterations");
    require_not_negative(options.decrease_tolerance, "GaussNewtonOptions.decrease_tolerance");
    require_positive(options.stiffness, "GaussNewtonOptions.stiffness");
}

GaussNewtonResult GaussNewton::minimize(const LengthDihedralEnergy& energy, VectorXd points,
                                        const GaussNewtonOptions& options,
                                        std::optional<SparseCholesky>* kept) const
{
    check(options);
    GaussNewtonResult result{std::move(points), 0.0, 0, false};
    Linearisation linear;
    result.value = evaluate(energy, result.points, options.stiffness, &linear);
    if (!std::isfinite(result.value))
        throw NumericalError("Gauss-Newton: the energy is not finite at the start");
    double damping = first_damping;
    std::optional<SparseCholesky> own;
    std::optional<SparseCholesky>& factor = kept != nullptr ? *kept : own;
    while (!result.converged && result.iterations < options.max_iterations) {
        ++result.iterations;
        SparseMatrix damped = linear.matrix;
        damped.diagonal() *= 1.0 + damping;
        damped.diagonal().array() += 1e-300; // where nothing pulls, nothing moves
        try {
            if (factor)
                factor->refactor(damped);
            else
                factor.emplace(damped, vertices_.size() > many_unknowns ? Ordering::NestedDissection
                                                                        : Ordering::MinimumDegree);
        } catch (const NumericalError&) { // too little damping for the digits there are
            damping *= 100.0;
            if (damping > most_damping)
                throw;
            continue;
        }
        const VectorXd step = factor->solve(linear.gradient);
        VectorXd next;
        double value = 0.0;
        double scale = 1.0;
        for (int halving = 0; halving <= halvings; ++halving, scale *= 0.5) {
            next = result.points;
            for (std::size_t i = 0; i < vertices_.size(); ++i)
                for (int k = carried_begin_[i]; k < carried_begin_[i + 1]; ++k)
                    next.segment<3>(3 * carried_[to_size(k)]) -=
                        scale * step.segment<3>(3 * static_cast<Eigen::Index>(i));
            value = evaluate(energy, next, options.stiffness, nullptr);
            if (value < result.value)
                break;
        }
        if (value < result.value) {
            result.converged = result.value - value <= options.decrease_tolerance * value;
            result.points = std::move(next);
            result.value = value;
            if (!result.converged)
                result.value = evaluate(energy, result.points, options.stiffness, &linear);
            // Down slowly and up fast, as is the custom with this method (Levenberg 1944, Marquardt 1963): a
            // failed step costs a factorisation.
            damping = std::max(0.2 * damping, least_damping);
        } else {
            damping *= 10.0;
            if (damping > most_damping) { // no step is short enough: a minimum up to rounding
                result.converged = true;
            }
        }
    }
    return result;
}

} // namespace shape::internal
