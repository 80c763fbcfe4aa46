// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_angles.h"

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/dihedral_angles.h"

namespace shape::internal {

using Eigen::Index;

void measure_angles(const Collection& block, RowMatrix& angles)
{
    angles.resize(static_cast<Index>(block.size()), block.topology.edge_count());
    parallel_for(block.size(), 1, [&](std::size_t mesh, std::size_t) {
        angles.row(static_cast<Index>(mesh)) =
            dihedral_angles(block.topology, block.points[mesh]).transpose();
    });
}

BranchSums::BranchSums(Index edges)
    : sharpest_(Eigen::VectorXd::Zero(edges)), cosines_(sharpest_), sines_(sharpest_)
{
}

void BranchSums::add(const RowMatrix& angles)
{
    constexpr std::size_t strip = 2048; // edges that are worked on together
    parallel_for(to_size(angles.cols()), strip, [&](std::size_t begin, std::size_t end) {
        const auto first = static_cast<Index>(begin);
        const auto count = static_cast<Index>(end - begin);
        Eigen::VectorXd sines(count), cosines(count);
        for (Index i = 0; i < angles.rows(); ++i) {
            const auto row = angles.row(i).segment(first, count).transpose();
            sines_cosines(row.data(), to_size(count), sines.data(), cosines.data());
            sharpest_.segment(first, count) =
                sharpest_.segment(first, count).cwiseMax(row.cwiseAbs());
            cosines_.segment(first, count) += cosines;
            sines_.segment(first, count) += sines;
        }
    });
}

Eigen::VectorXd BranchSums::means(Index count) const
{
    constexpr double near = 2.0; // [rad]; the fold begins at 2 pi / 3
    Eigen::VectorXd means = Eigen::VectorXd::Zero(sharpest_.size());
    for (Index e = 0; e < means.size(); ++e)
        if (sharpest_[e] > near)
            means[e] = circular_mean(cosines_[e], sines_[e], static_cast<double>(count));
    return means;
}

std::vector<std::span<double>> BranchSums::sums()
{
    return {{cosines_.data(), to_size(cosines_.size())}, {sines_.data(), to_size(sines_.size())}};
}

std::span<double> BranchSums::largest()
{
    return {sharpest_.data(), to_size(sharpest_.size())};
}

void BranchSums::save(PassState& state) const
{
    for (const Eigen::VectorXd* sums : {&sharpest_, &cosines_, &sines_})
        state.arrays.emplace_back(sums->transpose());
}

void BranchSums::restore(PassStateReader& state)
{
    for (Eigen::VectorXd* sums : {&sharpest_, &cosines_, &sines_})
        *sums = state.vector(sums->size());
}

void unify_branches(RowMatrix& angles, const Eigen::VectorXd& means)
{
    parallel_for(to_size(angles.rows()), 1, [&](std::size_t i, std::size_t) {
        auto row = angles.row(static_cast<Index>(i));
        for (Index e = 0; e < row.size(); ++e)
            row[e] = on_branch(row[e], means[e]);
    });
}

} // namespace shape::internal
