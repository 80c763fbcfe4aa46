// SPDX-License-Identifier: MIT

#include "libshape/mesh/corner_angles.h"

#include <cmath>

#include "libshape/base/blocks.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/base/vectorised.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
namespace {

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

/// Calls use(first, count, corner, sines, cosines) for the half angles of blocks of faces at each corner.
/// @param face_of  The i-th face.
template <class FaceOf, class Use>
void for_half_angles(const Topology& topology, const Eigen::VectorXd& lengths, int faces,
                     const FaceOf& face_of, const Use& use)
{
    if (lengths.size() != topology.edge_count())
        throw InvalidInput(join("lengths has ", lengths.size(), " entries, the topology ",
                                topology.edge_count(), " edges"));
    for_blocks(faces, [&](int first, int count) {
        Row sides[3]{};
        for (int i = 0; i < count; ++i)
            for (int k = 0; k < 3; ++k)
                sides[k][i] = lengths[topology.face_edges()(face_of(first + i), k)];
        for (int k = 0; k < 3; ++k) {
            Row sines, cosines;
            half_angles(count, sides[(k + 2) % 3], sides[k], sides[(k + 1) % 3], sines, cosines);
            use(first, count, k, sines, cosines);
        }
    });
}

template <class FaceOf>
Points angles_of(const Topology& topology, const Eigen::VectorXd& lengths, int faces,
                 const FaceOf& face_of)
{
    Points angles(faces, 3);
    for_half_angles(topology, lengths, faces, face_of,
                    [&](int first, int count, int k, const Row& sines, const Row& cosines) {
                        Row halves;
                        vector_angles(sines, cosines, to_size(count), halves);
                        for (int i = 0; i < count; ++i)
                            angles(first + i, k) = 2.0 * halves[i];
                    });
    return angles;
}

} // namespace

Points corner_angles(const Topology& topology, const Eigen::VectorXd& lengths)
{
    return angles_of(topology, lengths, topology.face_count(), [](int i) { return i; });
}

Points internal::corner_angles(const Topology& topology, const Eigen::VectorXd& lengths,
                               std::span<const int> faces)
{
    return angles_of(topology, lengths, static_cast<int>(faces.size()),
                     [&](int i) { return faces[to_size(i)]; });
}

Points internal::corner_half_sines(const Topology& topology, const Eigen::VectorXd& lengths)
{
    Points half_sines(topology.face_count(), 3);
    for_half_angles(
        topology, lengths, topology.face_count(), [](int i) { return i; },
        [&](int first, int count, int k, const Row& sines, const Row& cosines) {
            for (int i = 0; i < count; ++i)
                half_sines(first + i, k) =
                    sines[i] / std::sqrt(sines[i] * sines[i] + cosines[i] * cosines[i]);
        });
    return half_sines;
}

} // namespace shape
