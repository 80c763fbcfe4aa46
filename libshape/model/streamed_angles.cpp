// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_angles.h"

#include <array>
#include <cmath>
#include <vector>

#include "libshape/base/gathered_vectors.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/base/vectorised.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/hinge.h"
#include "libshape/mesh/measured_angles.h"

namespace shape::internal {

using Eigen::Index;

namespace {

/// Sums of the unit vectors in the direction of the angles of hinges (mesh/hinge.h), and whether an angle is
/// sharp, from edges b - a and sides c - a and d - a:
///
///     (sine, cosine) = (e . (n x m), |e| n . m) / |..|,      sharp: cosine < cos 2.
///
/// In memory a coordinate of 128 hinges is a row, edges.x: x0 x1 .. x127. The plain way, atan2 for every
/// angle and its sine and cosine afterwards, takes three times as long; here a lane is a hinge, and no angle is needed.
SHAPE_VECTORISED void add_directions(int count, const VectorRows& edges, const VectorRows& left,
                                     const VectorRows& right, double* __restrict sines,
                                     double* __restrict cosines, double* __restrict sharps)
{
    constexpr double cosine_of_sharp = -0.41614683654714241; // cos 2; the fold begins at 2 pi / 3
    for (int i = 0; i < count; ++i) {
        const Vector3<double> edge = edges[i];
        const auto normals = hinge_normals(edge, left[i], right[i]);
        const auto angle =
            hinge_angle(edge, std::sqrt(dot(edge, edge)), normals.left, normals.right);
        const double norm = std::sqrt(angle.sine * angle.sine + angle.cosine * angle.cosine);
        const bool is_flat = !(norm > 0.0); // on the boundary, or not defined
        const double cosine = is_flat ? 1.0 : angle.cosine / norm;
        sines[i] += is_flat ? 0.0 : angle.sine / norm;
        cosines[i] += cosine;
        sharps[i] = cosine < cosine_of_sharp ? 1.0 : sharps[i];
    }
}

} // namespace

void measure_angles(const Collection& block, Block angles)
{
    parallel_for(block.size(), 1, [&](std::size_t mesh, std::size_t) {
        measure_dihedral_angles(block.topology, block.points[mesh],
                                angles.row(static_cast<Index>(mesh)).transpose());
    });
}

BranchSums::BranchSums(Index edges)
    : sharp_(Eigen::VectorXd::Zero(edges)), cosines_(sharp_), sines_(sharp_)
{
}

void BranchSums::add(const Collection& block)
{
    const Topology& topology = block.topology;
    for_blocks(topology.edge_count(), [&](int first, int count) {
        std::array<std::array<int, 4>, block_size> corners;
        for (int i = 0; i < count; ++i) {
            std::array<int, 4>& hinge = corners[to_size(i)];
            hinge = hinge_corners(topology, first + i);
            if (hinge[3] < 0)
                hinge[3] = hinge[0]; // the boundary is flat
        }
        const auto corner = [&](int k) { return StridedRows{corners[0].data() + k, 4}; };
        for (const Points& points : block.points) {
            VectorRows along, left, right;
            gather_differences(count, points.data(), corner(1), corner(0), along);
            gather_differences(count, points.data(), corner(2), corner(0), left);
            gather_differences(count, points.data(), corner(3), corner(0), right);
            add_directions(count, along, left, right, sines_.data() + first,
                           cosines_.data() + first, sharp_.data() + first);
        }
    });
}

Eigen::VectorXd BranchSums::means(Index count) const
{
    Eigen::VectorXd means = Eigen::VectorXd::Zero(sharp_.size());
    for (Index e = 0; e < means.size(); ++e)
        if (sharp_[e] > 0.0)
            means[e] = circular_mean(cosines_[e], sines_[e], static_cast<double>(count));
    return means;
}

std::vector<std::span<double>> BranchSums::sums()
{
    return {{cosines_.data(), to_size(cosines_.size())}, {sines_.data(), to_size(sines_.size())}};
}

std::span<double> BranchSums::largest()
{
    return {sharp_.data(), to_size(sharp_.size())};
}

void BranchSums::save(PassState& state) const
{
    for (const Eigen::VectorXd* sums : {&sharp_, &cosines_, &sines_})
        state.arrays.emplace_back(sums->transpose());
}

void BranchSums::restore(PassStateReader& state)
{
    for (Eigen::VectorXd* sums : {&sharp_, &cosines_, &sines_})
        *sums = state.vector(sums->size());
}

void unify_branches(Block angles, const Eigen::VectorXd& means)
{
    std::vector<Index> near_fold; // few
    for (Index e = 0; e < means.size(); ++e)
        if (means[e] != 0.0)
            near_fold.push_back(e);
    parallel_for(to_size(angles.rows()), 1, [&](std::size_t i, std::size_t) {
        auto row = angles.row(static_cast<Index>(i));
        for (const Index e : near_fold)
            row[e] = on_branch(row[e], means[e]);
    });
}

} // namespace shape::internal
