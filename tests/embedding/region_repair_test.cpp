// SPDX-License-Identifier: MIT

#include "libshape/embedding/region_repair.h"

#include <gtest/gtest.h>

#include "libshape/embedding/fold_regions.h"
#include "libshape/embedding/hot_spots.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

using Eigen::VectorXd;

/// A height field whose vertex 84 lies over its neighbours, and its energy unfolded.
struct FoldedPatch
{
    test::TestMesh mesh = test::open_patch(12, 4);
    LengthDihedralEnergy energy{
        mesh.topology,
        {edge_lengths(mesh.topology, mesh.points), dihedral_angles(mesh.topology, mesh.points)},
        5e-3};
    VectorXd points;

    FoldedPatch()
    {
        Points folded = mesh.points;
        folded.row(84) += 2.2 * (mesh.points.row(85) - mesh.points.row(84));
        points = folded.reshaped<Eigen::RowMajor>();
    }
    [[nodiscard]] std::vector<std::vector<int>> folds() const
    {
        return folded_regions(mesh.topology, points, energy.target().dihedral_angles);
    }
    [[nodiscard]] double distance(const VectorXd& from) const
    {
        return (Eigen::Map<const Points>(from.data(), mesh.points.rows(), 3) - mesh.points)
            .rowwise()
            .norm()
            .maxCoeff();
    }
};

TEST(RegionRepair, TurnsAFoldedVertexBack)
{
    FoldedPatch patch;
    const RegionRepair repair =
        repair_regions(patch.energy, {patch.mesh.points}, patch.points, patch.folds());
    EXPECT_EQ(repair.replaced, 1);
    EXPECT_LT(patch.distance(repair.points), 1e-3);
}

TEST(RegionRepair, LowersTheEnergyByWhatItSays)
{
    FoldedPatch patch;
    VectorXd gradient;
    const double before = patch.energy.evaluate(patch.points, gradient);
    for (const std::vector<std::vector<int>>& regions :
         {patch.folds(), hot_spots(patch.energy, patch.points, {.seeds = 0.2, .rings = 2})}) {
        const RegionRepair repair =
            repair_regions(patch.energy, {patch.mesh.points}, patch.points, regions);
        const double after = patch.energy.evaluate(repair.points, gradient);
        EXPECT_LT(after, before);
        EXPECT_NEAR(before - after, repair.decrease, 1e-9 * before);
    }
}

TEST(RegionRepair, HoldsAllElse)
{
    FoldedPatch patch;
    const std::vector<std::vector<int>> regions = {{84, 85, 97}};
    const RegionRepair repair =
        repair_regions(patch.energy, {patch.mesh.points}, patch.points, regions);
    ASSERT_EQ(repair.replaced, 1);
    for (int v = 0; v < patch.mesh.points.rows(); ++v)
        if (v != 84 && v != 85 && v != 97)
            EXPECT_EQ(repair.points.segment<3>(3 * v), patch.points.segment<3>(3 * v)) << v;
}

TEST(RegionRepair, LeavesWhatIsAsWantedTheWholeMeshAndLargeRegionsAlone)
{
    FoldedPatch patch;
    const VectorXd wanted = patch.mesh.points.reshaped<Eigen::RowMajor>();
    const auto repaired = [&](const VectorXd& points, const std::vector<std::vector<int>>& regions,
                              const RegionRepairOptions& options = {}) {
        const RegionRepair repair =
            repair_regions(patch.energy, {patch.mesh.points}, points, regions, options);
        EXPECT_EQ(repair.replaced, 0);
        EXPECT_EQ(repair.decrease, 0.0);
        EXPECT_EQ(repair.points, points);
    };
    repaired(wanted, patch.folds());
    std::vector<int> all(static_cast<std::size_t>(patch.mesh.topology.vertex_count()));
    for (std::size_t v = 0; v < all.size(); ++v)
        all[v] = static_cast<int>(v);
    repaired(patch.points, {all});
    repaired(patch.points, patch.folds(), {.largest_region = 5});
    repaired(patch.points, {});
}

TEST(RegionRepair, GivesTheSameBitsForOneAndTwoThreads)
{
    FoldedPatch patch;
    const auto regions = hot_spots(patch.energy, patch.points, {.seeds = 1.0, .rings = 1});
    const auto run = [&](int threads) {
        const test::ThreadScope scope(threads);
        return repair_regions(patch.energy, {patch.mesh.points}, patch.points, regions).points;
    };
    EXPECT_EQ(run(1), run(2));
}

} // namespace
} // namespace shape
