// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/edge_space/shape_space.h"
#include "libshape/linalg/dense.h"
#include "libshape/mesh/collection.h"
#include "libshape/statistics/group_comparison.h"
#include "libshape/statistics/grouping.h"
#include "libshape/statistics/regression.h"

namespace shape {

/// What covariates such as age or size do to shape: a regression in a space of shapes, with the
/// companion angles that its shapes are decoded with.
struct CovariateEffect
{
    ShapeSpace space;
    BlockDesign design = BlockDesign::Crossed; ///< How the blocks were taken.
    Regression regression;                     ///< D coordinates on C covariates.
    Eigen::VectorXd mean_dihedral_angles;      ///< #E [rad]; or empty.
    RowMatrix slope_dihedral_angles; ///< C by #E [rad per unit of the covariate]; or C by 0.
    Eigen::VectorXd scores;          ///< N: regression_scores() along the first slope.
    Eigen::MatrixXd products;        ///< N by N inner products about the mean.
};

/// Regresses the shapes of a collection on covariates.
/// @param covariates  N by C.
/// @param blocks  Crossed with the covariates, each has an effect of its own, and slopes are those
///     within them; nested, their means are regressed, so that each counts once (covariate_blocks.h).
///     one_group() if there are none.
/// @throws InvalidInput as make_space(), regress() and block_design().
/// Memory: beside the collection, one N by D matrix.
[[nodiscard]] CovariateEffect covariate_effect(const Collection& collection,
                                               const ShapeSpace& space,
                                               const Eigen::MatrixXd& covariates,
                                               const Grouping& blocks);

/// The shape that the regression expects at some covariates.
/// @param covariates  C.
/// @param size  As decode() takes it.
/// @throws InvalidInput if the sizes disagree, or as decode().
[[nodiscard]] DecodedShape expected_shape(const CovariateEffect& effect,
                                          const Eigen::VectorXd& covariates, double size);

/// A mesh moved along the slopes from its own covariates to others: without the effect of the
/// covariates if those are their means. Its size stays unless the size is a coordinate.
/// @param mesh  A collection of one.
/// @param from, to  C.
/// @throws InvalidInput if the sizes disagree, or as encode() and decode().
[[nodiscard]] DecodedShape move_along_slopes(const CovariateEffect& effect, const Collection& mesh,
                                             const Eigen::VectorXd& from,
                                             const Eigen::VectorXd& to);

} // namespace shape
