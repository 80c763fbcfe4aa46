// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/base/progress.h"
#include "libshape/embedding/embedder.h"
#include "libshape/model/shape_model.h"

namespace shape {

/// A model as others have them: positions that depend linearly on scores. Exact in Procrustes space; an
/// approximation of a model of edge lengths, good near its mean.
struct LinearisedModel
{
    Points mean;               ///< #V by 3 [length], the mesh of the model's mean.
    RowMatrix basis;           ///< 3 #V by K orthonormal columns; row 3 v + axis is of vertex v.
    Eigen::VectorXd variances; ///< K, descending [length^2].
    RowMatrix scores;          ///< N by K of the model's meshes [length].
    bool is_exact = false;     ///< Of a model of Procrustes space, which is linear as it is.
};

/// Linearises a model at its mean size.
///
/// Mode k moves the positions by d_k = (x(+1) - x(-1)) / 2 for each standard deviation, where x(t) is
/// the mesh at t standard deviations, laid onto that of the mean. The covariance of the positions is then
/// sum_k d_k d_k^T; its eigenvectors and eigenvalues are the basis and the variances, which are fewer than K
/// where the d_k depend on each other (eigenvalues below 1e-12 times the largest).
/// @param modes  Number of leading modes of the model, in [1, K]; 0: all.
/// @throws InvalidInput if modes is out of its range; else as Embedder.
/// Cost: 2 K + 1 embeddings, and O(#V K^2).
[[nodiscard]] LinearisedModel linearise(const ShapeModel& model, int modes = 0,
                                        const EmbeddingOptions& options = {},
                                        const Progress& progress = {});

} // namespace shape
