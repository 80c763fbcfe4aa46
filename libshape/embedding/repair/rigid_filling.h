// SPDX-License-Identifier: MIT

#pragma once

#include <vector>

#include "libshape/embedding/energy/region_mesh.h"
#include "libshape/linalg/eight_lane_solve.h"

namespace shape::internal {

/// Fills a region with eight reference meshes, each bent into its surroundings as rigidly as possible
/// (Sorkine and Alexa 2007) and stretched to wanted lengths. Rotations on the rim are those of the
/// faces outside, which lie as wanted; blended inwards, they are where sweeps of rotations and
/// positions start. So the filling is unfolded where the reference is.
/// @param lengths  Wanted, of the region's edges; the unit is free.
/// @param laplacian  Of the moving vertices, weighted by 1 / lengths^2.
/// @param references  All vertices of the region; turned so that each rim fits as a whole.
/// @param points  All vertices of the region; the moving ones are overwritten.
/// @param sweeps  >= 0.
void fill_rigidly(const RegionMesh& region, const std::vector<float>& lengths,
                  const EightLaneSolve& laplacian, const EightLanePoints& references, int sweeps,
                  EightLanePoints& points);

} // namespace shape::internal
