// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape {

/// What a triangulation may break.
enum class DefectKind
{
    Empty,              ///< No vertex or no face.
    IndexOutOfRange,    ///< A face names a vertex that does not exist.
    DegenerateFace,     ///< A face names a vertex twice.
    DuplicateFace,      ///< Two faces have the same three vertices.
    NonManifoldEdge,    ///< An edge has more than two faces.
    FlippedFace,        ///< Two faces run through an edge in the same direction.
    BowTie,             ///< The faces at a vertex form more than one fan.
    IsolatedVertex,     ///< A vertex has no face.
    SeveralComponents,  ///< The surface is not connected.
    NotFinite,          ///< A coordinate is NaN or infinite.
    DegenerateTriangle, ///< A face has zero area or an edge of zero length.
    SizeOutOfRange,     ///< Edges are so long or short that powers of them over- or underflow.
};

/// One defect: the kind, the place, and a sentence with the place, the rule and a way to repair it.
struct Defect
{
    DefectKind kind;
    int face = -1;   ///< First face concerned, -1 if none.
    int vertex = -1; ///< First vertex concerned, -1 if none.
    std::string message;
};

/// Lists what keeps a face list from being one connected oriented manifold, possibly with
/// boundary; empty if nothing does. Connectivity alone, no positions.
///
/// @param limit  At most this many defects of each kind are listed; > 0.
/// Cost: O(#F log #F).
[[nodiscard]] std::vector<Defect> find_defects(const Faces& faces, int vertex_count, int limit = 5);

/// Lists positions that are not finite and faces whose area [length^2] is at most 1e-14 times
/// the square of their longest edge: there, angles have no meaning. Where the longest edge of all is not in
/// [1e-60, 1e60] [length], that alone: angles and energies hold fifth powers of lengths.
/// @param faces  Indices in [0, points.rows()).
[[nodiscard]] std::vector<Defect> find_degenerate_geometry(const Faces& faces, const Points& points,
                                                           int limit = 5);

} // namespace shape
