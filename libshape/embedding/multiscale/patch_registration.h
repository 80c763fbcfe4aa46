// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "libshape/embedding/multiscale/registration_options.h"

namespace shape::internal {

/// A position with 1 behind it, so that moments of all orders are one outer product.
using PaddedPoint = Eigen::Vector4d;

constexpr int max_patches = 16; ///< Most patches that are registered at once.

/// A point that two patches share: its row in each.
struct CommonVertex
{
    int first = 0;
    int second = 0;
};

/// The points that two patches share, a slice of a list that the caller keeps.
struct PatchOverlap
{
    int first = 0; ///< Index of a patch; < second.
    int second = 0;
    std::size_t begin = 0; ///< Into the list of common vertices.
    int count = 0;         ///< > 0
};

/// Inverse of the normal matrix of the translations (the overlaps' Laplacian, weighted by counts),
/// where patch 0 stays in place. It depends on the counts alone.
/// @return n - 1 by n - 1.
/// @throws InvalidInput if the overlaps do not link all n patches.
[[nodiscard]] Eigen::MatrixXd translation_inverse(int patch_count,
                                                  std::span<const PatchOverlap> overlaps);

/// Simultaneous registration of n patches (Williams, Bennamoun 2000; Winkler 2010, section 3.1):
/// the rotations of least sum, over all overlaps and their common vertices, of the squared distances
/// |R_k p_k + t_k - R_l p_l - t_l|^2. The translations are eliminated; what is left is
/// max_R sum_kl trace(R_k Q_kl R_l^T), climbed by turning one patch at a time. Patch 0 keeps the
/// identity. Where a patch has no unique best rotation, one near its last is taken; never a
/// reflection.
///
/// @param patches  n <= max_patches arrays of points, last entry 1.
/// @param overlaps  Each patch but the first has one with a patch before it.
/// @param common  What the overlaps' slices refer to.
/// @param inverse  translation_inverse() of the same overlaps, column-major.
/// @param[out] rotations  n; determinant +1.
/// Cost: O(number of common vertices + passes n^2). Allocates nothing.
void register_patches(std::span<const PaddedPoint* const> patches,
                      std::span<const PatchOverlap> overlaps, const CommonVertex* common,
                      const double* inverse, const RegistrationOptions& options,
                      std::span<Eigen::Matrix3d> rotations);

} // namespace shape::internal
