// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/gauss_newton.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/mesh/dihedral_angles.h"

namespace shape::internal {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Vertices of an edge's hinge: its ends, then those opposite on the left and on the right (-1).
std::array<int, 4> hinge_of(const Topology& topology, int edge)
{
    const int left = topology.edge_halfedges()(edge, 0);
    const int right = topology.edge_halfedges()(edge, 1);
    return {topology.source(left), topology.target(left), topology.source(Topology::previous(left)),
            right < 0 ? -1 : topology.source(Topology::previous(right))};
}

} // namespace

/// Gradient and Gauss-Newton matrix J^T J (the factor 2 of both left out).
struct GaussNewton::Linearisation
{
    SparseMatrix matrix;
    VectorXd gradient;
};

GaussNewton::GaussNewton(const Topology& topology, std::vector<int> vertices)
    : topology_(topology), vertices_(std::move(vertices))
{
    std::sort(vertices_.begin(), vertices_.end());
    std::vector<std::vector<int>> rows(static_cast<std::size_t>(topology.vertex_count()));
    for (std::size_t i = 0; i < vertices_.size(); ++i)
        rows[static_cast<std::size_t>(vertices_[i])] = {static_cast<int>(i)};
    find_pattern(rows);
}

GaussNewton::GaussNewton(const Topology& topology, const GradedUnknowns& unknowns)
    : topology_(topology), vertices_(unknowns.vertices)
{
    find_pattern(unknowns.rows);
}

/// @param rows  Per vertex, the unknown translations that move it.
void GaussNewton::find_pattern(const std::vector<std::vector<int>>& rows)
{
    const auto size = static_cast<int>(vertices_.size());
    carried_begin_.assign(static_cast<std::size_t>(size) + 1, 0);
    for (const std::vector<int>& of_vertex : rows)
        for (const int r : of_vertex)
            ++carried_begin_[static_cast<std::size_t>(r) + 1];
    for (std::size_t r = 0; r < static_cast<std::size_t>(size); ++r)
        carried_begin_[r + 1] += carried_begin_[r];
    carried_.resize(static_cast<std::size_t>(carried_begin_.back()));
    std::vector<int> next = carried_begin_;
    for (std::size_t v = 0; v < rows.size(); ++v)
        for (const int r : rows[v])
            carried_[static_cast<std::size_t>(next[static_cast<std::size_t>(r)]++)] =
                static_cast<int>(v);

    for (const int v : vertices_)
        for (const int h : topology_.outgoing(v))
            for (const int side : {h, Topology::next(h), Topology::previous(h)})
                edges_.push_back(topology_.edge(side));
    std::sort(edges_.begin(), edges_.end());
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());

    std::vector<std::pair<int, int>> blocks; // column, row
    for (const int e : edges_) {
        part_begin_.push_back(static_cast<int>(parts_.size()));
        const std::array<int, 4> hinge = hinge_of(topology_, e);
        std::map<int, unsigned> moved;
        for (std::size_t a = 0; a < 4; ++a)
            if (hinge[a] >= 0)
                for (const int r : rows[static_cast<std::size_t>(hinge[a])])
                    moved[r] |= 1u << a;
        const unsigned all = hinge[3] < 0 ? 7u : 15u;
        for (const auto& [r, bits] : moved)
            if (bits != all) // a translation of the whole hinge changes nothing
                parts_.push_back({r, bits});
        for (auto j = static_cast<std::size_t>(part_begin_.back()); j < parts_.size(); ++j)
            for (std::size_t i = j; i < parts_.size(); ++i)
                blocks.emplace_back(parts_[j].row, parts_[i].row);
    }
    part_begin_.push_back(static_cast<int>(parts_.size()));
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());

    block_begin_.assign(static_cast<std::size_t>(size) + 1, 0);
    for (const auto& [column, block_row] : blocks) {
        ++block_begin_[static_cast<std::size_t>(column) + 1];
        block_row_.push_back(block_row);
    }
    for (std::size_t j = 0; j < static_cast<std::size_t>(size); ++j)
        block_begin_[j + 1] += block_begin_[j];

    pattern_.resize(3 * size, 3 * size);
    pattern_.resizeNonZeros(9 * static_cast<Eigen::Index>(blocks.size()));
    int entry = 0;
    for (int j = 0; j < size; ++j)
        for (int c = 0; c < 3; ++c) {
            pattern_.outerIndexPtr()[3 * j + c] = entry;
            for (int k = block_begin_[static_cast<std::size_t>(j)];
                 k < block_begin_[static_cast<std::size_t>(j) + 1]; ++k)
                for (int r = 0; r < 3; ++r)
                    pattern_.innerIndexPtr()[entry++] =
                        3 * block_row_[static_cast<std::size_t>(k)] + r;
        }
    pattern_.outerIndexPtr()[3 * size] = entry;
    std::fill_n(pattern_.valuePtr(), entry, 0.0);
}

double GaussNewton::evaluate(const LengthDihedralEnergy& energy, const VectorXd& points,
                             double stiffness, Linearisation* linearisation) const
{
    const ShapePoint& target = energy.target();
    const auto point = [&](int v) -> Vector3d { return points.segment<3>(3 * v); };
    // Adds J^T J of one residual of a hinge whose derivatives by the hinge's vertices are g.
    std::vector<Vector3d> by_part;
    const auto add = [&](std::size_t i, const std::array<Vector3d, 4>& g, double weight,
                         double residual) {
        const Part* const parts = parts_.data() + part_begin_[i];
        const auto count = static_cast<std::size_t>(part_begin_[i + 1] - part_begin_[i]);
        by_part.assign(count, Vector3d::Zero());
        for (std::size_t p = 0; p < count; ++p)
            for (std::size_t a = 0; a < 4; ++a)
                if ((parts[p].moved & 1u << a) != 0)
                    by_part[p] += g[a];
        for (std::size_t q = 0; q < count; ++q) {
            const int column = parts[q].row;
            linearisation->gradient.segment<3>(3 * column) += weight * residual * by_part[q];
            const auto begin = block_begin_[static_cast<std::size_t>(column)];
            const auto end = block_begin_[static_cast<std::size_t>(column) + 1];
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
        const std::array<int, 4> hinge = hinge_of(topology_, e);
        const Vector3d a = point(hinge[0]);
        const Vector3d axis = point(hinge[1]) - a;
        const double length = axis.norm();
        const double strain = length / target.edge_lengths[e] - 1.0;
        const auto [value, weight] = stretch_term(stiffness * strain);
        sum += value / (stiffness * stiffness);
        const Vector3d along = length > 0.0 ? Vector3d(axis / length) : Vector3d(Vector3d::Zero());
        if (linearisation != nullptr) {
            const Vector3d pull = along / target.edge_lengths[e];
            add(i, {-pull, pull, Vector3d::Zero(), Vector3d::Zero()}, weight, strain);
        }
        if (hinge[3] < 0)
            continue;
        const Vector3d c = point(hinge[2]) - a;
        const Vector3d d = point(hinge[3]) - a;
        Vector3d left = axis.cross(c);
        Vector3d right = d.cross(axis);
        const double angle = std::atan2(axis.dot(left.cross(right)), length * left.dot(right));
        const double bend = wrapped_angle(angle - target.dihedral_angles[e]);
        const double bend_weight = energy.bend_weights()[e];
        sum += bend_weight * bend * bend;
        if (linearisation == nullptr || left.squaredNorm() == 0.0 || right.squaredNorm() == 0.0)
            continue;
        left /= left.squaredNorm();
        right /= right.squaredNorm();
        const double left_foot = c.dot(along);
        const double right_foot = d.dot(along);
        add(i,
            {(length - left_foot) * left + (length - right_foot) * right,
             left_foot * left + right_foot * right, -length * left, -length * right},
            bend_weight, bend);
    }
    return sum;
}

GaussNewtonResult GaussNewton::minimize(const LengthDihedralEnergy& energy, VectorXd points,
                                        const GaussNewtonOptions& options,
                                        std::optional<SparseCholesky>* kept) const
{
    GaussNewtonResult result{std::move(points), 0.0, 0, false};
    Linearisation linear;
    result.value = evaluate(energy, result.points, options.stiffness, &linear);
    if (!std::isfinite(result.value))
        throw NumericalError("Gauss-Newton: the energy is not finite at the start");
    constexpr double most_damping = 1e6;
    double damping = options.damping;
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
                factor.emplace(damped, vertices_.size() > 4000 ? Ordering::NestedDissection
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
        for (int halving = 0; halving <= options.halvings; ++halving, scale *= 0.5) {
            next = result.points;
            for (std::size_t i = 0; i < vertices_.size(); ++i)
                for (int k = carried_begin_[i]; k < carried_begin_[i + 1]; ++k)
                    next.segment<3>(3 * carried_[static_cast<std::size_t>(k)]) -=
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
            damping = std::max(0.2 * damping, options.least_damping);
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
