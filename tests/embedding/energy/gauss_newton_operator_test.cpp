// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/gauss_newton_operator.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/energy/stretch_term.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/lane_vectors.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

constexpr double mu = 0.02;

/// The target of a mesh: other lengths by up to 10 %, other angles by up to 0.1 rad.
ShapePoint target_near(const test::TestMesh& mesh, Random& random)
{
    ShapePoint target{edge_lengths(mesh.topology, mesh.points),
                      dihedral_angles(mesh.topology, mesh.points)};
    for (int e = 0; e < mesh.topology.edge_count(); ++e) {
        target.edge_lengths[e] *= 1.0 + random.uniform(-0.1, 0.1);
        target.dihedral_angles[e] += random.uniform(-0.1, 0.1);
    }
    return target;
}

void linearise(GaussNewtonOperator& matrix, LengthDihedralEnergy& energy, const Points& mesh)
{
    const VectorXd points = mesh.reshaped<Eigen::RowMajor>();
    VectorXd gradient;
    (void)energy.evaluate(points, gradient);
    matrix.linearise(points);
}

TEST(GaussNewtonOperator, IsTheSquareOfTheResidualsDerivatives)
{
    for (const test::TestMesh& mesh : test::sample_meshes())
        for (unsigned seed = 1; seed <= 3; ++seed) {
            SCOPED_TRACE(mesh.name);
            Random random(seed);
            const ShapePoint target = target_near(mesh, random);
            LengthDihedralEnergy energy(mesh.topology, target, mu);
            GaussNewtonOperator matrix(energy);
            linearise(matrix, energy, mesh.points);
            const LaneVectors v = test::random_lane_vectors(mesh.points.rows(), random);
            LaneVectors product;
            const double found = matrix.apply(v, product);

            // v . J^T J v by differences of lengths and angles along v.
            const VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
            constexpr double h = 1e-6;
            const Points motion = matrix.unit() * v.topRows<3>().transpose().cast<double>();
            const Points ahead = mesh.points + h * motion;
            const Points behind = mesh.points - h * motion;
            const VectorXd strains =
                (edge_lengths(mesh.topology, ahead) - edge_lengths(mesh.topology, behind))
                    .cwiseQuotient(target.edge_lengths) /
                (2.0 * h);
            const VectorXd ahead_angles = dihedral_angles(mesh.topology, ahead);
            const VectorXd behind_angles = dihedral_angles(mesh.topology, behind);
            double square = 0.0;
            for (int e = 0; e < mesh.topology.edge_count(); ++e) {
                const double strain = lengths[e] / target.edge_lengths[e] - 1.0;
                square += stretch_term(strain).weight * strains[e] * strains[e];
                if (mesh.topology.is_boundary_edge(e))
                    continue;
                const double bend = wrapped_angle(ahead_angles[e] - behind_angles[e]) / (2.0 * h);
                square += energy.bend_weights()[e] * bend * bend;
            }
            EXPECT_NEAR(v.cwiseProduct(product).cast<double>().sum(), square, 1e-4 * square);
            EXPECT_NEAR(found, square, 1e-4 * square);

            const LaneVectors w = test::random_lane_vectors(mesh.points.rows(), random);
            LaneVectors other;
            matrix.apply(w, other);
            const double one = w.cwiseProduct(product).cast<double>().sum();
            EXPECT_NEAR(v.cwiseProduct(other).cast<double>().sum(), one,
                        1e-5 * v.norm() * other.norm());
            EXPECT_EQ(product.row(3).cwiseAbs().maxCoeff(), 0.0F);

            const test::ThreadScope threads(3);
            LaneVectors again;
            EXPECT_EQ(matrix.apply(v, again), found);
            EXPECT_EQ(product, again);
        }
}

TEST(GaussNewtonOperator, AddsTheSquaresOfGapsThatLackSomething)
{
    const test::TestMesh mesh = test::icosphere(1);
    Random random(5);
    LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), mu);
    GaussNewtonOperator matrix(energy);
    const LaneVectors v = test::random_lane_vectors(mesh.points.rows(), random);
    LaneVectors product;
    linearise(matrix, energy, mesh.points);
    const double without = matrix.apply(v, product);
    const Eigen::Vector3d direction = Eigen::Vector3d::UnitY();
    energy.keep_apart({{{3, 8}, {1.0, -1.0}, direction, 10.0, 2.0},    // of a sphere of radius 1
                       {{4, 9}, {1.0, -1.0}, direction, -10.0, 2.0}}); // lacks nothing
    linearise(matrix, energy, mesh.points);
    const double change = matrix.unit() * static_cast<double>(v(1, 3) - v(1, 8));
    EXPECT_NEAR(matrix.apply(v, product) - without, 2.0 * change * change, 1e-4 * without);
}

TEST(GaussNewtonOperator, AddsTheSquaresOfAreasThatAreKept)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        Random random(4);
        ShapePoint target = test::shape_of(mesh.topology, mesh.points);
        for (double& length : target.edge_lengths)
            length *= random.uniform(1.4, 1.7);
        LengthDihedralEnergy energy(mesh.topology, target, mu);
        energy.keep_areas();
        GaussNewtonOperator matrix(energy);
        linearise(matrix, energy, mesh.points);
        EXPECT_FALSE(energy.collapses().empty());
        const LaneVectors v = test::random_lane_vectors(mesh.points.rows(), random);
        LaneVectors product;
        const double square = matrix.apply(v, product);
        const VectorXd motion = test::flat(v);
        LengthDihedralEnergy without(mesh.topology, target, mu);
        GaussNewtonOperator matrix_without(without);
        linearise(matrix_without, without, mesh.points);
        LaneVectors product_without;
        matrix_without.apply(v, product_without);
        VectorXd sum = test::flat(product_without);
        for (const auto& collapse : energy.collapses()) {
            VectorXd row = VectorXd::Zero(motion.size());
            for (int k = 0; k < 3; ++k)
                row.segment<3>(3 * mesh.topology.faces()(collapse.face, k)) =
                    matrix.unit() * collapse.gradients[to_size(k)];
            sum += row.dot(motion) * row;
        }
        EXPECT_LT((sum - test::flat(product)).norm(), 2e-6 * sum.norm());
        EXPECT_NEAR(square, motion.dot(sum), 1e-5 * square);
    }
}

TEST(GaussNewtonOperator, AddsTheWeightsOfVerticesThatAreHeld)
{
    const test::TestMesh mesh = test::torus(12, 20);
    Random random(6);
    LengthDihedralEnergy energy(mesh.topology, target_near(mesh, random), mu);
    const LaneVectors v = test::random_lane_vectors(mesh.points.rows(), random);
    GaussNewtonOperator matrix(energy);
    linearise(matrix, energy, mesh.points);
    LaneVectors product;
    const double before = matrix.apply(v, product);
    energy.hold_near(mesh.points.reshaped<Eigen::RowMajor>(), 1e3);
    linearise(matrix, energy, mesh.points);
    const double held = matrix.unit() * matrix.unit() *
                        energy.hold_weights().dot(
                            v.topRows<3>().cast<double>().colwise().squaredNorm().transpose());
    EXPECT_GT(held, 0.1 * before);
    EXPECT_NEAR(matrix.apply(v, product), before + held, 1e-4 * (before + held));
}

TEST(GaussNewtonOperator, AddsTheSquaresOfSumsThatAreHeld)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.2, 5);
    Random random(2);
    LengthDihedralEnergy energy(mesh.topology, target_near(mesh, random), mu);
    GaussNewtonOperator matrix(energy);
    const LaneVectors v = test::random_lane_vectors(mesh.points.rows(), random);
    linearise(matrix, energy, mesh.points);
    LaneVectors before;
    LaneVectors after;
    const double square = matrix.apply(v, before);
    const LengthDihedralEnergy::AngleSum sum{{2, 5, 8}, {1.0, -2.0, 0.5}, {0.0, 0.1, 0.2}, 300.0};
    energy.hold_sums({sum});
    linearise(matrix, energy, mesh.points);
    const double held = matrix.apply(v, after) - square;
    // The derivative of the sum by central differences.
    const double step = 1e-5;
    const auto sum_at = [&](double scale) {
        Points points = mesh.points;
        points += scale * matrix.unit() * v.topRows<3>().transpose().cast<double>();
        const VectorXd angles = dihedral_angles(mesh.topology, points);
        double value = 0.0;
        for (std::size_t i = 0; i < sum.edges.size(); ++i)
            value += sum.factors[i] * angles[sum.edges[i]];
        return value;
    };
    const double change = (sum_at(step) - sum_at(-step)) / (2.0 * step);
    EXPECT_NEAR(held, sum.stiffness * change * change, 1e-4 * held);
    EXPECT_GT(held, 0.01 * square);
    const double product = (v.cwiseProduct(after - before)).sum();
    EXPECT_NEAR(product, held, 1e-4 * held);
}

TEST(GaussNewtonOperator, IgnoresRigidMotions)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), mu);
        GaussNewtonOperator matrix(energy);
        linearise(matrix, energy, mesh.points);
        const Eigen::RowVector3d spin(0.3, -0.2, 0.5);
        LaneVectors v = LaneVectors::Zero(4, mesh.points.rows());
        for (Eigen::Index i = 0; i < mesh.points.rows(); ++i) {
            const Eigen::RowVector3d p = mesh.points.row(i) / matrix.unit();
            v.col(i).head<3>() =
                (Eigen::RowVector3d(1.0, 2.0, -1.0) + spin.cross(p)).transpose().cast<float>();
        }
        LaneVectors product;
        matrix.apply(v, product);
        EXPECT_LT(product.norm(), 1e-4 * v.norm());
    }
}

TEST(GaussNewtonOperator, LinearisesOnlyWhatTheEnergyEvaluated)
{
    const test::TestMesh mesh = test::icosphere(1);
    LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), mu);
    GaussNewtonOperator matrix(energy);
    EXPECT_THROW(matrix.linearise(mesh.points.reshaped<Eigen::RowMajor>()), InvalidInput);
    linearise(matrix, energy, mesh.points);
    EXPECT_THROW(matrix.linearise(VectorXd::Zero(6)), InvalidInput);
}

} // namespace
} // namespace shape
