// SPDX-License-Identifier: MIT

#include "libshape/edge_space/safe_range.h"

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double never = std::numeric_limits<double>::infinity();

/// Where a linear function that is `value` at 0 first becomes <= 0.
double first_zero(double value, double slope)
{
    if (value <= 0.0)
        return 0.0;
    return slope < 0.0 ? value / -slope : never;
}

/// Where c + b s + a s^2 first becomes <= 0, for s >= 0.
double first_zero(double c, double b, double a)
{
    if (c <= 0.0)
        return 0.0;
    const double discriminant = b * b - 4.0 * a * c;
    if (discriminant < 0.0)
        return never;
    // The roots are 2 c / q and q / (2 a), neither with cancellation.
    const double q = -b - std::copysign(std::sqrt(discriminant), b);
    const double first = q > 0.0 ? 2.0 * c / q : never;
    const double second = q * a > 0.0 ? q / (2.0 * a) : never;
    return std::min(first, second);
}

double plain_reach(const Vector3d& sides, const Vector3d& change)
{
    double reach = never;
    for (int i = 0; i < 3; ++i)
        reach = std::min(reach,
                         first_zero(sides.sum() - 2.0 * sides[i], change.sum() - 2.0 * change[i]));
    return reach;
}

/// The symmetric form with form(s, s) = 16 times the squared area of a triangle with squared sides s.
double area_form(const Vector3d& s, const Vector3d& t)
{
    return s.sum() * t.sum() - 2.0 * s.dot(t);
}

double squared_reach(const Vector3d& sides, const Vector3d& change)
{
    // Before a squared side reaches 0 the area has: there, form(s, s) = -(difference of the others)^2.
    if (!(sides.minCoeff() > 0.0))
        return 0.0;
    return first_zero(area_form(sides, sides), 2.0 * area_form(sides, change),
                      area_form(change, change));
}

void check(const VectorXd& weights, Eigen::Index meshes, const char* name)
{
    if (weights.size() != meshes)
        throw InvalidInput(join(name, " has ", weights.size(), " entries for ", meshes, " meshes"));
    if (!weights.allFinite())
        throw InvalidInput(join(name, " has an entry that is not finite"));
}

} // namespace

SafeReach safe_reach(const Topology& topology, const ShapeVectors& vectors, const VectorXd& start,
                     const VectorXd& direction, LengthBlend lengths)
{
    check(start, vectors.edge_lengths.rows(), "start");
    check(direction, vectors.edge_lengths.rows(), "direction");
    if (vectors.edge_lengths.cols() != topology.edge_count())
        throw InvalidInput(join("the vectors have ", vectors.edge_lengths.cols(),
                                " edges, the topology ", topology.edge_count()));
    const bool plain = lengths == LengthBlend::Plain;
    const auto combine = [&](const VectorXd& weights) -> VectorXd {
        if (plain)
            return vectors.edge_lengths.transpose() * weights;
        return vectors.edge_lengths.cwiseAbs2().transpose() * weights;
    };
    const VectorXd sides = combine(start);
    const VectorXd changes = combine(direction);
    SafeReach result;
    for (int f = 0; f < topology.face_count(); ++f) {
        const auto edges = topology.face_edges().row(f);
        const Vector3d side = sides(edges);
        const Vector3d change = changes(edges);
        const double reach = plain ? plain_reach(side, change) : squared_reach(side, change);
        if (reach < result.reach)
            result = {reach, f};
    }
    return result;
}

SafeReach safe_reach(const Topology& topology, const ShapeVectors& vectors, const VectorXd& weights,
                     LengthBlend lengths)
{
    check(weights, vectors.edge_lengths.rows(), "weights");
    if (weights.minCoeff() >= 0.0)
        return {};
    const VectorXd positive = weights.cwiseMax(0.0);
    if (!(positive.sum() > 0.0))
        throw InvalidInput("weights has no positive entry");
    const VectorXd start = positive / positive.sum();
    return safe_reach(topology, vectors, start, weights - start, lengths);
}

} // namespace shape
