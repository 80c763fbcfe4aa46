// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/conformal/compensated_points.h"
#include "libshape/conformal/cotangent_system.h"
#include "libshape/conformal/intrinsic_triangulation.h"

namespace shape::internal {

/// Lays out a flat disc: the boundary as the polygon that its lengths and angles span, the interior
/// by Laplace's equation with cotangent weights, which flat coordinates obey exactly; refined until
/// every edge is accurate relative to its own length. Breadth-first unfolding would add up errors.
///
/// @param u  Factors that make the disc flat.
/// @param boundary  Half-edges around the disc, which lies on their left; their sources are the
///     vertices that `system` holds fixed.
/// @param edge_weights  Half cotangent sums at u; `system` is factored with them.
/// @return Counter-clockwise, 0 about the middle of the vertices; without meaning at vertices that
///     are neither free nor on the boundary.
[[nodiscard]] PlanarLayout lay_out_disc(const IntrinsicTriangulation& triangulation,
                                        const Eigen::VectorXd& u, const std::vector<int>& boundary,
                                        const Eigen::VectorXd& edge_weights,
                                        const CotangentSystem& system);

} // namespace shape::internal
