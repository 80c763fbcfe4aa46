// SPDX-License-Identifier: MIT

#include "libshape/embedding/length_dihedral_energy.h"

#include <gtest/gtest.h>

#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/threads.h"
#include "libshape/embedding/gauss_newton.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

using Eigen::VectorXd;

VectorXd flat(const Points& points)
{
    return points.reshaped<Eigen::RowMajor>();
}

/// Every coordinate moved by up to `amount` of the mean edge length.
Points shaken(const test::TestMesh& mesh, double amount, unsigned seed)
{
    Random random(seed);
    const double reach = amount * edge_lengths(mesh.topology, mesh.points).mean();
    return mesh.points + Points::NullaryExpr(mesh.points.rows(), 3,
                                             [&] { return random.uniform(-reach, reach); });
}

TEST(StretchTerm, IsTheSquareOfSmallStrainsAndItsWeightTheSlope)
{
    EXPECT_NEAR(stretch_term(1e-4).value, 1e-8, 1e-13);
    EXPECT_NEAR(stretch_term(1e3).value / 1e6, 9.0, 1e-3);
    for (const double s : {-0.5, -0.03, 0.001, 0.02, 0.1, 2.0}) {
        const double h = 1e-6 * std::abs(s);
        const double slope = (stretch_term(s + h).value - stretch_term(s - h).value) / (2.0 * h);
        EXPECT_NEAR(stretch_term(s).weight, slope / (2.0 * s), 1e-7 * slope / s);
    }
}

TEST(LengthDihedralEnergy, VanishesAtTheMeshItself)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
        VectorXd gradient;
        EXPECT_LT(energy.evaluate(flat(test::moved(mesh.points, 3)), gradient), 1e-24);
        EXPECT_LT(gradient.norm(), 1e-11);
    }
}

TEST(LengthDihedralEnergy, IsTheSumOfItsDefinition)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const ShapePoint target = test::shape_of(mesh.topology, mesh.points);
        const Points points = shaken(mesh, 0.2, 5);
        const ShapePoint found = test::shape_of(mesh.topology, points);
        const double mu = 0.03;
        double sum = 0.0;
        for (int e = 0; e < mesh.topology.edge_count(); ++e) {
            const double strain = found.edge_lengths[e] / target.edge_lengths[e] - 1.0;
            const double bend = wrapped_angle(found.dihedral_angles[e] - target.dihedral_angles[e]);
            sum += stretch_term(strain).value + mu * bend * bend;
        }
        VectorXd gradient;
        EXPECT_NEAR(
            LengthDihedralEnergy(mesh.topology, target, mu).evaluate(flat(points), gradient), sum,
            1e-13 * sum);
    }
}

TEST(LengthDihedralEnergy, HasTheGradientOfCentralDifferences)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.7);
        VectorXd x = flat(shaken(mesh, 0.1, 7));
        VectorXd gradient;
        VectorXd unused;
        (void)energy.evaluate(x, gradient);
        Random random(9);
        const double step = 1e-6;
        for (int sample = 0; sample < 30; ++sample) {
            const auto i =
                static_cast<Eigen::Index>(random.index(static_cast<std::uint64_t>(x.size())));
            const double here = x[i];
            x[i] = here + step;
            const double above = energy.evaluate(x, unused);
            x[i] = here - step;
            const double below = energy.evaluate(x, unused);
            x[i] = here;
            EXPECT_NEAR((above - below) / (2.0 * step), gradient[i], 1e-7 * gradient.norm());
        }
    }
}

TEST(LengthDihedralEnergy, HasTheSameBitsForAnyThreadCount)
{
    const test::TestMesh mesh = test::bumpy_sphere(4, 0.3, 1);
    LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
    const VectorXd x = flat(shaken(mesh, 0.1, 2));
    const int threads = thread_count();
    VectorXd one;
    VectorXd three;
    set_thread_count(1);
    const double value_one = energy.evaluate(x, one);
    set_thread_count(3);
    const double value_three = energy.evaluate(x, three);
    set_thread_count(threads);
    EXPECT_EQ(value_one, value_three);
    EXPECT_TRUE(one == three);
}

TEST(LengthDihedralEnergy, RefusesBadTargets)
{
    const test::TestMesh mesh = test::tetrahedron();
    const ShapePoint good = test::shape_of(mesh.topology, mesh.points);
    ShapePoint bad = good;
    bad.edge_lengths[2] = 0.0;
    EXPECT_THROW(LengthDihedralEnergy(mesh.topology, bad, 1.0), InvalidInput);
    bad = good;
    bad.dihedral_angles[1] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(LengthDihedralEnergy(mesh.topology, bad, 1.0), InvalidInput);
    bad = good;
    bad.edge_lengths.conservativeResize(5);
    EXPECT_THROW(LengthDihedralEnergy(mesh.topology, bad, 1.0), InvalidInput);
    EXPECT_THROW(LengthDihedralEnergy(mesh.topology, good, 0.0), InvalidInput);
}

TEST(GaussNewton, FindsAShakenMeshAgain)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
        std::vector<int> all;
        for (int v = 0; v < mesh.topology.vertex_count(); ++v)
            all.push_back(v);
        const GaussNewtonResult result =
            GaussNewton(mesh.topology, all)
                .minimize(energy, flat(shaken(mesh, 0.05, 4)), {.max_iterations = 60});
        EXPECT_LT(result.value, 1e-18);
        VectorXd gradient;
        EXPECT_NEAR(energy.evaluate(result.points, gradient), result.value, 1e-18);
    }
}

TEST(GaussNewton, MovesTheNamedVerticesOnlyAndEndsWhereTheirGradientVanishes)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 1);
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    Random random(3);
    for (double& length : target.edge_lengths)
        length *= random.uniform(0.97, 1.03);
    LengthDihedralEnergy energy(mesh.topology, target, 0.1);
    const std::vector<int> some{3, 17, 40, 41, 200};
    const VectorXd start = flat(mesh.points);
    const GaussNewtonResult result =
        GaussNewton(mesh.topology, some)
            .minimize(energy, start, {.max_iterations = 200, .decrease_tolerance = 0.0});
    VectorXd before;
    VectorXd after;
    (void)energy.evaluate(start, before);
    (void)energy.evaluate(result.points, after);
    for (int v = 0; v < mesh.topology.vertex_count(); ++v) {
        if (std::find(some.begin(), some.end(), v) != some.end())
            EXPECT_LT(after.segment<3>(3 * v).norm(), 1e-6 * before.norm());
        else
            EXPECT_EQ(result.points.segment<3>(3 * v), start.segment<3>(3 * v));
    }
}

} // namespace
} // namespace shape
