// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/conformal/compensated_points.h"
#include "libshape/conformal/intrinsic_triangulation.h"
#include "libshape/conformal/triangulation_repair.h"

namespace shape::internal {

/// A conformally equivalent flat disc.
struct FlatMetric
{
    IntrinsicTriangulation triangulation; ///< Edges keep their numbers when they are flipped.
    Eigen::VectorXd u;                    ///< #V log factors [1].
    std::vector<int> boundary;            ///< Half-edges around the disc, which lies on their left.
    PlanarLayout layout;                  ///< #V; 0 for the removed vertex.
    double angle_residual = 0.0;          ///< max |2 pi - angle sum| inside [rad].
    int newton_steps = 0;                 ///< In all rounds.
    int rounds = 0;                       ///< Repairs of the triangulation.
    bool all_released = false;            ///< Every edge was allowed to flip.
    std::vector<int> broken_faces;        ///< Not empty only if repair came to no end.

    [[nodiscard]] bool converged() const { return broken_faces.empty() && angle_residual <= 1e-10; }
};

/// Flattens a disc whose boundary vertices keep given factors.
///
/// Where no solution exists with the edges as they are (some face breaks its triangle inequality at
/// the minimiser of the convex energy), the longest edges of those faces are allowed to flip in
/// Penner coordinates; they flip where they are not Delaunay. If that does not do, the faces around
/// follow, ring by ring, and in the end all.
///
/// @param factors  #V; those of boundary vertices are kept, others ignored.
/// @throws InvalidInput if factors has another size.
[[nodiscard]] FlatMetric flatten_disc(IntrinsicTriangulation triangulation,
                                      const Eigen::VectorXd& factors,
                                      const TriangulationRepairOptions& options = {});

/// Flattens a closed surface of genus 0 with one vertex at infinity, from where all neighbours look
/// equally far: u_i = -2 log a_0i on its link (Bobenko, Pinkall, Springborn 2015, section 3.2). In
/// repairs a link edge whose face breaks at it flips, so that the third vertex joins the link; an
/// edge at infinity that may flip does so where the link is reflex. With all edges released these
/// are the optimality conditions of the convex problem that always has a solution (Springborn 2019).
[[nodiscard]] FlatMetric flatten_punctured_sphere(IntrinsicTriangulation triangulation,
                                                  int removed_vertex,
                                                  const TriangulationRepairOptions& options = {});

} // namespace shape::internal
