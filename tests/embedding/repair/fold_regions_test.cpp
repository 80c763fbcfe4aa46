// SPDX-License-Identifier: MIT

#include "libshape/embedding/repair/fold_regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/vertex_regions.h"
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

/// The four vertices of a hinge.
std::vector<int> corners_of(const Topology& t, int edge)
{
    std::vector<int> corners;
    for (const int h : t.edge_halfedges().row(edge)) {
        corners.push_back(t.source(h));
        corners.push_back(t.source(Topology::previous(h)));
    }
    return corners;
}

/// A mesh as it is wanted, but for three edges: one that is folded (1.2 rad), one of its face that is
/// suspect (0.7 rad), and another suspect far away.
struct Bent
{
    test::TestMesh mesh = test::icosphere(3);
    const Topology& t = mesh.topology;
    int folded = t.face_edges()(0, 0);
    int beside = t.face_edges()(0, 1);
    int alone = t.face_edges()(t.face_count() - 1, 0);
    VectorXd angles = dihedral_angles(t, mesh.points);

    Bent()
    {
        angles[folded] += 1.2;
        angles[beside] -= 0.7;
        angles[alone] += 0.7;
    }
    [[nodiscard]] std::vector<std::vector<int>> regions(const FoldRegionOptions& options) const
    {
        return folded_regions(t, rows_of(mesh.points), angles, options);
    }
    /// What is expected around these edges.
    [[nodiscard]] std::vector<std::vector<int>> around(const std::vector<int>& edges,
                                                       int rings) const
    {
        std::vector<int> seeds;
        for (const int e : edges)
            for (const int v : corners_of(t, e))
                seeds.push_back(v);
        return regions_around(t, seeds, rings);
    }
};

TEST(FoldedRegions, HaveAsManyRingsAsWanted)
{
    const Bent bent;
    for (const int rings : {0, 1, 2, 3})
        EXPECT_EQ(bent.regions({.rings = rings}), bent.around({bent.folded, bent.beside}, rings))
            << rings;
}

TEST(FoldedRegions, AreJudgedByTheFoldAndReachAsFarAsSuspects)
{
    const Bent bent;
    const auto regions = [&](double fold_angle, double suspect_angle) {
        return bent.regions({fold_angle, suspect_angle, 1});
    };
    EXPECT_EQ(regions(1.0, 0.69), bent.around({bent.folded, bent.beside}, 1));
    EXPECT_EQ(regions(1.0, 0.71), bent.around({bent.folded}, 1));
    EXPECT_EQ(regions(1.19, 0.71), bent.around({bent.folded}, 1));
    EXPECT_EQ(regions(1.21, 0.69), std::vector<std::vector<int>>());
    EXPECT_EQ(regions(0.69, 0.69), bent.around({bent.folded, bent.beside, bent.alone}, 1));
    ASSERT_EQ(regions(0.69, 0.69).size(), 2U);
}

TEST(FoldedRegions, DoNotLookAtTheBoundary)
{
    const test::TestMesh mesh = test::open_patch(6, 1);
    VectorXd angles = dihedral_angles(mesh.topology, mesh.points);
    for (int e = 0; e < mesh.topology.edge_count(); ++e)
        if (mesh.topology.is_boundary_edge(e))
            angles[e] = 3.0;
    EXPECT_TRUE(folded_regions(mesh.topology, rows_of(mesh.points), angles).empty());
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
