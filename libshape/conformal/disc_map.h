// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/conformal/certificate.h"
#include "libshape/conformal/compensated_points.h"
#include "libshape/mesh/topology.h"

namespace shape {

struct DiscMapOptions
{
    /// Boundary vertices keep these u_i; #V, finite, others are ignored. Empty: 0, boundary edges keep
    /// their lengths; of all choices this distorts areas least.
    Eigen::VectorXd boundary_factors;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const DiscMapOptions& options);

/// A discrete conformal map of a disc to the plane.
struct DiscMap
{
    ConformalCertificate certificate = ConformalCertificate::Unsolved;
    Eigen::VectorXd factors;     ///< #V, u_i of eq. (13).
    PlanarLayout layout;         ///< #V, counter-clockwise. Far apart parts may overlap.
    ConformalEdges edges;        ///< How well eq. (13) holds.
    double angle_residual = 0.0; ///< max |2 pi - angle sum| inside [rad].
    int newton_steps = 0;        ///< In all rounds, each with one factorisation.
    int repair_rounds = 0;
};

/// Flattens a disc conformally with given factors on its boundary (Springborn, Schröder, Pinkall
/// 2008), on its own triangulation where that has a solution and with few flipped edges where not
/// (about faces that break). A face that breaks at a boundary edge cannot be repaired: Unsolved.
///
/// @param lengths  #E [length], > 0, finite.
/// @throws InvalidInput if the mesh has not exactly one boundary loop and genus 0, or lengths or
///     boundary_factors break a rule.
[[nodiscard]] DiscMap map_to_plane(const Topology& topology, const Eigen::VectorXd& lengths,
                                   const DiscMapOptions& options = {});

} // namespace shape
