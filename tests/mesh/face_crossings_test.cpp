// SPDX-License-Identifier: MIT

#include "libshape/mesh/face_crossings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libshape/base/random.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

using namespace internal;

TEST(SideOfPlane, IsExactWhereRoundingIsNot)
{
    // Points of a plane with coordinates that are sums of powers of two; the last one is off it by one
    // unit in the last place, far less than the determinant's rounding.
    const double a[] = {0.5, 0.5, 0.5};
    const double b[] = {12.0, 12.0, 12.0};
    const double c[] = {24.0, 24.0, 25.0};
    double d[] = {7.0, 7.0, -3.0};
    EXPECT_EQ(side_of_plane(a, b, c, d), 0);
    for (const double towards : {0.0, 8.0}) {
        d[0] = std::nextafter(7.0, towards);
        const int side = side_of_plane(a, b, c, d);
        EXPECT_NE(side, 0);
        EXPECT_EQ(side_of_plane(b, a, c, d), -side);
        EXPECT_EQ(side_of_plane(b, c, a, d), side);
    }
    d[0] = std::nextafter(7.0, 0.0);
    const int below = side_of_plane(a, b, c, d);
    d[0] = std::nextafter(7.0, 8.0);
    EXPECT_EQ(side_of_plane(a, b, c, d), -below);
}

TEST(FaceTree, FindsNothingInSurfacesThatDoNotCrossThemselves)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        EXPECT_TRUE(FaceTree(mesh.topology, mesh.points).crossings(mesh.points).empty());
    }
}

TEST(FaceTree, FindsWhatComparingAllPairsFinds)
{
    // A torus so thick that it passes through itself at its axis, in general position.
    test::TestMesh mesh = test::torus(24, 36);
    Random random(4);
    Points thick = mesh.points;
    const double inner = mesh.points.leftCols<2>().rowwise().norm().minCoeff();
    const double outer = mesh.points.leftCols<2>().rowwise().norm().maxCoeff();
    const double inwards = inner + 0.3 * (outer - inner);
    for (auto row : thick.rowwise()) {
        const double from_axis = std::hypot(row.x(), row.y());
        row.head<2>() *= (from_axis - inwards) / from_axis;
        for (double& value : row)
            value += random.uniform(-1e-3, 1e-3);
    }
    const FaceTree tree(mesh.topology, mesh.points); // of another shape
    const std::vector<FacePair> pairs = tree.crossings(thick);
    EXPECT_GT(pairs.size(), 20U);
    EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));

    const auto corner = [&](int face, int c) {
        return thick.data() + 3 * mesh.topology.faces()(face, c % 3);
    };
    const auto side_crosses = [&](int of, int face) {
        for (int c = 0; c < 3; ++c) {
            const double* const p = corner(of, c);
            const double* const q = corner(of, c + 1);
            const auto turn = [&](int k) {
                return side_of_plane(p, q, corner(face, k), corner(face, k + 1));
            };
            if (side_of_plane(corner(face, 0), corner(face, 1), corner(face, 2), p) *
                        side_of_plane(corner(face, 0), corner(face, 1), corner(face, 2), q) <
                    0 &&
                turn(0) != 0 && turn(0) == turn(1) && turn(1) == turn(2))
                return true;
        }
        return false;
    };
    std::vector<FacePair> expected;
    for (int f = 0; f < mesh.topology.face_count(); ++f)
        for (int g = f + 1; g < mesh.topology.face_count(); ++g)
            if (side_crosses(f, g) || side_crosses(g, f))
                expected.push_back({f, g});
    EXPECT_EQ(pairs, expected);

    const test::ThreadScope one_thread(1);
    EXPECT_EQ(tree.crossings(thick), pairs);
}

TEST(FaceTree, SeesAFoldedNeighbourThatPassesThroughAndNotOneThatTouches)
{
    // Two triangles with a common corner, the second one through the first or just up to it.
    Faces faces(4, 3);
    faces << 0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5;
    const Topology topology(faces, 6);
    Points points(6, 3);
    points << 0, 0, 0, 4, -1, 0, 4, 1, 0, 0, 3, 1, 3, 0, 1, 3, 0, -1;
    const FaceTree tree(topology, points);
    EXPECT_EQ(tree.crossings(points), (std::vector<FacePair>{{0, 3}}));
    points(5, 2) = 0.0;
    EXPECT_TRUE(tree.crossings(points).empty());
}

} // namespace
} // namespace shape
