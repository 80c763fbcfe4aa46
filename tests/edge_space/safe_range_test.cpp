// SPDX-License-Identifier: MIT

#include "libshape/edge_space/safe_range.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/edge_space/admissibility.h"
#include "tests/support/collections.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr LengthBlend blends[] = {LengthBlend::Plain, LengthBlend::Squared};

bool is_feasible(const Topology& topology, const ShapeVectors& vectors, const VectorXd& weights,
                 LengthBlend lengths)
{
    return check_admissibility(topology, blend(vectors, weights, lengths).edge_lengths)
        .triangles.empty();
}

/// One triangle as two meshes with the given sides.
ShapeVectors triangles(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
    ShapeVectors vectors;
    vectors.edge_lengths.resize(2, 3);
    vectors.edge_lengths << a.transpose(), b.transpose();
    vectors.dihedral_angles = RowMatrix::Zero(2, 3);
    return vectors;
}

const Topology& one_face()
{
    static const Topology topology(Faces{{0, 1, 2}}, 3);
    return topology;
}

TEST(SafeReach, IsWhereTheFirstTriangleBreaks)
{
    // Sides 1, 1, 1 + s: breaks at s = 1.
    const ShapeVectors plain = triangles({1, 1, 1}, {1, 1, 2});
    const SafeReach reach =
        safe_reach(one_face(), plain, Vector2d(1, 0), Vector2d(-1, 1), LengthBlend::Plain);
    EXPECT_DOUBLE_EQ(reach.reach, 1.0);
    EXPECT_EQ(reach.face, 0);
    // Squares 1, 1, 1 + s: breaks at s = 3.
    const ShapeVectors squared = triangles({1, 1, 1}, {1, 1, std::sqrt(2.0)});
    EXPECT_NEAR(
        safe_reach(one_face(), squared, Vector2d(1, 0), Vector2d(-1, 1), LengthBlend::Squared)
            .reach,
        3.0, 1e-14);
}

TEST(SafeReach, EndsBeforeALengthVanishes)
{
    // Squares 4, 4, 4 - s: area vanishes with the side, at s = 4.
    const ShapeVectors vectors = triangles({2, 2, 2}, {2, 2, std::sqrt(3.0)});
    EXPECT_NEAR(
        safe_reach(one_face(), vectors, Vector2d(1, 0), Vector2d(-1, 1), LengthBlend::Squared)
            .reach,
        4.0, 1e-13);
}

TEST(SafeReach, IsInfiniteWhereNothingBreaks)
{
    const ShapeVectors vectors = triangles({1, 1, 1}, {2, 2, 2});
    for (const LengthBlend lengths : blends) {
        const SafeReach reach =
            safe_reach(one_face(), vectors, Vector2d(1, 0), Vector2d(-1, 1), lengths);
        EXPECT_TRUE(std::isinf(reach.reach));
        EXPECT_EQ(reach.face, -1);
        EXPECT_TRUE(std::isinf(safe_reach(one_face(), vectors, Vector2d(0.5, 0.5), lengths).reach));
    }
}

TEST(SafeReach, AgreesWithACheckOfEveryTriangle)
{
    for (unsigned seed = 1; seed <= 6; ++seed) {
        const Collection collection = test::bumpy_spheres(4, seed);
        const ShapeVectors vectors = shape_vectors(collection, Scale::None);
        const VectorXd start = VectorXd::Unit(4, 0);
        VectorXd away(4);
        away << 2.0, -1.0, -1.5, 0.5;
        int found = 0; // along one of two opposite directions lengths shrink until one breaks
        for (const VectorXd& direction : {away, VectorXd(-away)})
            for (const LengthBlend lengths : blends) {
                const double reach =
                    safe_reach(collection.topology, vectors, start, direction, lengths).reach;
                const auto holds_at = [&](double step) {
                    return is_feasible(collection.topology, vectors, start + step * direction,
                                       lengths);
                };
                for (const double share : {0.1, 0.5, 0.9, 1.0 - 1e-9})
                    EXPECT_TRUE(holds_at(share * std::min(reach, 100.0))) << share;
                if (std::isfinite(reach)) {
                    EXPECT_FALSE(holds_at((1.0 + 1e-9) * reach));
                    ++found;
                }
            }
        EXPECT_GE(found, 2);
    }
}

TEST(SafeReach, OfWeightsStartsAtTheirPositivePart)
{
    const Collection collection = test::bumpy_spheres(2, 3);
    const ShapeVectors vectors = shape_vectors(collection, Scale::None);
    for (const LengthBlend lengths : blends) {
        const double line =
            safe_reach(collection.topology, vectors, Vector2d(0, 1), Vector2d(-1, 1), lengths)
                .reach;
        const SafeReach reach =
            safe_reach(collection.topology, vectors, Vector2d(-0.25, 1.25), lengths);
        EXPECT_NEAR(reach.reach, line / 0.25, 1e-9 * reach.reach);
    }
}

TEST(SafeReach, RefusesWhatDoesNotFit)
{
    const ShapeVectors vectors = triangles({1, 1, 1}, {1, 1, 2});
    EXPECT_THROW((void)safe_reach(one_face(), vectors, VectorXd::Ones(3), LengthBlend::Plain),
                 InvalidInput);
    EXPECT_THROW((void)safe_reach(one_face(), vectors, Vector2d(NAN, 1), LengthBlend::Plain),
                 InvalidInput);
    EXPECT_THROW((void)safe_reach(one_face(), vectors, Vector2d(-1, -1), LengthBlend::Plain),
                 InvalidInput);
    EXPECT_THROW((void)safe_reach(test::tetrahedron().topology, vectors, Vector2d(2, -1),
                                  LengthBlend::Plain),
                 InvalidInput);
}

} // namespace
} // namespace shape
