// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/conformal/sphere_map.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// The morph from a mesh (k = 0) to its conformal sphere (k = 1): lengths by eq. (13) of Rojas 2014
/// with the factors k u, companion dihedral angles blended from both ends (section 5 there).
struct ConformalMorph
{
    Topology topology;
    Eigen::VectorXd log_lengths; ///< #E, of the mesh.
    Eigen::VectorXd log_ratios; ///< #E, log(sphere / mesh): (u_i + u_j) / 2, and the measured ratio
                                ///< on flipped edges, so that k = 1 is the sphere in any case.
    RowMatrix dihedral_angles;  ///< 2 by #E [rad]: mesh, sphere; on one branch per edge.
};

/// One point of the morph. Blending factors linearly may break triangle inequalities although both
/// ends keep them: in log lengths the broken triangles, not the others, are a convex set.
struct MorphFrame
{
    ShapePoint point;                 ///< Keeps every triangle inequality by a part in 1e-6.
    std::vector<int> corrected_faces; ///< Faces that eq. (13) breaks, or all but breaks. Ascending.
    double largest_correction = 0.0;  ///< max |l / l* - 1|, l* by eq. (13).
};

/// @param points  The mesh that `map` was made from, #V by 3 [length].
/// @throws InvalidInput if sizes differ, or the map is Unsolved.
[[nodiscard]] ConformalMorph make_conformal_morph(const Topology& topology, const Points& points,
                                                  const SphereMap& map);

/// The point at parameter k, corrected where needed: the lengths l that minimise
/// sum_e (l_e / l*_e - 1)^2 with longest <= (1 - 1e-6) (sum of the others) in every face. The
/// minimiser is unique and depends continuously on k.
/// @param k  In [0, 1].
/// @throws InvalidInput if k is outside.
[[nodiscard]] MorphFrame morph_frame(const ConformalMorph& morph, double k);

/// k = sin(pi s / 2): equal steps of s are about equal steps of shape. At k a cylinder has become a
/// cone that opens by asin(k) to either side, so equal steps of k would tear the end apart.
/// @param s  In [0, 1].
[[nodiscard]] double morph_parameter(double s);

/// s of morph_parameter.
/// @param k  In [0, 1].
[[nodiscard]] double inverse_morph_parameter(double k);

} // namespace shape
