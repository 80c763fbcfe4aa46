// SPDX-License-Identifier: MIT

#include "libshape/conformal/sphere_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/conformal/closed_meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using std::numbers::pi;

SphereMap map_mesh(const test::TestMesh& mesh, int infinite_vertex = -1)
{
    return map_to_sphere(mesh.topology, edge_lengths(mesh.topology, mesh.points),
                         {.infinite_vertex = infinite_vertex});
}

/// What an exact map promises.
void expect_exact(const SphereMap& map)
{
    EXPECT_EQ(map.certificate, ConformalCertificate::Exact);
    EXPECT_TRUE(map.edges.flipped.empty());
    EXPECT_TRUE(map.reversed_faces.empty());
    EXPECT_LE(map.edges.worst, 1e-10);
    EXPECT_LE(map.angle_residual, 1e-12);
    EXPECT_LE(map.balance_residual, 1e-12);
    EXPECT_LE(map.newton_steps, 25);
    EXPECT_EQ(map.repair_rounds, 0);
}

/// Chords on the sphere of two maps are equal: the maps differ by a rotation.
double largest_chord_difference(const Topology& topology, const SphereMap& a, const SphereMap& b)
{
    double largest = 0.0;
    for (int v = 0; v < topology.vertex_count(); ++v)
        for (int w = 0; w < v; w += 7)
            largest = std::max(largest, std::abs(a.sphere.difference(v, w).norm() -
                                                 b.sphere.difference(v, w).norm()));
    return largest;
}

TEST(SphereMap, OfPlatonicSolidsIsTheirCircumscribedSphere)
{
    for (const test::TestMesh& mesh : {test::tetrahedron(), test::icosphere(0)}) {
        const SphereMap map = map_mesh(mesh);
        expect_exact(map);
        // All edges a have one length, all chords b too: 4 / sqrt(6) and 4 / sqrt(10 + 2 sqrt 5).
        const double chord = mesh.topology.vertex_count() == 4
                                 ? 4.0 / std::sqrt(6.0)
                                 : 4.0 / std::sqrt(10.0 + 2.0 * std::sqrt(5.0));
        const double a = edge_lengths(mesh.topology, mesh.points)[0];
        const double area = std::sqrt(3.0) / 4.0 * a * a * mesh.topology.face_count();
        EXPECT_NEAR(map.radius, std::sqrt(area / (4.0 * pi)), 1e-14);
        for (const double u : map.factors)
            EXPECT_NEAR(u, std::log(map.radius * chord / a), 1e-13);
    }
}

TEST(SphereMap, RecoversInscribedPolyhedraFromScrambledLengths)
{
    for (unsigned seed = 1; seed <= 5; ++seed) {
        const test::TestMesh mesh = test::random_inscribed(300, seed);
        const Eigen::VectorXd chords = edge_lengths(mesh.topology, mesh.points);
        Random random(seed);
        Eigen::VectorXd w(mesh.points.rows());
        for (double& value : w)
            value = random.uniform(-1.0, 1.0);
        Eigen::VectorXd lengths = chords;
        for (int e = 0; e < lengths.size(); ++e)
            lengths[e] *=
                std::exp(-0.5 * (w[mesh.topology.edges()(e, 0)] + w[mesh.topology.edges()(e, 1)]));
        const SphereMap map = map_to_sphere(mesh.topology, lengths);
        expect_exact(map);
        // Up to Möbius transformations: the length cross ratio of every edge is that of the points.
        const Topology& t = mesh.topology;
        const auto cross_ratio = [&](int e, const auto& distance) {
            const int h = t.edge_halfedges()(e, 0);
            const int a = t.source(h);
            const int b = t.target(h);
            const int c = t.source(Topology::previous(h));
            const int d = t.source(Topology::previous(t.opposite(h)));
            return std::log(distance(a, c) * distance(b, d) / (distance(c, b) * distance(d, a)));
        };
        for (int e = 0; e < t.edge_count(); ++e)
            EXPECT_NEAR(
                cross_ratio(e, [&](int a, int b) { return map.sphere.difference(a, b).norm(); }),
                cross_ratio(
                    e,
                    [&](int a, int b) { return (mesh.points.row(a) - mesh.points.row(b)).norm(); }),
                1e-10);
        // And the factors are w plus those of one Möbius transformation: b^2 of two points is
        // proportional to the product of its factors, at every pair.
        for (int v = 1; v < t.vertex_count(); ++v) {
            const int o = v == 1 ? 2 : 1;
            const auto factor = [&](int i) { return map.factors[i] - w[i]; };
            const auto stretch = [&](int i, int j) {
                return 2.0 * std::log(map.radius * map.sphere.difference(i, j).norm() /
                                      (mesh.points.row(i) - mesh.points.row(j)).norm());
            };
            EXPECT_NEAR(factor(0) + factor(v), stretch(0, v), 1e-10);
            EXPECT_NEAR(factor(o) + factor(v), stretch(o, v), 1e-10);
        }
    }
}

TEST(SphereMap, DoesNotDependOnTheInfiniteVertex)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 1);
    const SphereMap first = map_mesh(mesh);
    expect_exact(first);
    for (int i = 0; i < 10; ++i) {
        const SphereMap other = map_mesh(mesh, 61 * i);
        expect_exact(other);
        EXPECT_EQ(other.infinite_vertex, 61 * i);
        EXPECT_NEAR((other.factors - first.factors).lpNorm<Eigen::Infinity>(), 0.0, 1e-10);
        EXPECT_LE(largest_chord_difference(mesh.topology, other, first), 1e-10);
    }
}

TEST(SphereMap, PutsTheInfiniteVertexAtThePole)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.5, 3);
    const SphereMap map = map_mesh(mesh, 17);
    EXPECT_EQ((map.sphere.points.row(17) - Eigen::RowVector3d(0, 0, -1)).norm(), 0.0);
    for (int v = 0; v < mesh.topology.vertex_count(); ++v)
        EXPECT_NEAR(map.sphere.points.row(v).norm(), 1.0, 1e-15);
}

TEST(SphereMap, ScalesWithTheUnitOfLengthAndKnowsNoMirror)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.5, 3);
    const Eigen::VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
    const SphereMap map = map_to_sphere(mesh.topology, lengths);
    const SphereMap scaled = map_to_sphere(mesh.topology, 1e6 * lengths);
    EXPECT_NEAR(scaled.radius / map.radius, 1e6, 1e-6);
    EXPECT_NEAR((scaled.factors - map.factors).lpNorm<Eigen::Infinity>(), 0.0, 1e-11);
}

TEST(SphereMap, KeepsEdgesThatAreTooShortForDoubles)
{
    // Factors of a limb fall exponentially with its length.
    const test::TestMesh mesh = test::stretched(test::globe(24, 200), {0.05, 0.05, 1.0});
    const SphereMap map = map_mesh(mesh);
    double shortest = 2.0;
    for (int e = 0; e < mesh.topology.edge_count(); ++e)
        shortest = std::min(
            shortest,
            map.sphere.difference(mesh.topology.edges()(e, 0), mesh.topology.edges()(e, 1)).norm());
    EXPECT_LT(shortest, 1e-14);
    EXPECT_NE(map.certificate, ConformalCertificate::Unsolved);
    EXPECT_LE(map.edges.worst, 1e-10);
}

TEST(SphereMap, RepairsSliversWithFewFlips)
{
    const test::TestMesh mesh = test::with_slivers(test::bumpy_sphere(3, 0.5, 3), 0.02, 1.0, 7);
    const SphereMap map = map_mesh(mesh);
    EXPECT_EQ(map.certificate, ConformalCertificate::Repaired);
    EXPECT_GT(map.edges.flipped.size(), 0u);
    const int sliver_count = mesh.topology.vertex_count() - 642;
    EXPECT_LT(static_cast<int>(map.edges.flipped.size()), sliver_count);
    EXPECT_LE(map.edges.worst, 1e-10);
    EXPECT_LE(map.angle_residual, 1e-11);
    EXPECT_LE(map.balance_residual, 1e-12);
    // The flipped edges are those on which the equation fails.
    double worst = 0.0;
    for (const int e : map.edges.flipped)
        worst = std::max(worst, std::abs(map.edges.residuals[e]));
    EXPECT_GT(worst, 1e-6);
}

TEST(SphereMap, SolvesWhereTheTriangulationIsFarFromDelaunay)
{
    const test::TestMesh mesh = test::stretched(test::random_inscribed(500, 5), {1.0, 3.0, 0.1});
    const SphereMap map = map_mesh(mesh);
    EXPECT_TRUE(map.certificate == ConformalCertificate::Repaired ||
                map.certificate == ConformalCertificate::Refined);
    EXPECT_LE(map.edges.worst, 1e-10);
    EXPECT_LE(map.balance_residual, 1e-12);
}

TEST(SphereMap, RefinedIsTheOneIdealPolyhedronWhateverTheInfiniteVertex)
{
    // Rivin's theorem: with all edges free to flip there is one solution. Locally repaired maps do
    // depend on the infinite vertex, near the flips.
    for (const test::TestMesh& mesh :
         {test::stretched(test::random_inscribed(300, 5), {1, 1, 10}),
          test::with_slivers(test::bumpy_sphere(2, 0.5, 3), 0.2, 0.1, 7), test::globe(12, 60)}) {
        SCOPED_TRACE(mesh.name);
        const Eigen::VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
        Eigen::VectorXd first;
        int compared = 0;
        for (int i = 0; i < 6; ++i) {
            const SphereMap map =
                map_to_sphere(mesh.topology, lengths,
                              {.infinite_vertex = i * mesh.topology.vertex_count() / 6,
                               .repair = {.local_rounds = 0}});
            if (map.certificate != ConformalCertificate::Refined)
                continue; // solved on the mesh's own edges, seen from there
            if (first.size() == 0)
                first = map.factors;
            EXPECT_NEAR((map.factors - first).lpNorm<Eigen::Infinity>(), 0.0, 1e-8);
            ++compared;
        }
        EXPECT_GE(compared, 5);
    }
}

TEST(SphereMap, SaysThatFacesAreReversedThoughEquation13Holds)
{
    const SphereMap map = map_mesh(test::jittered(test::bumpy_sphere(2, 0.5, 28), 0.2, 28));
    EXPECT_EQ(map.certificate, ConformalCertificate::Folded);
    EXPECT_TRUE(map.edges.flipped.empty());
    EXPECT_GT(map.reversed_faces.size(), 0u);
    EXPECT_LE(map.edges.worst, 1e-10);
}

TEST(SphereMap, TakesLengthsThatBreakTriangleInequalities)
{
    const test::TestMesh mesh = test::icosphere(2);
    Eigen::VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
    lengths[10] *= 2.5;
    const SphereMap map = map_to_sphere(mesh.topology, lengths);
    EXPECT_NE(map.certificate, ConformalCertificate::Unsolved);
    EXPECT_LE(map.edges.worst, 1e-10);
}

TEST(SphereMap, HasTheSameBitsForAnyNumberOfThreads)
{
    const test::TestMesh mesh = test::bumpy_sphere(4, 0.6, 2);
    const auto run = [&](int threads) {
        const test::ThreadScope scope(threads);
        return map_mesh(mesh);
    };
    const SphereMap one = run(1);
    const SphereMap three = run(3);
    EXPECT_EQ(one.factors, three.factors);
    EXPECT_EQ(one.sphere.points, three.sphere.points);
    EXPECT_EQ(one.sphere.remainders, three.sphere.remainders);
}

TEST(SphereMap, RefusesWhatIsNotASphereAndSaysWhatToDo)
{
    const auto message = [](const test::TestMesh& mesh) -> std::string {
        try {
            (void)map_mesh(mesh);
        } catch (const InvalidInput& error) {
            EXPECT_EQ(error.what(), why_not_spherical(mesh.topology));
            return error.what();
        }
        return "taken";
    };
    EXPECT_NE(message(test::open_patch(5, 1)).find("close the holes"), std::string::npos);
    EXPECT_NE(message(test::open_cylinder(6, 4)).find("2 boundary loops"), std::string::npos);
    EXPECT_NE(message(test::torus(9, 16)).find("genus 1"), std::string::npos);
    EXPECT_EQ(why_not_spherical(test::icosphere(1).topology), "");
    const test::TestMesh mesh = test::icosphere(1);
    EXPECT_THROW((void)map_mesh(mesh, 42), InvalidInput);
    EXPECT_THROW((void)map_mesh(mesh, -2), InvalidInput);
    EXPECT_THROW((void)map_to_sphere(mesh.topology, Eigen::VectorXd::Ones(3)), InvalidInput);
    EXPECT_THROW((void)map_to_sphere(mesh.topology, Eigen::VectorXd::Zero(120)), InvalidInput);
}

} // namespace
} // namespace shape
