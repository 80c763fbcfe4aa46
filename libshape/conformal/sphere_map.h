// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libshape/conformal/moebius.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// What a conformal map to the sphere is worth.
enum class ConformalCertificate
{
    Exact,    ///< Eq. (13) holds on every edge and no face is reversed.
    Folded,   ///< Eq. (13) holds on every edge, but some faces are reversed.
    Repaired, ///< Eq. (13) holds on all edges but those that had to be flipped.
    Refined,  ///< The same, and local repair did not do: every edge was allowed to flip, and the
              ///< triangulation is the Delaunay triangulation of the result.
    Unsolved, ///< No map was found: a face stays broken, or a residual exceeds 1e-9.
};

struct SphereMapOptions
{
    int infinite_vertex = -1; ///< Vertex whose star is taken out to solve; -1: central_vertex().
};

/// A discrete conformal map to a sphere about 0 with the area of the mesh.
struct SphereMap
{
    ConformalCertificate certificate = ConformalCertificate::Unsolved;
    Eigen::VectorXd factors;         ///< #V, u_i of b_ij = exp((u_i + u_j) / 2) a_ij (Rojas 2014,
                                     ///< eq. 13); a the mesh's lengths, b chords of the sphere.
    double radius = 0.0;             ///< [length]
    SpherePoints sphere;             ///< #V on the unit sphere.
    std::vector<int> flipped_edges;  ///< Edges on which eq. (13) need not hold. Ascending.
    std::vector<int> reversed_faces; ///< Faces of the mesh that are clockwise on the sphere, seen
                                     ///< from outside. Ascending.
    Eigen::VectorXd edge_residuals;  ///< #E, log(b_ij / a_ij) - (u_i + u_j) / 2.
    double residual = 0.0;           ///< max |edge_residuals| over the edges that are not flipped.
    double angle_residual = 0.0;     ///< max |2 pi - angle sum| of the flat metric [rad].
    double balance_residual = 0.0;   ///< |area-weighted mean of the points on the unit sphere|.
    int newton_steps = 0;            ///< In all rounds, each with one factorisation.
    int repair_rounds = 0;
    int infinite_vertex = -1;
};

/// "exact", "folded", "repaired", "refined" or "unsolved".
[[nodiscard]] const char* name(ConformalCertificate certificate);

/// Why no conformal map to the sphere exists, and what to do; empty if the mesh qualifies.
[[nodiscard]] std::string why_not_spherical(const Topology& topology);

/// Maps a closed mesh of genus 0 conformally to the sphere, on its own triangulation where that has
/// a solution and with few flipped edges where not (flat_metric.h). The map is unique up to the
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
