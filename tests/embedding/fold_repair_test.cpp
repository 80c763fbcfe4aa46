// SPDX-License-Identifier: MIT

#include "libshape/embedding/fold_repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libshape/base/random.h"
#include "libshape/embedding/rigid_filling.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

using Eigen::VectorXd;

ShapePoint shape_of(const Topology& topology, const Points& points)
{
    return {edge_lengths(topology, points), dihedral_angles(topology, points)};
}

VectorXd rows_of(const Points& points)
{
    return points.reshaped<Eigen::RowMajor>();
}

/// A height field of 49 by 49 vertices with nine of its vertices folded over their neighbours.
struct FoldedPatch
{
    test::TestMesh mesh = test::open_patch(48, 4);
    Points folded = mesh.points;

    FoldedPatch()
    {
        for (int row = 8; row <= 40; row += 16)
            for (int column = 8; column <= 40; column += 16) {
                const int v = 49 * row + column;
                folded.row(v) += 2.2 * (mesh.points.row(v + 1) - mesh.points.row(v));
            }
    }
};

TEST(FoldedRegions, AreTheRingsAroundFolds)
{
    const FoldedPatch patch;
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
    angles.array() += 2.0 * 3.14159265358979;
    EXPECT_TRUE(folded_regions(mesh.topology, rows_of(mesh.points), angles).empty());
}

TEST(RigidFilling, PutsAReferenceInAnotherPoseWhereItBelongs)
{
    const test::TestMesh mesh = test::open_patch(12, 4);
    const RegionMesh region(mesh.topology, {70, 71, 83, 84, 85, 97});
    const VectorXd wanted = edge_lengths(mesh.topology, mesh.points);
    std::vector<float> lengths;
    Eigen::MatrixXd laplacian =
        Eigen::MatrixXd::Zero(region.moving_vertices, region.moving_vertices);
    for (std::size_t e = 0; e < region.edges.size(); ++e) {
        lengths.push_back(static_cast<float>(wanted[region.edges[e]]));
        const double weight = 1.0 / (wanted[region.edges[e]] * wanted[region.edges[e]]);
        const int a = region.ends[2 * e];
        const int b = region.ends[2 * e + 1];
        for (const int end : {a, b})
            if (end < region.moving_vertices)
                laplacian(end, end) += weight;
        if (a < region.moving_vertices && b < region.moving_vertices) {
            laplacian(a, b) -= weight;
            laplacian(b, a) -= weight;
        }
    }
    // Eight turns about the x axis by up to 70 degrees.
    EightfoldPoints references(region.vertices.size());
    EightfoldPoints points(region.vertices.size());
    for (std::size_t v = 0; v < points.size(); ++v)
        for (int k = 0; k < Eightfold::lanes; ++k) {
            const Eigen::RowVector3f p = mesh.points.row(region.vertices[v]).cast<float>();
            const auto angle = static_cast<float>(0.175 * k);
            references[v].x.of[k] = p[0];
            references[v].y.of[k] = std::cos(angle) * p[1] - std::sin(angle) * p[2];
            references[v].z.of[k] = std::sin(angle) * p[1] + std::cos(angle) * p[2];
            if (static_cast<int>(v) < region.moving_vertices)
                continue;
            points[v].x.of[k] = p[0];
            points[v].y.of[k] = p[1];
            points[v].z.of[k] = p[2];
        }
    fill_rigidly(region, lengths, EightfoldSolve(laplacian.sparseView()), references, 10, points);
    for (std::size_t v = 0; v < static_cast<std::size_t>(region.moving_vertices); ++v)
        for (int k = 0; k < Eightfold::lanes; ++k) {
            const Eigen::RowVector3f found(points[v].x.of[k], points[v].y.of[k], points[v].z.of[k]);
            EXPECT_LT((found - mesh.points.row(region.vertices[v]).cast<float>()).norm(),
                      1e-4F * static_cast<float>(wanted.mean()))
                << k;
        }
}

TEST(FoldRepair, TurnsFoldedVerticesBack)
{
    const FoldedPatch patch;
    const Topology& t = patch.mesh.topology;
    const LengthDihedralEnergy energy(t, shape_of(t, patch.mesh.points), 5e-3);
    const FoldRepair repair = repair_folds(energy, {patch.mesh.points}, rows_of(patch.folded));
    EXPECT_EQ(repair.regions, 9);
    EXPECT_EQ(repair.replaced, 9);
    EXPECT_LT((repair.points - rows_of(patch.mesh.points)).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(FoldRepair, LeavesAMeshWithoutFoldsAlone)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 1);
    const LengthDihedralEnergy energy(mesh.topology, shape_of(mesh.topology, mesh.points), 5e-3);
    const VectorXd points = rows_of(mesh.points);
    const FoldRepair repair = repair_folds(energy, {mesh.points}, points);
    EXPECT_EQ(repair.regions, 0);
    EXPECT_EQ(repair.points, points);
}

TEST(FoldRepair, LeavesRegionsThatAreTheMeshOrTooLargeAlone)
{
    const FoldedPatch patch;
    const Topology& t = patch.mesh.topology;
    const LengthDihedralEnergy energy(t, shape_of(t, patch.mesh.points), 5e-3);
    EXPECT_EQ(
        repair_folds(energy, {patch.mesh.points}, rows_of(patch.folded), {.largest_region = 8})
            .regions,
        0);
    EXPECT_EQ(repair_folds(energy, {patch.mesh.points}, rows_of(patch.folded),
                           {.regions = {.rings = 60}, .largest_region = 10000})
                  .regions,
              0);
}

TEST(FoldRepair, NeverRaisesTheEnergyWhateverTheReferences)
{
    for (unsigned seed = 1; seed <= 4; ++seed) {
        const FoldedPatch patch;
        const Topology& t = patch.mesh.topology;
        Random random(seed);
        ShapePoint target = shape_of(t, patch.mesh.points);
        for (int e = 0; e < t.edge_count(); ++e)
            target.dihedral_angles[e] += random.uniform(-0.3, 0.3);
        LengthDihedralEnergy energy(t, target, 5e-3);
        // More references than lanes, the worst of all among them.
        std::vector<Points> references(seed == 1 ? 9 : seed - 2U, patch.mesh.points);
        references.push_back(test::moved(patch.folded, seed));
        VectorXd gradient;
        const double before = energy.evaluate(rows_of(patch.folded), gradient);
        const FoldRepair repair = repair_folds(energy, references, rows_of(patch.folded));
        EXPECT_GT(repair.regions, 0);
        EXPECT_LT(energy.evaluate(repair.points, gradient), before);
    }
}

TEST(FoldRepair, GivesTheSameBitsForAnyNumberOfThreads)
{
    const FoldedPatch patch;
    const Topology& t = patch.mesh.topology;
    const LengthDihedralEnergy energy(t, shape_of(t, patch.mesh.points), 5e-3);
    const auto repaired_by = [&](int threads) {
        const test::ThreadScope scope(threads);
        return repair_folds(energy, {patch.mesh.points}, rows_of(patch.folded)).points;
    };
    const VectorXd one = repaired_by(1);
    EXPECT_EQ(one, repaired_by(2));
    EXPECT_EQ(one, repaired_by(3));
}

} // namespace
} // namespace shape
