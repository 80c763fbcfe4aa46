// SPDX-License-Identifier: MIT

#include "libshape/registration/scan_fit.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/mesh/dihedral_angles.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape::test {
namespace {

/// A head of 642 vertices with its own features, and a scan of a wider one of another triangulation.
TestMesh pattern()
{
    return bumpy_sphere(3, 0.3, 5);
}
Points widened(const Points& points)
{
    Points wide = points;
    wide.col(0) *= 1.15;
    return wide;
}
Scan scan_of(const TestMesh& mesh)
{
    return clean_scan(mesh.points, mesh.topology.faces());
}
TestMesh wide_scan()
{
    TestMesh mesh = bumpy_sphere(4, 0.3, 5); // finer: other vertices on the same bumps
    mesh.points = widened(mesh.points);
    return mesh;
}
double rms(const Points& a, const Points& b)
{
    return std::sqrt((a - b).squaredNorm() / static_cast<double>(a.rows()));
}

/// On the pattern and where widened() brings them.
LandmarkPairs five_landmarks(const TestMesh& mesh)
{
    const std::vector<int> vertices{0, 100, 200, 300, 400};
    LandmarkPairs marks;
    marks.names = {"a", "b", "c", "d", "e"};
    marks.on_template = mesh.points(vertices, Eigen::all);
    marks.on_scan = widened(mesh.points)(vertices, Eigen::all);
    return marks;
}

LandmarkPairs marks_at(const std::vector<int>& vertices, const Points& here, const Points& there)
{
    LandmarkPairs marks;
    for (std::size_t i = 0; i < vertices.size(); ++i)
        marks.names.push_back(std::string(1, static_cast<char>('a' + i)));
    marks.on_template = here(vertices, Eigen::all);
    marks.on_scan = there(vertices, Eigen::all);
    return marks;
}

TEST(ScanFitter, FindsTheVerticesOfAWiderShape)
{
    const TestMesh mesh = pattern();
    const ScanFit fit = ScanFitter(mesh.topology, mesh.points).fit(scan_of(wide_scan()));
    EXPECT_EQ(fit.status, FitStatus::Good);
    EXPECT_EQ(fit.unseen_vertices, 0);
    EXPECT_EQ(fit.scale, 1.0);
    EXPECT_LT(fit.scan_to_fit.mean, 0.002 * fit.diagonal);
    EXPECT_LT(rms(fit.points, widened(mesh.points)), 0.01 * fit.diagonal);
    EXPECT_LT(rms(fit.points, widened(mesh.points)), 0.3 * rms(mesh.points, widened(mesh.points)));
}

TEST(ScanFitter, FollowsTheScanWhereverItLiesInWhateverUnit)
{
    TestMesh mesh = pattern();
    TestMesh scan = wide_scan();
    for (Points* points : {&mesh.points, &scan.points})
        points->col(1) *= 1.6; // a ball's start would be anyone's guess
    const Points there = 1000.0 * moved(scan.points, 3);
    const Points truth = 1000.0 * moved(widened(mesh.points), 3);
    scan.points = there;
    const ScanFit fit = ScanFitter(mesh.topology, mesh.points).fit(scan_of(scan));
    EXPECT_NEAR(fit.scale, 1000.0, 100.0);
    EXPECT_EQ(fit.status, FitStatus::Good);
    EXPECT_LT(rms(fit.points, truth), 0.02 * fit.diagonal);
}

TEST(ScanFitter, FollowsAScanThatIsFarAwayButNotTurned)
{
    const TestMesh mesh = pattern();
    TestMesh scan = wide_scan();
    const Eigen::RowVector3d away(20.0, -3.0, 5.0);
    scan.points.rowwise() += away;
    const ScanFit fit = ScanFitter(mesh.topology, mesh.points).fit(scan_of(scan));
    EXPECT_EQ(fit.status, FitStatus::Good);
    EXPECT_LT(rms(fit.points, Points(widened(mesh.points).rowwise() + away)), 0.01 * fit.diagonal);
}

TEST(ScanFitter, ALargerScanHasTheSameFitButForTheFactor)
{
    const TestMesh mesh = pattern();
    const ScanFitter fitter(mesh.topology, mesh.points);
    const TestMesh scan = wide_scan();
    const ScanFit known = fitter.fit(scan_of(scan));
    EXPECT_EQ(known.status, FitStatus::Good);
    for (const double factor : {1000.0, 0.001, 25.4, 3.0}) {
        const ScanFit fit = fitter.fit(clean_scan(factor * scan.points, scan.topology.faces()));
        EXPECT_EQ(fit.status, known.status) << factor;
        EXPECT_LT((fit.points / factor - known.points).cwiseAbs().maxCoeff(), 1e-4 * known.diagonal)
            << factor;
        EXPECT_NEAR(fit.strain_rms, known.strain_rms, 1e-4) << factor;
    }
    const ScanFit in_mm = fitter.fit(clean_scan(1000.0 * scan.points, scan.topology.faces()));
    EXPECT_EQ(in_mm.scale, 1000.0);
    EXPECT_LT((in_mm.growth - known.growth).cwiseAbs().maxCoeff(), 1e-4);
    const LandmarkPairs marks = five_landmarks(mesh);
    const ScanFit marked = fitter.fit(scan_of(scan), marks);
    const ScanFit marked_in_mm =
        fitter.fit(clean_scan(1000.0 * scan.points, scan.topology.faces()),
                   {marks.names, marks.on_template, 1000.0 * marks.on_scan});
    EXPECT_EQ(marked_in_mm.status, marked.status);
    EXPECT_LT((marked_in_mm.points / 1000.0 - marked.points).cwiseAbs().maxCoeff(),
              1e-4 * marked.diagonal);
}

/// Nearly the same after half a turn about any of their axes; the scan is a fifth larger.
struct HalfTurns
{
    TestMesh mesh = bumpy_sphere(3, 0.05, 5);
    TestMesh scan = bumpy_sphere(4, 0.05, 8);
    TestMesh truth = bumpy_sphere(3, 0.05, 8); // other vertices of the scan's surface

    HalfTurns()
    {
        stretch(mesh.points, 1.4, 0.7);
        for (TestMesh* other : {&scan, &truth}) {
            stretch(other->points, 1.45, 0.68);
            other->points *= 1.2;
        }
    }
    static void stretch(Points& points, double by_x, double by_z)
    {
        points.col(0) *= by_x;
        points.col(2) *= by_z;
    }
};

TEST(ScanFitter, DoubtsAStartWhenATurnedOneIsNearlyAsGoodInWhateverUnit)
{
    const HalfTurns shapes;
    const ScanFitter fitter(shapes.mesh.topology, shapes.mesh.points);
    const ScanFit known = fitter.fit(scan_of(shapes.scan));
    EXPECT_EQ(known.status, FitStatus::Check);
    EXPECT_NE(known.start_doubt.find("degrees it fits nearly as well"), std::string::npos)
        << known.start_doubt;
    EXPECT_EQ(known.reasons, std::vector<std::string>{known.start_doubt});
    // As it lies is how it is meant.
    EXPECT_LT(rms(known.points, shapes.truth.points), 0.1 * known.diagonal);
    for (const double factor : {1000.0, 100.0, 10.0, 3.0, 2.0, 1.3, 0.001}) {
        const ScanFit fit =
            fitter.fit(clean_scan(factor * shapes.scan.points, shapes.scan.topology.faces()));
        EXPECT_EQ(fit.status, FitStatus::Check) << factor;
        EXPECT_EQ(fit.start_doubt, known.start_doubt) << factor;
        EXPECT_LT((fit.points / factor - known.points).cwiseAbs().maxCoeff(), 1e-4 * known.diagonal)
            << factor;
    }
}

TEST(ScanFitter, KeepsADoubtUntilLandmarksDispelIt)
{
    const HalfTurns shapes;
    const ScanFitter fitter(shapes.mesh.topology, shapes.mesh.points);
    const Scan scan = scan_of(shapes.scan);
    const ScanFit first = fitter.fit(scan);
    const ScanFit again =
        fitter.fit_again(scan, {}, first, shape_of(shapes.mesh.topology, shapes.truth.points));
    EXPECT_EQ(again.status, FitStatus::Check);
    EXPECT_EQ(again.start_doubt, first.start_doubt);
    EXPECT_EQ(std::ranges::count(again.reasons, first.start_doubt), 1);
    const std::vector<int> vertices{351, 170}; // at the ends of two axes
    const ScanFit marked =
        fitter.fit(scan, marks_at(vertices, shapes.mesh.points, shapes.truth.points));
    EXPECT_EQ(marked.start_doubt, "");
}

TEST(ScanFitter, TurnsAScanThatIsInsideOut)
{
    const TestMesh mesh = pattern();
    const ScanFitter fitter(mesh.topology, mesh.points);
    Scan scan = scan_of(wide_scan());
    const ScanFit straight = fitter.fit(scan);
    scan.faces.col(1).swap(scan.faces.col(2));
    const ScanFit turned = fitter.fit(scan);
    EXPECT_EQ(straight.turned_faces, 0);
    EXPECT_EQ(turned.turned_faces, scan.faces.rows());
    EXPECT_LT(rms(straight.points, turned.points), 1e-3 * straight.diagonal);
}

TEST(ScanFitter, MeetsLandmarks)
{
    const TestMesh mesh = pattern();
    const LandmarkPairs marks = five_landmarks(mesh);
    const ScanFit fit = ScanFitter(mesh.topology, mesh.points).fit(scan_of(wide_scan()), marks);
    ASSERT_EQ(fit.landmark_errors.size(), 5);
    EXPECT_LT(fit.landmark_errors.maxCoeff(), 1e-3 * fit.diagonal);
    EXPECT_EQ(fit.status, FitStatus::Good);
}

TEST(ScanFitter, SaysThatLandmarksLookLikeAnotherUnit)
{
    const TestMesh mesh = pattern();
    LandmarkPairs marks = five_landmarks(mesh);
    marks.on_scan *= 0.1;
    const ScanFitter fitter(mesh.topology, mesh.points);
    const ScanFit fit = fitter.fit(scan_of(wide_scan()), marks);
    EXPECT_NE(fit.status, FitStatus::Good);
    const auto is_said = [](const std::string& reason) {
        return reason.find(
                   "of the scan look as if they were in another unit than the mesh "
                   "(millimetres and centimetres?): times 10 all") != std::string::npos;
    };
    EXPECT_EQ(std::count_if(fit.reasons.begin(), fit.reasons.end(), is_said), 1);
    marks.on_template *= 1000.0;
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)fitter.fit(scan_of(wide_scan()), marks);
              }).find("the landmarks of the template look as if"),
              std::string::npos);
}

TEST(ScanFitter, SaysWhereAHalfHasNoCounterpart)
{
    const TestMesh mesh = pattern();
    const Scan whole = scan_of(wide_scan());
    std::vector<int> kept;
    for (int f = 0; f < whole.faces.rows(); ++f)
        if (whole.points(whole.faces(f, 0), 2) > 0.0)
            kept.push_back(f);
    const ScanFit fit = ScanFitter(mesh.topology, mesh.points)
                            .fit(clean_scan(whole.points, whole.faces(kept, Eigen::all)));
    EXPECT_NE(fit.status, FitStatus::Good);
    EXPECT_GT(fit.unseen_vertices, mesh.points.rows() / 4);
    int wrong = 0; // seen below, or unseen above, well off the cut
    for (int v = 0; v < mesh.points.rows(); ++v)
        wrong += (mesh.points(v, 2) < -0.3 && fit.seen[static_cast<std::size_t>(v)] != 0) ||
                         (mesh.points(v, 2) > 0.3 && fit.seen[static_cast<std::size_t>(v)] == 0)
                     ? 1
                     : 0;
    EXPECT_LT(wrong, mesh.points.rows() / 50);
}

TEST(ScanFitter, SaysWhatOfTheScanHasNoCounterpartInTheFit)
{
    const TestMesh mesh = pattern();
    const TestMesh wide = wide_scan();
    const TestMesh ball = icosphere(1);
    const Points beside = (0.2 * ball.points).rowwise() + Eigen::RowVector3d(0.0, 1.7, 0.0);
    Points points(wide.points.rows() + beside.rows(), 3);
    points << wide.points, beside;
    Faces faces(wide.topology.face_count() + ball.topology.face_count(), 3);
    faces << wide.topology.faces(),
        (ball.topology.faces().array() + static_cast<int>(wide.points.rows())).matrix();
    const ScanFitter fitter(mesh.topology, mesh.points);
    const LandmarkPairs marks = five_landmarks(mesh);
    EXPECT_EQ(fitter.fit(scan_of(wide), marks).unclaimed_share, 0.0);
    const ScanFit fit = fitter.fit(clean_scan(points, faces), marks);
    // Radii 0.2 and some 1.1: the bumps add to the area too.
    EXPECT_NEAR(fit.unclaimed_share, 0.04 / 1.2, 0.015);
    EXPECT_EQ(fit.status, FitStatus::Check);
    EXPECT_TRUE(std::any_of(fit.reasons.begin(), fit.reasons.end(), [](const std::string& reason) {
        return reason.ends_with(" % of the scan's surface has no counterpart in the fit");
    }));
}

TEST(ScanFitter, ScansMayGoOnWhereTheTemplateEnds)
{
    const TestMesh mesh = pattern();
    const Scan whole = scan_of(mesh);
    std::vector<int> kept;
    for (int f = 0; f < whole.faces.rows(); ++f)
        if (whole.points(whole.faces(f, 0), 2) > -0.3)
            kept.push_back(f);
    const Scan part = clean_scan(whole.points, whole.faces(kept, Eigen::all));
    const Topology topology(part.faces, static_cast<int>(part.points.rows()));
    const ScanFit fit = ScanFitter(topology, part.points, {.search_start = false})
                            .fit(scan_of(bumpy_sphere(4, 0.3, 5)));
    EXPECT_GT(fit.scan_to_fit.max, 0.1 * fit.diagonal);
    EXPECT_LT(fit.unclaimed_share, 0.01);
}

TEST(ScanFitter, FailsOnAnotherThingAltogether)
{
    const TestMesh mesh = pattern();
    Faces one(1, 3);
    one << 0, 1, 2;
    Points corners(3, 3);
    corners << 0, 0, 0, 1, 0, 0, 0, 1, 0;
    const ScanFitter fitter(mesh.topology, mesh.points);
    const ScanFit triangle = fitter.fit(clean_scan(corners, one));
    EXPECT_EQ(triangle.status, FitStatus::Failed);
    EXPECT_FALSE(triangle.reasons.empty());
}

bool says(const ScanFit& fit, const std::string& part)
{
    return std::ranges::any_of(fit.reasons, [&](const std::string& reason) {
        return reason.find(part) != std::string::npos;
    });
}

TEST(ScanFitter, SaysWhichLandmarksWereSwappedOrLieOffTheSurface)
{
    const TestMesh mesh = pattern();
    const Points truth = widened(mesh.points);
    const ScanFitter fitter(mesh.topology, mesh.points);
    const std::vector<int> vertices{0, 100, 200, 300, 400, 500};
    LandmarkPairs swapped = marks_at(vertices, mesh.points, truth);
    swapped.on_scan.row(0).swap(swapped.on_scan.row(3));
    const ScanFit slip = fitter.fit(scan_of(wide_scan()), swapped);
    EXPECT_NE(slip.status, FitStatus::Good);
    EXPECT_TRUE(says(slip, "landmarks 'a' and 'd' look exchanged"));
    LandmarkPairs off = marks_at(vertices, mesh.points, truth);
    off.on_scan.row(2) *= 1.3;
    const ScanFit fit = fitter.fit(scan_of(wide_scan()), off);
    EXPECT_NE(fit.status, FitStatus::Good);
    EXPECT_TRUE(says(fit, "landmark 'c' lies "));
    // A code does not hide how far off it is by making the fit large: as many scan diagonals as it is away.
    off.on_scan.row(2) = Eigen::RowVector3d(9.0, 0.0, 0.0) * bounding_box_diagonal(truth);
    const ScanFit coded = fitter.fit(scan_of(wide_scan()), off);
    const double reach = truth.rowwise().norm().maxCoeff() / bounding_box_diagonal(truth);
    for (const std::string& reason : coded.reasons)
        if (reason.starts_with("landmark 'c' lies ")) {
            const double said = std::stod(reason.substr(18));
            EXPECT_GE(said, 100.0 * (9.0 - reach) - 0.1);
            EXPECT_LE(said, 900.0);
        }
    EXPECT_TRUE(says(coded, "landmark 'c' lies "));
}

TEST(ScanFitter, SaysWhichLandmarksLieOffTheTemplate)
{
    const TestMesh mesh = pattern();
    const Points truth = widened(mesh.points);
    const ScanFitter fitter(mesh.topology, mesh.points);
    LandmarkPairs marks = marks_at({0, 100, 200, 300, 400, 500}, mesh.points, truth);
    const double diagonal = bounding_box_diagonal(mesh.points);
    const auto moved_out = [&](double by) {
        LandmarkPairs off = marks;
        off.on_template.row(2) += by * diagonal * off.on_template.row(2).normalized();
        return fitter.fit(scan_of(wide_scan()), off);
    };
    EXPECT_EQ(moved_out(0.003).status, FitStatus::Good); // placed by hand
    const ScanFit fit = moved_out(0.1);
    EXPECT_EQ(fit.status, FitStatus::Check);
    ASSERT_EQ(std::ranges::count_if(fit.reasons,
                                    [](const std::string& reason) {
                                        return reason.find("off the template") != std::string::npos;
                                    }),
              1);
    EXPECT_TRUE(says(fit, "landmark 'c' lies "));
    // A tolerance is one of the scan, which is as large here: three of them are within.
    const ScanFitter tolerant(mesh.topology, mesh.points, {.landmark_tolerance = 0.05 * diagonal});
    LandmarkPairs off = marks;
    off.on_template.row(2) += 0.1 * diagonal * off.on_template.row(2).normalized();
    EXPECT_FALSE(says(tolerant.fit(scan_of(wide_scan()), off), "off the template"));
}

TEST(ScanFitter, SaysThatLandmarksFitAMirrorImage)
{
    const TestMesh mesh = pattern();
    const Eigen::DiagonalMatrix<double, 3> mirror(-1.0, 1.0, 1.0);
    TestMesh scan = wide_scan();
    scan.points = scan.points * mirror;
    const LandmarkPairs marks =
        marks_at({0, 100, 200, 300, 400, 500}, mesh.points, widened(mesh.points) * mirror);
    EXPECT_TRUE(says(ScanFitter(mesh.topology, mesh.points).fit(scan_of(scan), marks),
                     "look like a mirror image"));
}

TEST(ScanFitter, TakesOneOrTwoLandmarksToo)
{
    const TestMesh mesh = pattern();
    const Points truth = widened(mesh.points);
    for (const std::vector<int>& vertices : {std::vector<int>{50}, std::vector<int>{50, 400}}) {
        const ScanFit fit = ScanFitter(mesh.topology, mesh.points)
                                .fit(scan_of(wide_scan()), marks_at(vertices, mesh.points, truth));
        EXPECT_EQ(fit.status, FitStatus::Good);
        EXPECT_LT(fit.landmark_errors.maxCoeff(), 1e-3 * fit.diagonal);
    }
}

TEST(ScanFitter, NeverCallsAnotherThingGood)
{
    const TestMesh mesh = pattern();
    const ScanFitter fitter(mesh.topology, mesh.points);
    for (const TestMesh& other : {torus(40, 60), open_patch(30, 2), open_cylinder(40, 40)}) {
        const ScanFit fit = fitter.fit(scan_of(other));
        EXPECT_NE(fit.status, FitStatus::Good) << other.name;
        EXPECT_FALSE(fit.reasons.empty());
    }
}

TEST(ScanFitter, CountsPairsOfFacesThatCrossBeyondThoseOfTheTemplate)
{
    const TestMesh mesh = pattern();
    EXPECT_EQ(ScanFitter(mesh.topology, mesh.points).fit(scan_of(wide_scan())).crossing_pairs, 0);
    const FoldedPatch folded = folded_patch();
    const ScanFitter fitter(folded.mesh.topology, folded.folded, {.search_start = false});
    const ScanFit fit = fitter.fit(clean_scan(folded.folded, folded.mesh.topology.faces()));
    EXPECT_LE(fit.crossing_pairs, 2); // its own do not count
}

TEST(ScanFitter, FitsAgainWhatItIsToldToExpect)
{
    const TestMesh mesh = pattern();
    const Points truth = widened(mesh.points);
    const ScanFitter fitter(mesh.topology, mesh.points);
    const Scan scan = scan_of(wide_scan());
    const ScanFit first = fitter.fit(scan);
    const ShapePoint rest = shape_of(mesh.topology, truth);
    const ScanFit again = fitter.fit_again(scan, {}, first, rest);
    // Who knows the true lengths goes towards the true vertices.
    EXPECT_LT(rms(again.points, truth), rms(first.points, truth));
    EXPECT_LT(again.strain_rms, first.strain_rms);
    // All the more if vertices may slide along the surface.
    const ScanFit slid = fitter.fit_again(scan, {}, first, rest, Sliding::Free);
    EXPECT_LT(rms(slid.points, truth), 0.7 * rms(again.points, truth));
    ScanFit other = first;
    other.points.conservativeResize(5, 3);
    EXPECT_THROW((void)fitter.fit_again(scan, {}, other, rest), InvalidInput);
    EXPECT_THROW((void)fitter.fit_again(scan, {}, first,
                                        {Eigen::VectorXd::Ones(3), Eigen::VectorXd::Zero(3)}),
                 InvalidInput);
}

TEST(ScanFitterSlow, TakesAMillionVertices)
{
    const TestMesh mesh = pattern();
    TestMesh scan = bumpy_sphere(8, 0.3, 5); // 655,362 vertices
    scan.points = widened(scan.points);
    const ScanFit fit = ScanFitter(mesh.topology, mesh.points).fit(scan_of(scan));
    EXPECT_EQ(fit.status, FitStatus::Good);
    EXPECT_LT(fit.scan_to_fit.mean, 0.002 * fit.diagonal);
}

/// A scan of the pattern, finer, of which a part has grown.
Scan grown_scan()
{
    TestMesh scan = bumpy_sphere(4, 0.3, 5);
    for (Eigen::Index v = 0; v < scan.points.rows(); ++v)
        if (scan.points(v, 0) > 0.0)
            scan.points(v, 0) *= 1.4;
    return scan_of(scan);
}

TEST(ScanFitter, HeldFirmlyTogetherGrowthIsMoreAlike)
{
    const TestMesh mesh = pattern();
    const auto spread = [&](double growth_smoothness) {
        const ScanFit fit =
            ScanFitter(mesh.topology, mesh.points,
                       {.growth_smoothness = growth_smoothness, .search_start = false})
                .fit(grown_scan());
        return fit.growth_high / fit.growth_low;
    };
    EXPECT_LT(spread(5000.0), 0.9 * spread(0.5));
}

TEST(ScanFitter, ASmoothFitKeepsTheBendsOfTheTemplate)
{
    const TestMesh mesh = pattern();
    const Eigen::VectorXd own = dihedral_angles(mesh.topology, mesh.points);
    const auto change = [&](double smoothness) {
        const ScanFit fit = ScanFitter(mesh.topology, mesh.points,
                                       {.smoothness = smoothness, .search_start = false})
                                .fit(grown_scan());
        return (dihedral_angles(mesh.topology, fit.points) - own).norm();
    };
    EXPECT_LT(change(100.0), 0.9 * change(0.01));
}

TEST(ScanFitter, StartsWhereTheTemplateLiesIfItIsToldTo)
{
    TestMesh mesh = pattern();
    mesh.points.col(1) *= 1.6;
    Points turned = mesh.points;
    turned.col(0) *= -1.0;
    turned.col(1) *= -1.0; // by half a turn about z
    const Scan scan = clean_scan(turned, mesh.topology.faces());
    const auto error = [&](bool search_start) {
        const ScanFit fit =
            ScanFitter(mesh.topology, mesh.points, {.search_start = search_start}).fit(scan);
        return rms(fit.points, turned) / fit.diagonal;
    };
    EXPECT_LT(error(true), 0.02);
    EXPECT_GT(error(false), 0.1);
}

TEST(ScanFitter, MeetsLandmarksAboutAsNearAsItIsToldTo)
{
    const TestMesh mesh = pattern();
    const std::vector<int> vertices{0, 100, 200, 300, 400};
    LandmarkPairs marks{{"a", "b", "c", "d", "e"},
                        mesh.points(vertices, Eigen::all),
                        mesh.points(vertices, Eigen::all)};
    // One was placed carelessly, along the surface.
    const Eigen::RowVector3d at = marks.on_scan.row(2);
    Eigen::Index near = 0;
    (void)((mesh.points.rowwise() - at).rowwise().norm().array() - 0.2).abs().minCoeff(&near);
    marks.on_scan.row(2) = mesh.points.row(near);
    const auto error = [&](double tolerance) {
        const ScanFit fit = ScanFitter(mesh.topology, mesh.points,
                                       {.landmark_tolerance = tolerance, .search_start = false})
                                .fit(clean_scan(mesh.points, mesh.topology.faces()), marks);
        return fit.landmark_errors[2] / fit.diagonal;
    };
    EXPECT_LT(error(0.0), 1.5e-3);
    EXPECT_GT(error(0.3), 1e-2);
}

TEST(ScanFitter, GivesTheSameBitsForAnyNumberOfThreads)
{
    const TestMesh mesh = pattern();
    const Scan scan = scan_of(wide_scan());
    const auto with = [&](int threads) {
        const ThreadScope scope(threads);
        return ScanFitter(mesh.topology, mesh.points).fit(scan).points;
    };
    EXPECT_EQ(with(1), with(3));
}

TEST(ScanFitter, RefusesLandmarksThatLeaveTheStartOpenAndOptionsOutOfRange)
{
    const TestMesh mesh = pattern();
    const ScanFitter fitter(mesh.topology, mesh.points);
    const Scan scan = scan_of(wide_scan());
    LandmarkPairs line{{"a", "b", "c"}, Points::Zero(3, 3), Points::Zero(3, 3)};
    line.on_template.col(0) << 0.5, 1.0, 2.0;
    line.on_scan = line.on_template;
    EXPECT_NE(message_of<InvalidInput>([&] { (void)fitter.fit(scan, line); }).find("on a line"),
              std::string::npos);
    LandmarkPairs coded{{"a", "b", "c", "d"}, {}, {}};
    coded.on_template = mesh.points(std::vector<int>{0, 5, 11, 3}, Eigen::all);
    coded.on_scan = coded.on_template;
    coded.on_scan.row(1).setConstant(-9999.0);
    coded.on_scan.row(3).setConstant(-9999.0);
    const std::string said = message_of<InvalidInput>([&] { (void)fitter.fit(scan, coded); });
    EXPECT_TRUE(said.starts_with("landmarks of the scan: 'b' lies ")) << said;
    EXPECT_NE(said.find(" diagonals away, 'd' lies "), std::string::npos) << said;
    EXPECT_NE(said.find("a code for a missing one?"), std::string::npos) << said;
    EXPECT_EQ(said.find("'a'"), std::string::npos) << said;
    // One code among landmarks that leave no turn open; and of the template.
    LandmarkPairs one = five_landmarks(mesh);
    one.on_scan.row(2).setConstant(-9999.0);
    EXPECT_TRUE(message_of<InvalidInput>([&] {
                    (void)fitter.fit(scan, one);
                }).starts_with("landmarks of the scan: 'c' lies "));
    one = five_landmarks(mesh);
    one.on_template.row(4).setConstant(-9999.0);
    EXPECT_TRUE(message_of<InvalidInput>([&] {
                    (void)fitter.fit(scan, one);
                }).starts_with("landmarks of the template: 'e' lies "));
    line.names.pop_back();
    EXPECT_THROW((void)fitter.fit(scan, line), InvalidInput);
    FitOptions options;
    options.boundaries = {"mouth"};
    const ScanFitter named(mesh.topology, mesh.points, options);
    EXPECT_NE(message_of<InvalidInput>([&] { (void)named.fit(scan); }).find("'mouth'"),
              std::string::npos);
    EXPECT_THROW(ScanFitter(mesh.topology, mesh.points, {.smoothness = 0.0}), InvalidInput);
    EXPECT_THROW(ScanFitter(mesh.topology, mesh.points, {.growth_smoothness = 0.0}), InvalidInput);
    EXPECT_THROW(ScanFitter(mesh.topology, mesh.points, {.landmark_tolerance = -1.0}),
                 InvalidInput);
}

TEST(ScanFitter, RefusesToNameABoundaryOfWhatHasNone)
{
    const TestMesh closed = icosphere(2), open = open_cylinder(24, 16);
    const LandmarkPairs mark{{"rim"}, open.points.topRows(1), open.points.topRows(1)};
    const auto refusal = [&](const TestMesh& pattern, const TestMesh& scan) {
        const ScanFitter fitter(pattern.topology, pattern.points,
                                {.search_start = false, .boundaries = {"rim"}});
        return message_of<InvalidInput>([&] { (void)fitter.fit(scan_of(scan), mark); });
    };
    EXPECT_EQ(refusal(closed, open), "boundary 'rim': the template has no boundary");
    EXPECT_EQ(refusal(closed, closed), "boundary 'rim': the template has no boundary");
    EXPECT_EQ(refusal(open, closed), "boundary 'rim': the scan has no boundary");
}

TEST(ScanFitter, PairsLoopsByNameThatLieTooFarApartForTheRule)
{
    const TestMesh mesh = open_cylinder(24, 16); // of radius 1, from z = 0 to 4
    TestMesh longer = open_cylinder(40, 40);     // to z = 5, farther than a tenth of 2 pi
    longer.points.col(2) *= 1.25;
    // A landmark nearer the upper loops, which holds its place.
    const Points at = mesh.points.row(12 * 24);
    const auto missing = [&](const std::vector<std::string>& boundaries) {
        const ScanFit fit = ScanFitter(mesh.topology, mesh.points,
                                       {.search_start = false, .boundaries = boundaries})
                                .fit(scan_of(longer), {{"rim"}, at, at});
        return 5.0 - fit.points.col(2).bottomRows(24).mean(); // of the upper loop
    };
    EXPECT_GT(missing({}), 0.9);
    EXPECT_LT(missing({"rim"}), 0.3);
}

} // namespace
} // namespace shape::test
