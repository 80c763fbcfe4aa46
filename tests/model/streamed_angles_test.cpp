// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_angles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string>

#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/shape_vectors.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

/// Sheets folded over where x = 0, with noise that makes some more hinges sharp.
Collection crumpled(int count)
{
    test::TestMesh patch = test::open_patch(12, 3);
    for (Index v = 0; v < patch.points.rows(); ++v) {
        const double beyond = std::max(patch.points(v, 0), 0.0);
        patch.points(v, 0) -= 2.0 * beyond;
        patch.points(v, 2) = 0.4 * beyond;
    }
    Collection meshes{patch.topology, {}, {}, {}};
    Random random(7);
    for (int i = 0; i < count; ++i) {
        Points points = patch.points;
        for (double& x : points.reshaped())
            x += random.uniform(-0.06, 0.06);
        meshes.points.push_back(points);
        meshes.names.push_back(std::to_string(i));
    }
    return meshes;
}

RowMatrix angles_of(const Collection& meshes)
{
    RowMatrix angles(static_cast<Eigen::Index>(meshes.size()), meshes.topology.edge_count());
    measure_angles(meshes, angles);
    return angles;
}

Collection part(const Collection& meshes, int first, int count)
{
    Collection some{meshes.topology, {}, {}, {}};
    some.points.assign(meshes.points.begin() + first, meshes.points.begin() + first + count);
    some.names.assign(meshes.names.begin() + first, meshes.names.begin() + first + count);
    return some;
}

TEST(BranchSums, AreThoseOfTheAnglesWhereOneIsSharp)
{
    const Collection meshes = crumpled(20);
    const RowMatrix angles = angles_of(meshes);
    BranchSums branches(angles.cols());
    branches.add(part(meshes, 0, 13));
    branches.add(part(meshes, 13, 7));
    const Eigen::VectorXd means = branches.means(20);
    int sharp = 0, beyond = 0;
    for (Index e = 0; e < angles.cols(); ++e) {
        const bool is_sharp = (angles.col(e).array().abs() > 2.0).any();
        EXPECT_EQ(branches.largest()[to_size(e)] > 0.0, is_sharp) << e;
        if (!is_sharp) {
            EXPECT_EQ(means[e], 0.0) << e;
            continue;
        }
        ++sharp;
        beyond += std::abs(means[e]) > 2.0 ? 1 : 0;
        const double expected = circular_mean(angles.col(e).array().cos().sum(),
                                              angles.col(e).array().sin().sum(), 20.0);
        EXPECT_NEAR(std::remainder(means[e] - expected, 2.0 * std::numbers::pi), 0.0, 1e-12) << e;
    }
    EXPECT_GT(sharp, 10);
    EXPECT_GT(beyond, 0);
    EXPECT_LT(sharp, angles.cols() / 2);
}

TEST(BranchSums, TurnNeitherByWhatIsFlatNorByBoundariesNorByMeshesWithoutArea)
{
    const test::TestMesh patch = test::open_patch(4, 1);
    const Points points = Points::Zero(patch.points.rows(), 3);
    BranchSums branches(patch.topology.edge_count());
    branches.add({patch.topology, {"a"}, {points}, {}});
    for (const double sharp : branches.largest())
        EXPECT_EQ(sharp, 0.0);
    for (const std::span<double> sum : branches.sums())
        for (const double value : sum)
            EXPECT_TRUE(value == 0.0 || value == 1.0);
}

TEST(BranchSums, HaveTheSameBitsForAnyThreadCountAndTile)
{
    const Collection meshes = crumpled(9);
    const auto means = [&](int threads, int tile) {
        const test::ThreadScope scope(threads);
        BranchSums branches(meshes.topology.edge_count());
        for (int first = 0; first < 9; first += tile)
            branches.add(part(meshes, first, std::min(tile, 9 - first)));
        return branches.means(9);
    };
    const Eigen::VectorXd expected = means(1, 9);
    EXPECT_TRUE(means(3, 9) == expected);
    EXPECT_TRUE(means(1, 2) == expected);
}

} // namespace
} // namespace shape
