// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_angles.h"

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/dihedral_angles.h"

namespace shape::internal {

using Eigen::Index;

namespace {

constexpr double sharp = 2.0; ///< [rad]; the fold begins at 2 pi / 3.

} // namespace

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

void BranchSums::look_for_sharp(const RowMatrix& angles)
{
    parallel_for(to_size(angles.cols()), 4096, [&](std::size_t begin, std::size_t end) {
        const auto first = static_cast<Index>(begin);
        const auto count = static_cast<Index>(end - begin);
        auto sharpest = sharpest_.segment(first, count);
        for (Index i = 0; i < angles.rows(); ++i)
            sharpest =
                sharpest.cwiseMax(angles.row(i).segment(first, count).transpose().cwiseAbs());
    });
}

void BranchSums::add_sharp(Index first, const RowMatrix& columns)
{
    Eigen::VectorXd angles(columns.rows()), sines(columns.rows()), cosines(columns.rows());
    for (Index e = 0; e < columns.cols(); ++e) {
        if (sharpest_[first + e] <= sharp)
            continue;
        angles = columns.col(e);
        sines_cosines(angles.data(), to_size(angles.size()), sines.data(), cosines.data());
        for (Index i = 0; i < angles.size(); ++i) { // in the order of add()
            cosines_[first + e] += cosines[i];
            sines_[first + e] += sines[i];
        }
    }
}

bool BranchSums::has_sharp(Index first, Index count) const
{
    return (sharpest_.segment(first, count).array() > sharp).any();
}

Eigen::VectorXd BranchSums::means(Index count) const
{
    Eigen::VectorXd means = Eigen::VectorXd::Zero(sharpest_.size());
    for (Index e = 0; e < means.size(); ++e)
        if (sharpest_[e] > sharp)
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
