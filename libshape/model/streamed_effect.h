// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <functional>

#include "libshape/model/covariate_effect.h"
#include "libshape/model/streamed_products.h"

namespace shape {

struct StreamedEffectOptions : StreamedProductsOptions
{
    /// N by C covariates of the meshes of these sizes (see sizes() of shape_space.h).
    std::function<Eigen::MatrixXd(const Eigen::VectorXd& sizes)> covariates = {};
    /// Whether shapes are wanted: mean and slopes, which take two further passes. Else `regression.mean`,
    /// `regression.slopes` and the angles stay empty.
    bool with_shapes = true;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const StreamedEffectOptions& options);

struct StreamedEffect
{
    CovariateEffect effect;
    Eigen::MatrixXd covariates;  ///< N by C.
    Eigen::VectorXd sizes;       ///< N [length].
    Eigen::VectorXd slope_norms; ///< C: of the slopes, wanted or not.
    Points reference_points;     ///< The first mesh.
    int passes = 0;
};

/// covariate_effect() of the meshes of a collection that need not fit into memory, to rounding: weights of
/// meshes make slopes, and the inner products of meshes all the figures of these.
/// @throws as covariate_effect() and measure_products(); InvalidInput if there are no covariates.
/// Cost: that of measure_products(), and with shapes 4 N E C multiplications in two passes.
[[nodiscard]] StreamedEffect covariate_effect(const MeshStream& meshes, const Grouping& blocks,
                                              const StreamedEffectOptions& options);

} // namespace shape
