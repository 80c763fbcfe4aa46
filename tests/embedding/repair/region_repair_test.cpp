// SPDX-License-Identifier: MIT

#include "libshape/embedding/repair/region_repair.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "libshape/base/random.h"
#include "libshape/embedding/repair/fold_regions.h"
#include "libshape/embedding/repair/hot_spots.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

VectorXd rows_of(const Points& points)
{
    return points.reshaped<Eigen::RowMajor>();
}

/// Folded patches, and the energy whose minimum they are unfolded.
struct Folded
{
    test::FoldedPatch patch = test::folded_patch();
    LengthDihedralEnergy energy{patch.mesh.topology,
                                test::shape_of(patch.mesh.topology, patch.mesh.points), 5e-3};
    VectorXd points = rows_of(patch.folded);
    VectorXd wanted = rows_of(patch.mesh.points);

    [[nodiscard]] std::vector<std::vector<int>> folds(int rings = 3) const
    {
        return folded_regions(patch.mesh.topology, points, energy.target().dihedral_angles,
                              {.rings = rings});
    }
    [[nodiscard]] RegionRepair repaired(std::vector<std::vector<int>> regions,
                                        const RegionRepairOptions& options = {}) const
    {
        return repair_regions(energy, {patch.mesh.points}, points, std::move(regions), options);
    }
};

TEST(RegionRepair, TurnsFoldedVerticesBack)
{
    const Folded f;
    const RegionRepair repair = f.repaired(f.folds());
    EXPECT_EQ(repair.replaced, 9);
    EXPECT_LT((repair.points - f.wanted).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(RegionRepair, LowersTheEnergyByWhatItSays)
{
    Folded f;
    VectorXd gradient;
    const double before = f.energy.evaluate(f.points, gradient);
    for (const auto& regions : {f.folds(), hot_spots(f.energy, f.points)}) {
        const RegionRepair repair = f.repaired(regions);
        const double after = f.energy.evaluate(repair.points, gradient);
        EXPECT_LT(after, before);
        EXPECT_NEAR(before - after, repair.decrease, 1e-9 * before);
    }
}

TEST(RegionRepair, HoldsAllElse)
{
    const Folded f;
    const std::vector<int> region = {400, 401, 449}; // the first fold, a neighbour, one below
    const RegionRepair repair = f.repaired({region});
    ASSERT_EQ(repair.replaced, 1);
    for (int v = 0; v < f.patch.mesh.topology.vertex_count(); ++v)
        if (std::find(region.begin(), region.end(), v) == region.end()) {
            EXPECT_EQ(repair.points.segment<3>(3 * v), f.points.segment<3>(3 * v)) << v;
        }
}

TEST(RegionRepair, TriesWhatItsOptionsSay)
{
    const Folded f;
    const auto points = [&](const RegionRepairOptions& options) {
        return f.repaired(f.folds(), options).points;
    };
    EXPECT_NE(points({.filling_sweeps = 0}), points({.filling_sweeps = 15}));
    EXPECT_NE(points({.descent = {.newton_steps = 1}}), points({}));
}

TEST(RegionRepair, MorePerturbedStartsFindLowerEnergies)
{
    const Folded f;
    const Topology& t = f.patch.mesh.topology;
    double by_few = 0.0, by_many = 0.0;
    for (unsigned seed = 1; seed <= 4; ++seed) { // targets that no mesh has: minima everywhere
        Random random(seed);
        ShapePoint target = f.energy.target();
        for (int e = 0; e < t.edge_count(); ++e)
            target.dihedral_angles[e] += random.uniform(-1.5, 1.5);
        const LengthDihedralEnergy energy(t, target, 5e-3);
        const auto decrease = [&](int starts) {
            return repair_regions(energy, {}, f.points, f.folds(), {.perturbed_starts = starts})
                .decrease;
        };
        by_few += decrease(0);
        by_many += decrease(40);
        EXPECT_EQ(decrease(0), decrease(7)); // of the eight lanes one is the region as it is
    }
    EXPECT_GT(by_many, by_few);
}

TEST(RegionRepair, LeavesAloneWhatIsAsWanted)
{
    const Folded f;
    const RegionRepair repair =
        repair_regions(f.energy, {f.patch.mesh.points}, f.wanted, f.folds());
    EXPECT_EQ(repair.replaced, 0);
    EXPECT_EQ(repair.decrease, 0.0);
    EXPECT_EQ(repair.points, f.wanted);
}

TEST(RegionRepair, LeavesRegionsThatAreTheMeshOrTooLargeAlone)
{
    const Folded f;
    EXPECT_EQ(f.repaired({}).points, f.points);
    EXPECT_EQ(f.repaired(f.folds(), {.largest_region = 8}).points, f.points);
    EXPECT_EQ(f.repaired(f.folds(60), {.largest_region = 10000}).points, f.points);
}

TEST(RegionRepair, NeverRaisesTheEnergyWhateverTheReferences)
{
    for (unsigned seed = 1; seed <= 4; ++seed) {
        const test::FoldedPatch patch = test::folded_patch();
        const Topology& t = patch.mesh.topology;
        Random random(seed);
        ShapePoint target = test::shape_of(t, patch.mesh.points);
        for (int e = 0; e < t.edge_count(); ++e)
            target.dihedral_angles[e] += random.uniform(-0.3, 0.3);
        LengthDihedralEnergy energy(t, target, 5e-3);
        // More references than lanes, the worst of all among them.
        std::vector<Points> references(seed == 1 ? 9 : seed - 2U, patch.mesh.points);
        references.push_back(test::moved(patch.folded, seed));
        VectorXd gradient;
        const double before = energy.evaluate(rows_of(patch.folded), gradient);
        const RegionRepair repair =
            repair_regions(energy, references, rows_of(patch.folded),
                           folded_regions(t, rows_of(patch.folded), target.dihedral_angles));
        EXPECT_GT(repair.replaced, 0);
        EXPECT_LT(energy.evaluate(repair.points, gradient), before);
    }
}

TEST(RegionRepair, GivesTheSameBitsForAnyNumberOfThreads)
{
    const Folded f;
    const auto repaired_by = [&](int threads) {
        const test::ThreadScope scope(threads);
        return f.repaired(f.folds()).points;
    };
    const VectorXd one = repaired_by(1);
    EXPECT_EQ(one, repaired_by(2));
    EXPECT_EQ(one, repaired_by(3));
}

} // namespace
} // namespace shape
