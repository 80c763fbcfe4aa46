// SPDX-License-Identifier: MIT

#pragma once

#include <span>
#include <string>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/mesh/points.h"

namespace shape {

/// Vertices that lie on one another, ascending; at least two.
using VertexGroup = std::vector<int>;

/// How near vertices must be that lie on one another, as a part of the diagonal of the bounding box:
/// coordinates in single precision, of a mesh around the origin.
inline constexpr double coincidence = 1e-7;

/// The groups of vertices that lie on one another in every one of the meshes, by their lowest
/// vertex. Exporters double vertices where texture or normals jump; edge lengths do not know that
/// such a seam is closed, and a blend tears it open.
///
/// Two vertices lie on one another if their distance is <= `tolerance` times the diagonal of the bounding
/// box, directly or by way of others. Of more than 64 vertices in one place the rest may be left apart.
///
/// @param meshes  At least one; all of one size, finite.
/// @param tolerance  >= 0.
/// @throws InvalidInput if a rule is broken.
/// Cost: O(#V log #V) once and O(#V) a mesh.
[[nodiscard]] std::vector<VertexGroup> coincident_vertices(std::span<const Points> meshes,
                                                           double tolerance = coincidence);

/// Where the boundary of a surface meets itself in every one of some meshes.
struct SeamVertices
{
    std::vector<VertexGroup> coincident; ///< On one another, as nearly as their numbers can tell.
    /// Further groups, whose vertices are a little apart: rounded more than their numbers show, or meant. A group may
    /// hold some of `coincident`.
    std::vector<VertexGroup> near;
    double gap =
        0.0; ///< Of `near`: the farthest from the first of its group, over the diagonal [1].
};

/// The groups of boundary vertices (ends of edges that one face alone has) that meet in all meshes, by their lowest
/// vertex. With the diagonal D and the spacing s of the coordinates (coordinate_spacing.h: 6e-5 for single precision
/// at 900) of a mesh, and the shortest edge l at either of them, two vertices
/// - lie on one another if their distance is <= max(1e-7 D, min(r D, l / 10)), where r is the largest 4 s / D of the
///   meshes, and at most 1e-4: the same for all meshes;
/// - lie near one another if it is <= max(1e-7 D, min(1e-3 D, l / 10));
/// directly or by way of others. Of more than 64 vertices in one place the rest may be left apart.
///
/// @param faces  Any, of the vertices of the meshes.
/// @param meshes  At least one; all of one size, finite.
/// @throws InvalidInput if a rule is broken.
/// Cost: O(#F log #F) once, and of each mesh O(#F + #B log #B) for #B boundary vertices while any meet.
[[nodiscard]] SeamVertices seam_vertices(const Faces& faces, std::span<const Points> meshes);

/// "; 24 of 24 vertices lie on others: ..." if boundary vertices do, or near others, else empty (also if a coordinate
/// is not finite): what may have broken a surface into components.
/// @throws InvalidInput if a face names a vertex that is not.
[[nodiscard]] std::string describe_coincident(const Faces& faces, const Points& points);

/// Thrown by collect(): a surface in several pieces, or with several fans of faces at a vertex, of which
/// there are fewer once weld() makes one of the vertices that lie on one another.
class SplitSurface : public InvalidInput
{
public:
    using InvalidInput::InvalidInput;
};

/// The faces with some vertices made one, or with some left out.
struct VertexChoice
{
    Faces faces;
    std::vector<int> vertices; ///< Entry i: what vertex i of the faces was before; ascending.
};

/// Makes each group one vertex, the lowest; the others keep their order. Faces that lose a corner by
/// it go.
/// @throws InvalidInput if a face or a group names a vertex outside [0, vertex_count).
/// Cost: O(#V + #F).
[[nodiscard]] VertexChoice weld(const Faces& faces, int vertex_count,
                                const std::vector<VertexGroup>& groups);

/// Keeps these faces and the vertices that they have; both keep their order.
/// @param kept  One entry a face. @throws InvalidInput if not, or if a vertex is out of range.
[[nodiscard]] VertexChoice keep_faces(const Faces& faces, int vertex_count,
                                      const std::vector<bool>& kept);

/// The positions of the chosen vertices.
[[nodiscard]] Points chosen_points(const Points& points, const std::vector<int>& vertices);

} // namespace shape
