// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/descent.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/embedding/energy/gauss_newton.h"
#include "libshape/embedding/start/edge_laplacian.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

constexpr double mu = 5e-3;

struct Problem
{
    test::TestMesh mesh;
    ShapePoint target; ///< Of no mesh unless `reachable`.
    VectorXd start;
    SinglePrecisionSolve preconditioner;

    Descent descend(LengthDihedralEnergy& energy, const DescentOptions& options) const
    {
        return Descender(energy, preconditioner).descend(start, options);
    }
};

Problem problem(const test::TestMesh& mesh, ShapePoint target, const Points& start)
{
    return {
        mesh, std::move(target), start.reshaped<Eigen::RowMajor>(),
        EdgeLaplacian(mesh.topology, edge_lengths(mesh.topology, mesh.points)).single_precision()};
}

Problem perturbed(const test::TestMesh& mesh, bool reachable, unsigned seed)
{
    Random random(seed);
    const VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    if (!reachable)
        for (int e = 0; e < mesh.topology.edge_count(); ++e)
            target.edge_lengths[e] *= 1.0 + random.uniform(-0.02, 0.02);
    const double reach = 0.05 * lengths.mean();
    const Points moved = mesh.points + Points::NullaryExpr(mesh.points.rows(), 3, [&] {
                             return random.uniform(-reach, reach);
                         });
    return problem(mesh, std::move(target), moved);
}

TEST(Descent, FindsAMeshThatIsThere)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Problem p = perturbed(mesh, true, 1);
        LengthDihedralEnergy energy(mesh.topology, p.target, mu);
        const Descent descent = p.descend(
            energy,
            {.max_linear_steps = 2000, .decrease_tolerance = 0.0, .value_tolerance = 1e-20});
        EXPECT_TRUE(descent.converged);
        EXPECT_LE(descent.energy, 1e-20);
    }
}

TEST(Descent, EndsWhereGaussNewtonWithADirectSolverEnds)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Problem p = perturbed(mesh, false, 2);
        LengthDihedralEnergy energy(mesh.topology, p.target, mu);
        const GaussNewtonResult direct =
            GaussNewton(mesh.topology, graded_unknowns(mesh.topology, p.target.edge_lengths))
                .minimize(energy, p.start, {.max_iterations = 200, .decrease_tolerance = 1e-10});
        const Descent descent =
            p.descend(energy, {.max_linear_steps = 3000, .decrease_tolerance = 1e-10});
        EXPECT_NEAR(descent.energy, direct.value, 1e-4 * direct.value);
    }
}

TEST(Descent, NeverRisesAndCountsItsSteps)
{
    const Problem p = perturbed(test::sample_meshes().back(), false, 3);
    LengthDihedralEnergy energy(p.mesh.topology, p.target, mu);
    double last = std::numeric_limits<double>::infinity();
    for (const int steps : {0, 1, 4, 8, 12, 20}) {
        const DescentOptions options{.max_linear_steps = steps, .decrease_tolerance = 0.0};
        const Descent descent = p.descend(energy, options);
        VectorXd gradient;
        EXPECT_EQ(descent.energy, energy.evaluate(descent.points, gradient));
        EXPECT_EQ(descent.linear_steps, steps);
        EXPECT_FALSE(descent.converged);
        EXPECT_LT(descent.energy, last);
        last = descent.energy;
    }
}

TEST(Descent, DoesNotDependOnThoseBefore)
{
    const Problem p = perturbed(test::bumpy_sphere(3, 0.3, 1), false, 3);
    const Problem other = perturbed(p.mesh, false, 4);
    LengthDihedralEnergy energy(p.mesh.topology, p.target, mu);
    const DescentOptions options{.max_linear_steps = 20};
    Descender descender(energy, p.preconditioner);
    const Descent first = descender.descend(p.start, options);
    EXPECT_NE(descender.descend(other.start, options).points, first.points);
    const Descent again = descender.descend(p.start, options);
    EXPECT_EQ(again.points, first.points);
    EXPECT_EQ(again.energy, first.energy);
}

TEST(Descent, HasTheSameBitsForAnyThreadCount)
{
    const Problem p = perturbed(test::bumpy_sphere(4, 0.3, 1), false, 3);
    LengthDihedralEnergy energy(p.mesh.topology, p.target, mu);
    const auto points = [&](int threads) {
        const test::ThreadScope scope(threads);
        return p.descend(energy, {.max_linear_steps = 20}).points;
    };
    const VectorXd one = points(1);
    EXPECT_EQ(points(2), one);
    EXPECT_EQ(points(3), one);
}

/// Puts a vertex of a face near the middle of the edge opposite.
/// @param height  Over what it was; < 0 turns the face over.
void flatten(const Topology& topology, int face, double height, VectorXd& points)
{
    const auto corners = topology.faces().row(face);
    auto tip = points.segment<3>(3 * corners[0]);
    const Eigen::Vector3d middle =
        0.5 * (points.segment<3>(3 * corners[1]) + points.segment<3>(3 * corners[2]));
    tip = middle + height * (tip - middle);
}

TEST(Descent, GoesOnBesideFacesThatLostTheirArea)
{
    const DescentOptions options{.max_linear_steps = 400, .decrease_tolerance = 1e-6};
    for (const test::TestMesh& mesh : {test::bumpy_sphere(3, 0.3, 1), test::open_patch(20, 2)}) {
        const Problem whole = perturbed(mesh, false, 5);
        LengthDihedralEnergy energy(mesh.topology, whole.target, mu);
        const double lowest = whole.descend(energy, options).energy;
        for (const double height : {0.0, 1e-7, 1e-3, -1e-3, -0.3}) {
            SCOPED_TRACE(mesh.name + ", " + std::to_string(height));
            Problem collapsed = whole;
            for (int f = 0; f < mesh.topology.face_count(); f += mesh.topology.face_count() / 4)
                flatten(mesh.topology, f, height, collapsed.start);
            VectorXd gradient;
            const double first = energy.evaluate(collapsed.start, gradient);
            EXPECT_GT(first, 100.0 * lowest);
            const Descent descent = collapsed.descend(energy, options);
            // One that has turned over may stay so.
            EXPECT_LT(descent.energy, height < 0.0 ? 0.2 * first : 1.01 * lowest);
        }
    }
}

TEST(Descent, HoldsFacesThatWouldTurnOverAndMovesAllElse)
{
    // Lengths that pull the tips of faces across the edge opposite, angles that keep them where they are:
    // E jumps where a face turns over. Steps that are cut short there end while everything else still
    // has far to go, above half of the mu pi^2 that a hinge turned over costs.
    constexpr double stiff = 0.3;
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.3, 1);
    const Problem whole = perturbed(mesh, true, 5);
    for (const int count : {1, 4})
        for (const double height : {1e-4, 1e-3, 0.02}) {
            SCOPED_TRACE(std::to_string(count) + " faces, " + std::to_string(height));
            Problem pulled = whole;
            VectorXd across = mesh.points.reshaped<Eigen::RowMajor>();
            for (int i = 0; i < count; ++i) {
                const int face = (7 + 77 * i) % mesh.topology.face_count();
                flatten(mesh.topology, face, -0.2, across);
                flatten(mesh.topology, face, height, pulled.start);
            }
            pulled.target.edge_lengths = edge_lengths(
                mesh.topology, Eigen::Map<const Points>(across.data(), mesh.points.rows(), 3));
            LengthDihedralEnergy energy(mesh.topology, pulled.target, stiff);
            const Descent descent =
                pulled.descend(energy, {.max_linear_steps = 100, .decrease_tolerance = 1e-6});
            EXPECT_LT(descent.energy, stiff * std::numbers::pi * std::numbers::pi / 3.0);
        }
}

TEST(Descent, RefusesBadOptionsAndStarts)
{
    Problem p = perturbed(test::sample_meshes().front(), true, 4);
    LengthDihedralEnergy energy(p.mesh.topology, p.target, mu);
    EXPECT_THROW((void)p.descend(energy, {.max_linear_steps = -1}), InvalidInput);
    EXPECT_THROW((void)p.descend(energy, {.first_linear_steps = 1}), InvalidInput);
    p.start[0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)p.descend(energy, {}), NumericalError);
}

} // namespace
} // namespace shape
