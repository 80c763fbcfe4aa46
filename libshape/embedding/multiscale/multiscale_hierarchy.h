// SPDX-License-Identifier: MIT

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "libshape/embedding/multiscale/patch_registration.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Entries [begin, begin + count) of an array.
struct Slice
{
    std::size_t begin = 0;
    int count = 0;
};

/// A patch of faces, with slices of the arrays of its MultiscaleHierarchy. A node without children
/// is a leaf; its patch is glued, that of any other node is blended from its children's.
struct PatchNode
{
    int parent = -1;     ///< -1 at the root, which is node 0.
    int first_child = 0; ///< Children are consecutive; each shares vertices with one before it.
    int child_count = 0;
    Slice faces{};
    Slice vertices{};
    Slice edges{};
    Slice overlaps{}; ///< What the children share.
    Slice gluing{};   ///< How a leaf is glued.

    [[nodiscard]] bool is_leaf() const { return child_count == 0; }
};

/// An edge of a patch, by rows of the patch's vertices.
struct PatchEdge
{
    int lower = 0;
    int upper = 0;  ///< > lower
    int edge = 0;   ///< Its number in the topology.
    int copies = 0; ///< Number of children that have it; 0 in a leaf.
};

/// One triangle of a leaf. The edge from vertices 0 to 1 belongs, in this direction, to a triangle
/// placed before, whose third vertex is 2; vertex 3 is to be placed beyond it. The first entry of a
/// leaf is its first triangle, vertices 0 to 2, and has no vertex 3.
struct GlueStep
{
    std::array<int, 4> vertices{}; ///< Rows of the leaf's vertices.
    std::array<int, 3> edges{}; ///< Numbers in the topology: 0 1, 0 3, 1 3; at first 0 1, 0 2, 1 2.
};

/// Nodes below one other, all in one run: what one thread works on.
struct Subtree
{
    int root = 0;
    int begin = 0; ///< Nodes below the root are [begin, end); end == begin if it is a leaf.
    int end = 0;
};

/// A mesh split into patches, those into smaller ones, and so on. Children come after their
/// parents. Every patch is connected across edges.
struct MultiscaleHierarchy
{
    std::vector<PatchNode> nodes;
    std::vector<int> faces;
    std::vector<int> vertices;  ///< In the order of elimination, the same in all patches.
    std::vector<int> in_parent; ///< Beside `vertices`: the row in the parent; unused at the root.
    std::vector<PatchEdge> edges;
    std::vector<PatchOverlap> overlaps;
    std::vector<CommonVertex> common; ///< What the overlaps refer to.
    std::vector<GlueStep> gluing;
    std::vector<Subtree> subtrees; ///< Their roots, and what is above them, are nodes [0, top).
    int top = 0;
};

struct HierarchyOptions
{
    /// Seed triangles are drawn by this.
    std::uint64_t seed = 1;
    /// A patch is split into this many, m of Winkler 2010; in [4, max_patches].
    int children = 6;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const HierarchyOptions& options);

/// Splits a mesh as Winkler 2010, section 3.3, does: from m random seed triangles, regions grow
/// until they meet. The seeds are moved twice to the middle of what they reach (not in the paper). Where two
/// regions meet, the one that comes first takes the triangle behind the edge: neighbours overlap in
/// a strip of width one. Patches of less than m triangles, and those that no split makes smaller,
/// are leaves.
/// @param points  Any mesh of the topology; only the middles of the regions depend on it.
/// @throws InvalidInput if points has another size or children is out of its range.
/// Cost: O(#F log #F). Same result for any thread count.
[[nodiscard]] MultiscaleHierarchy build_hierarchy(const Topology& topology, const Points& points,
                                                  const HierarchyOptions& options = {});

} // namespace shape::internal
