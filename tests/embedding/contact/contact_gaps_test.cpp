// SPDX-License-Identifier: MIT

#include "libshape/embedding/contact/contact_gaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
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

/// Mean of the squared lengths of the edges at a vertex.
double square_around(const TwoSpheres& spheres, int v)
{
    double sum = 0.0;
    const auto spokes = spheres.topology.spokes(v);
    for (const Topology::Spoke& spoke : spokes)
        sum += (spheres.points.segment<3>(3 * spoke.vertex) - spheres.points.segment<3>(3 * v))
                   .squaredNorm();
    return sum / static_cast<double>(spokes.size());
}

/// The length of the edges around a gap's place, which its stiffness is made of.
double edge_of(const Gap& gap, const ContactGapOptions& options)
{
    return std::sqrt(options.stiffness / gap.stiffness);
}

TEST(ContactGaps, AreFoundAroundPairsWithinTheRings)
{
    const TwoSpheres spheres(1.9);
    const Topology& t = spheres.topology;
    std::vector<std::set<int>> near(
        3); // vertices of the pairs' faces, and within one and two rings
    for (const FacePair& pair : spheres.pairs)
        for (const int f : pair)
            near[0].insert(t.faces().row(f).begin(), t.faces().row(f).end());
    for (std::size_t ring = 1; ring < near.size(); ++ring) {
        near[ring] = near[ring - 1];
        for (const int v : near[ring - 1])
            for (const Topology::Spoke& spoke : t.spokes(v))
                near[ring].insert(spoke.vertex);
    }
    for (int rings = 0; rings <= 2; ++rings) {
        std::set<int> places;
        for (const Gap& gap : contact_gaps(t, spheres.points, spheres.pairs, {.rings = rings}))
            places.insert(gap.vertices.begin(), gap.vertices.begin() + 2);
        const std::set<int>& expected = near[static_cast<std::size_t>(rings)];
        EXPECT_TRUE(std::ranges::includes(expected, places)) << rings;
        if (rings > 0) { // and not only nearer
            EXPECT_FALSE(std::ranges::includes(near[static_cast<std::size_t>(rings) - 1], places));
        }
    }
}

TEST(ContactGaps, AskForTheMarginOrAStep)
{
    const TwoSpheres spheres(1.9);
    for (const ContactGapOptions& options :
         {ContactGapOptions{}, ContactGapOptions{.margin = 0.0}, ContactGapOptions{.step = 0.5},
          ContactGapOptions{.margin = 9.0, .step = 0.2}, ContactGapOptions{.stiffness = 7.0}}) {
        const auto gaps = contact_gaps(spheres.topology, spheres.points, spheres.pairs, options);
        ASSERT_FALSE(gaps.empty());
        for (const Gap& gap : gaps) {
            const double edge = edge_of(gap, options);
            EXPECT_NEAR(edge,
                        std::sqrt(0.5 * (square_around(spheres, gap.vertices[0]) +
                                         square_around(spheres, gap.vertices[1]))),
                        1e-12);
            EXPECT_NEAR(
                gap.least,
                std::min(options.margin * edge, reached(gap, spheres.points) + options.step * edge),
                1e-12);
        }
    }
}

TEST(ContactGaps, PointOutWhicheverWayTheFacesRun)
{
    const TwoSpheres spheres(1.9);
    Faces reversed = spheres.topology.faces();
    reversed.col(1).swap(reversed.col(2));
    const Topology inside_out(reversed, spheres.topology.vertex_count());
    const auto directions = [&](const Topology& topology) {
        std::map<std::pair<int, int>, Eigen::Vector3d> found;
        for (const Gap& gap : contact_gaps(topology, spheres.points, spheres.pairs))
            found[std::minmax(gap.vertices[0], gap.vertices[1])] = gap.direction;
        return found;
    };
    const auto expected = directions(spheres.topology), found = directions(inside_out);
    ASSERT_FALSE(expected.empty());
    ASSERT_EQ(found.size(), expected.size());
    for (const auto& [place, direction] : expected) {
        ASSERT_TRUE(found.contains(place));
        EXPECT_LT((found.at(place) - direction).norm(), 1e-9);
    }
}

TEST(ContactGaps, LeaveAloneWhatIsTooDeep)
{
    const TwoSpheres spheres(1.8);
    const auto is_deeper = [&](const ContactGapOptions& options, double than) {
        return std::ranges::any_of(
            contact_gaps(spheres.topology, spheres.points, spheres.pairs, options),
            [&](const Gap& gap) {
                return reached(gap, spheres.points) < -than * edge_of(gap, options);
            });
    };
    EXPECT_TRUE(is_deeper({}, 0.4));
    EXPECT_FALSE(is_deeper({.deepest = 0.4}, 0.4));
    EXPECT_TRUE(is_deeper({.deepest = 0.4}, 0.2));
}

TEST(ContactGaps, AreNoneWithoutPairs)
{
    const TwoSpheres spheres(1.9);
    EXPECT_TRUE(contact_gaps(spheres.topology, spheres.points, {}).empty());
}

} // namespace
} // namespace shape
