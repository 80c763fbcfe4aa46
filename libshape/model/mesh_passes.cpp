// SPDX-License-Identifier: MIT

#include "libshape/model/mesh_passes.h"

#include <algorithm>
#include <utility>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/streamed_space.h"
#include "libshape/model/streamed_fit.h"

namespace shape::internal {
namespace {

using Eigen::Index;

using Arrays = std::vector<std::vector<double>>;

/// Adds partial sums two by two as soon as both are there, so that few are held.
class PartialSumTree
{
public:
    explicit PartialSumTree(const std::vector<std::span<double>>& sums) : sums_(sums) {}

    /// @param is_last  The arrays stay where they are, with all that was added before.
    void end_sum(bool is_last)
    {
        int level = 0;
        while (!waiting_.empty() && waiting_.back().level == level) {
            for (std::size_t k = 0; k < sums_.size(); ++k)
                for (std::size_t i = 0; i < sums_[k].size(); ++i)
                    sums_[k][i] = waiting_.back().arrays[k][i] + sums_[k][i];
            waiting_.pop_back();
            ++level;
        }
        if (is_last)
            return;
        Arrays arrays;
        for (const std::span<double> sum : sums_) {
            arrays.emplace_back(sum.begin(), sum.end());
            std::ranges::fill(sum, 0.0);
        }
        waiting_.push_back({level, std::move(arrays)});
    }

private:
    struct Waiting
    {
        int level;
        Arrays arrays;
    };
    const std::vector<std::span<double>>& sums_;
    std::vector<Waiting> waiting_;
};

/// The number with its lowest `bits` bits in the other order.
int mirrored(int number, int bits)
{
    int result = 0;
    for (int bit = 0; bit < bits; ++bit)
        result |= (number >> bit & 1) << (bits - 1 - bit);
    return result;
}

} // namespace

MeshPasses::MeshPasses(const MeshStream& meshes, const SpaceOptions& space, std::uint64_t memory,
                       Progress progress, Ranks ranks)
    : meshes_(meshes),
      space_(make_space(meshes, space, 8)),
      dimension_(internal::dimension(space_, meshes.topology)),
      memory_(memory > 0 ? memory : usual_memory()),
      progress_(std::move(progress)),
      ranks_(std::move(ranks))
{
    check(ranks_);
}

/// Tiles number, number + partial_sums, number + 2 partial_sums, ...
void MeshPasses::run_partial_sum(const PassRange& range, Index number, const Visit& visit)
{
    const auto [begin, end, tile] = range;
    if (ranks_.partial_sums == 1)
        return for_each_block(meshes_, begin, end, tile, [&](Index first, const Collection& part) {
            visit(first, part, rows_);
        });
    std::vector<std::size_t> own;
    for (Index first = begin + number * tile; first < end; first += ranks_.partial_sums * tile)
        for (Index mesh = first; mesh < std::min(first + tile, end); ++mesh)
            own.push_back(to_size(mesh));
    const MeshStream some = subset(meshes_, own);
    for_each_block(some, 0, some.size(), tile, [&](Index first, const Collection& part) {
        visit(static_cast<Index>(own[to_size(first)]), part, rows_);
    });
}

void MeshPasses::run(const std::string& name, const PassRange& range, const Visit& visit,
                     const std::vector<std::span<double>>& sums,
                     const std::function<void()>& finish)
{
    const auto kilobytes = [&](Index count) {
        return to_size(count) * to_size(meshes_.bytes_per_mesh) / 1000;
    };
    const std::string stage = join("pass ", count_ + 1, ", ", name, ", kB");
    const Index share = (range.end - range.begin) / ranks_.count;
    Index done = 0;
    const auto visit_and_tell = [&](Index first, const Collection& block, RowMatrix& rows) {
        visit(first, block, rows);
        done += static_cast<Index>(block.size());
        if (progress_)
            progress_(stage, kilobytes(done), kilobytes(std::max(share, done)));
    };
    // Partial sums are added as a tree over the bits of their numbers, the highest first; the lowest bits say which
    // process takes one, so that the last steps are between processes.
    PartialSumTree tree(sums);
    const int own = ranks_.partial_sums / ranks_.count;
    int bits = 0;
    while (1 << bits < own)
        ++bits;
    for (int k = 0; k < own; ++k) {
        run_partial_sum(range, ranks_.number + ranks_.count * mirrored(k, bits), visit_and_tell);
        if (finish)
            finish();
        tree.end_sum(k + 1 == own);
    }
    for (const std::span<double> sum : sums)
        ranks_.all_reduce_sum(sum);
    ++count_;
}

void MeshPasses::show(const PassRange& range, const Visit& visit)
{
    for_each_block(meshes_, range.begin, range.end, range.tile,
                   [&](Index first, const Collection& part) { visit(first, part, rows_); });
}

void MeshPasses::gather(std::span<double> numbers) const
{
    ranks_.all_reduce_sum(numbers);
}

void MeshPasses::encode(const Collection& block, RowMatrix& rows) const
{
    Eigen::VectorXd sizes;
    internal::encode(space_, block, rows, sizes);
}

void MeshPasses::encode(const Collection& block, RowMatrix& rows,
                        Eigen::Ref<Eigen::VectorXd> sizes) const
{
    Eigen::VectorXd measured;
    internal::encode(space_, block, rows, measured);
    sizes = measured;
}

} // namespace shape::internal
