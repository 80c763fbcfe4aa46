// SPDX-License-Identifier: MIT

#pragma once

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

/// Compares the meshes. Of closed ones, the signs of their volumes tell. Open ones are compared by
/// their dihedral angles, which a mirror image negates: mesh i is of the other kind if the cosine
/// between its angles and the mean direction of all (each turned by its sign) is < -0.5. All
/// are inside out if V < 0 (V volume, A area) for all that are not mirrored; of open meshes, if
/// V < -0.02 A^1.5 and the fans that fill their openings have an area <= A / 4: a sheet or a bowl has
/// no inside.
/// @param meshes  Each #V by 3.
/// @throws InvalidInput if one has another number of vertices.
/// Cost: O(N #F); of open meshes, at most 2,000 angles each.
[[nodiscard]] Handedness compare_handedness(const Topology& topology,
                                            std::span<const Points> meshes);

/// Whether a mesh is a mirror image of another of the same triangulation, by that rule.
/// @throws InvalidInput if one has another number of vertices. Cost: as compare_handedness() of two.
[[nodiscard]] bool is_mirror_image(const Topology& topology, const Points& mesh,
                                   const Points& reference);

} // namespace shape
