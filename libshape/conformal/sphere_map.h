// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libshape/conformal/certificate.h"
#include "libshape/conformal/compensated_points.h"
#include "libshape/conformal/triangulation_repair.h"
#include "libshape/mesh/topology.h"

namespace shape {

struct SphereMapOptions
{
    /// The star of this vertex is taken out to solve, >= -1; -1: that of central_vertex().
    int infinite_vertex = -1;
    /// A triangulation without solution is repaired as these options say.
    TriangulationRepairOptions repair = {};
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const SphereMapOptions& options);

/// A discrete conformal map to a sphere about 0 with the area of the mesh.
struct SphereMap
{
    ConformalCertificate certificate = ConformalCertificate::Unsolved;
    Eigen::VectorXd factors;         ///< #V, u_i of eq. (13); b are chords of the sphere.
    double radius = 0.0;             ///< [length]
    SpherePoints sphere;             ///< #V on the unit sphere.
    ConformalEdges edges;            ///< How well eq. (13) holds.
    std::vector<int> reversed_faces; ///< Faces of the mesh that are clockwise on the sphere, seen
                                     ///< from outside. Ascending.
    double angle_residual = 0.0;     ///< max |2 pi - angle sum| of the flat metric [rad].
    double balance_residual = 0.0;   ///< |area-weighted mean of the points on the unit sphere|.
    int newton_steps = 0;            ///< In all rounds, each with one factorisation.
    int repair_rounds = 0;
    int infinite_vertex = -1;
};

/// Why no conformal map to the sphere exists, and what to do; empty if the mesh qualifies.
[[nodiscard]] std::string why_not_spherical(const Topology& topology);

/// Maps a closed mesh of genus 0 conformally to the sphere, on its own triangulation where that has
/// a solution and with few flipped edges where not (about faces that break). The map is unique up to the
/// Möbius transformations of the sphere; these are used to bring the area-weighted mean of the
/// points to 0, which leaves rotations: the infinite vertex is at (0, 0, -1).
///
/// @param lengths  #E [length], > 0, finite.
/// @throws InvalidInput if the mesh does not qualify (why_not_spherical), lengths or the option
///     breaks a rule.
/// Cost: 5 to 25 factorisations of a Laplacian where no repair is needed.
[[nodiscard]] SphereMap map_to_sphere(const Topology& topology, const Eigen::VectorXd& lengths,
                                      const SphereMapOptions& options = {});

} // namespace shape
