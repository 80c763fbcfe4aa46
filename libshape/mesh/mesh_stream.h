// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "libshape/mesh/collection.h"

namespace shape {

/// Meshes in correspondence whose positions are read when they are needed: a collection that need not
/// fit into memory.
struct MeshStream
{
    /// Makes the meshes that were fetched, on all threads; points are #V by 3 already.
    using Unpack = std::function<void(std::span<Points> points)>;

    Topology topology;
    std::vector<std::string> names;   ///< N, unique.
    Labels labels;                    ///< Each column N values.
    std::uint64_t bytes_per_mesh = 0; ///< Read for a mesh.
    /// Reads the bytes of meshes, ascending indices in [0, N), and does no more than to wait for them:
    /// it is called ahead, on a thread of its own.
    std::function<Unpack(std::vector<Eigen::Index> meshes)> fetch;

    [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(names.size()); }
};

/// A collection in memory as a stream, which refers to it.
[[nodiscard]] MeshStream stream_of(const Collection& collection);

/// Some meshes of a stream, with their labels, by ascending indices in [0, N).
/// @throws InvalidInput naming an index that is not in [0, N), or not above the one before.
[[nodiscard]] MeshStream subset(const MeshStream& stream, const std::vector<std::size_t>& meshes);

/// The meshes of both, one after the other. Where one has a label that the other lacks, its values
/// are empty there.
/// @throws InvalidInput if a name occurs in both, or the triangulations differ.
[[nodiscard]] MeshStream joined(const MeshStream& first, const MeshStream& second);

/// Runs visit(first, block) for the meshes [begin, end) in order, `size` at a time (the last ones fewer).
/// The next block is read meanwhile on a thread; without one to be had, in between.
/// @param block  A collection without names and labels: meshes first, first + 1, ...
void for_each_block(const MeshStream& stream, Eigen::Index begin, Eigen::Index end,
                    Eigen::Index size,
                    const std::function<void(Eigen::Index first, const Collection& block)>& visit);

} // namespace shape
