// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <vector>

#include "libshape/base/to_size.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// The faces of a mesh in connected patches, and how to get from face to face.
struct FacePatches
{
    /// The way out of a face over one of its half-edges, within its patch.
    struct Way
    {
        int neighbour; ///< Its place in the patch, -1 if it is of another one.
        int edge;
        bool from_left; ///< The face lies left of the edge.
    };
    struct Bridge ///< An edge between patches.
    {
        int edge, lower_face, higher_face; ///< Faces of the lower and the higher patch.
        bool from_left;                    ///< The lower one lies left of the edge.
    };
    struct Pair ///< Patches with bridges between them.
    {
        int lower, higher;
        int rank; ///< Among the pairs of its lower patch.
        std::size_t first_bridge;
    };

    int edge_count;
    std::vector<int> faces;      ///< Patch by patch; the first of a patch is its root.
    std::vector<int> begins;     ///< Where each patch begins in `faces`, and the end.
    std::vector<Way> ways;       ///< Three of every entry of `faces`.
    std::vector<Bridge> bridges; ///< Pair by pair.
    std::vector<Pair> pairs;     ///< Sorted.
    int largest = 0;             ///< Number of faces.

    /// Breadth-first discs of at most this many faces; those left over at the rim of one seed the next.
    /// Where fewer than an eighth are left between discs, they join one of them.
    /// Cost: O(#F log #F).
    FacePatches(const Topology& topology, int faces_per_patch);

    [[nodiscard]] int count() const { return static_cast<int>(begins.size()) - 1; }
    [[nodiscard]] int begin(int patch) const { return begins[to_size(patch)]; }
    [[nodiscard]] int size(int patch) const { return begin(patch + 1) - begin(patch); }

    /// Where the bridges of a pair end.
    [[nodiscard]] std::size_t end_bridge(std::size_t pair) const
    {
        return pair + 1 < pairs.size() ? pairs[pair + 1].first_bridge : bridges.size();
    }
};

} // namespace shape::internal
