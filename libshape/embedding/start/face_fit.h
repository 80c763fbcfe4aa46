// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/embedding/start/face_layout.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// The local half of a local-global step: every face, with half of each of its neighbours laid out
/// beside it, is rotated to its best fit to the points. Neighbours, because their bending is part of
/// what is wanted.
/// @param weights  #E weights of the edges in the fits.
/// @param frames  #F rotations near the solution: where the fits start from.
/// @return #F rotations.
/// Cost: O(#F).
[[nodiscard]] Rotations fit_faces(const Topology& topology, const FaceLayout& layout,
                                  const Eigen::VectorXd& weights, const Points& points,
                                  Rotations frames);

} // namespace shape::internal
