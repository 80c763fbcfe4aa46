// SPDX-License-Identifier: MIT

#include "libshape/mesh/edge_lengths.h"

#include <algorithm>
#include <cmath>

#include "libshape/base/blocks.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/base/vectorised.h"

namespace shape {
using namespace internal;
namespace {

/// l = sqrt((x^2 + y^2) + z^2). In memory a coordinate of 128 vectors is a row, x: x0 x1 .. x127: the plain
/// loop over edges reads x y z of two vertices, which do not fill a register, and takes a root at a time.
SHAPE_VECTORISED void norms(int count, const VectorRows& vectors, double* __restrict lengths)
{
    for (int i = 0; i < count; ++i)
        lengths[i] = std::sqrt((vectors.x[i] * vectors.x[i] + vectors.y[i] * vectors.y[i]) +
                               vectors.z[i] * vectors.z[i]);
}

/// Vectors in the direction of half the angles between sides a and b of triangles with the third side c.
/// Kahan's form of the law of cosines, accurate for needles too: with high >= low for a and b,
///
///     tan^2(gamma / 2) = ((high - low) + c) s / ((high + (low + c)) ((high - c) + low)),
///     s = c - (high - low) or low - (high - c), whichever differences are exact.
///
/// In memory a side of 128 triangles is a row, a: a0 a1 .. a127. The plain loop branches by which side is
/// longest and calls atan2 for each; here these are choices between values, and vector_angles() takes
/// the whole row of (cosine, sine) afterwards.
SHAPE_VECTORISED void half_angles(int count, const double* a, const double* b, const double* c,
                                  double* __restrict sines, double* __restrict cosines)
{
    for (int i = 0; i < count; ++i) {
        const double high = a[i] < b[i] ? b[i] : a[i];
        const double low = a[i] < b[i] ? a[i] : b[i];
        const double s = c[i] <= low ? c[i] - (high - low) : low - (high - c[i]);
        const double numerator = ((high - low) + c[i]) * s;
        const double denominator = (high + (low + c[i])) * ((high - c[i]) + low);
        const bool is_flat = denominator <= 0.0; // c >= a + b
        sines[i] = is_flat ? 1.0 : std::sqrt(numerator > 0.0 ? numerator : 0.0);
        cosines[i] = is_flat ? 0.0 : std::sqrt(denominator);
    }
}

} // namespace

Eigen::VectorXd edge_lengths(const Topology& topology, const Points& points)
{
    if (points.rows() != topology.vertex_count())
        throw InvalidInput(join("points has ", points.rows(), " rows, the topology ",
                                topology.vertex_count(), " vertices"));
    const Edges& edges = topology.edges();
    Eigen::VectorXd lengths(edges.rows());
    for_blocks(topology.edge_count(), [&](int first, int count) {
        VectorRows along;
        for (int i = 0; i < count; ++i)
            along.set(i, vector3(points.data() + 3 * edges(first + i, 1)) -
                             vector3(points.data() + 3 * edges(first + i, 0)));
        norms(count, along, lengths.data() + first);
    });
    return lengths;
}

Points corner_angles(const Topology& topology, const Eigen::VectorXd& lengths)
{
    if (lengths.size() != topology.edge_count())
        throw InvalidInput(join("lengths has ", lengths.size(), " entries, the topology ",
                                topology.edge_count(), " edges"));
    const Faces& face_edges = topology.face_edges();
    Points angles(face_edges.rows(), 3);
    for_blocks(topology.face_count(), [&](int first, int count) {
        Row sides[3]{};
        for (int i = 0; i < count; ++i)
            for (int k = 0; k < 3; ++k)
                sides[k][i] = lengths[face_edges(first + i, k)];
        for (int k = 0; k < 3; ++k) {
            Row sines, cosines, halves;
            half_angles(count, sides[(k + 2) % 3], sides[k], sides[(k + 1) % 3], sines, cosines);
            vector_angles(sines, cosines, to_size(count), halves);
            for (int i = 0; i < count; ++i)
                angles(first + i, k) = 2.0 * halves[i];
        }
    });
    return angles;
}

} // namespace shape
