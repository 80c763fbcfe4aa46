// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/embedding/face_layout.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// The local half of a local-global step: every wedge of two neighbouring faces, rigid as laid out,
/// is rotated to its best fit to the points; a face then wants the mean of what its wedges want.
/// Wedges rather than faces, because their bending is part of what is wanted.
/// @param weights  #E weights of the edges in the fits.
/// @param frames  #F rotations near the solution: where the fits start from, and the answer for a
///     face without neighbour.
/// @return #F matrices, rotations where all wedges of a face agree.
/// Cost: O(#E).
[[nodiscard]] std::vector<Eigen::Matrix3d> fit_wedges(const Topology& topology,
                                                      const FaceLayout& layout,
                                                      const Eigen::VectorXd& weights,
                                                      const Points& points,
                                                      std::vector<Eigen::Matrix3d> frames);

} // namespace shape
