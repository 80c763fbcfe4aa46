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
/// Times that a step is halved at most, before it is damped: an evaluation costs far less than the
/// factorisation that more damping asks for.
constexpr int step_halvings = 3;
/// A step is not halved if E falls by this part of what its linear model promises.
constexpr double good_part = 0.7;
/// Residuals are looked at this far ahead along a step and behind, to find how they curve.
constexpr double look_ahead = 0.1;
/// Unknowns from which nested dissection, slower to find, saves more in the factorisations.
constexpr std::size_t many_unknowns = 4000;

/// What a line search has found.
struct Taken
{
    VectorXd points; ///< Empty if `part` is 0.
    double value;    ///< E there.
    double part;     ///< Of the step; 0: E falls nowhere.
};

/// Halves a step, step_halvings times at most, until E falls by good_part of what is promised, or no further than the
/// step before made it fall: then that is taken.
/// @param value  E before the step.
/// @param promised  How far its linear model lets E fall at the whole step.
/// @param points_at  The points at a part of the step.
/// @param value_at  E at some points.
template <typename PointsAt, typename ValueAt>
Taken halved_until_good(double value, double promised, const PointsAt& points_at,
                        const ValueAt& value_at)
{
    Taken best{{}, value, 0.0};
    double scale = 1.0;
    for (int halving = 0; halving <= step_halvings; ++halving, scale *= 0.5) {
        VectorXd tried = points_at(scale);
        const double there = value_at(tried);
        if (!(there < best.value)) {
            if (best.part > 0.0)
                break;
            continue;
        }
        best = {std::move(tried), there, scale};
        if (value - there >= good_part * promised)
            break;
    }
    return best;
}

} // namespace

/// Of the edges: relative errors of lengths, and of the angles [rad], 0 on the boundary.
struct GaussNewton::Residuals
{
    VectorXd strains;
    VectorXd bends;
    double value = 0.0; ///< E.

    /// The second differences of strains and bends between those ahead and behind along a step.
    [[nodiscard]] Residuals curving(const Residuals& ahead, const Residuals& behind) const
    {
        Residuals result{(ahead.strains - 2.0 * strains + behind.strains), VectorXd(bends.size()),
                         0.0};
        for (Eigen::Index i = 0; i < result.bends.size(); ++i)
            result.bends[i] = wrapped_angle(ahead.bends[i] - bends[i]) +
                              wrapped_angle(behind.bends[i] - bends[i]);
        return result;
    }
};

/// Their derivatives by the corners of the hinges, and weights: J and W.
struct GaussNewton::Slopes
{
    struct Hinge
    {
        Vector3d pull; ///< Of the strain by b; by a its negative.
        double stretch_weight = 0.0;
        std::array<Vector3d, 4> turns; ///< Of the angle by a, b, c, d.
        double bend_weight = 0.0;
    };
    std::vector<Hinge> hinges;
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

    for (std::size_t i = 0; i < edges_.size(); ++i)
        for (int q = part_begin_[i]; q < part_begin_[i + 1]; ++q)
            for (int p = q; p < part_begin_[i + 1]; ++p) {
                const auto column = to_size(parts_[to_size(q)].row);
                const int begin = block_begin_[column];
                const auto k = std::lower_bound(block_row_.begin() + begin,
                                                block_row_.begin() + block_begin_[column + 1],
                                                parts_[to_size(p)].row) -
                               block_row_.begin();
                pair_value_.push_back(9 * begin + 3 * (static_cast<int>(k) - begin));
            }
}

GaussNewton::Residuals GaussNewton::evaluate(const LengthDihedralEnergy& energy,
                                             const VectorXd& points, double stiffness,
                                             Slopes* slopes) const
{
    const ShapePoint& target = energy.target();
    const auto point = [&](int v) { return vector3(points.data() + 3 * v); };
    const auto count = static_cast<Eigen::Index>(edges_.size());
    Residuals residuals{VectorXd(count), VectorXd::Zero(count), 0.0};
    if (slopes != nullptr)
        slopes->hinges.resize(edges_.size());
    for (std::size_t i = 0; i < edges_.size(); ++i) {
        const int e = edges_[i];
        const std::array<int, 4> hinge = hinge_corners(topology_, e);
        const Vector3<double> a = point(hinge[0]);
        const Vector3<double> edge = point(hinge[1]) - a;
        const double length = std::sqrt(dot(edge, edge));
        const double strain = length / target.edge_lengths[e] - 1.0;
        const auto [value, weight] = stretch_term(stiffness * strain);
        residuals.strains[static_cast<Eigen::Index>(i)] = strain;
        residuals.value += value / (stiffness * stiffness);
        const Vector3d along =
            length > 0.0 ? Vector3d(eigen(edge) / length) : Vector3d(Vector3d::Zero());
        if (slopes != nullptr)
            slopes->hinges[i] = {
                along / target.edge_lengths[e],
                weight,
                {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()},
                0.0};
        if (hinge[3] < 0)
            continue;
        const Vector3<double> c = point(hinge[2]) - a;
        const Vector3<double> d = point(hinge[3]) - a;
        const HingeNormals<double> normals = hinge_normals(edge, c, d);
        const double angle = angle_of(hinge_angle(edge, length, normals.left, normals.right));
        const double bend = wrapped_angle(angle - target.dihedral_angles[e]);
        const double bend_weight = energy.bend_weights()[e];
        residuals.bends[static_cast<Eigen::Index>(i)] = bend;
        residuals.value += bend_weight * bend * bend;
        Vector3d left = eigen(normals.left);
        Vector3d right = eigen(normals.right);
        if (slopes == nullptr || left.squaredNorm() == 0.0 || right.squaredNorm() == 0.0)
            continue;
        left /= left.squaredNorm();
        right /= right.squaredNorm();
        const HingeShares<double> of_left = hinge_shares(length, eigen(c).dot(along));
        const HingeShares<double> of_right = hinge_shares(length, eigen(d).dot(along));
        slopes->hinges[i].turns = {of_left.a * left + of_right.a * right,
                                   of_left.b * left + of_right.b * right, of_left.c * left,
                                   of_right.c * right};
        slopes->hinges[i].bend_weight = bend_weight;
    }
    return residuals;
}

/// J^T W r by the unknowns: of the residuals at a point half the gradient of E.
VectorXd GaussNewton::forces(const Slopes& slopes, const Residuals& residuals) const
{
    VectorXd forces = VectorXd::Zero(pattern_.rows());
    for (std::size_t i = 0; i < edges_.size(); ++i) {
        const Slopes::Hinge& hinge = slopes.hinges[i];
        const auto row = static_cast<Eigen::Index>(i);
        const double bend = hinge.bend_weight * residuals.bends[row];
        std::array<Vector3d, 4> at = hinge.turns;
        for (Vector3d& force : at)
            force *= bend;
        const Vector3d pull = hinge.stretch_weight * residuals.strains[row] * hinge.pull;
        at[0] -= pull;
        at[1] += pull;
        for (int p = part_begin_[i]; p < part_begin_[i + 1]; ++p)
            for (std::size_t a = 0; a < 4; ++a)
                if ((parts_[to_size(p)].moved & 1u << a) != 0)
                    forces.segment<3>(3 * parts_[to_size(p)].row) += at[a];
    }
    return forces;
}

/// The values of J^T W J.
void GaussNewton::fill(const Slopes& slopes, SparseMatrix& matrix) const
{
    std::fill_n(matrix.valuePtr(), matrix.nonZeros(), 0.0);
    std::vector<Vector3d> pulls; // of the parts of a hinge
    std::vector<Vector3d> turns;
    std::size_t pair = 0;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
        const Slopes::Hinge& hinge = slopes.hinges[i];
        const Part* const parts = parts_.data() + part_begin_[i];
        const auto count = to_size(part_begin_[i + 1] - part_begin_[i]);
        pulls.assign(count, Vector3d::Zero());
        turns.assign(count, Vector3d::Zero());
        for (std::size_t p = 0; p < count; ++p) {
            for (std::size_t a = 0; a < 4; ++a)
                if ((parts[p].moved & 1u << a) != 0)
                    turns[p] += hinge.turns[a];
            const bool moves_a = (parts[p].moved & 1u) != 0;
            const bool moves_b = (parts[p].moved & 2u) != 0;
            if (moves_a != moves_b)
                pulls[p] = moves_b ? hinge.pull : Vector3d(-hinge.pull);
        }
        for (std::size_t q = 0; q < count; ++q) {
            const auto column = to_size(parts[q].row);
            const int stride = 3 * (block_begin_[column + 1] - block_begin_[column]);
            const Vector3d pull = hinge.stretch_weight * pulls[q];
            const Vector3d turn = hinge.bend_weight * turns[q];
            for (std::size_t p = q; p < count; ++p) {
                double* values = matrix.valuePtr() + pair_value_[pair++];
                for (int c = 0; c < 3; ++c, values += stride)
                    for (int r = 0; r < 3; ++r)
                        values[r] += pull[c] * pulls[p][r] + turn[c] * turns[p][r];
            }
        }
    }
}

/// The points - scale * step.
VectorXd GaussNewton::moved(VectorXd points, double scale, const VectorXd& step) const
{
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
        const Vector3d by = scale * step.segment<3>(3 * static_cast<Eigen::Index>(i));
        for (int k = carried_begin_[i]; k < carried_begin_[i + 1]; ++k)
            points.segment<3>(3 * carried_[to_size(k)]) -= by;
    }
    return points;
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
    GaussNewtonResult result{std::move(points), 0.0, 0, false, 0.0};
    const auto residuals_at = [&](const VectorXd& at) {
        return evaluate(energy, at, options.stiffness, nullptr);
    };
    Slopes slopes;
    Residuals residuals = evaluate(energy, result.points, options.stiffness, &slopes);
    result.value = residuals.value;
    if (!std::isfinite(result.value))
        throw NumericalError("Gauss-Newton: the energy is not finite at the start");
    SparseMatrix matrix = pattern_;
    fill(slopes, matrix);
    VectorXd diagonal = matrix.diagonal();
    double damping = first_damping;
    std::optional<SparseCholesky> own;
    std::optional<SparseCholesky>& factor = kept != nullptr ? *kept : own;
    while (!result.converged && result.iterations < options.max_iterations) {
        ++result.iterations;
        matrix.diagonal() = (1.0 + damping) * diagonal;
        matrix.diagonal().array() += 1e-300; // where nothing pulls, nothing moves
        try {
            if (factor)
                factor->refactor(matrix);
            else
                factor.emplace(matrix, vertices_.size() > many_unknowns ? Ordering::NestedDissection
                                                                        : Ordering::MinimumDegree);
        } catch (const NumericalError&) { // too little damping for the digits there are
            damping *= 100.0;
            if (damping > most_damping)
                throw;
            continue;
        }
        const VectorXd gradient = forces(slopes, residuals);
        const VectorXd step = factor->solve(gradient);
        const Residuals ahead = residuals_at(moved(result.points, look_ahead, step));
        const Residuals behind = residuals_at(moved(result.points, -look_ahead, step));
        const Residuals curving = residuals.curving(ahead, behind);
        const VectorXd acceleration =
            factor->solve(forces(slopes, curving)) / (look_ahead * look_ahead);

        Taken taken = halved_until_good(
            result.value, gradient.dot(step),
            [&](double scale) {
                return moved(moved(result.points, scale, step), 0.5 * scale * scale, acceleration);
            },
            [&](const VectorXd& at) { return residuals_at(at).value; });
        result.last_step = taken.part;
        if (result.last_step > 0.0) {
            result.converged =
                result.value - taken.value <= options.decrease_tolerance * taken.value;
            result.points = std::move(taken.points);
            result.value = taken.value;
            if (!result.converged && result.iterations < options.max_iterations) {
                residuals = evaluate(energy, result.points, options.stiffness, &slopes);
                fill(slopes, matrix);
                diagonal = matrix.diagonal();
            }
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
