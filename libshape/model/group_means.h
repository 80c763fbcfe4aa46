// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <functional>

#include "libshape/edge_space/shape_space.h"
#include "libshape/linalg/dense.h"
#include "libshape/mesh/collection.h"
#include "libshape/statistics/grouping.h"

namespace shape {

/// N by any number of covariates of N meshes of these sizes (see sizes() of shape_space.h); empty: none.
using CovariatesOfSizes = std::function<Eigen::MatrixXd(const Eigen::VectorXd& sizes)>;

/// A collection as groups of points of a space: what tests need of all, and the means as shapes.
struct GroupedShapes
{
    ShapeSpace space;
    Eigen::MatrixXd products;   ///< N by N inner products about the mean (inner_products.h).
    Eigen::VectorXd sizes;      ///< N, see sizes() of shape_space.h [length].
    RowMatrix means;            ///< G by D coordinates of the groups' means; NaN if not determined.
    RowMatrix dihedral_angles;  ///< G by #E [rad], their companions; or G by 0.
    Eigen::VectorXd mean_sizes; ///< G [length]; by the weights of the means.
    Eigen::VectorXd covariate_means; ///< C: where adjusted means are; or 0.
};

/// @throws InvalidInput if the grouping is of another number of meshes or has an empty group, or as
///     make_space().
/// Memory: beside the collection, one N by D matrix.
[[nodiscard]] GroupedShapes group_shapes(const Collection& collection, const Grouping& groups,
                                         const SpaceOptions& options = {});

/// The same with the means that compare_groups() of these blocks and covariates is of: of the means of blocks, of
/// blocks that have members of several groups, and adjusted for the covariates (group_comparison.h). Companions and
/// sizes are combined by the weights of the coordinates.
/// @param blocks  groups_of_one() if there are none.
/// @throws InvalidInput also if a covariate is not finite.
[[nodiscard]] GroupedShapes group_shapes(const Collection& collection, const Grouping& groups,
                                         const SpaceOptions& options, const Grouping& blocks,
                                         const CovariatesOfSizes& covariates = {});

/// The mean of a group as a shape of the mean size of its members.
/// @param group  Index in [0, G).
/// @throws InvalidInput if it is out of its range, or not determined.
[[nodiscard]] DecodedShape mean_shape(const GroupedShapes& shapes, int group);

} // namespace shape
