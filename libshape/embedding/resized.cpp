// SPDX-License-Identifier: MIT

#include "libshape/embedding/resized.h"

#include <cmath>
#include <utility>
#include <variant>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/target_size.h"

namespace shape {
using namespace internal;

DecodedShape resized(DecodedShape shape, double factor)
{
    if (!(factor > 0.0 && std::isfinite(factor)))
        throw InvalidInput(join("resized: the factor is ", factor, ", must be > 0 and finite"));
    if (Points* const mesh = std::get_if<Points>(&shape))
        *mesh *= factor;
    if (ShapePoint* const point = std::get_if<ShapePoint>(&shape)) {
        point->edge_lengths *= factor;
        point->positions *= factor;
    }
    return shape;
}

Embedding resized(Embedding embedding, const Topology& topology, const DecodedShape& shape,
                  double factor)
{
    if (factor == 1.0)
        return embedding;
    const DecodedShape target = resized(shape, factor);
    embedding.points *= factor;
    if (const ShapePoint* const point = std::get_if<ShapePoint>(&target)) {
        check_size(point->edge_lengths.cwiseAbs().maxCoeff(), "the target");
        if (!embedding.report.reason.empty()) // it names sides
            embedding.report.reason = describe(check_admissibility(topology, point->edge_lengths),
                                               topology, point->edge_lengths);
    }
    return embedding;
}

} // namespace shape
