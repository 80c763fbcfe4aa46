// SPDX-License-Identifier: MIT

#include "libshape/embedding/contact/contact_gaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/two_spheres.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;
using test::TwoSpheres;
using Gap = LengthDihedralEnergy::Gap;

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
