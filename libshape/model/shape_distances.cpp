// SPDX-License-Identifier: MIT

#include "libshape/model/shape_distances.h"

#include <cmath>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/statistics/distance_matrix.h"

namespace shape {
using namespace internal;

ShapeDistances shape_distances(const Collection& collection, const SpaceOptions& options)
{
    if (collection.size() < 2)
        throw InvalidInput(join("distances need at least 2 meshes, there are ", collection.size()));
    ShapeSpace space = make_space(collection, options);
    Eigen::MatrixXd matrix = distance_matrix(encode(space, collection));
    if (std::holds_alternative<ProcrustesSpace>(space)) {
        const double size = options.scale == Scale::Unit ? sizes(space, collection).mean() : 1.0;
        matrix *= size / std::sqrt(static_cast<double>(collection.topology.vertex_count()));
    }
    return {std::move(space), std::move(matrix)};
}

} // namespace shape
