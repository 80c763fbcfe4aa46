// SPDX-License-Identifier: MIT

#include "libshape/embedding/contact/contact_gaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;
using Gap = LengthDihedralEnergy::Gap;

/// Two spheres of radius 1 beside each other along x, and all pairs of their faces that cross. They lack a face each, far from each
/// other, where a prism joins them to one surface.
struct TwoSpheres
{
    Topology topology;
    VectorXd points;
    std::vector<FacePair> pairs;

    explicit TwoSpheres(double distance) : topology(joined_spheres())
    {
        const Points sphere = test::icosphere(2).points;
        Points both(2 * sphere.rows(), 3);
        // Not quite beside: where edges meet edges, no edge crosses a face.
        both << sphere, sphere.rowwise() + Eigen::RowVector3d(distance, 0.03, 0.05);
        points = both.reshaped<Eigen::RowMajor>();
        pairs = FaceTree(topology, both).crossings(both);
        const int prism = topology.face_count() - 6;
        std::erase_if(pairs, [&](const FacePair& pair) { return pair[1] >= prism; });
    }

    static Topology joined_spheres()
    {
        const test::TestMesh sphere = test::icosphere(2);
        const Faces& faces = sphere.topology.faces();
        const int count = sphere.topology.vertex_count();
        const auto last = faces.rows() - 1;
        int left = 0, right = 0;
        const auto place = [&](Eigen::Index f) { return sphere.points(faces.row(f), 0).sum(); };
        for (int f = 0; f <= last; ++f) {
            left = place(f) < place(left) ? f : left;
            right = place(f) > place(right) ? f : right;
        }
        Faces both(2 * faces.rows() + 4, 3);
        int row = 0;
        for (int f = 0; f <= last; ++f)
            if (f != left)
                both.row(row++) = faces.row(f);
        for (int f = 0; f <= last; ++f)
            if (f != right)
                both.row(row++) = faces.row(f).array() + count;
        for (int k = 0; k < 3; ++k) {
            const int a = faces(left, k), next_a = faces(left, (k + 1) % 3);
            const int b = faces(right, (3 - k) % 3) + count, next_b = faces(right, 2 - k) + count;
            both.row(row++) << a, next_a, next_b;
            both.row(row++) << a, next_b, b;
        }
        return {both, 2 * count};
    }
};

/// The vector of a gap along its direction.
double reached(const Gap& gap, const VectorXd& points)
{
    double sum = 0.0;
    for (std::size_t i = 0; i < gap.vertices.size(); ++i)
        sum += gap.factors[i] * gap.direction.dot(points.segment<3>(3 * gap.vertices[i]));
    return sum;
}

TEST(ContactGaps, OfTwoSpheresPointOutAndAreAsDeepAsTheyOverlap)
{
    const double overlap = 0.15;
    const TwoSpheres spheres(2.0 - overlap);
    ASSERT_FALSE(spheres.pairs.empty());
    const auto gaps = contact_gaps(spheres.topology, spheres.points, spheres.pairs);
    double deepest = 0.0;
    for (const Gap& gap : gaps) {
        double sum = 0.0;
        for (const double factor : gap.factors)
            sum += factor;
        EXPECT_NEAR(sum, 0.0, 1e-12);
        EXPECT_NEAR(gap.direction.norm(), 1.0, 1e-12);
        // From the other sphere's centre outwards: the place is of the right or of the left one.
        const bool is_left = gap.vertices[0] < spheres.topology.vertex_count() / 2;
        EXPECT_LT(is_left ? gap.direction.x() : -gap.direction.x(), -0.5);
        EXPECT_LE(gap.least, std::max(reached(gap, spheres.points), 0.1) + 0.1);
        deepest = std::min(deepest, reached(gap, spheres.points));
    }
    // Facets lie up to 0.03 below the sphere.
    EXPECT_NEAR(deepest, -overlap, 0.06);
}

TEST(ContactGaps, OfSurfacesThatAreApartLackNothing)
{
    const TwoSpheres crossing(1.9);
    const TwoSpheres apart(2.2);
    const auto gaps = contact_gaps(apart.topology, apart.points, crossing.pairs);
    ASSERT_FALSE(gaps.empty());
    for (const Gap& gap : gaps)
        EXPECT_EQ(LengthDihedralEnergy::lack(gap, apart.points), 0.0);
}

TEST(ContactGaps, AreNoneWithoutPairs)
{
    const TwoSpheres spheres(1.9);
    EXPECT_TRUE(contact_gaps(spheres.topology, spheres.points, {}).empty());
}

} // namespace
} // namespace shape
