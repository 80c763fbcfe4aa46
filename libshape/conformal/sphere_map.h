// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libshape/conformal/moebius.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// What a conformal map is worth.
enum class ConformalCertificate
{
    Exact,    ///< Eq. (13) holds on every edge, and no face is reversed on the sphere.
    Repaired, ///< A few edges were flipped where the triangulation has no solution.
    Refined,  ///< The triangulation was replaced by the Delaunay triangulation of the solution.
};

struct SphereMapOptions
{
    int removed_vertex = -1;  ///< Vertex that is sent to infinity; -1: chosen.
    int max_flip_rounds = 30; ///< Rounds of local repairs before the triangulation is replaced; >= 0.
};

/// A discrete conformal map to the sphere with the area of the mesh.
struct SphereMap
{
    ConformalCertificate certificate = ConformalCertificate::Exact;
    Eigen::VectorXd factors;        ///< #V, u_i of b_ij = exp((u_i + u_j) / 2) a_ij.
    double radius = 0.0;            ///< [length]
    SpherePoints sphere;            ///< #V on the unit sphere, balanced.
    std::vector<int> flipped_edges; ///< Edges of the mesh on which eq. (13) does not hold. Ascending.
    Eigen::VectorXd edge_residuals; ///< #E, log(chord / a_ij) - (u_i + u_j) / 2.
    double residual = 0.0;          ///< max |edge_residuals| over the edges not flipped.
    double angle_residual = 0.0;    ///< max |2 pi - angle sum| of the flat metric [rad].
    double balance_residual = 0.0;  ///< |area-weighted mean of the points|.
    std::vector<int> reversed_faces; ///< Faces of the mesh that are clockwise on the sphere.
    int newton_steps = 0;           ///< In all rounds.
    int flip_rounds = 0;
    std::size_t broken = 0;
    int removed_vertex = -1;
};

/// Why no conformal map to the sphere exists, and what to do; empty if the mesh qualifies.
[[nodiscard]] std::string why_not_spherical(const Topology& topology);

[[nodiscard]] SphereMap map_to_sphere(const Topology& topology, const Eigen::VectorXd& lengths,
                                      const SphereMapOptions& options = {});

} // namespace shape
