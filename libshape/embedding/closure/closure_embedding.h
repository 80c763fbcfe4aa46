// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/base/progress.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/closure/dihedral_solver.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// A mesh, and how the solver for its dihedral angles ended.
struct ClosureEmbedding
{
    Points points;             ///< #V by 3 [length], centroid at 0.
    DihedralSolution solution; ///< The angles that points were made from; they fit them if E = 0.
};

/// Embeds edge lengths as published by Rojas 2014, section 2: dihedral angles that close the walk
/// around every vertex (dihedral_solver.h), frames (vertex_frames.h), positions
/// (vertex_positions.h).
///
/// Where the angles leave E > 0 the positions have other lengths than asked for: the target may
/// have no mesh, or the solver stopped in a local minimum. Negated angles give the mirror image.
/// @param target  #E lengths [length], > 0; #E initial angles [rad]; all finite.
/// @throws InvalidInput if a size, a value or an option breaks a rule.
/// @throws NumericalError if the lengths break a triangle inequality (names the worst face), or if
///     a normal matrix is not numerically positive definite.
[[nodiscard]] ClosureEmbedding embed_by_closure(
    const Topology& topology, const ShapePoint& target,
    const LbfgsOptions& options = dihedral_solver_defaults, const Progress& progress = {});

} // namespace shape::internal
