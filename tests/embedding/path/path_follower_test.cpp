// SPDX-License-Identifier: MIT

#include "libshape/embedding/path/path_follower.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/conformal/conformal_morph.h"
#include "libshape/embedding/energy/graded_unknowns.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

/// A cone with a round cap; edges at its tip are exp(2 * steepness) times shorter than at the cap.
Points horn(const Points& sphere, double steepness)
{
    Points points(sphere.rows(), 3);
    for (Eigen::Index v = 0; v < sphere.rows(); ++v)
        points.row(v) = std::exp(steepness * (sphere(v, 2) - 1.0)) *
                        Eigen::RowVector3d(sphere(v, 0), sphere(v, 1), 1.0);
    return points;
}

double worst_edge(const Topology& topology, const Points& points, const VectorXd& lengths)
{
    return (edge_lengths(topology, points).array() / lengths.array() - 1.0).abs().maxCoeff();
}

TEST(GradedUnknowns, MoveFineRegionsAsAWhole)
{
    const test::TestMesh mesh = test::icosphere(4);
    const VectorXd even = edge_lengths(mesh.topology, mesh.points);
    const GradedUnknowns plain = graded_unknowns(mesh.topology, even);
    EXPECT_EQ(plain.vertices.size(), to_size(mesh.topology.vertex_count()) - 1);
    for (const std::vector<int>& rows : plain.rows)
        EXPECT_LE(rows.size(), 1u);

    const VectorXd lengths = edge_lengths(mesh.topology, horn(mesh.points, 9.0));
    const GradedUnknowns graded = graded_unknowns(mesh.topology, lengths);
    std::size_t deepest = 0;
    int free = 0; // edges whose ends every large unknown moves alike
    for (int e = 0; e < mesh.topology.edge_count(); ++e) {
        const auto& a = graded.rows[to_size(mesh.topology.edges()(e, 0))];
        const auto& b = graded.rows[to_size(mesh.topology.edges()(e, 1))];
        deepest = std::max({deepest, a.size(), b.size()});
        free += a.size() > 1 && b.size() > 1 && a.front() == b.front() ? 1 : 0;
    }
    EXPECT_GE(deepest, 3u);
    EXPECT_GT(free, 0);
}

TEST(Continuation, FindsTheMeshThatHasTheTargetExactly)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 1);
    const Points bent = test::bumpy_sphere(3, 0.35, 1).points;
    const ContinuedMesh found = Continuation(mesh.topology, edge_lengths(mesh.topology, bent))
                                    .move(mesh.points, test::shape_of(mesh.topology, bent),
                                          {.decrease_tolerance = 1e-6, .max_iterations = 30});
    EXPECT_LE(worst_edge(mesh.topology, found.points, edge_lengths(mesh.topology, bent)), 1e-6);
}

TEST(Continuation, MeetsLengthsOverEightOrdersOfMagnitude)
{
    const test::TestMesh mesh = test::icosphere(4);
    const Points from = horn(mesh.points, 9.0);
    const ShapePoint target = test::shape_of(mesh.topology, horn(mesh.points, 8.7));
    ASSERT_LE(target.edge_lengths.minCoeff(), 1e-7 * target.edge_lengths.maxCoeff());
    const ContinuedMesh found =
        Continuation(mesh.topology, target.edge_lengths)
            .move(from, target, {.decrease_tolerance = 1e-6, .max_iterations = 30});
    EXPECT_LE(worst_edge(mesh.topology, found.points, target.edge_lengths), 1e-5);
}

TEST(Continuation, PaysLessByTheWorstEdgeTheStifferItIs)
{
    // Halfway between the angles of two meshes, with the lengths of neither.
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 1);
    const Points other = test::bumpy_sphere(3, 0.3, 2).points;
    const ShapePoint a = test::shape_of(mesh.topology, mesh.points);
    const ShapePoint b = test::shape_of(mesh.topology, other);
    const ShapePoint half{0.5 * (a.edge_lengths + b.edge_lengths), a.dihedral_angles};
    Continuation continuation(mesh.topology, half.edge_lengths);
    const auto worst = [&](double stiffness) {
        const ContinuedMesh found = continuation.adjust(mesh.points, half,
                                                        {.smoothness = 1e-2,
                                                         .stiffness = stiffness,
                                                         .decrease_tolerance = 1e-6,
                                                         .max_iterations = 40});
        return worst_edge(mesh.topology, found.points, half.edge_lengths);
    };
    EXPECT_LT(worst(12.0), 0.8 * worst(1.0));
}

TEST(Continuation, StopsAfterTheStepsThatItMayTake)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.3, 1);
    const ShapePoint target = test::shape_of(mesh.topology, test::bumpy_sphere(2, 0.4, 1).points);
    Continuation continuation(mesh.topology, target.edge_lengths);
    for (const int steps : {0, 1, 3}) {
        const ContinuedMesh found = continuation.adjust(
            mesh.points, target, {.decrease_tolerance = 0.0, .max_iterations = steps});
        EXPECT_EQ(found.iterations, steps);
        EXPECT_FALSE(found.converged);
    }
}

TEST(Continuation, SettlesOnLengthsAsNearAsWanted)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 1);
    const VectorXd lengths = edge_lengths(mesh.topology, test::bumpy_sphere(3, 0.33, 1).points);
    Continuation continuation(mesh.topology, lengths);
    for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
        const ContinuedMesh found =
            continuation.settle(mesh.points, lengths, {.edge_tolerance = tolerance});
        EXPECT_TRUE(found.converged) << tolerance;
        EXPECT_LE(worst_edge(mesh.topology, found.points, lengths), tolerance * (1.0 + 1e-9));
    }
    const ContinuedMesh same = continuation.settle(mesh.points, lengths, {.rounds = 0});
    EXPECT_EQ(same.points, mesh.points);
    EXPECT_EQ(same.iterations, 0);
    EXPECT_FALSE(same.converged);
}

TEST(Continuation, SettlesFewEdgesInTheirRegionsAlone)
{
    test::TestMesh mesh = test::icosphere(4);
    const VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
    const VectorXd lifted = 1.01 * mesh.points.row(7).transpose();
    mesh.points.row(7) = lifted;
    const ContinuedMesh found =
        Continuation(mesh.topology, lengths).settle(mesh.points, lengths, {.edge_tolerance = 1e-3});
    EXPECT_TRUE(found.converged);
    EXPECT_LE(worst_edge(mesh.topology, found.points, lengths), 1e-3 * (1.0 + 1e-9));
    // Far from there no edge has changed: the mesh as a whole was held.
    const VectorXd errors =
        (edge_lengths(mesh.topology, found.points).array() / lengths.array() - 1.0).abs();
    for (int e = 0; e < mesh.topology.edge_count(); ++e)
        if (mesh.points.row(mesh.topology.edges()(e, 0)).dot(lifted) < 0.0) {
            ASSERT_LE(errors[e], 1e-13) << e;
        }
}

TEST(Continuation, RefusesWhatDoesNotFit)
{
    const test::TestMesh mesh = test::icosphere(1);
    const ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    EXPECT_THROW(Continuation(mesh.topology, VectorXd::Ones(2)), InvalidInput);
    EXPECT_THROW(Continuation(mesh.topology, 0.0 * target.edge_lengths), InvalidInput);
    Continuation continuation(mesh.topology, target.edge_lengths);
    EXPECT_THROW((void)continuation.move(Points(3, 3), target), InvalidInput);
    EXPECT_THROW((void)continuation.adjust(Points(3, 3), target), InvalidInput);
    EXPECT_THROW((void)continuation.move(mesh.points, {VectorXd(2), VectorXd(2)}), InvalidInput);
    EXPECT_THROW((void)continuation.adjust(mesh.points, target, {.smoothness = 0.0}), InvalidInput);
    EXPECT_THROW((void)continuation.settle(Points(3, 3), target.edge_lengths), InvalidInput);
    EXPECT_THROW((void)continuation.settle(mesh.points, VectorXd::Ones(2)), InvalidInput);
    EXPECT_THROW((void)continuation.settle(mesh.points, -target.edge_lengths), InvalidInput);
}

/// Two knobs on a bar.
test::TestMesh dumbbell()
{
    test::TestMesh mesh = test::icosphere(3);
    for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
        const double z = mesh.points(v, 2);
        mesh.points.row(v) = mesh.points.row(v).cwiseProduct(
            Eigen::RowVector3d(0.4 + 0.6 * z * z, 0.4 + 0.6 * z * z, 2.0));
    }
    return mesh;
}

class FollowedMorph : public testing::Test
{
protected:
    FollowedMorph() : FollowedMorph(dumbbell()) {}
    explicit FollowedMorph(test::TestMesh made) : mesh(std::move(made)) {}

    const test::TestMesh mesh;
    const Topology& topology = mesh.topology;
    const SphereMap map = map_to_sphere(topology, edge_lengths(topology, mesh.points));
    const ConformalMorph morph = make_conformal_morph(topology, mesh.points, map);

    [[nodiscard]] VectorXd lengths(double s) const
    {
        return morph_frame(morph, morph_parameter(s)).point.edge_lengths;
    }
    /// Between the end of the path and the sphere, over the radius.
    [[nodiscard]] double gap(const Points& end) const
    {
        const Points sphere = map.radius * map.sphere.points;
        const Points difference = best_rigid_motion(end, sphere)(end) - sphere;
        return difference.rowwise().norm().maxCoeff() / map.radius;
    }
    [[nodiscard]] PathFollower follower(const PathFollowerOptions& options = {}) const
    {
        return {topology, mesh.points, [this](double s) { return lengths(s); },
                morph.dihedral_angles.row(1).transpose(), options};
    }
};

TEST_F(FollowedMorph, MeetsTheLengthsEverywhere)
{
    PathFollower follower = this->follower();
    for (int i = 0; i <= 10; ++i) {
        const double s = inverse_morph_parameter(i / 10.0);
        EXPECT_LE(worst_edge(topology, follower.at(s).mesh.points, lengths(s)), 4e-3) << s;
    }
    EXPECT_LE(gap(follower.at(1.0).mesh.points), 1e-3);
}

TEST_F(FollowedMorph, AdjustsUntilTheLengthsAreAsNearAsWanted)
{
    const double s = inverse_morph_parameter(0.5);
    const auto worst = [&](int rounds, double edge_tolerance) {
        PathFollowerOptions options;
        options.rounds = rounds;
        options.edge_tolerance = edge_tolerance;
        return worst_edge(topology, follower(options).at(s).mesh.points, lengths(s));
    };
    EXPECT_LE(worst(12, 2e-5), 2e-5);
    EXPECT_GT(worst(12, 1e-2), 2e-5); // no nearer than wanted,
    EXPECT_GT(worst(0, 2e-5), 2e-5);  // or than the rounds allow
}

TEST_F(FollowedMorph, ChangesSteadily)
{
    PathFollower follower = this->follower();
    constexpr int frames = 48; // three to a step
    VectorXd before = dihedral_angles(topology, mesh.points);
    std::vector<double> steps;
    for (int i = 1; i <= frames; ++i) {
        const VectorXd next =
            dihedral_angles(topology, follower.at(static_cast<double>(i) / frames).mesh.points);
        steps.push_back(
            (next - before).unaryExpr([](double a) { return wrapped_angle(a); }).norm());
        before = next;
    }
    std::vector<double> sorted = steps;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_LE(sorted.back(), 3.0 * sorted[sorted.size() / 2]);
}

class FollowedBumps : public FollowedMorph
{
protected:
    FollowedBumps() : FollowedMorph(test::bumpy_sphere(3, 0.4, 2)) {}
};

TEST_F(FollowedBumps, LoseTheirDentsOnTheWayToTheSphere)
{
    PathFollower follower = this->follower();
    for (const double k : {0.25, 0.5, 0.75, 1.0}) {
        const double s = inverse_morph_parameter(k);
        EXPECT_LE(worst_edge(topology, follower.at(s).mesh.points, lengths(s)), 4e-3) << k;
    }
    EXPECT_LE(gap(follower.at(1.0).mesh.points), 1e-3);
}

TEST_F(FollowedBumps, KeepTheirDentsWithoutGuidance)
{
    PathFollowerOptions options;
    options.angle_gain = 1.0;
    options.guidance = 1e-4;
    EXPECT_GE(gap(follower(options).at(1.0).mesh.points), 0.1);
}

TEST_F(FollowedMorph, DependsOnWhereAloneNotOnTheWayThere)
{
    PathFollower once = follower();
    PathFollower often = follower();
    EXPECT_EQ(often.at(0.0).mesh.points, mesh.points);
    (void)often.at(0.7);
    (void)often.at(0.3);
    EXPECT_EQ(often.at(0.5).mesh.points, once.at(0.5).mesh.points);
}

TEST_F(FollowedMorph, RefusesWhatDoesNotFit)
{
    const auto path = [this](double s) { return lengths(s); };
    const auto options = [](int steps, double angle_gain, int rounds) {
        PathFollowerOptions chosen;
        chosen.steps = steps;
        chosen.angle_gain = angle_gain;
        chosen.rounds = rounds;
        return chosen;
    };
    const VectorXd end = morph.dihedral_angles.row(1).transpose();
    EXPECT_THROW(PathFollower(topology, mesh.points, path, VectorXd(3)), InvalidInput);
    EXPECT_THROW(PathFollower(topology, mesh.points, path, end, options(0, 1, 1)), InvalidInput);
    EXPECT_THROW(PathFollower(topology, mesh.points, path, end, options(1, 0, 1)), InvalidInput);
    EXPECT_THROW(PathFollower(topology, mesh.points, path, end, options(1, 1, -1)), InvalidInput);
    PathFollower good = follower();
    EXPECT_THROW((void)good.at(-0.1), InvalidInput);
    EXPECT_THROW((void)good.at(1.1), InvalidInput);
    EXPECT_THROW((void)good.at(std::nan("")), InvalidInput);
}

} // namespace
} // namespace shape
