// SPDX-License-Identifier: MIT

#include "libshape/edge_space/admissibility.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/corner_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
namespace {

constexpr double angle_rounding = 1e-12; ///< [rad] Sums of angles are rounded by 1e-15.

void check_finite(const Eigen::VectorXd& lengths, const char* argument)
{
    for (Eigen::Index e = 0; e < lengths.size(); ++e)
        if (!std::isfinite(lengths[e]))
            throw InvalidInput(
                join(argument, " of edge ", e, " is ", lengths[e], ", must be finite"));
}

void check_size(const Topology& topology, const Eigen::VectorXd& lengths, const char* argument)
{
    if (lengths.size() != topology.edge_count())
        throw InvalidInput(join(argument, " has ", lengths.size(), " entries, the topology ",
                                topology.edge_count(), " edges"));
    check_finite(lengths, argument);
}

/// Lengths of the sides of a face.
Eigen::Vector3d sides(const Topology& topology, const Eigen::VectorXd& lengths, int face)
{
    const int* const edges = topology.face_edges().data() + 3 * face;
    return {lengths[edges[0]], lengths[edges[1]], lengths[edges[2]]};
}

/// Vertices of which a bound does not show that their largest angle is no larger than the others together. With
/// q = sin(angle / 2) an angle lies in [2 q, pi q], as sines are concave there: it is not, if
///
///     2 (sum of q - largest q) >= pi (largest q).
std::vector<int> vertices_in_doubt(const Topology& topology, const Eigen::VectorXd& lengths)
{
    constexpr double safe = 1.0 + 0.5 * std::numbers::pi * (1.0 + 1e-6); // a margin for rounding
    const Points half_sines = corner_half_sines(topology, lengths);
    std::vector<int> doubtful;
    for (int v = 0; v < topology.vertex_count(); ++v) {
        double largest = 0.0;
        double sum = 0.0;
        for (const int h : topology.outgoing(v)) {
            const double q = half_sines.data()[h];
            largest = std::max(largest, q);
            sum += q;
        }
        if (!(sum >= safe * largest)) // so of broken faces too, whose q are anything
            doubtful.push_back(v);
    }
    return doubtful;
}

template <class Violation>
void sort_worst_first(std::vector<Violation>& violations)
{
    std::stable_sort(violations.begin(), violations.end(),
                     [](const Violation& a, const Violation& b) { return a.excess > b.excess; });
}

// How far the values of a triangle's sides can go along a change before an inequality breaks.

constexpr double never = std::numeric_limits<double>::infinity();

double step_of_lengths(const Eigen::Vector3d& side, const Eigen::Vector3d& change)
{
    double step = never;
    for (int c = 0; c < 3; ++c) {
        // Slack of the inequality "side c is shorter than the two others": linear in the step.
        const double slack = side.sum() - 2.0 * side[c];
        const double slope = change.sum() - 2.0 * change[c];
        if (slope < 0.0)
            step = std::min(step, slack / -slope);
    }
    return step;
}

/// The first positive root of (sum of squares)^2 - 2 (sum of fourth powers) = 16 area^2, which is
/// quadratic in the step.
double step_of_squares(const Eigen::Vector3d& square, const Eigen::Vector3d& change)
{
    const double c = square.sum() * square.sum() - 2.0 * square.squaredNorm();
    const double b = 2.0 * square.sum() * change.sum() - 4.0 * square.dot(change);
    const double a = change.sum() * change.sum() - 2.0 * change.squaredNorm();
    const double discriminant = b * b - 4.0 * a * c;
    if (discriminant < 0.0)
        return never;
    const double z = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
    double step = never;
    if (z > 0.0)
        step = c / z; // the root that b's sign makes accurate
    if (a != 0.0 && z / a > 0.0)
        step = std::min(step, z / a);
    return step;
}

/// Newton's method from 0: the slack relative to the longest side, a sum of two exponentials less 1,
/// is convex, so that the steps approach its first root from the left.
double step_of_logarithms(const Eigen::Vector3d& logarithm, const Eigen::Vector3d& change,
                          double limit)
{
    // Far from the root a step divides the excess by about e, near it digits double: 200 are enough for
    // sides whose ratio is 1e80.
    constexpr int most_steps = 200;
    double least = limit;
    for (int c = 0; c < 3; ++c) {
        const int a = (c + 1) % 3;
        const int b = (c + 2) % 3;
        double step = 0.0;
        for (int i = 0; i < most_steps && step < least; ++i) {
            const double p = std::exp(logarithm[a] - logarithm[c] + step * (change[a] - change[c]));
            const double q = std::exp(logarithm[b] - logarithm[c] + step * (change[b] - change[c]));
            const double slope = p * (change[a] - change[c]) + q * (change[b] - change[c]);
            if (slope >= 0.0) {
                step = never;
                break;
            }
            const double advance = (p + q - 1.0) / -slope;
            step += std::max(advance, 0.0);
            if (advance <= 1e-15 * step) // some units of the last place
                break;
        }
        least = std::min(least, step);
    }
    return least;
}

} // namespace

Admissibility check_admissibility(const Topology& topology, const Eigen::VectorXd& lengths)
{
    check_size(topology, lengths, "lengths");
    Admissibility result;
    std::vector<char> broken(to_size(topology.vertex_count()), 0);
    for (int f = 0; f < topology.face_count(); ++f) {
        const Eigen::Vector3d side = sides(topology, lengths, f);
        const double longest = side.maxCoeff();
        const double others = side.sum() - longest;
        if (longest < others)
            continue;
        result.triangles.push_back(
            {f, others > 0.0 ? longest / others - 1.0 : std::numeric_limits<double>::infinity()});
        for (const int v : topology.faces().row(f))
            broken[to_size(v)] = 1;
    }
    for (const int v : vertices_in_doubt(topology, lengths)) {
        if (topology.is_boundary_vertex(v) || broken[to_size(v)])
            continue;
        std::vector<int> faces;
        for (const int h : topology.outgoing(v))
            faces.push_back(h / 3);
        const Points angles = internal::corner_angles(topology, lengths, faces);
        double largest = 0.0;
        double sum = 0.0;
        Eigen::Index row = 0;
        for (const int h : topology.outgoing(v)) {
            const double angle = angles(row++, h % 3);
            largest = std::max(largest, angle);
            sum += angle;
        }
        if (const double excess = largest - (sum - largest); excess > angle_rounding)
            result.vertices.push_back({v, excess});
    }
    sort_worst_first(result.triangles);
    sort_worst_first(result.vertices);
    return result;
}

Eigen::VectorXd positive_lengths(const Eigen::VectorXd& lengths)
{
    check_finite(lengths, "length");
    const double mean = lengths.mean();
    if (!(mean > 0.0))
        throw InvalidInput(join("the mean of the lengths is ", mean, ", must be > 0"));
    // Short, for such an edge should be; but not so short that E, of relative lengths, sees nothing else.
    // Those that are left of it are kept from ratios whose inverse squares no float holds.
    return (lengths.array() > 0.0).select(lengths.cwiseMax(1e-9 * mean), 1e-2 * mean);
}

std::string describe(const Admissibility& admissibility, const Topology& topology,
                     const Eigen::VectorXd& lengths)
{
    std::string text;
    if (!admissibility.triangles.empty()) {
        const int face = admissibility.triangles.front().face;
        const Eigen::Vector3d side = sides(topology, lengths, face);
        const auto corners = topology.faces().row(face);
        text = join(admissibility.triangles.size(), " of ", topology.face_count(),
                    " faces break the triangle inequality, worst face ", face, " (vertices ",
                    corners[0], ", ", corners[1], ", ", corners[2], ") with sides ", side[0], ", ",
                    side[1], ", ", side[2]);
    }
    if (!admissibility.vertices.empty()) {
        const VertexViolation& worst = admissibility.vertices.front();
        text += join(text.empty() ? "" : "; ", admissibility.vertices.size(), " of ",
                     topology.vertex_count(),
                     " vertices have a face angle larger than the sum of their others, worst "
                     "vertex ",
                     worst.vertex, " by ", worst.excess, " rad");
    }
    return text;
}

double feasible_step(const Topology& topology, const Eigen::VectorXd& values,
                     const Eigen::VectorXd& direction, double limit, LengthCoordinates coordinates)
{
    check_size(topology, values, "lengths");
    check_size(topology, direction, "direction");
    const Eigen::VectorXd lengths = to_lengths(coordinates, values);
    double step = limit;
    for (int f = 0; f < topology.face_count(); ++f) {
        const Eigen::Vector3d side = sides(topology, lengths, f);
        if (2.0 * side.maxCoeff() >= side.sum())
            return 0.0;
        const Eigen::Vector3d value = sides(topology, values, f);
        const Eigen::Vector3d change = sides(topology, direction, f);
        switch (coordinates) {
            case LengthCoordinates::Plain:
                step = std::min(step, step_of_lengths(value, change));
                break;
            case LengthCoordinates::Squared:
                step = std::min(step, step_of_squares(value, change));
                break;
            case LengthCoordinates::Log:
                step = std::min(step, step_of_logarithms(value, change, step));
                break;
        }
    }
    return step;
}

} // namespace shape
