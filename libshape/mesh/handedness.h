// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// Volume inside a mesh [length^3]: sum over the faces of det(a, b, c) / 6. Positive if the faces run
/// counter-clockwise seen from outside, negative if the mesh is inside out. Every loop of the boundary
/// is filled by a fan around its centroid. A mirror image has the negative.
/// @throws InvalidInput if points do not fit the topology. Cost: O(#F).
[[nodiscard]] double signed_volume(const Topology& topology, const Points& points);

/// What the volumes and dihedral angles of meshes of one triangulation say of their orientation.
struct Handedness
{
    /// Meshes that are mirror images of the others: the fewer of the two kinds; of equally many,
    /// those inside out. Ascending.
    std::vector<std::size_t> mirrored;
    /// The others are inside out.
    bool inside_out = false;
};

/// Compares the meshes. Of closed ones, the signs of their volumes tell; nothing is said of a mesh whose
/// abs(V) / A^1.5 is below a quarter of the median, as of one whose vertices are permuted. Open ones are compared by
/// the sines of their dihedral angles, which a mirror image negates: mesh i is of the other kind if the cosine
/// between its sines and the mean of the others' (each turned by its sign) is < -0.5. All
/// are inside out if V < 0 (V volume, A area) for all that are not mirrored; of open meshes, if
/// V < -0.02 A^1.5 and the fans that fill their openings have an area <= A / 4: a sheet or a bowl has
/// no inside.
/// @param meshes  Each #V by 3.
/// @throws InvalidInput if one has another number of vertices.
/// Cost: O(N #F); of open meshes, at most 2,000 angles each.
[[nodiscard]] Handedness compare_handedness(const Topology& topology,
                                            std::span<const Points> meshes);

/// Whether a mesh is a mirror image of another of the same triangulation, by that rule; or of meshes of which the other is
/// one, if their mean dihedral angles are given: of open ones, these tell better than those of one mesh.
/// @param mean_dihedral_angles  #E [rad], or empty.
/// @throws InvalidInput if a number of vertices or edges is another.
/// Cost: as compare_handedness() of two.
[[nodiscard]] bool is_mirror_image(const Topology& topology, const Points& mesh,
                                   const Points& reference,
                                   const Eigen::VectorXd& mean_dihedral_angles = {});

} // namespace shape
