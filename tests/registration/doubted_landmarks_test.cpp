// SPDX-License-Identifier: MIT

#include "libshape/registration/doubted_landmarks.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/registration/scan_fit.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

using namespace shape::test;

/// A head with its own features, a wider one of another triangulation, and landmarks on both.
struct Heads
{
    TestMesh mesh = bumpy_sphere(3, 0.3, 5);
    Points truth = widened(mesh.points);
    Scan scan;
    ScanFitter fitter{mesh.topology, mesh.points};
    double diagonal = bounding_box_diagonal(truth);

    Heads()
    {
        const TestMesh fine = bumpy_sphere(4, 0.3, 5);
        scan = clean_scan(widened(fine.points), fine.topology.faces());
    }
    static Points widened(Points points)
    {
        points.col(0) *= 1.15;
        return points;
    }
    [[nodiscard]] LandmarkPairs marks_at(const std::vector<int>& vertices) const
    {
        LandmarkPairs marks;
        for (std::size_t i = 0; i < vertices.size(); ++i)
            marks.names.push_back(std::string(1, static_cast<char>('a' + i)));
        marks.on_template = mesh.points(vertices, Eigen::all);
        marks.on_scan = truth(vertices, Eigen::all);
        return marks;
    }
    /// The vertex of which a distance from vertex v, over the diagonal, is nearest to `far`.
    [[nodiscard]] int vertex_at(int v, double far) const
    {
        Eigen::Index best = 0;
        const Eigen::VectorXd away = (truth.rowwise() - truth.row(v)).rowwise().norm() / diagonal;
        (away.array() - far).abs().minCoeff(&best);
        return static_cast<int>(best);
    }
};
const Heads& heads()
{
    static const Heads result;
    return result;
}
const std::vector<int> places{0, 100, 200, 300, 400, 500};

bool says(const ScanFit& fit, const std::string& part)
{
    return std::ranges::any_of(fit.reasons, [&](const std::string& reason) {
        return reason.find(part) != std::string::npos;
    });
}

TEST(DoubtedLandmarks, AreNamedWithHowFarTheyAreOff)
{
    const Heads& h = heads();
    for (const bool on_scan : {true, false})
        for (const double far : {0.15, 0.25}) {
            LandmarkPairs marks = h.marks_at(places);
            const int there = h.vertex_at(200, far);
            (on_scan ? marks.on_scan : marks.on_template).row(2) =
                (on_scan ? h.truth : h.mesh.points).row(there);
            const ScanFit fit = h.fitter.fit(h.scan, marks);
            EXPECT_NE(fit.status, FitStatus::Good);
            EXPECT_TRUE(says(fit, "landmark 'c' may be in the wrong place")) << on_scan << far;
            ASSERT_EQ(fit.doubted_landmarks.size(), 1U) << on_scan << far;
            EXPECT_EQ(fit.doubted_landmarks.front().name, "c");
            EXPECT_NEAR(fit.doubted_landmarks.front().off, far * h.diagonal, 0.05 * h.diagonal);
        }
}

TEST(DoubtedLandmarks, StayInDoubtInLaterRounds)
{
    const Heads& h = heads();
    LandmarkPairs marks = h.marks_at(places);
    marks.on_scan.row(2) = h.truth.row(h.vertex_at(200, 0.2));
    const ScanFit fit = h.fitter.fit(h.scan, marks);
    const ShapePoint rest{edge_lengths(h.mesh.topology, h.truth),
                          dihedral_angles(h.mesh.topology, h.truth)};
    const ScanFit again = h.fitter.fit_again(h.scan, marks, fit, rest);
    EXPECT_NE(again.status, FitStatus::Good);
    EXPECT_TRUE(says(again, "landmark 'c' may be in the wrong place"));
}

TEST(DoubtedLandmarks, AreNotThoseThatAHandHasPlaced)
{
    const Heads& h = heads();
    LandmarkPairs marks = h.marks_at(places);
    EXPECT_EQ(h.fitter.fit(h.scan, marks).status, FitStatus::Good);
    for (const int v : {0, 2, 4})
        marks.on_scan.row(v) +=
            0.01 * h.diagonal *
            Eigen::RowVector3d::UnitX().cross(marks.on_scan.row(v).normalized());
    EXPECT_TRUE(h.fitter.fit(h.scan, marks).doubted_landmarks.empty());
    // What is tolerated is three times a standard deviation.
    marks.on_scan.row(2) = h.truth.row(h.vertex_at(200, 0.2));
    const ScanFitter tolerant(h.mesh.topology, h.mesh.points,
                              {.landmark_tolerance = 0.08 * h.diagonal});
    EXPECT_TRUE(tolerant.fit(h.scan, marks).doubted_landmarks.empty());
}

TEST(DoubtedLandmarks, OfThreeNoneCanBeTold)
{
    const Heads& h = heads();
    LandmarkPairs marks = h.marks_at({0, 200, 400});
    marks.on_scan.row(1) = h.truth.row(h.vertex_at(200, 0.2));
    EXPECT_TRUE(h.fitter.fit(h.scan, marks).doubted_landmarks.empty());
}

TEST(DoubtedLandmarks, TwoOrThreeBesideEachOthersNamesAreNamed)
{
    const Heads& h = heads();
    LandmarkPairs marks = h.marks_at({0, 200, 400});
    EXPECT_EQ(h.fitter.fit(h.scan, marks).status, FitStatus::Good);
    marks.on_scan.row(0).swap(marks.on_scan.row(2));
    ScanFit fit = h.fitter.fit(h.scan, marks);
    EXPECT_NE(fit.status, FitStatus::Good);
    EXPECT_TRUE(says(fit, "landmarks 'a' and 'c' look exchanged"));
    marks.on_scan.row(0).swap(marks.on_scan.row(1)); // in a circle
    EXPECT_TRUE(says(h.fitter.fit(h.scan, marks), "landmarks 'a', 'b' and 'c' look exchanged"));
    marks = h.marks_at({50, 400});
    EXPECT_EQ(h.fitter.fit(h.scan, marks).status, FitStatus::Good);
    marks.on_scan.row(0).swap(marks.on_scan.row(1));
    fit = h.fitter.fit(h.scan, marks);
    EXPECT_NE(fit.status, FitStatus::Good);
    EXPECT_TRUE(says(fit, "landmarks 'a' and 'b' look exchanged"));
}

} // namespace
} // namespace shape
