// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "libshape/base/progress.h"
#include "libshape/base/ranks.h"
#include "libshape/edge_space/shape_space.h"
#include "libshape/linalg/dense.h"
#include "libshape/mesh/mesh_stream.h"
#include "libshape/statistics/classical_scaling.h"

namespace shape {

struct StreamedDistancesOptions
{
    /// In which space meshes are compared.
    SpaceOptions space = {};
    /// At most this much memory is used [byte]; 0: a quarter of the machine's.
    std::uint64_t memory = 0;
    Progress progress = {}; ///< Called with kilobytes read, of the pass that its stage names.
    Ranks ranks = {};       ///< Other processes that share the passes.
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const StreamedDistancesOptions& options);

/// Rows of the matrix of shape_distances(), of meshes that come by in passes: shows distances(i, j) of
/// mesh first + i from mesh j, blocks of rows in their order. A distance is that in memory to 1e-10 of itself,
/// and 0 of equal meshes.
///
/// @return The space that they were measured in.
/// @throws as shape_distances(), and what reading throws; LimitExceeded if the memory does not hold a row.
///     Procrustes space is refused.
/// Cost: N^2 E multiplications, and N / h passes where h meshes are held beside as many rows.
ShapeSpace for_each_distance_row(
    const MeshStream& meshes, const StreamedDistancesOptions& options,
    const std::function<void(Eigen::Index first, const RowMatrix& distances)>& visit);

/// classical_scaling() of those distances: the scores of principal components, which block Krylov or inner
/// products find (streamed_fit.h), so that no distance is needed.
/// @param dimensions  In [1, N].
/// @throws as fit_model() of streams; InvalidInput of other dimensions.
[[nodiscard]] ClassicalScaling classical_scaling(const MeshStream& meshes, int dimensions,
                                                 const StreamedDistancesOptions& options);

} // namespace shape
