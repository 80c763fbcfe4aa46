// SPDX-License-Identifier: MIT

#include "libshape/embedding/sequence_jumps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

using test::TestMesh;

constexpr double degrees = std::numbers::pi / 180.0;

/// Two equal triangles that meet at a hinge, bent by an angle.
Points hinge(double angle)
{
    return Points{{0, 0, 0}, {0, 1, 0}, {-1, 0.5, 0}, {std::cos(angle), 0.5, -std::sin(angle)}};
}
const Faces hinge_faces{{0, 1, 2}, {1, 0, 3}};

/// A smooth motion of a bumpy sphere: it bends and swells, each frame in another pose.
std::vector<Points> smooth_motion(const Points& points, int count, unsigned seed)
{
    std::vector<Points> frames;
    for (int k = 0; k < count; ++k) {
        const double t = 2.0 * k / count;
        Points frame = points;
        for (auto row : frame.rowwise()) {
            row.x() += 0.3 * std::sin(t) * row.z() * row.z();
            row *= 1.0 + 0.2 * t * row.y();
        }
        frames.push_back(test::moved(frame, seed + static_cast<unsigned>(k)));
    }
    return frames;
}

std::vector<SequenceStep> steps_of(const Topology& topology, const std::vector<Points>& frames)
{
    std::vector<SequenceStep> steps;
    for (std::size_t k = 1; k < frames.size(); ++k)
        steps.push_back(measure_step(topology, frames[k - 1], frames[k]));
    return steps;
}

std::vector<std::size_t> jumps_in(const Topology& topology, const std::vector<Points>& frames)
{
    std::vector<std::size_t> from;
    for (const SequenceJump& jump : find_jumps(steps_of(topology, frames)))
        from.push_back(jump.from);
    return from;
}

/// Steps of equal displacement and bending.
std::vector<SequenceStep> steps(const std::vector<double>& sizes)
{
    std::vector<SequenceStep> result;
    for (const double size : sizes)
        result.push_back({size, size});
    return result;
}

using Indices = std::vector<std::size_t>;

TEST(SequenceStep, OfARigidMotionIsZero)
{
    for (const TestMesh& mesh : test::sample_meshes()) {
        const SequenceStep step =
            measure_step(mesh.topology, mesh.points, test::moved(mesh.points, 7));
        EXPECT_LE(step.displacement, 1e-12) << mesh.name;
        EXPECT_LE(step.bending, 1e-7) << mesh.name;
    }
}

TEST(SequenceStep, OfAGrowingSphereIsItsGrowth)
{
    const TestMesh sphere = test::icosphere(2);
    const SequenceStep step = measure_step(sphere.topology, sphere.points, 1.1 * sphere.points);
    EXPECT_NEAR(step.displacement, 0.1 / bounding_box_diagonal(sphere.points), 1e-12);
    EXPECT_LE(step.bending, 1e-12);
}

TEST(SequenceStep, OfAHingeIsItsShareOfTheChange)
{
    // The hinge has the area of both triangles, the four other edges that of one each.
    const Topology topology(hinge_faces, 4);
    for (const auto& [before, after] : {std::pair(10.0, 25.0), std::pair(179.0, -166.0)})
        EXPECT_NEAR(measure_step(topology, hinge(before * degrees), hinge(after * degrees)).bending,
                    15.0 * degrees / std::sqrt(3.0), 1e-12);
}

TEST(SequenceStep, RefusesPointsOfAnotherMesh)
{
    const TestMesh mesh = test::tetrahedron();
    EXPECT_THROW((void)measure_step(mesh.topology, mesh.points, Points::Zero(3, 3)), InvalidInput);
    EXPECT_THROW((void)measure_step(mesh.topology, Points::Zero(3, 3), mesh.points), InvalidInput);
}

TEST(SequenceJumps, AreNoneInASmoothSequence)
{
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const TestMesh mesh = test::bumpy_sphere(2, 0.2, seed);
        for (const int count : {4, 10, 100})
            EXPECT_EQ(jumps_in(mesh.topology, smooth_motion(mesh.points, count, seed)), Indices{});
    }
}

TEST(SequenceJumps, AreWhereTheRestOfASequenceIsMirrored)
{
    for (const std::size_t at : {1U, 9U, 18U}) {
        const TestMesh mesh = test::bumpy_sphere(2, 0.2, 1);
        std::vector<Points> frames = smooth_motion(mesh.points, 20, 1);
        for (std::size_t k = at; k < frames.size(); ++k)
            frames[k].col(0) *= -1.0;
        EXPECT_EQ(jumps_in(mesh.topology, frames), (Indices{at - 1}));
    }
}

TEST(SequenceJumps, AreWhereASingleVertexFoldsIn)
{
    const TestMesh mesh = test::icosphere(3);
    std::vector<Points> frames = smooth_motion(mesh.points, 30, 1);
    const int tip = 17;
    for (std::size_t k = 12; k < frames.size(); ++k) {
        Eigen::RowVector3d ring = Eigen::RowVector3d::Zero();
        for (const int h : mesh.topology.outgoing(tip))
            ring += frames[k].row(mesh.topology.target(h));
        ring /= static_cast<double>(mesh.topology.outgoing(tip).size());
        const Eigen::RowVector3d up = frames[k].row(tip) - ring;
        frames[k].row(tip) = ring - 6.0 * up;
    }
    EXPECT_EQ(jumps_in(mesh.topology, frames), (Indices{11}));
}

TEST(SequenceJumps, OfAFrameThatIsWrongAloneAreTwo)
{
    const TestMesh mesh = test::bumpy_sphere(2, 0.2, 1);
    std::vector<Points> frames = smooth_motion(mesh.points, 20, 1);
    frames[8].col(1) *= -1.0;
    EXPECT_EQ(jumps_in(mesh.topology, frames), (Indices{7, 8}));
}

TEST(SequenceJumps, FollowTheInequalityThatIsStated)
{
    const auto found = find_jumps(steps({0.1, 0.1, 0.3, 1.01, 0.2, 0.1, 0.2}));
    ASSERT_EQ(found.size(), 1U); // the median of the six others is 0.15
    EXPECT_EQ(found[0].from, 3U);
    EXPECT_NEAR(found[0].ratio, 1.01 / 0.15, 1e-12);
    EXPECT_TRUE(find_jumps(steps({0.1, 0.1, 0.5, 0.1, 0.1})).empty()); // 5 is not more than 5
    EXPECT_EQ(find_jumps(steps({0.1, 0.1, 0.4, 0.1, 0.1}), {.ratio = 3.0}).size(), 1U);
    // A change of speed is not a jump.
    EXPECT_TRUE(find_jumps(steps({8, 8, 8, 8, 8, 1, 1, 1, 1, 1})).empty());
    // Only steps within reach count.
    EXPECT_EQ(find_jumps(steps({9, 9, 8, 1, 6, 1, 9, 9, 9}), {.reach = 1}).size(), 1U);
}

TEST(SequenceJumps, EitherMeasureCounts)
{
    std::vector<SequenceStep> moving(9, {0.01, 0.01});
    moving[3].displacement = 0.2;
    moving[6].bending = 0.1;
    const auto found = find_jumps(moving);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_NEAR(found[0].ratio, 20.0, 1e-12);
    EXPECT_NEAR(found[1].ratio, 10.0, 1e-12);
}

TEST(SequenceJumps, OfAStillSequenceMustBeVisible)
{
    EXPECT_TRUE(find_jumps(steps({0, 0, 9e-4, 0, 0})).empty());
    EXPECT_EQ(find_jumps(steps({0, 0, 1e-2, 0, 0})).size(), 1U);
}

TEST(SequenceJumps, NeedTwoStepsNearby)
{
    EXPECT_TRUE(find_jumps({}).empty());
    EXPECT_TRUE(find_jumps(steps({1.0, 1e-3})).empty());
    EXPECT_EQ(find_jumps(steps({1.0, 1e-3, 1e-3})).size(), 1U);
}

TEST(SequenceJumps, RefuseOptionsOutOfRange)
{
    const auto message = [](const JumpOptions& options) {
        return test::message_of<InvalidInput>([&] { (void)find_jumps({}, options); });
    };
    EXPECT_NE(message({.ratio = 0.0}).find("ratio"), std::string::npos);
    EXPECT_NE(message({.reach = 0}).find("reach"), std::string::npos);
    EXPECT_NE(message({.least_displacement = -1.0}).find("least_displacement"), std::string::npos);
    EXPECT_NE(message({.least_bending = std::nan("")}).find("least_bending"), std::string::npos);
}

} // namespace
} // namespace shape
