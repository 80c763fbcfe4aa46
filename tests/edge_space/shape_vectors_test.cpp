// SPDX-License-Identifier: MIT

#include "libshape/edge_space/shape_vectors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/collections.h"
#include "tests/support/matrices.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using std::numbers::pi;

/// Angles of one edge given in degrees, unified, in degrees.
std::vector<double> unified(const std::vector<double>& degrees)
{
    RowMatrix column(static_cast<Eigen::Index>(degrees.size()), 1);
    std::copy(degrees.begin(), degrees.end(), column.data());
    column = unify_branches(column * (pi / 180.0)) * (180.0 / pi);
    return {column.data(), column.data() + column.size()};
}

void expect_near(const std::vector<double>& actual, const std::vector<double>& expected)
{
    ASSERT_EQ(actual.size(), expected.size());
    for (std::size_t i = 0; i < actual.size(); ++i)
        EXPECT_NEAR(actual[i], expected[i], 1e-12);
}

TEST(Encode, GivesLengthsOfUnitSumAnglesAndSizes)
{
    const Collection collection = test::bumpy_spheres(4, 1);
    const ShapeVectors unit = shape_vectors(collection, Scale::Unit);
    const ShapeVectors plain = shape_vectors(collection, Scale::None);
    for (Eigen::Index i = 0; i < 4; ++i) {
        const Points& points = collection.points[to_size(i)];
        const Eigen::VectorXd lengths = edge_lengths(collection.topology, points);
        EXPECT_NEAR(unit.edge_lengths.row(i).sum(), 1.0, 1e-14);
        EXPECT_EQ(plain.edge_lengths.row(i).transpose(), lengths);
        EXPECT_EQ(plain.sizes[i], lengths.sum());
        EXPECT_LE((unit.sizes[i] * unit.edge_lengths.row(i).transpose() - lengths).norm(), 1e-14);
        EXPECT_EQ(unit.dihedral_angles.row(i).transpose(),
                  dihedral_angles(collection.topology, points));
    }
    EXPECT_EQ(unit.dihedral_angles, plain.dihedral_angles);
    EXPECT_EQ(unit.sizes, plain.sizes);
}

TEST(Encode, KnowsNoPose)
{
    const Collection collection = test::bumpy_spheres(5, 2);
    const ShapeVectors here = shape_vectors(collection, Scale::None);
    const ShapeVectors there = shape_vectors(test::moved(collection, 77), Scale::None);
    EXPECT_LE((here.edge_lengths - there.edge_lengths).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LE((here.dihedral_angles - there.dihedral_angles).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Encode, KnowsNoSizeIfAskedForUnitScale)
{
    const Collection collection = test::bumpy_spheres(5, 3);
    Collection scaled = collection;
    for (std::size_t i = 0; i < scaled.size(); ++i)
        scaled.points[i] *= 0.3 + static_cast<double>(i);
    const ShapeVectors a = shape_vectors(collection, Scale::Unit);
    const ShapeVectors b = shape_vectors(scaled, Scale::Unit);
    EXPECT_LE((a.edge_lengths - b.edge_lengths).cwiseAbs().maxCoeff(), 1e-17);
    EXPECT_LE((a.dihedral_angles - b.dihedral_angles).cwiseAbs().maxCoeff(), 1e-13);
    for (Eigen::Index i = 0; i < 5; ++i)
        EXPECT_NEAR(b.sizes[i], (0.3 + static_cast<double>(i)) * a.sizes[i], 1e-12);
}

TEST(Encode, NegatesTheAnglesOfAMirrorImageAndKeepsItsLengths)
{
    const Collection collection = test::bumpy_spheres(3, 4);
    Collection mirror = collection;
    for (Points& points : mirror.points)
        points.col(0) *= -1.0;
    const ShapeVectors a = shape_vectors(collection, Scale::Unit);
    const ShapeVectors b = shape_vectors(mirror, Scale::Unit);
    EXPECT_EQ(a.edge_lengths, b.edge_lengths);
    EXPECT_LE((a.dihedral_angles + b.dihedral_angles).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Encode, HasTheSameBitsForAnyThreadCount)
{
    const Collection collection = test::bumpy_spheres(9, 5);
    const auto encoded = [&](int threads) {
        const test::ThreadScope scope(threads);
        return shape_vectors(collection, Scale::Unit);
    };
    EXPECT_EQ(encoded(1).edge_lengths, encoded(3).edge_lengths);
    EXPECT_EQ(encoded(1).dihedral_angles, encoded(3).dihedral_angles);
}

TEST(UnifyBranches, BringsAnglesOnBothSidesOfTheFoldTogether)
{
    expect_near(unified({170, -170}), {170, 190});
    expect_near(unified({170, 175, -174}), {170, 175, 186});
    expect_near(unified({-170, -175, 174}), {-170, -175, -186});
    expect_near(unified({170, 175, -150}), {-190, -185, -150}); // the mean is -175
    expect_near(unified({180, -179, -178}), {-180, -179, -178});
}

TEST(UnifyBranches, LetsASurfaceBendThroughFlatNotThroughItself)
{
    expect_near(unified({100, -100}), {100, -100});
    expect_near(unified({119, -119}), {119, -119});
    // The fold is the mean, but the third angle is too far from it to have gone through.
    expect_near(unified({170, -170, -110}), {-190, -170, -110});
}

TEST(UnifyBranches, LeavesAnEdgeWhoseMeanIsNotNearTheFold)
{
    expect_near(unified({10, -20, 30, 170, -175}), {10, -20, 30, 170, -175});
    expect_near(unified({0, 180}), {0, 180});
    expect_near(unified({-90, 90}), {-90, 90});
    expect_near(unified({150}), {150});
}

TEST(UnifyBranches, MovesByFullTurnsToWithinAHalfTurnOfTheMean)
{
    Random random(6);
    RowMatrix angles(7, 400);
    for (double& angle : angles.reshaped())
        angle = random.uniform(-pi, pi);
    const RowMatrix result = unify_branches(angles);
    int moved = 0;
    for (Eigen::Index e = 0; e < angles.cols(); ++e) {
        const double mean =
            std::atan2(angles.col(e).array().sin().sum(), angles.col(e).array().cos().sum());
        for (Eigen::Index i = 0; i < angles.rows(); ++i) {
            const double angle = angles(i, e);
            const double change = result(i, e) - angle;
            const bool both_near_fold =
                std::abs(mean) >= 2.0 * pi / 3.0 && std::abs(angle) >= 2.0 * pi / 3.0;
            EXPECT_NEAR(change, 2.0 * pi * std::round(change / (2.0 * pi)), 1e-14);
            if (both_near_fold)
                EXPECT_LE(std::abs(result(i, e) - mean), pi + 1e-14);
            else
                EXPECT_EQ(change, 0.0);
            moved += std::abs(change) > 1.0;
        }
    }
    EXPECT_GT(moved, 50);
}

TEST(UnifyBranches, TakesNoRows)
{
    EXPECT_EQ(unify_branches(RowMatrix(0, 5)).cols(), 5);
}

TEST(Blend, GivesAnInputBackForAUnitWeight)
{
    const ShapeVectors vectors = shape_vectors(test::bumpy_spheres(3, 7), Scale::None);
    for (const LengthBlend lengths : {LengthBlend::Plain, LengthBlend::Squared})
        for (int i = 0; i < 3; ++i) {
            const ShapePoint point = blend(vectors, Eigen::Vector3d::Unit(i), lengths);
            EXPECT_LE((point.edge_lengths - vectors.edge_lengths.row(i).transpose()).norm(), 1e-14);
            EXPECT_EQ(point.dihedral_angles, vectors.dihedral_angles.row(i).transpose());
        }
}

TEST(Blend, CombinesLengthsOrTheirSquaresAndAnglesPlainly)
{
    ShapeVectors vectors{RowMatrix(2, 2), RowMatrix(2, 2), Eigen::VectorXd::Ones(2)};
    vectors.edge_lengths << 1, 7, 3, 1;
    vectors.dihedral_angles << 0.5, 3.0, -0.5, 4.0;
    const Eigen::Vector2d half(0.5, 0.5);
    EXPECT_EQ(blend(vectors, half).edge_lengths, Eigen::Vector2d(2, 4));
    EXPECT_EQ(blend(vectors, half).dihedral_angles, Eigen::Vector2d(0, 3.5));
    const ShapePoint squared = blend(vectors, half, LengthBlend::Squared);
    EXPECT_LE((squared.edge_lengths - Eigen::Vector2d(std::sqrt(5.0), 5.0)).norm(), 1e-15);
    EXPECT_EQ(squared.dihedral_angles, Eigen::Vector2d(0, 3.5));
    // Extrapolation: 2 * 1 - 1 * 9 < 0 has no root.
    EXPECT_EQ(blend(vectors, Eigen::Vector2d(2, -1), LengthBlend::Squared).edge_lengths[0], 0.0);
    EXPECT_EQ(blend(vectors, Eigen::Vector2d(2, -1)).edge_lengths, Eigen::Vector2d(-1, 13));
}

TEST(Blend, RefusesWeightsThatBreakARule)
{
    const ShapeVectors vectors = shape_vectors(test::bumpy_spheres(2, 8), Scale::Unit);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)blend(vectors, Eigen::Vector3d(1, 0, 0)), InvalidInput);
    EXPECT_THROW((void)blend(vectors, Eigen::Vector2d(0.5, 0.5 + 2e-9)), InvalidInput);
    EXPECT_THROW((void)blend(vectors, Eigen::Vector2d(nan, 1)), InvalidInput);
    EXPECT_NO_THROW((void)blend(vectors, Eigen::Vector2d(0.5, 0.5 + 5e-10)));
    EXPECT_NO_THROW((void)blend(vectors, Eigen::Vector2d(-2, 3)));
}

} // namespace
} // namespace shape
