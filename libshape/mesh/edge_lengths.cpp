// SPDX-License-Identifier: MIT

#include "libshape/mesh/edge_lengths.h"

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/gathered_vectors.h"
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
        const int* const ends = edges.data() + 2 * first;
        gather_differences(count, points.data(), {ends + 1, 2}, {ends, 2}, along);
        norms(count, along, lengths.data() + first);
    });
    return lengths;
}

} // namespace shape
