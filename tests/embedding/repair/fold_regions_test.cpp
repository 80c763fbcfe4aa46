// SPDX-License-Identifier: MIT

#include "libshape/embedding/repair/fold_regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libshape/mesh/dihedral_angles.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

VectorXd rows_of(const Points& points)
{
    return points.reshaped<Eigen::RowMajor>();
}

TEST(FoldedRegions, AreTheRingsAroundFolds)
{
    const test::FoldedPatch patch = test::folded_patch();
    const Topology& t = patch.mesh.topology;
    const VectorXd angles = dihedral_angles(t, patch.mesh.points);
    const auto regions = folded_regions(t, rows_of(patch.folded), angles);
    ASSERT_EQ(regions.size(), 9U);
    for (std::size_t k = 0; k < regions.size(); ++k) {
        const int folded =
            49 * (8 + 16 * static_cast<int>(k / 3)) + 8 + 16 * static_cast<int>(k % 3);
        EXPECT_NE(std::find(regions[k].begin(), regions[k].end(), folded), regions[k].end());
        for (const int v : regions[k]) {
            EXPECT_LE(std::abs(v / 49 - folded / 49), 6);
            EXPECT_LE(std::abs(v % 49 - folded % 49), 6);
        }
    }
    EXPECT_TRUE(folded_regions(t, rows_of(patch.mesh.points), angles).empty());
    EXPECT_TRUE(
        folded_regions(t, rows_of(patch.folded), angles, {.fold_angle = 4.0, .suspect_angle = 0.5})
            .empty());
}

TEST(FoldedRegions, TakeAnglesAsTheyAreUpToFullTurns)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 1);
    VectorXd angles = dihedral_angles(mesh.topology, mesh.points);
    angles.array() += 2.0 * std::numbers::pi;
    EXPECT_TRUE(folded_regions(mesh.topology, rows_of(mesh.points), angles).empty());
}

} // namespace
} // namespace shape
