// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <limits>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// How far a ray through the space can be followed.
struct SafeReach
{
    double reach = std::numeric_limits<double>::infinity(); ///< >= 0.
    int face = -1; ///< The first whose triangle inequality breaks there; -1 if none ever does.
};

/// The largest r such that blend(vectors, start + s * direction, lengths) keeps every triangle
/// inequality (strictly, with positive lengths) for all s in [0, r); 0 if the start breaks one.
///
/// Exact per face: for plain lengths every inequality is linear in s; for squared lengths 16 times
/// the squared area is a quadratic in s, and its first root is where the first inequality breaks.
/// Combinations with weights in [0, 1] never break any.
/// @param start  N weights that sum to 1.
/// @param direction  N weights that sum to 0.
/// @throws InvalidInput if a size does not fit or a value is not finite.
/// Cost: O(N #E).
[[nodiscard]] SafeReach safe_reach(const Topology& topology, const ShapeVectors& vectors,
                                   const Eigen::VectorXd& start, const Eigen::VectorXd& direction,
                                   LengthBlend lengths);

/// The same for weights beyond the inputs: start is their positive part, scaled to sum 1, and direction leads
/// to them. Safe if the reach exceeds 1; infinite if none is negative. @throws as above, or if none is positive.
[[nodiscard]] SafeReach safe_reach(const Topology& topology, const ShapeVectors& vectors,
                                   const Eigen::VectorXd& weights, LengthBlend lengths);

} // namespace shape
