// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <functional>

#include "libshape/conformal/certificate.h"
#include "libshape/conformal/intrinsic_triangulation.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Measures how well eq. (13) of Rojas 2014 holds.
/// @param lengths  #E, a_ij [length].
/// @param factors  #V, u_i.
/// @param triangulation  Of the result.
/// @param distance  b_ij between two vertices [length].
[[nodiscard]] ConformalEdges measure_conformal_edges(
    const Topology& topology, const Eigen::VectorXd& lengths, const Eigen::VectorXd& factors,
    const IntrinsicTriangulation& triangulation, const std::function<double(int, int)>& distance);

} // namespace shape::internal
