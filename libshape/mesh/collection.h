// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

#include "libshape/mesh/labels.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// N meshes in correspondence: one triangulation, N sets of positions, names and labels.
struct Collection
{
    Topology topology;
    std::vector<std::string> names; ///< N, unique.
    std::vector<Points> points;     ///< N of #V by 3 [length], finite.
    Labels labels;                  ///< Each column N values.

    [[nodiscard]] std::size_t size() const { return points.size(); }
};

/// Some meshes of a collection, with their labels, by indices in [0, N).
/// @throws InvalidInput naming an index that is not.
[[nodiscard]] Collection subset(const Collection& collection,
                                const std::vector<std::size_t>& meshes);

/// A mesh as read: faces may still be anything.
struct NamedMesh
{
    std::string name; ///< File stem, or the member of a collection file.
    std::string path; ///< For messages.
    Points points;
    Faces faces;
};

/// Puts meshes together, checking that they are in correspondence.
///
/// @throws InvalidInput naming the mesh and the place if there is no mesh, a name occurs twice, the
///     first mesh is not a valid Topology (SplitSurface if welding mends it), a mesh has degenerate
///     geometry (find_degenerate_geometry), or a mesh differs from the first; then the message names
///     the first differing face and the likely cause: other counts, permuted vertices or faces,
///     flipped orientation, or other diagonals.
/// Cost: linear in the input, O(#F log #F) once.
[[nodiscard]] Collection collect(std::vector<NamedMesh> meshes);

/// Why two face lists over the same number of vertices differ; empty if they are equal.
[[nodiscard]] std::string describe_correspondence_break(const NamedMesh& reference,
                                                        const NamedMesh& mesh);

} // namespace shape
