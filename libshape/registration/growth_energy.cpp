// SPDX-License-Identifier: MIT

#include "libshape/registration/growth_energy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/energy/stretch_term.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/vertex_normals.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t grain = 1024; // vertices a task: some 10 us of work, a fixed order of sums

/// The sum of the products of all four lanes.
double dot(const LaneVectors& a, const LaneVectors& b)
{
    return parallel_sum(to_size(a.cols()), grain, [&](std::size_t begin, std::size_t end) {
        double sum = 0.0;
        for (auto i = static_cast<Index>(begin); i < static_cast<Index>(end); ++i)
            sum += static_cast<double>(a.col(i).dot(b.col(i)));
        return sum;
    });
}

template <class Matrix, class Vector>
auto times(const Matrix& m, const Vector& v)
{
    return Vector(m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[1] * v[0] + m[3] * v[1] + m[4] * v[2],
                  m[2] * v[0] + m[4] * v[1] + m[5] * v[2]);
}

VectorXd row_by_row(const Points& points)
{
    return VectorXd::Map(points.data(), points.size());
}

/// Of the Laplacian of the edges with these weights, plus a diagonal.
SparseMatrix laplacian_of(const Topology& topology, const VectorXd& weights, const VectorXd& added)
{
    std::vector<Eigen::Triplet<double>> entries;
    VectorXd diagonal = VectorXd::Zero(added.size());
    for (int e = 0; e < topology.edge_count(); ++e) {
        const int i = topology.edges()(e, 0), j = topology.edges()(e, 1);
        diagonal[i] += weights[e];
        diagonal[j] += weights[e];
        entries.emplace_back(std::max(i, j), std::min(i, j), -weights[e]);
    }
    for (int v = 0; v < added.size(); ++v) // about 1e-6 of it holds what nothing pulls
        entries.emplace_back(v, v, (1.0 + 1e-6) * diagonal[v] + added[v]);
    SparseMatrix matrix(added.size(), added.size());
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

} // namespace

void check(const GrowthOptions& options)
{
    require_positive(options.smoothness, "GrowthOptions.smoothness");
    require_positive(options.growth_smoothness, "GrowthOptions.growth_smoothness");
    require_positive(options.stiffness, "GrowthOptions.stiffness");
}

GrowthEnergy::GrowthEnergy(const Topology& topology, const ShapePoint& rest,
                           const GrowthOptions& options)
    : topology_(topology),
      options_((check(options), options)),
      rest_lengths_(rest.edge_lengths),
      unit_(rest_lengths_.mean()),
      energy_(topology, rest, options.smoothness),
      operator_(energy_),
      directions_(4, topology.edge_count()),
      growth_slopes_(to_size(topology.edge_count()))
{
    energy_.stiffen(options.stiffness);
    clear_pulls(Points::Zero(topology.vertex_count(), 3));
}

void GrowthEnergy::clear_pulls(const Points& points)
{
    pulled_from_ = row_by_row(points);
    pulls_.setZero(6, topology_.vertex_count());
    pull_sides_.setZero(topology_.vertex_count(), 3);
    pull_value_ = 0.0;
}

void GrowthEnergy::add_pull(int vertex, const Vector3d& direction, double distance, double weight)
{
    const double r = distance / unit_;
    const Vector3d& a = direction;
    Eigen::Matrix<double, 6, 1> square;
    square << a[0] * a[0], a[0] * a[1], a[0] * a[2], a[1] * a[1], a[1] * a[2], a[2] * a[2];
    pulls_.col(vertex) += weight * square;
    pull_sides_.row(vertex) += weight * r * a.transpose();
    pull_value_ += weight * r * r;
}

VectorXd GrowthEnergy::wanted_lengths(const VectorXd& growth) const
{
    VectorXd lengths(rest_lengths_.size());
    for (int e = 0; e < lengths.size(); ++e)
        lengths[e] =
            rest_lengths_[e] *
            std::exp(0.5 * (growth[topology_.edges()(e, 0)] + growth[topology_.edges()(e, 1)]));
    return lengths;
}

VectorXd GrowthEnergy::strains(const Points& points, const VectorXd& growth) const
{
    return edge_lengths(topology_, points).cwiseQuotient(wanted_lengths(growth)).array() - 1.0;
}

double GrowthEnergy::evaluate(const VectorXd& points, const VectorXd& growth, Gradient& gradient)
{
    energy_.want_lengths(wanted_lengths(growth));
    double value = energy_.evaluate(points, gradient.points) + pull_value_;
    gradient.growth.setZero(growth.size());
    const double gamma = options_.growth_smoothness;
    for (int e = 0; e < topology_.edge_count(); ++e) {
        const int i = topology_.edges()(e, 0), j = topology_.edges()(e, 1);
        const double strain = energy_.lengths()[e] / energy_.target().edge_lengths[e] - 1.0;
        const double by_growth =
            -stretch_term(options_.stiffness * strain).weight * strain * (1.0 + strain);
        const double step = growth[i] - growth[j];
        gradient.growth[i] += by_growth + 2.0 * gamma * step;
        gradient.growth[j] += by_growth - 2.0 * gamma * step;
        value += gamma * step * step;
    }
    for (int v = 0; v < topology_.vertex_count(); ++v) {
        const Vector3d moved = (points.segment<3>(3 * v) - pulled_from_.segment<3>(3 * v)) / unit_;
        const Vector3d pulled = times(pulls_.col(v), moved);
        const Vector3d side = pull_sides_.row(v);
        value += moved.dot(pulled) - 2.0 * side.dot(moved);
        gradient.points.segment<3>(3 * v) += 2.0 * (pulled - side) / unit_;
    }
    return value;
}

void GrowthEnergy::linearise(const VectorXd& points)
{
    operator_.linearise(points);
    for (int e = 0; e < topology_.edge_count(); ++e) {
        const double length = energy_.lengths()[e], wanted = energy_.target().edge_lengths[e];
        const double strain = length / wanted - 1.0;
        const double root = std::sqrt(stretch_term(options_.stiffness * strain).weight);
        const Vector3d along = points.segment<3>(3 * topology_.edges()(e, 1)) -
                               points.segment<3>(3 * topology_.edges()(e, 0));
        const double scale = length > 0.0 ? root * unit_ / (length * wanted) : 0.0;
        directions_.col(e) << (scale * along).cast<float>(), 0.0F;
        growth_slopes_[to_size(e)] = static_cast<float>(0.5 * root * (1.0 + strain));
    }
    single_pulls_ = pulls_.cast<float>();
}

void GrowthEnergy::apply(const LaneVectors& v, LaneVectors& product)
{
    (void)operator_.apply(v, product); // which leaves the fourth lane alone
    const auto gamma = static_cast<float>(options_.growth_smoothness);
    parallel_for(to_size(topology_.vertex_count()), grain, [&](std::size_t begin, std::size_t end) {
        for (int i = static_cast<int>(begin); i < static_cast<int>(end); ++i) {
            const Eigen::Vector4f here = v.col(i);
            Eigen::Vector4f force = product.col(i);
            force[3] = 0.0F;
            for (const Topology::Spoke& spoke : topology_.spokes(i)) {
                const Eigen::Vector4f there = v.col(spoke.vertex);
                const float slope = growth_slopes_[to_size(spoke.edge)];
                const float grown = slope * (here[3] + there[3]);
                const float sign = topology_.edges()(spoke.edge, 0) == i ? 1.0F : -1.0F;
                const Eigen::Vector3f direction = sign * directions_.col(spoke.edge).head<3>();
                const float stretched = direction.dot(there.head<3>() - here.head<3>());
                force.head<3>() += grown * direction;
                force[3] += gamma * (here[3] - there[3]) - slope * (stretched - grown);
            }
            force.head<3>() += times(single_pulls_.col(i), Eigen::Vector3f(here.head<3>()));
            product.col(i) = force;
        }
    });
}

SinglePrecisionSolve GrowthEnergy::factor_of(const VectorXd& weights, const VectorXd& added)
{
    const SparseMatrix matrix = laplacian_of(topology_, weights, added);
    if (cholesky_)
        cholesky_->refactor(matrix);
    else
        cholesky_.emplace(matrix);
    return SinglePrecisionSolve(*cholesky_);
}

void GrowthEnergy::prepare()
{
    const VectorXd weights =
        (rest_lengths_ / unit_).cwiseMax(1e-3).array().square().inverse().matrix(); // floats
    if (options_.slides_freely)
        prepare_to_slide(weights);
    else
        preconditioner_ =
            factor_of(weights, ((pulls_.row(0) + pulls_.row(3) + pulls_.row(5)) / 3.0).transpose());
}

void GrowthEnergy::prepare_to_slide(const VectorXd& weights)
{
    const int count = topology_.vertex_count();
    const Points normals =
        vertex_normals(Points::Map(pulled_from_.data(), count, 3), topology_.faces());
    to_lanes(normals.data(), count, 1.0, normals_);
    VectorXd across(count), along(count);
    for (int v = 0; v < count; ++v) {
        const Vector3d n = normals.row(v);
        across[v] = n.dot(times(pulls_.col(v), n));
        along[v] = 0.5 * std::max(0.0, pulls_(0, v) + pulls_(3, v) + pulls_(5, v) - across[v]);
    }
    across_ = factor_of(weights, across);
    along_ = factor_of(weights, along);
    if (growing_)
        return;
    VectorXd by_strains = VectorXd::Zero(count); // of u, at no strain
    for (int e = 0; e < topology_.edge_count(); ++e)
        for (const int v : topology_.edges().row(e))
            by_strains[v] += 0.5;
    growing_ = factor_of(VectorXd::Constant(topology_.edge_count(), options_.growth_smoothness),
                         by_strains);
}

double GrowthEnergy::precondition(const LaneVectors& rhs, LaneVectors& solution)
{
    if (!options_.slides_freely) {
        (void)preconditioner_->solve(rhs, solution, workspace_);
        return dot(rhs, solution);
    }
    const Index count = rhs.cols();
    solution.resize(4, count);
    part_.setZero(4, count);
    for (Index v = 0; v < count; ++v)
        part_(0, v) = normals_.col(v).dot(rhs.col(v));
    (void)across_->solve(part_, solved_, workspace_);
    for (Index v = 0; v < count; ++v) {
        const Eigen::Vector4f n = normals_.col(v);
        solution.col(v) = solved_(0, v) * n;
        part_.col(v) = rhs.col(v) - part_(0, v) * n;
    }
    part_.row(3).setZero();
    (void)along_->solve(part_, solved_, workspace_);
    for (Index v = 0; v < count; ++v) {
        const Eigen::Vector4f n = normals_.col(v);
        solution.col(v) += solved_.col(v) - n.dot(solved_.col(v)) * n;
    }
    part_.setZero();
    part_.row(0) = rhs.row(3);
    (void)growing_->solve(part_, solved_, workspace_);
    solution.row(3) = solved_.row(0);
    return dot(rhs, solution);
}

double GrowthEnergy::step(Points& points, VectorXd& growth, int linear_steps)
{
    const VectorXd start = row_by_row(points);
    Gradient gradient;
    const double value = evaluate(start, growth, gradient);
    linearise(start);
    const Index count = points.rows();
    LaneVectors residual(4, count), move = LaneVectors::Zero(4, count);
    for (Index i = 0; i < count; ++i)
        residual.col(i) << (-0.5 * unit_ * gradient.points.segment<3>(3 * i)).cast<float>(),
            static_cast<float>(-0.5 * gradient.growth[i]);
    LaneVectors direction, image, preconditioned;
    double square = 1.0, first_square = 0.0;
    for (int k = 0; k < linear_steps; ++k) {
        const double last_square = std::exchange(square, precondition(residual, preconditioned));
        if (k == 0)
            first_square = square;
        if (!(square > 1e-8 * first_square)) // 1e-4 of the residual: what floats can tell
            break;
        if (k == 0)
            direction = preconditioned;
        else
            direction = preconditioned + static_cast<float>(square / last_square) * direction;
        apply(direction, image);
        const double curvature = dot(direction, image);
        if (!(curvature > 0.0))
            break;
        const auto length = static_cast<float>(square / curvature);
        move += length * direction;
        residual -= length * image;
    }
    double scale = 1.0;
    for (int halvings = 0; halvings < 6; ++halvings, scale *= 0.5) {
        VectorXd next = start;
        VectorXd next_growth = growth;
        for (Index i = 0; i < count; ++i) {
            next.segment<3>(3 * i) += scale * unit_ * move.col(i).head<3>().cast<double>();
            next_growth[i] += scale * static_cast<double>(move(3, i));
        }
        const double next_value = evaluate(next, next_growth, gradient);
        if (next_value < value) {
            points = Points::Map(next.data(), count, 3);
            growth = next_growth;
            return next_value;
        }
    }
    return value;
}

} // namespace shape::internal
