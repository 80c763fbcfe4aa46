// SPDX-License-Identifier: MIT

#include "libshape/embedding/contact/contact_separation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "libshape/embedding/start/edge_laplacian.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/two_spheres.h"

namespace shape {
using namespace internal;
namespace {

struct Overlapping
{
    explicit Overlapping(double distance) : spheres(distance) {}

    test::TwoSpheres spheres;
    Points points = Points::Map(spheres.points.data(), spheres.topology.vertex_count(), 3);
    FaceTree faces{spheres.topology, points};
    Eigen::VectorXd lengths = edge_lengths(spheres.topology, points);
    EdgeLaplacian laplacian{spheres.topology, lengths};

    /// The prism passes through both spheres, and may.
    [[nodiscard]] std::vector<FacePair> of_the_prism() const
    {
        std::vector<FacePair> pairs;
        const int count = spheres.topology.face_count();
        for (int f = 0; f < count; ++f)
            for (int g = std::max(f + 1, count - 6); g < count; ++g)
                pairs.push_back({f, g});
        return pairs;
    }
    [[nodiscard]] ContactSeparation separate(const ContactSeparationOptions& options = {},
                                             bool all_is_acceptable = true)
    {
        return separate_contacts(
            spheres.topology, faces, of_the_prism(), laplacian.single_precision(), points,
            [&](const Points&) { return all_is_acceptable; }, options);
    }
    [[nodiscard]] std::size_t pairs_of_spheres(const Points& now) const
    {
        std::vector<FacePair> pairs = faces.crossings(now);
        std::erase_if(pairs, [&](const FacePair& pair) {
            return pair[1] >= spheres.topology.face_count() - 6;
        });
        return pairs.size();
    }
    /// The largest change of an edge, as a part of it.
    [[nodiscard]] double stretch(const Points& now) const
    {
        return ((edge_lengths(spheres.topology, now) - lengths).array() / lengths.array())
            .abs()
            .maxCoeff();
    }
};

struct Separation : testing::Test, Overlapping
{
    Separation() : Overlapping(1.9) {}
};

TEST_F(Separation, LeavesNoPairAndCountsWhatItLeaves)
{
    ASSERT_GT(spheres.pairs.size(), 10U);
    const ContactSeparation apart = separate();
    EXPECT_EQ(apart.pairs, 0);
    EXPECT_EQ(pairs_of_spheres(apart.points), 0U);
    EXPECT_LE(stretch(apart.points), 0.1);
}

TEST_F(Separation, StretchesNoEdgeFurtherThanAllowed)
{
    const double needed = stretch(separate().points);
    ASSERT_GT(needed, 1e-3);
    const ContactSeparation within = separate({.stretch = 0.5 * needed});
    EXPECT_LE(stretch(within.points), 0.5 * needed);
    const ContactSeparation untouched = separate({.stretch = 1e-9});
    EXPECT_TRUE(untouched.points == points);
    EXPECT_EQ(untouched.pairs, static_cast<int>(spheres.pairs.size()));
}

TEST_F(Separation, LeavesAllowedPairsAndMeshesThatAreNotAcceptable)
{
    EXPECT_TRUE(separate_contacts(spheres.topology, faces, faces.crossings(points),
                                  laplacian.single_precision(), points,
                                  [](const Points&) { return true; })
                    .points == points);
    EXPECT_TRUE(separate({}, false).points == points);
}

TEST_F(Separation, RefinementsTakeBackWhatWasMovedTooFar)
{
    Overlapping deeper(1.7); // these take several rounds, and go too far
    const double at_once = deeper.stretch(deeper.separate({.refinements = 0}).points);
    const ContactSeparation refined = deeper.separate();
    EXPECT_EQ(refined.pairs, 0);
    EXPECT_LT(deeper.stretch(refined.points), 0.95 * at_once);
}

TEST_F(Separation, WeakGapsPartSurfacesAsTheyGrowStiffer)
{
    const ContactGapOptions weak{.stiffness = 1e-4};
    EXPECT_GT(separate({.gaps = weak, .growth = 1.0}).pairs, 0);
    EXPECT_EQ(separate({.gaps = weak, .growth = 2.0}).pairs, 0);
}

TEST_F(Separation, SmootherMeshesKeepTheirAngles)
{
    const auto bent = [&](double smoothness) {
        const ContactSeparation apart = separate({.smoothness = smoothness});
        EXPECT_EQ(apart.pairs, 0);
        return (dihedral_angles(spheres.topology, apart.points) -
                dihedral_angles(spheres.topology, points))
            .norm();
    };
    EXPECT_LT(bent(0.05), 0.8 * bent(5e-4));
}

TEST_F(Separation, TakesAsManyLinearStepsARoundAsItIsToldTo)
{
    const auto moved_at_once = [&](int steps) { // in the first round that is better
        double moved = 0.0;
        (void)separate_contacts(spheres.topology, faces, of_the_prism(),
                                laplacian.single_precision(), points,
                                [&](const Points& now) {
                                    if (moved == 0.0)
                                        moved = (now - points).norm();
                                    return false;
                                },
                                {.linear_steps = steps});
        return moved;
    };
    EXPECT_GT(moved_at_once(2), 0.0);
    EXPECT_NE(moved_at_once(2), moved_at_once(24));
    EXPECT_NE(moved_at_once(2), moved_at_once(3)); // whose first Newton steps are the same
}

TEST_F(Separation, LeavesAMeshAloneWhereMostPairsStay)
{
    const std::size_t before = spheres.pairs.size();
    bool is_seen = false;
    for (const double stiffness : {0.003, 0.01, 0.03, 0.1, 0.3})
        for (const int rounds : {1, 2}) {
            std::size_t least = before;
            const ContactSeparation result = separate_contacts(
                spheres.topology, faces, of_the_prism(), laplacian.single_precision(), points,
                [&](const Points& now) {
                    least = std::min(least, pairs_of_spheres(now));
                    return true;
                },
                {.gaps = {.stiffness = stiffness}, .rounds = rounds});
            if (least == before || 2 * least <= before)
                continue;
            is_seen = true;
            EXPECT_TRUE(result.points == points);
            EXPECT_EQ(result.pairs, static_cast<int>(before));
        }
    EXPECT_TRUE(is_seen);
}

TEST_F(Separation, WithoutRoundsNothingMoves)
{
    EXPECT_TRUE(separate({.rounds = 0}).points == points);
}

} // namespace
} // namespace shape
