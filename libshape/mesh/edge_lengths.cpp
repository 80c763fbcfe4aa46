// SPDX-License-Identifier: MIT

#include "libshape/mesh/edge_lengths.h"

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;
namespace {

/// Angle between sides a and b of the triangle with the third side c. Kahan's form of the law of
/// cosines: accurate for needles too.
double angle_between(double a, double b, double c)
{
    const double high = std::max(a, b);
    const double low = std::min(a, b);
    const double s = c <= low ? c - (high - low) : low - (high - c);
    const double numerator = ((high - low) + c) * s;
    const double denominator = (high + (low + c)) * ((high - c) + low);
    if (denominator <= 0.0) // c >= a + b
        return M_PI;
    return 2.0 * std::atan(std::sqrt(std::max(0.0, numerator) / denominator));
}

} // namespace

Eigen::VectorXd edge_lengths(const Topology& topology, const Points& points)
{
    if (points.rows() != topology.vertex_count())
        throw InvalidInput(join("points has ", points.rows(), " rows, the topology ",
                                topology.vertex_count(), " vertices"));
    const Edges& edges = topology.edges();
    Eigen::VectorXd lengths(edges.rows());
    for (Eigen::Index e = 0; e < edges.rows(); ++e)
        lengths[e] = (points.row(edges(e, 1)) - points.row(edges(e, 0))).norm();
    return lengths;
}

Points corner_angles(const Topology& topology, const Eigen::VectorXd& lengths)
{
    if (lengths.size() != topology.edge_count())
        throw InvalidInput(join("lengths has ", lengths.size(), " entries, the topology ",
                                topology.edge_count(), " edges"));
    const Faces& face_edges = topology.face_edges();
    Points angles(face_edges.rows(), 3);
    parallel_for(to_size(face_edges.rows()), 4096, [&](std::size_t begin, std::size_t end) {
        for (auto f = static_cast<Eigen::Index>(begin); f < static_cast<Eigen::Index>(end); ++f) {
            const double l0 = lengths[face_edges(f, 0)];
            const double l1 = lengths[face_edges(f, 1)];
            const double l2 = lengths[face_edges(f, 2)];
            angles(f, 0) = angle_between(l2, l0, l1);
            angles(f, 1) = angle_between(l0, l1, l2);
            angles(f, 2) = angle_between(l1, l2, l0);
        }
    });
    return angles;
}

} // namespace shape
