// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "libshape/base/progress.h"
#include "libshape/base/ranks.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/shape_space.h"
#include "libshape/linalg/dense.h"
#include "libshape/mesh/mesh_stream.h"

namespace shape::internal {

/// Meshes [begin, end) that come by, `tile` at a time.
struct PassRange
{
    Eigen::Index begin = 0;
    Eigen::Index end = 0;
    Eigen::Index tile = 1;
};

/// Passes over the meshes of a stream as points of a space, shared with other processes if there are some.
class MeshPasses
{
public:
    /// @param memory  [byte]; 0: usual_memory().
    /// @throws as make_space() of streams.
    /// Cost: as make_space(). The stream must outlive the passes.
    MeshPasses(const MeshStream& meshes, const SpaceOptions& space, std::uint64_t memory,
               Progress progress, Ranks ranks = {});

    [[nodiscard]] const MeshStream& meshes() const { return meshes_; }
    [[nodiscard]] const ShapeSpace& space() const { return space_; }
    [[nodiscard]] Eigen::Index dimension() const { return dimension_; }
    [[nodiscard]] std::uint64_t memory() const { return memory_; }
    [[nodiscard]] const Ranks& ranks() const { return ranks_; }
    [[nodiscard]] int count() const { return count_; } ///< Passes so far.
    void set_count(int count) { count_ = count; }      ///< Of a run that is resumed.

    /// All meshes.
    [[nodiscard]] PassRange all(Eigen::Index tile) const { return {0, meshes_.size(), tile}; }

    using Visit = std::function<void(Eigen::Index first, const Collection& block, RowMatrix& rows)>;

    /// A pass of which each process sees its own tiles. visit() may fill the array, which is kept: fresh
    /// memory costs more than what is done in it.
    /// @param sums  Arrays that visit() adds to: in the end the sums over all meshes. Each must be
    ///     0 at the beginning and in one piece.
    /// @param finish  Called before the sums are taken: adds to them what visit() has put off.
    void run(const std::string& name, const PassRange& range, const Visit& visit,
             const std::vector<std::span<double>>& sums = {},
             const std::function<void()>& finish = {});

    /// The same meshes for every process; no pass of its own.
    void show(const PassRange& range, const Visit& visit);

    /// Gives back the array that visit() fills: no further pass is near.
    void rest() { rows_.resize(0, 0); }

    /// Adds up what every process has found of its own tiles, 0 elsewhere.
    void gather(std::span<double> numbers) const;

    /// The coordinates of a block, and the sizes of its meshes.
    void encode(const Collection& block, RowMatrix& rows) const;
    void encode(const Collection& block, RowMatrix& rows, Eigen::Ref<Eigen::VectorXd> sizes) const;

private:
    void run_partial_sum(const PassRange& range, Eigen::Index number, const Visit& visit);

    const MeshStream& meshes_;
    ShapeSpace space_;
    Eigen::Index dimension_;
    std::uint64_t memory_;
    Progress progress_;
    Ranks ranks_;
    int count_ = 0;
    RowMatrix rows_;
};

/// The numbers of an array in one piece.
template <class Array>
[[nodiscard]] std::span<double> numbers_of(Array& array)
{
    return {array.data(), to_size(array.size())};
}

} // namespace shape::internal
