// SPDX-License-Identifier: MIT

#include "libshape/registration/prior_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/registration/synthetic_scan.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace shape::test {
namespace {

/// A head that differs from the first by two numbers.
Points person(const Points& points, double wide, double tall)
{
    Points shape = points;
    shape.col(0) *= 1.0 + wide;
    shape.col(1) *= 1.4 + tall;
    for (Eigen::Index v = 0; v < shape.rows(); ++v)
        if (shape(v, 2) > 0.0)
            shape(v, 2) *= 1.0 + 0.5 * wide;
    return shape;
}

struct Group
{
    TestMesh mesh = bumpy_sphere(3, 0.3, 5);
    Points pattern = person(mesh.points, 0.0, 0.0);
    std::vector<Points> truth;
    std::vector<Scan> scans;

    Group()
    {
        for (int i = 0; i < 6; ++i) {
            truth.push_back(person(mesh.points, 0.06 * (i - 2.5), 0.08 * ((i * 5) % 6 - 2.5)));
            scans.push_back(
                synthetic_scan(mesh.topology, truth.back(),
                               {.vertices = 700, .seed = static_cast<std::uint64_t>(i)}));
        }
    }
    [[nodiscard]] double edge_error(const Points& points, std::size_t i) const
    {
        const Eigen::VectorXd lengths = edge_lengths(mesh.topology, truth[i]);
        return (edge_lengths(mesh.topology, points) - lengths).norm() / lengths.norm();
    }
};

const Group& group()
{
    static const Group made;
    return made;
}

std::vector<ScanFit> first_fits(const ScanFitter& fitter)
{
    std::vector<ScanFit> fits;
    for (const Scan& scan : group().scans)
        fits.push_back(fitter.fit(scan));
    return fits;
}

TEST(PriorFit, AGroupsFitsAgreeBetterAfterARoundAndStayOnTheirScans)
{
    const Group& g = group();
    const ScanFitter fitter(g.mesh.topology, g.pattern);
    std::vector<ScanFit> fits = first_fits(fitter);
    const auto source = [&](std::size_t i) { return std::pair(g.scans[i], LandmarkPairs{}); };
    const GroupRound first = fit_group_again(fitter, g.mesh.topology, source, fits);
    const GroupRound second = fit_group_again(fitter, g.mesh.topology, source, fits);
    EXPECT_EQ(first.fits, 6);
    EXPECT_LT(second.unexpected, first.unexpected);
    EXPECT_LT(second.change, first.change);
    for (std::size_t i = 0; i < fits.size(); ++i) {
        EXPECT_LT(fits[i].scan_to_fit.mean, 0.003 * fits[i].diagonal);
        EXPECT_NE(fits[i].status, FitStatus::Failed);
    }
}

TEST(PriorFit, DoesNotDependOnTheOrderOfTheScansButForRounding)
{
    const Group& g = group();
    const ScanFitter fitter(g.mesh.topology, g.pattern);
    std::vector<ScanFit> fits = first_fits(fitter);
    std::vector<ScanFit> turned(fits.rbegin(), fits.rend());
    const auto source = [&](std::size_t i) { return std::pair(g.scans[i], LandmarkPairs{}); };
    const auto from_behind = [&](std::size_t i) { return source(g.scans.size() - 1 - i); };
    (void)fit_group_again(fitter, g.mesh.topology, source, fits);
    (void)fit_group_again(fitter, g.mesh.topology, from_behind, turned);
    for (std::size_t i = 0; i < fits.size(); ++i)
        EXPECT_LT((fits[i].points - turned[fits.size() - 1 - i].points).cwiseAbs().maxCoeff(),
                  1e-3 * fits[i].diagonal);
}

TEST(PriorFit, LeavesFailedFitsOutAndNeedsFour)
{
    const Group& g = group();
    const ScanFitter fitter(g.mesh.topology, g.pattern);
    std::vector<ScanFit> fits(6);
    for (std::size_t i = 0; i < 6; ++i) {
        fits[i].points = g.truth[i];
        fits[i].seen.assign(static_cast<std::size_t>(g.truth[i].rows()), 1);
    }
    fits[5].status = FitStatus::Failed;
    const auto source = [&](std::size_t i) { return std::pair(g.scans[i], LandmarkPairs{}); };
    EXPECT_EQ(fit_group_again(fitter, g.mesh.topology, source, fits).fits, 5);
    EXPECT_EQ(fits[5].points, g.truth[5]);
    for (ScanFit& fit : fits)
        fit.points = g.truth[0];
    EXPECT_EQ(message_of<InvalidInput>(
                  [&] { (void)fit_group_again(fitter, g.mesh.topology, source, fits); }),
              "a group's fits are all equal");
    fits[3].status = fits[4].status = FitStatus::Failed;
    EXPECT_THROW((void)fit_group_again(fitter, g.mesh.topology, source, fits), InvalidInput);
}

TEST(PriorFit, RefusesAPriorOfAnotherTriangulation)
{
    const Group& g = group();
    const TestMesh other = icosphere(1);
    Collection known{other.topology, {}, {}, {}};
    known.points = {person(other.points, 0.0, 0.0), person(other.points, 0.1, 0.0)};
    const ShapePrior prior = prior_of(shape_vectors(known, Scale::Unit), -1, 1e-9);
    const ScanFitter fitter(g.mesh.topology, g.pattern);
    EXPECT_THROW((void)fit_by_prior(fitter, g.mesh.topology, prior, g.scans[0]), InvalidInput);
}

TEST(PriorFit, ShowsWhatAScanHidesAsTheModelExpectsIt)
{
    const Group& g = group();
    // Five shapes are known; of the sixth the half z > 0 is seen.
    Collection known{g.mesh.topology, {}, {}, {}};
    for (std::size_t i = 0; i < 5; ++i)
        known.points.push_back(g.truth[i]);
    const ShapePrior prior = prior_of(shape_vectors(known, Scale::Unit), -1, 1e-9);
    std::vector<int> kept;
    const Scan& whole = g.scans[5];
    for (int f = 0; f < whole.faces.rows(); ++f)
        if (whole.points(whole.faces(f, 0), 2) > 0.0)
            kept.push_back(f);
    const Scan half = clean_scan(whole.points, whole.faces(kept, Eigen::all));
    FitOptions options;
    options.search_start = false;
    const ScanFitter fitter(g.mesh.topology, g.pattern, options);
    const ScanFit alone = fitter.fit(half);
    const PriorFit held = fit_by_prior(fitter, g.mesh.topology, prior, half);
    EXPECT_LT(g.edge_error(held.fit.points, 5), 0.95 * g.edge_error(alone.points, 5));
    EXPECT_LT(held.fit.scan_to_fit.mean, 0.003 * held.fit.diagonal);
}

} // namespace
} // namespace shape::test
