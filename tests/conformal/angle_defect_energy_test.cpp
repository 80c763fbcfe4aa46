// SPDX-License-Identifier: MIT

#include "libshape/conformal/angle_defect_energy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/conformal/closed_meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using std::numbers::pi;

IntrinsicTriangulation triangulate(const test::TestMesh& mesh)
{
    return {mesh.topology, edge_lengths(mesh.topology, mesh.points)};
}

Eigen::VectorXd random_factors(int count, double size, unsigned seed)
{
    Random random(seed);
    Eigen::VectorXd u(count);
    for (double& value : u)
        value = size * random.normal();
    return u;
}

TEST(Lobachevsky, HasItsKnownValues)
{
    // L(pi/3) is a third of the volume of the regular ideal tetrahedron, L(pi/4) half of Catalan's
    // constant.
    EXPECT_NEAR(3.0 * lobachevsky(pi / 3.0), 1.0149416064096536250, 1e-15);
    EXPECT_NEAR(2.0 * lobachevsky(pi / 4.0), 0.91596559417721901505, 1e-15);
    EXPECT_EQ(lobachevsky(0.0), 0.0);
    EXPECT_NEAR(lobachevsky(pi / 2.0), 0.0, 1e-16);
}

TEST(Lobachevsky, IsOddHasPeriodPiAndDuplicates)
{
    Random random(1);
    for (int i = 0; i < 1000; ++i) {
        const double x = random.uniform(-4.0, 4.0);
        EXPECT_NEAR(lobachevsky(-x), -lobachevsky(x), 1e-15);
        EXPECT_NEAR(lobachevsky(x + pi), lobachevsky(x), 1e-14);
        EXPECT_NEAR(lobachevsky(2.0 * x), 2.0 * lobachevsky(x) + 2.0 * lobachevsky(x + pi / 2.0),
                    1e-14);
    }
}

TEST(TriangleAngles, AgreeWithTheLawOfCosines)
{
    Random random(2);
    for (int i = 0; i < 1000; ++i) {
        const double a = random.uniform(0.5, 1.0);
        const double b = random.uniform(0.5, 1.0);
        const double c = random.uniform(std::abs(a - b) + 1e-3, a + b - 1e-3);
        const TriangleAngles t = triangle_angles({std::log(a), std::log(b), std::log(c)});
        EXPECT_FALSE(t.broken);
        EXPECT_NEAR(t.angles[0] + t.angles[1] + t.angles[2], pi, 1e-14);
        EXPECT_NEAR(std::cos(t.angles[2]), (a * a + b * b - c * c) / (2.0 * a * b), 1e-13);
        EXPECT_NEAR(t.weights[2] * 2.0 * std::tan(t.angles[2]), 1.0, 1e-9);
    }
}

TEST(TriangleAngles, OfABrokenTriangleAreFlat)
{
    const TriangleAngles t = triangle_angles({0.0, std::log(2.5), 0.0});
    EXPECT_TRUE(t.broken);
    EXPECT_EQ(t.angles, (std::array<double, 3>{0.0, pi, 0.0}));
    EXPECT_EQ(t.weights, (std::array<double, 3>{0.0, 0.0, 0.0}));
    // Equality counts as broken: there is no area.
    EXPECT_TRUE(triangle_angles({std::log(2.0), 0.0, 0.0}).broken);
}

TEST(AngleDefectEnergy, HasTheAngleDefectsAsGradientOnBrokenTrianglesToo)
{
    const test::TestMesh mesh = test::bumpy_sphere(1, 0.4, 4);
    const IntrinsicTriangulation t = triangulate(mesh);
    bool any_broken = false;
    for (const double size : {0.1, 0.5, 2.0}) {
        const Eigen::VectorXd u = random_factors(t.vertex_count(), size, 8);
        for (const int removed : {-1, 3}) {
            const AngleDefects at = measure_angle_defects(t, u, removed);
            any_broken |= !at.broken_faces.empty();
            for (int v = 0; v < t.vertex_count(); ++v) {
                if (v == removed) {
                    EXPECT_EQ(at.defects[v], 0.0);
                    continue;
                }
                // Fourth-order differences; the energy is only once differentiable where a
                // triangle is about to break.
                const auto energy = [&](double step) {
                    Eigen::VectorXd moved = u;
                    moved[v] += step;
                    return angle_defect_energy(t, moved, removed);
                };
                const double h = 1e-4;
                const double slope =
                    (8.0 * (energy(h) - energy(-h)) - (energy(2.0 * h) - energy(-2.0 * h))) /
                    (12.0 * h);
                EXPECT_NEAR(slope, at.defects[v], size < 0.3 ? 1e-8 : 2e-3) << "vertex " << v;
            }
        }
    }
    EXPECT_TRUE(any_broken);
}

TEST(AngleDefectEnergy, IsConvex)
{
    const IntrinsicTriangulation t = triangulate(test::bumpy_sphere(1, 0.4, 4));
    for (unsigned seed = 0; seed < 200; ++seed) {
        const Eigen::VectorXd u = random_factors(t.vertex_count(), 1.0, 2 * seed);
        const Eigen::VectorXd w = random_factors(t.vertex_count(), 1.0, 2 * seed + 1);
        const double middle = angle_defect_energy(t, 0.5 * (u + w));
        const double mean = 0.5 * (angle_defect_energy(t, u) + angle_defect_energy(t, w));
        EXPECT_LT(middle, mean);
    }
}

TEST(AngleDefectEnergy, HasTheCotangentLaplacianAsHessian)
{
    const IntrinsicTriangulation t = triangulate(test::bumpy_sphere(1, 0.4, 4));
    const Eigen::VectorXd u = random_factors(t.vertex_count(), 0.1, 3);
    const AngleDefects at = measure_angle_defects(t, u);
    ASSERT_TRUE(at.broken_faces.empty());
    const Eigen::VectorXd direction = random_factors(t.vertex_count(), 1.0, 4);
    Eigen::VectorXd expected = Eigen::VectorXd::Zero(t.vertex_count());
    for (int e = 0; e < t.edge_count(); ++e) {
        const int a = t.source(t.halfedge(e));
        const int b = t.target(t.halfedge(e));
        const double flow = at.edge_weights[e] * (direction[a] - direction[b]);
        expected[a] += flow;
        expected[b] -= flow;
    }
    const double h = 1e-5;
    const Eigen::VectorXd measured = (measure_angle_defects(t, u + h * direction).defects -
                                      measure_angle_defects(t, u - h * direction).defects) /
                                     (2.0 * h);
    EXPECT_NEAR((measured - expected).lpNorm<Eigen::Infinity>(), 0.0, 1e-7);
}

TEST(AngleDefectEnergy, IsContinuousAcrossAFlip)
{
    // Scale until an edge is exactly at the Delaunay limit, where its four vertices are concyclic:
    // the energy and its gradient are those of the flipped triangulation.
    const IntrinsicTriangulation t = triangulate(test::jittered(test::icosphere(1), 0.2, 6));
    int checked = 0;
    for (int e = 0; e < t.edge_count(); ++e) {
        const int h = t.halfedge(e);
        Eigen::VectorXd u = Eigen::VectorXd::Zero(t.vertex_count());
        const auto opposite_angles = [&](double raised) {
            u[t.source(h)] = raised;
            u[t.target(h)] = raised;
            double sum = 0.0;
            for (const int side : {h, t.opposite(h)})
                sum += triangle_angles(scaled_sides(t, u, Topology::face(side)))
                           .angles[to_size(side % 3)];
            return sum;
        };
        double low = -2.0;
        double high = 1.0;
        if (opposite_angles(low) > pi || opposite_angles(high) < pi)
            continue;
        for (int i = 0; i < 100; ++i)
            (opposite_angles(0.5 * (low + high)) < pi ? low : high) = 0.5 * (low + high);
        opposite_angles(low);
        IntrinsicTriangulation flipped = t;
        flipped.flip(e);
        EXPECT_NEAR(angle_defect_energy(flipped, u), angle_defect_energy(t, u), 1e-12);
        EXPECT_NEAR(
            (measure_angle_defects(flipped, u).defects - measure_angle_defects(t, u).defects)
                .lpNorm<Eigen::Infinity>(),
            0.0, 1e-12);
        ++checked;
    }
    EXPECT_GT(checked, 20);
}

TEST(AngleDefectEnergy, HasTheSameBitsForAnyNumberOfThreads)
{
    const IntrinsicTriangulation t = triangulate(test::bumpy_sphere(4, 0.4, 4));
    const Eigen::VectorXd u = random_factors(t.vertex_count(), 0.3, 3);
    const auto run = [&](int threads) {
        const test::ThreadScope scope(threads);
        return std::pair(angle_defect_energy(t, u), measure_angle_defects(t, u).defects);
    };
    EXPECT_EQ(run(1), run(3));
}

} // namespace
} // namespace shape
