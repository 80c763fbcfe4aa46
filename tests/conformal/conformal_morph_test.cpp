// SPDX-License-Identifier: MIT

#include "libshape/conformal/conformal_morph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/conformal/closed_meshes.h"

namespace shape {
namespace {

ConformalMorph morph_of(const test::TestMesh& mesh)
{
    return make_conformal_morph(
        mesh.topology, mesh.points,
        map_to_sphere(mesh.topology, edge_lengths(mesh.topology, mesh.points)));
}

TEST(ConformalMorph, StartsAtTheMeshAndEndsAtTheSphere)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.4, 2);
    const Eigen::VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
    const SphereMap map = map_to_sphere(mesh.topology, lengths);
    const ConformalMorph morph = make_conformal_morph(mesh.topology, mesh.points, map);
    const MorphFrame start = morph_frame(morph, 0.0);
    EXPECT_NEAR((start.point.edge_lengths - lengths).lpNorm<Eigen::Infinity>(), 0.0, 1e-14);
    EXPECT_NEAR((start.point.dihedral_angles - dihedral_angles(mesh.topology, mesh.points))
                    .lpNorm<Eigen::Infinity>(),
                0.0, 1e-15);
    const Points sphere = map.radius * map.sphere.points;
    const MorphFrame end = morph_frame(morph, 1.0);
    EXPECT_NEAR(
        (end.point.edge_lengths - edge_lengths(mesh.topology, sphere)).lpNorm<Eigen::Infinity>(),
        0.0, 1e-12);
    EXPECT_NEAR((end.point.dihedral_angles - dihedral_angles(mesh.topology, sphere))
                    .lpNorm<Eigen::Infinity>(),
                0.0, 1e-10);
}

TEST(ConformalMorph, FollowsEquation13)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.4, 2);
    const Eigen::VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
    const SphereMap map = map_to_sphere(mesh.topology, lengths);
    const ConformalMorph morph = make_conformal_morph(mesh.topology, mesh.points, map);
    for (const double k : {0.25, 0.5, 0.75}) {
        const MorphFrame frame = morph_frame(morph, k);
        EXPECT_TRUE(frame.corrected_faces.empty());
        EXPECT_EQ(frame.largest_correction, 0.0);
        for (int e = 0; e < lengths.size(); ++e) {
            const double u =
                map.factors[mesh.topology.edges()(e, 0)] + map.factors[mesh.topology.edges()(e, 1)];
            EXPECT_NEAR(frame.point.edge_lengths[e] / (std::exp(0.5 * k * u) * lengths[e]), 1.0,
                        1e-13);
        }
    }
}

TEST(ConformalMorph, CorrectsBrokenFacesAsLittleAsItCan)
{
    const test::TestMesh mesh = test::stretched(test::random_inscribed(500, 5), {1, 1, 10});
    const ConformalMorph morph = morph_of(mesh);
    int corrected = 0;
    for (int i = 0; i <= 20; ++i) {
        const double k = i / 20.0;
        const MorphFrame frame = morph_frame(morph, k);
        const Eigen::VectorXd wanted = (morph.log_lengths + k * morph.log_ratios).array().exp();
        EXPECT_TRUE(check_admissibility(mesh.topology, frame.point.edge_lengths).triangles.empty());
        corrected += static_cast<int>(frame.corrected_faces.size());
        EXPECT_EQ(frame.largest_correction == 0.0, frame.corrected_faces.empty());
        for (const TriangleViolation& violation :
             check_admissibility(mesh.topology, wanted).triangles)
            EXPECT_TRUE(std::binary_search(frame.corrected_faces.begin(),
                                           frame.corrected_faces.end(), violation.face));
        // Minimal: going any part of the way back to the wanted lengths breaks a face again.
        if (frame.corrected_faces.empty())
            continue;
        const Eigen::VectorXd nearer =
            frame.point.edge_lengths + 1e-3 * (wanted - frame.point.edge_lengths);
        double worst = -1.0;
        for (int f = 0; f < mesh.topology.face_count(); ++f)
            for (int c = 0; c < 3; ++c) {
                const auto l = [&](int j) { return nearer[mesh.topology.face_edges()(f, j % 3)]; };
                worst = std::max(worst, l(c) - (1.0 - 1e-6) * (l(c + 1) + l(c + 2)));
            }
        EXPECT_GT(worst, 0.0);
    }
    EXPECT_GT(corrected, 0);
}

TEST(ConformalMorph, CorrectsToTheNearestLengths)
{
    // The inequalities are those of a convex cone C in x = l / l*. Its point nearest to 1, and no other,
    // has (1 - x) . x = 0 and (1 - x) . z <= 0 for all z in C; any mesh gives such a z.
    const test::TestMesh mesh = test::stretched(test::random_inscribed(500, 5), {1, 1, 10});
    const ConformalMorph morph = morph_of(mesh);
    int corrected = 0;
    for (int i = 1; i < 10; ++i) {
        const double k = i / 10.0;
        const MorphFrame frame = morph_frame(morph, k);
        if (frame.corrected_faces.empty())
            continue;
        ++corrected;
        const Eigen::VectorXd wanted = (morph.log_lengths + k * morph.log_ratios).array().exp();
        const Eigen::VectorXd x = frame.point.edge_lengths.cwiseQuotient(wanted);
        const Eigen::VectorXd missed = Eigen::VectorXd::Ones(x.size()) - x;
        ASSERT_GT(missed.norm(), 1e-6);
        EXPECT_LE(std::abs(missed.dot(x)), 1e-6 * missed.norm()) << k;
        internal::Random random(1);
        for (int sample = 0; sample < 20; ++sample) {
            const Points other =
                Points::NullaryExpr(mesh.points.rows(), 3, [&] { return random.normal(); });
            const Eigen::VectorXd z =
                edge_lengths(mesh.topology, other).cwiseQuotient(wanted).normalized();
            EXPECT_LE(missed.dot(z), 1e-6 * missed.norm()) << k;
        }
    }
    EXPECT_GT(corrected, 0);
}

TEST(ConformalMorph, IsContinuousInItsParameter)
{
    const test::TestMesh mesh = test::stretched(test::random_inscribed(500, 5), {1, 1, 10});
    const ConformalMorph morph = morph_of(mesh);
    const int frames = 2000;
    Eigen::VectorXd before = morph_frame(morph, 0.0).point.edge_lengths.array().log();
    double largest = 0.0;
    for (int i = 1; i <= frames; ++i) {
        const Eigen::VectorXd next =
            morph_frame(morph, static_cast<double>(i) / frames).point.edge_lengths.array().log();
        largest = std::max(largest, (next - before).lpNorm<Eigen::Infinity>());
        before = next;
    }
    // No step is much longer than the steps of the factors alone.
    const double unmended = morph.log_ratios.lpNorm<Eigen::Infinity>() / frames;
    EXPECT_LE(largest, 3.0 * unmended);
}

TEST(ConformalMorph, HasAPaceThatIsUndone)
{
    EXPECT_EQ(morph_parameter(0.0), 0.0);
    EXPECT_EQ(morph_parameter(1.0), 1.0);
    for (const double k : {0.0, 0.1, 0.5, 0.9, 1.0})
        EXPECT_NEAR(morph_parameter(inverse_morph_parameter(k)), k, 1e-15);
}

TEST(ConformalMorph, RefusesWhatDoesNotFit)
{
    const test::TestMesh mesh = test::icosphere(1);
    SphereMap map = map_to_sphere(mesh.topology, edge_lengths(mesh.topology, mesh.points));
    const ConformalMorph morph = make_conformal_morph(mesh.topology, mesh.points, map);
    EXPECT_THROW((void)morph_frame(morph, -0.1), InvalidInput);
    EXPECT_THROW((void)morph_frame(morph, 1.1), InvalidInput);
    EXPECT_THROW((void)morph_frame(morph, std::nan("")), InvalidInput);
    EXPECT_THROW((void)make_conformal_morph(mesh.topology, Points(3, 3), map), InvalidInput);
    const test::TestMesh other = test::icosphere(2);
    EXPECT_THROW((void)make_conformal_morph(other.topology, other.points, map), InvalidInput);
    map.certificate = ConformalCertificate::Unsolved;
    EXPECT_THROW((void)make_conformal_morph(mesh.topology, mesh.points, map), InvalidInput);
}

} // namespace
} // namespace shape
