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
    /// Meshes of which that is a guess: open ones that bend the other way than the others, as a mirror image would, and
    /// may do so by nature. None of `mirrored`; ascending.
    std::vector<std::size_t> bent;
    /// The others are inside out.
    bool inside_out = false;
};

/// Compares the meshes. Of closed ones, the signs of their volumes tell; nothing is said of a mesh whose
/// abs(V) / A^1.5 is below a quarter of the median, as of one whose vertices are permuted. Open ones are compared by
/// the sines of their dihedral angles, which a mirror image negates: mesh i is of the other kind if the cosine
/// between its sines and the mean of the others' (each turned by its sign) is < -0.5. Those are mirror images, and not
/// `bent` as leaves, membranes, caps and bags are, where
/// - the volumes with openings filled have opposite signs, by the bounds of `inside_out` below, and no opening has more
///   than a tenth of the area: what is wider can be pulled inside out; or
/// - the surface is none that can be pushed through: the strain of laying it flat, that may_bend_over() bounds, is >= 20 rad
///   of the mean curvature of all meshes, spread over five rings, which leaves noise out (sheets, domes, boxes and tubes have
///   up to 13, faces, arms and hands 60 and more); and the mirror image of each is nearer to one of the others than 0.7 of
///   what it is itself (after the best motion, unit sizes): where a middle was pushed through, the rim stayed.
/// How far or how alike they bend tells nothing: caps that snap through evenly bend as far as before.
/// All are inside out if V < 0 (V volume, A area) for all that are not mirrored; of open meshes, if
/// V < -0.02 A^1.5 and the fans that fill their openings have an area <= A / 4: a sheet or a bowl has
/// no inside.
/// @param meshes  Each #V by 3.
/// @throws InvalidInput if one has another number of vertices.
/// Cost: O(N #F); of open meshes, at most 2,000 angles each.
[[nodiscard]] Handedness compare_handedness(const Topology& topology,
                                            std::span<const Points> meshes);

/// Whether a surface is a sheet that ordinary bending takes to its mirror image, as a leaf that curls the other way, so
/// that nothing tells one from the other: open, of genus 0, and it can be laid flat with little strain,
///
///     sum abs(2 pi - a_v) over the inner vertices + sum abs(abs(t_l) - 2 pi) over the loops of the boundary < 1 rad
///
/// (a_v: sum of the angles at v; t_l: the angle by which loop l turns within the surface, 0 at the ends of a tube). Sheets
/// with noise have 0.04 to 1, faces, hands and arms 20 and more.
/// @throws InvalidInput if points do not fit the topology. Cost: O(#F).
[[nodiscard]] bool may_bend_over(const Topology& topology, const Points& points);

/// Whether a mesh is a mirror image of another of the same triangulation, by that rule; or of meshes of which the other is
/// one, if their mean dihedral angles are given: of open ones, these tell better than those of one mesh.
/// Of open ones that may be a guess, as compare_handedness() says.
/// @param mean_dihedral_angles  #E [rad], or empty.
/// @throws InvalidInput if a number of vertices or edges is another.
/// Cost: as compare_handedness() of two.
[[nodiscard]] bool is_mirror_image(const Topology& topology, const Points& mesh,
                                   const Points& reference,
                                   const Eigen::VectorXd& mean_dihedral_angles = {});

/// Whether a mesh of which is_mirror_image() says so may as well bend the other way by nature: what compare_handedness() of
/// the two calls `bent`; if mean angles are given, an open mesh of which that strain is below 20 rad.
/// @throws InvalidInput as is_mirror_image().
[[nodiscard]] bool may_be_bent(const Topology& topology, const Points& mesh,
                               const Points& reference,
                               const Eigen::VectorXd& mean_dihedral_angles = {});

} // namespace shape
