// SPDX-License-Identifier: MIT

#include "libshape/synthetic/synthetic.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
namespace {

/// Volume under the surface seen from the origin [length^3]; > 0 if faces look outwards.
double signed_volume(const Faces& faces, const Points& points)
{
    double volume = 0.0;
    for (const auto& face : faces.rowwise()) {
        const Eigen::Vector3d a = points.row(face[0]);
        const Eigen::Vector3d b = points.row(face[1]);
        const Eigen::Vector3d c = points.row(face[2]);
        volume += a.dot(b.cross(c)) / 6.0;
    }
    return volume;
}

double smallest_angle_deg(const Collection& collection, std::size_t mesh)
{
    const Eigen::VectorXd lengths = edge_lengths(collection.topology, collection.points[mesh]);
    return 180.0 / std::numbers::pi * corner_angles(collection.topology, lengths).minCoeff();
}

/// A few members are enough for laws that hold for each.
int few(const SyntheticDataset& dataset)
{
    return std::min(dataset.count.standard, 5);
}

const Points& mesh_named(const Collection& collection, const std::string& name)
{
    const auto found = std::find(collection.names.begin(), collection.names.end(), name);
    if (found == collection.names.end())
        throw std::out_of_range(name);
    return collection.points[to_size(found - collection.names.begin())];
}

TEST(Synthetic, EverySetHasTheWantedSizeAndOneKindOfSurface)
{
    for (const SyntheticDataset& dataset : synthetic_datasets())
        for (const int wanted : {0, 1000, 6000}) {
            if (wanted > dataset.vertices.high)
                continue;
            SCOPED_TRACE(dataset.name + " " + std::to_string(wanted));
            const Collection set =
                make_synthetic(dataset.name, {.count = few(dataset), .vertices = wanted});
            const int target = wanted == 0 ? dataset.vertices.standard : wanted;
            EXPECT_NEAR(set.topology.vertex_count(), target, 0.05 * target);
            EXPECT_EQ(set.topology.is_closed(), dataset.name != "faces");
            EXPECT_EQ(set.topology.genus(), dataset.name == "torus" ? 1 : 0);
            for (const LabelColumn& column : set.labels)
                EXPECT_EQ(column.values.size(), set.size());
            for (const Points& points : set.points)
                EXPECT_GT(signed_volume(set.topology.faces(), points), 0.0);
        }
}

TEST(Synthetic, NoTriangleIsASliver)
{
    // thin_cylinder has long triangles on purpose: 12 times as long as wide is 4 degrees.
    for (const SyntheticDataset& dataset : synthetic_datasets())
        for (const std::uint64_t seed : {1U, 2U, 3U}) {
            const Collection set =
                make_synthetic(dataset.name, {.count = few(dataset), .seed = seed});
            for (std::size_t i = 0; i < set.size(); ++i)
                EXPECT_GT(smallest_angle_deg(set, i), 3.0) << set.names[i] << ", seed " << seed;
        }
}

TEST(Synthetic, TheSeedDecidesEverythingRandomAndNothingElse)
{
    const std::set<std::string> random_sets{"faces", "femurs", "heads", "noisy_helix", "torus"};
    for (const SyntheticDataset& dataset : synthetic_datasets()) {
        SCOPED_TRACE(dataset.name);
        const Collection a = make_synthetic(dataset.name, {.count = few(dataset), .seed = 7});
        const Collection b = make_synthetic(dataset.name, {.count = few(dataset), .seed = 7});
        const Collection c = make_synthetic(dataset.name, {.count = few(dataset), .seed = 8});
        EXPECT_EQ(a.topology, b.topology);
        EXPECT_EQ(a.points, b.points);
        const bool differs = a.points != c.points || !(a.topology == c.topology);
        EXPECT_EQ(differs, random_sets.contains(dataset.name));
    }
}

TEST(Synthetic, MoreIndividualsLeaveTheFirstOnesAsTheyAre)
{
    for (const char* name : {"faces", "femurs", "heads"}) {
        const Collection few = make_synthetic(name, {.count = 5});
        const Collection many = make_synthetic(name, {.count = 7});
        ASSERT_GT(many.size(), few.size());
        for (std::size_t i = 0; i < few.size(); ++i) {
            EXPECT_EQ(few.names[i], many.names[i]);
            EXPECT_EQ(few.points[i], many.points[i]);
        }
    }
}

TEST(Synthetic, RefusesUnknownNamesAndCountsOutOfRange)
{
    EXPECT_THROW((void)make_synthetic("teapot"), InvalidInput);
    EXPECT_THROW((void)make_synthetic("arm", {.count = 1}), InvalidInput);
    EXPECT_THROW((void)make_synthetic("arm", {.vertices = 3}), InvalidInput);
    EXPECT_THROW((void)make_synthetic("faces", {.vertices = -5}), InvalidInput);
    EXPECT_THROW((void)make_synthetic("icosahedron", {.vertices = 100}), InvalidInput);
}

TEST(Faces, AreLabelledBySubjectAndExpression)
{
    const Collection set = make_synthetic("faces", {.count = 2, .vertices = 500});
    EXPECT_EQ(set.names, (std::vector<std::string>{"s000_neutral", "s000_happy", "s000_angry",
                                                   "s001_neutral", "s001_happy", "s001_angry"}));
    EXPECT_EQ(find_label(set.labels, "subject").values[3], "s001");
    EXPECT_EQ(find_label(set.labels, "expression").values[4], "happy");
}

TEST(Faces, OfManyPeopleHaveNoSliver)
{
    for (const int vertices : {300, 2500}) {
        const Collection set = make_synthetic("faces", {.count = 100, .vertices = vertices});
        for (std::size_t i = 0; i < set.size(); ++i)
            EXPECT_GT(smallest_angle_deg(set, i), 3.0) << set.names[i];
    }
}

TEST(Faces, MoveMostAroundTheMouthInASmileAndAtTheBrowsInAScowl)
{
    const Collection set = make_synthetic("faces", {.count = 1});
    const auto place_of_largest_move = [&](const char* name) {
        Eigen::Index v = 0;
        (mesh_named(set, name) - set.points[0]).rowwise().norm().maxCoeff(&v);
        return Eigen::Vector3d(set.points[0].row(v));
    };
    const Eigen::Vector3d smile = place_of_largest_move("s000_happy");
    EXPECT_NEAR(std::abs(smile.x()), 27.0, 8.0);
    EXPECT_NEAR(smile.y(), -74.0, 12.0);
    const Eigen::Vector3d scowl = place_of_largest_move("s000_angry");
    EXPECT_NEAR(scowl.y(), 18.0, 8.0);
}

TEST(Icosahedron, HasTwoShapesOfEqualEdges)
{
    const Collection set = make_synthetic("icosahedron");
    const Eigen::VectorXd convex = edge_lengths(set.topology, set.points[0]);
    const Eigen::VectorXd pushed = edge_lengths(set.topology, set.points[1]);
    EXPECT_LT((convex - pushed).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((convex.array() - convex.mean()).abs().maxCoeff(), 1e-12);
    const RigidMotion motion = best_rigid_motion(set.points[0], set.points[1]);
    EXPECT_GT((motion(set.points[0]) - set.points[1]).norm(), 0.5);
}

TEST(Barbells, WithEqualEndsDifferInTheBarAlone)
{
    const Collection set = make_synthetic("barbells");
    for (const std::string kind : {"a", "b"}) {
        const Points& small = mesh_named(set, "barbell_" + kind + "_short");
        const Points& large = mesh_named(set, "barbell_" + kind + "_long");
        int in_ends = 0;
        for (Eigen::Index v = 0; v < small.rows(); ++v) {
            if (small(v, 0) > 0.0 && small(v, 0) < 2.0)
                continue;
            ++in_ends;
            const double shift = small(v, 0) > 1.0 ? 4.0 : 0.0;
            EXPECT_NEAR(large(v, 0), small(v, 0) + shift, 1e-12);
            EXPECT_EQ(large.row(v).tail<2>(), small.row(v).tail<2>());
        }
        EXPECT_GT(in_ends, small.rows() / 4);
    }
    EXPECT_NE(mesh_named(set, "barbell_a_short"), mesh_named(set, "barbell_b_short"));

    // Six bars, each as much longer than the one before; the ends reach 2 beyond them.
    const Collection many = make_synthetic("barbells", {.count = 12});
    ASSERT_EQ(many.size(), 12U);
    EXPECT_EQ(many.labels[1].values[4], "04");
    const auto bar = [&](const std::string& name) {
        const Points& points = mesh_named(many, name);
        return points.col(0).maxCoeff() - points.col(0).minCoeff();
    };
    const double ends = bar("barbell_a_00") - 1.0;
    EXPECT_NEAR(bar("barbell_a_05") - ends, 12.0, 1e-9);
    EXPECT_NEAR(bar("barbell_a_01") - ends, std::pow(12.0, 0.2), 1e-9);
    EXPECT_THROW((void)make_synthetic("barbells", {.count = 5}), InvalidInput);
}

TEST(Femurs, WithEqualEndsDifferInTheShaftAlone)
{
    const Collection set = make_synthetic("femurs", {.count = 2});
    const Points& small = mesh_named(set, "femur_short");
    const Points& large = mesh_named(set, "femur_long");
    int knee = 0;
    int hip = 0;
    for (Eigen::Index v = 0; v < small.rows(); ++v) {
        const Eigen::RowVector3d moved = large.row(v) - small.row(v);
        if (small(v, 1) < 70.0) {
            EXPECT_LT(moved.norm(), 1e-9);
            ++knee;
        } else if (small(v, 1) > 275.0) {
            EXPECT_LT((moved - Eigen::RowVector3d(0.0, 140.0, 0.0)).norm(), 1e-9);
            ++hip;
        }
    }
    EXPECT_GT(knee, 200);
    EXPECT_GT(hip, 100);
}

TEST(Femurs, ComeWithTwoKindsOfEndsOnTheSameShafts)
{
    const Collection set = make_synthetic("femurs", {.count = 4});
    const auto shaft_of = [&](const std::string& name) {
        const Points& points = mesh_named(set, name);
        return points.col(1).maxCoeff() - points.col(1).minCoeff();
    };
    EXPECT_NEAR(shaft_of("femur_long") - shaft_of("femur_short"), 140.0, 1e-9);
    EXPECT_NEAR(shaft_of("femur_stout_long") - shaft_of("femur_stout_short"), 140.0, 1e-9);
    const auto knee_of = [&](const std::string& name) { // the knee is below the origin's 70 mm
        const Points& points = mesh_named(set, name);
        return (points.col(1).array() < 40.0).select(points.col(0), 0.0).cwiseAbs().maxCoeff();
    };
    EXPECT_GT(knee_of("femur_stout_short"), 1.15 * knee_of("femur_short"));
    EXPECT_NEAR(knee_of("femur_stout_short"), knee_of("femur_stout_long"), 1e-9);
    EXPECT_EQ(set.labels.at(1).values,
              (std::vector<std::string>{"slender", "slender", "stout", "stout"}));
    EXPECT_EQ(make_synthetic("femurs", {.count = 5}).names.back(), "femur_000");
}

TEST(Helix, KeepsTheLengthsOfTheCylinderWithinTheCurvatureOfItsAxis)
{
    // A fibre at distance r from an axis of curvature k is longer or shorter by at most r k.
    const double curvature = 1.0 / (1.0 + std::pow(0.8 / (2.0 * std::numbers::pi), 2));
    for (const int turns : {1, 4, 7}) {
        const Collection set = make_synthetic("helix", {.count = turns, .vertices = 6000});
        const Eigen::ArrayXd straight = edge_lengths(set.topology, set.points[0]);
        const Eigen::ArrayXd wound = edge_lengths(set.topology, set.points[1]);
        EXPECT_LT((wound / straight - 1.0).abs().maxCoeff(), 0.2 * curvature);
        EXPECT_LT(std::abs((wound / straight - 1.0).mean()), 0.01);
        EXPECT_EQ(set.labels.at(0).values.at(1), std::to_string(turns));
    }
}

TEST(Torus, IsStretchedToTheBarrelAlongItsAxis)
{
    const Collection set = make_synthetic("torus", {.count = 3});
    EXPECT_EQ(set.names, (std::vector<std::string>{"torus", "torus_0001", "barrel"}));
    EXPECT_EQ(set.points[2], set.points[0] * Eigen::Vector3d(1.0, 4.0, 1.0).asDiagonal());
}

TEST(Arm, BendsTheForearmRigidlyByNinetyDegrees)
{
    const Collection set = make_synthetic("arm", {.count = 3});
    EXPECT_EQ(set.names, (std::vector<std::string>{"arm_straight", "arm_0001", "arm_bent"}));
    EXPECT_EQ(set.labels.at(0).values, (std::vector<std::string>{"0", "45", "90"}));
    // The hand: everything beyond 50 along the straight arm.
    std::vector<Eigen::Index> hand;
    for (Eigen::Index v = 0; v < set.points[0].rows(); ++v)
        if (set.points[0](v, 0) > 50.0)
            hand.push_back(v);
    const RigidMotion motion =
        best_rigid_motion(set.points[0](hand, Eigen::all), set.points[2](hand, Eigen::all));
    const Points moved = motion(set.points[0](hand, Eigen::all));
    EXPECT_LT((moved - set.points[2](hand, Eigen::all)).cwiseAbs().maxCoeff(), 1e-3);
    EXPECT_NEAR(Eigen::AngleAxisd(motion.rotation).angle(), std::numbers::pi / 2.0, 1e-4);
}

} // namespace
} // namespace shape
