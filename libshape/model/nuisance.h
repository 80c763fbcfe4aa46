// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/edge_space/shape_space.h"
#include "libshape/linalg/dense.h"
#include "libshape/mesh/collection.h"
#include "libshape/model/difference.h"
#include "libshape/model/shape_model.h"

namespace shape {

/// Directions of a space that an analysis is not interested in, such as the modes of pose.
struct Nuisance
{
    Topology topology;
    Points reference_points; ///< #V by 3 [length], of one of the meshes that the directions are of.
    ShapeSpace space;
    Eigen::VectorXd origin;    ///< D; amounts are 0 there.
    RowMatrix directions;      ///< K by D, orthonormal rows.
    RowMatrix dihedral_angles; ///< K by #E [rad], their companions; or K by 0.
};

/// The first modes of a model, from its mean.
/// @param count  K in [1, number of modes].
/// @throws InvalidInput if it is out of its range.
[[nodiscard]] Nuisance leading_modes(const ShapeModel& model, int count);

/// The direction of a difference, from the mean it starts from.
/// @throws InvalidInput if the difference is 0.
[[nodiscard]] Nuisance direction_of(const DifferenceVector& difference);

/// How far each mesh lies along the directions, N by K.
/// @throws InvalidInput if the meshes have another triangulation, saying what differs.
[[nodiscard]] RowMatrix amounts_of(const Nuisance& nuisance, const Collection& collection);

/// A mesh whose amounts along the directions are replaced, and nothing else of it but, with them,
/// its companion angles: all 0 remove the nuisance, those of one mesh bring all others into its
/// pose. Sums of unit-sum lengths and sizes stay.
/// @param mesh  A collection of one.
/// @param amounts  K.
/// @throws InvalidInput if the sizes disagree, a value is not finite, or the mesh has another
///     triangulation.
[[nodiscard]] DecodedShape with_amounts(const Nuisance& nuisance, const Collection& mesh,
                                        const Eigen::VectorXd& amounts);

} // namespace shape
