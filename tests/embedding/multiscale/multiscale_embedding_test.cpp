// SPDX-License-Identifier: MIT

#include "libshape/embedding/multiscale/multiscale_embedding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <thread>

#include "libshape/base/error.h"
#include "libshape/base/threads.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/embedding/multiscale/multiscale_meshes.h"

namespace shape {
namespace {

/// Another mesh of the same topology: bent by one radian, with no stretch along its middle if it is
/// slender, and widened.
Points bent(const Points& points)
{
    const double low = points.col(2).minCoeff();
    const double span = points.col(2).maxCoeff() - low;
    const double radius = std::max(span, 1.5 * points.col(0).cwiseAbs().maxCoeff());
    Points result(points.rows(), 3);
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        const double angle = (points(v, 2) - low) / span;
        const double reach = radius + points(v, 0);
        result.row(v) << reach * std::cos(angle), 1.1 * points(v, 1), reach * std::sin(angle);
    }
    return result;
}

ShapePoint own_point(const Topology& topology, const Points& points)
{
    return {edge_lengths(topology, points), dihedral_angles(topology, points)};
}

ShapePoint halfway(const ShapePoint& a, const ShapePoint& b)
{
    return {(a.edge_lengths + b.edge_lengths) / 2.0, (a.dihedral_angles + b.dihedral_angles) / 2.0};
}

/// Largest distance after the best rigid motion, over the bounding-box diagonal.
double rigid_distance(const Points& points, const Points& expected)
{
    const Points moved = best_rigid_motion(points, expected)(points);
    return (moved - expected).rowwise().norm().maxCoeff() / bounding_box_diagonal(expected);
}

TEST(MultiscaleEmbedding, ReproducesTheReferenceAndAnyOtherMesh)
{
    for (const test::TestMesh& mesh : test::multiscale_meshes()) {
        SCOPED_TRACE(mesh.name);
        const MultiscaleEmbedder embedder(mesh.topology, mesh.points);
        for (const Points& points : {mesh.points, bent(mesh.points)}) {
            const Points found = embedder.embed(own_point(mesh.topology, points)).points;
            EXPECT_LT(rigid_distance(found, points), 1e-9);
            EXPECT_LT(found.colwise().mean().norm(), 1e-12);
        }
    }
}

TEST(MultiscaleEmbedding, FromTheIdentityReproducesTheReferenceInPlace)
{
    for (const test::TestMesh& mesh : test::multiscale_meshes()) {
        SCOPED_TRACE(mesh.name);
        const MultiscaleEmbedder embedder(
            mesh.topology, mesh.points,
            {.registration = {.start = RegistrationStart::Identity, .passes = 4}});
        const Points found = embedder.embed(own_point(mesh.topology, mesh.points)).points;
        const Points centred = mesh.points.rowwise() - mesh.points.colwise().mean();
        EXPECT_LT((found - centred).norm(), 1e-9 * centred.norm());
    }
}

TEST(MultiscaleEmbedding, GivesTheMirrorImageOfNegatedAngles)
{
    for (const test::TestMesh& mesh : test::multiscale_meshes()) {
        SCOPED_TRACE(mesh.name);
        const MultiscaleEmbedder embedder(mesh.topology, mesh.points);
        ShapePoint target = own_point(mesh.topology, mesh.points);
        target.dihedral_angles *= -1.0;
        const Points mirror = mesh.points * Eigen::Vector3d(1, 1, -1).asDiagonal();
        EXPECT_LT(rigid_distance(embedder.embed(target).points, mirror), 1e-9);
    }
}

TEST(MultiscaleEmbedding, TurnsWithTheReferenceAndScalesWithTheUnit)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 5);
    const ShapePoint target =
        halfway(own_point(mesh.topology, mesh.points), own_point(mesh.topology, bent(mesh.points)));
    const Points found = MultiscaleEmbedder(mesh.topology, mesh.points).embed(target).points;

    const Points moved = test::moved(mesh.points, 3);
    const Points turned = MultiscaleEmbedder(mesh.topology, moved).embed(target).points;
    EXPECT_LT(rigid_distance(turned, found), 1e-9);
    const RigidMotion motion = best_rigid_motion(mesh.points, moved);
    EXPECT_LT((found * motion.rotation.transpose() - turned).norm(), 1e-9 * found.norm());

    const ShapePoint scaled{1e3 * target.edge_lengths, target.dihedral_angles};
    const Points larger = MultiscaleEmbedder(mesh.topology, mesh.points).embed(scaled).points;
    EXPECT_LT((larger - 1e3 * found).norm(), 1e-9 * larger.norm());
}

/// Winkler 2010, Figures 7 and 8: 99 % of the edges within 2.5 %, of the angles within 1 degree.
TEST(MultiscaleEmbedding, KeepsLengthsAndAnglesOfABentTubeAsWellAsPublished)
{
    const test::TestMesh mesh = test::open_cylinder(24, 100);
    const ShapePoint target =
        halfway(own_point(mesh.topology, mesh.points), own_point(mesh.topology, bent(mesh.points)));
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const Points found =
            MultiscaleEmbedder(mesh.topology, mesh.points, {.seed = seed}).embed(target).points;
        Eigen::VectorXd stretch =
            (edge_lengths(mesh.topology, found).array() / target.edge_lengths.array() - 1.0).abs();
        Eigen::VectorXd drift =
            (dihedral_angles(mesh.topology, found) - target.dihedral_angles).cwiseAbs();
        std::sort(stretch.begin(), stretch.end());
        std::sort(drift.begin(), drift.end());
        EXPECT_LT(stretch[stretch.size() * 99 / 100], 0.025);
        EXPECT_LT(drift[drift.size() * 99 / 100], std::numbers::pi / 180.0);
        EXPECT_GT(stretch.maxCoeff(), 1e-6); // halfway there is no mesh: the gaps are shared out
    }
}

TEST(MultiscaleEmbedding, SameBitsForAnyThreadCountAndWhenCalledConcurrently)
{
    const test::TestMesh mesh = test::bumpy_sphere(5, 0.3, 5); // large enough for CHOLMOD
    const ShapePoint target =
        halfway(own_point(mesh.topology, mesh.points), own_point(mesh.topology, bent(mesh.points)));
    const int threads = thread_count();
    set_thread_count(1);
    const Points one = MultiscaleEmbedder(mesh.topology, mesh.points).embed(target).points;
    set_thread_count(2);
    const MultiscaleEmbedder embedder(mesh.topology, mesh.points);
    EXPECT_EQ(embedder.embed(target).points, one);
    Points first, second;
    std::thread other([&] { first = embedder.embed(target).points; });
    second = embedder.embed(target).points;
    other.join();
    set_thread_count(threads);
    EXPECT_EQ(first, one);
    EXPECT_EQ(second, one);
}

TEST(MultiscaleEmbedding, DependsOnTheSeedOnlyWhereNoMeshHasTheTarget)
{
    const test::TestMesh mesh = test::torus(12, 30);
    const MultiscaleEmbedder first(mesh.topology, mesh.points, {.seed = 1});
    const MultiscaleEmbedder second(mesh.topology, mesh.points, {.seed = 2});
    const ShapePoint own = own_point(mesh.topology, bent(mesh.points));
    EXPECT_LT(rigid_distance(first.embed(own).points, second.embed(own).points), 1e-9);
    const ShapePoint target = halfway(own, own_point(mesh.topology, mesh.points));
    EXPECT_GT(rigid_distance(first.embed(target).points, second.embed(target).points), 1e-6);
}

TEST(MultiscaleEmbedding, RefusesBadTargetsAndOptions)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.3, 1);
    const MultiscaleEmbedder embedder(mesh.topology, mesh.points);
    const ShapePoint good = own_point(mesh.topology, mesh.points);
    const auto changed_length = [&](double length) {
        ShapePoint target = good;
        target.edge_lengths[7] = length;
        return target;
    };
    EXPECT_THROW((void)embedder.embed({good.edge_lengths.head(3), good.dihedral_angles}),
                 InvalidInput);
    EXPECT_THROW((void)embedder.embed({good.edge_lengths, good.dihedral_angles.head(3)}),
                 InvalidInput);
    EXPECT_THROW((void)embedder.embed(changed_length(0.0)), NumericalError);
    EXPECT_THROW((void)embedder.embed(changed_length(std::numeric_limits<double>::infinity())),
                 InvalidInput);
    ShapePoint no_angle = good;
    no_angle.dihedral_angles[0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)embedder.embed(no_angle), InvalidInput);
    EXPECT_THROW((void)embedder.embed(changed_length(10.0)), NumericalError);

    EXPECT_THROW(MultiscaleEmbedder(mesh.topology, mesh.points.topRows(3)), InvalidInput);
    EXPECT_THROW(MultiscaleEmbedder(mesh.topology, mesh.points, {.children = 2}), InvalidInput);
    EXPECT_THROW(MultiscaleEmbedder(mesh.topology, mesh.points, {.registration = {.passes = -1}}),
                 InvalidInput);
}

} // namespace
} // namespace shape
