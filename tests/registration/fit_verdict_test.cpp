// SPDX-License-Identifier: MIT

#include "libshape/registration/fit_verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/meshes.h"

namespace shape::internal {
namespace {

using namespace shape::test;

/// Of a ring, whose points go to `turns` times their angle about its axis.
Points wound(const Points& points, double turns)
{
    Points result = points;
    for (auto point : result.rowwise()) {
        const double radius = std::hypot(point[0], point[1]);
        const double angle = turns * std::atan2(point[1], point[0]);
        point[0] = radius * std::cos(angle);
        point[1] = radius * std::sin(angle);
    }
    return result;
}

/// What is said of a fit of a ring that winds so often about a scan of the same ring.
ScanFit judged(double turns)
{
    const TestMesh ring = torus(24, 72);
    const Surface scan(ring.points, ring.topology.faces());
    const TemplateFigures own(ring.topology, ring.points);
    const LevelMesh mesh{wound(ring.points, turns), Eigen::VectorXd::Zero(ring.points.rows())};
    const Eigen::VectorXd strains = Eigen::VectorXd::Zero(ring.topology.edge_count());
    const LandmarkPairs no_landmarks;
    const Eigen::VectorXd none;
    const Points nowhere(0, 3);
    ScanFit fit;
    judge({.topology = ring.topology,
           .mesh = mesh,
           .strains = strains,
           .scan = scan,
           .diagonal = bounding_box_diagonal(ring.points),
           .start_growth = 1.0,
           .landmarks = no_landmarks,
           .off_template = none,
           .reached = nowhere,
           .landmark_tolerance = 0.0},
          own, fit);
    return fit;
}

bool says(const ScanFit& fit, const std::string& what)
{
    return std::any_of(fit.reasons.begin(), fit.reasons.end(), [&](const std::string& reason) {
        return reason.find(what) != std::string::npos;
    });
}

TEST(FitVerdict, EveryPartInItsOwnPlaceIsGood)
{
    const ScanFit fit = judged(1.0);
    EXPECT_EQ(fit.status, FitStatus::Good);
    EXPECT_EQ(fit.unclaimed_share, 0.0);
    EXPECT_EQ(fit.contested_vertices, 0);
}

TEST(FitVerdict, SaysThatTwoPartsLieInTheSamePlace)
{
    const ScanFit fit = judged(2.0);
    EXPECT_EQ(fit.unclaimed_share, 0.0);
    EXPECT_GT(fit.contested_vertices, static_cast<int>(fit.seen.size()) / 3);
    EXPECT_EQ(fit.status, FitStatus::Check);
    EXPECT_TRUE(says(fit, " of the vertices lie where another part of the template does"));
}

TEST(FitVerdict, SaysWhatOfTheScanIsLeftOut)
{
    const ScanFit fit = judged(0.5);
    EXPECT_EQ(fit.contested_vertices, 0);
    EXPECT_GT(fit.unclaimed_share, 0.3);
    EXPECT_TRUE(says(fit, " of the scan's surface has no counterpart in the fit"));
}

} // namespace
} // namespace shape::internal
