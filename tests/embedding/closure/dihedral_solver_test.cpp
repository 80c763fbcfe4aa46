// SPDX-License-Identifier: MIT

#include "libshape/embedding/closure/dihedral_solver.h"

#include <gtest/gtest.h>

#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/closure/closure.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

struct Problem
{
    test::TestMesh mesh;
    Points corners;
    Eigen::VectorXd own;
    Eigen::VectorXd initial; ///< Own angles, perturbed.
};

Problem problem(const test::TestMesh& mesh, double size)
{
    Problem p{mesh,
              corner_angles(mesh.topology, edge_lengths(mesh.topology, mesh.points)),
              dihedral_angles(mesh.topology, mesh.points),
              {}};
    p.initial = p.own;
    Random random(5);
    for (double& angle : p.initial)
        angle += size * random.normal();
    return p;
}

TEST(DihedralSolver, LeavesTheAnglesOfAMeshAlone)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Problem p = problem(mesh, 0.0);
        const DihedralSolution solution = solve_dihedrals(mesh.topology, p.corners, p.own);
        EXPECT_TRUE(solution.converged);
        EXPECT_EQ(solution.iterations, 0);
        EXPECT_EQ(solution.evaluations, 2);
        EXPECT_EQ(solution.dihedral_angles, p.own);
    }
}

TEST(DihedralSolver, LowersTheEnergyToAStationaryPoint)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Problem p = problem(mesh, 0.05);
        const DihedralSolution solution =
            solve_dihedrals(mesh.topology, p.corners, p.initial,
                            {.gradient_tolerance = 1e-7, .decrease_tolerance = 0.0});
        ClosureEnergy closure(mesh.topology, p.corners);
        Eigen::VectorXd gradient(p.own.size());
        const double start = closure.evaluate(p.initial, gradient);
        const double end = closure.evaluate(solution.dihedral_angles, gradient);
        EXPECT_TRUE(solution.converged);
        EXPECT_LE(gradient.lpNorm<Eigen::Infinity>(), 1e-7);
        EXPECT_EQ(solution.gradient_maximum, gradient.lpNorm<Eigen::Infinity>());
        EXPECT_EQ(solution.energy, end);
        EXPECT_LT(end, 0.1 * start);
        for (int e = 0; e < mesh.topology.edge_count(); ++e)
            if (mesh.topology.is_boundary_edge(e)) {
                EXPECT_EQ(solution.dihedral_angles[e], p.initial[e]);
            }
    }
}

TEST(DihedralSolver, FindsTheAnglesOfATetrahedronFromNearby)
{
    const Problem p = problem(test::tetrahedron(), 0.05);
    const DihedralSolution solution =
        solve_dihedrals(p.mesh.topology, p.corners, p.initial, {.decrease_tolerance = 0.0});
    EXPECT_TRUE(solution.converged);
    EXPECT_LT((solution.dihedral_angles - p.own).lpNorm<Eigen::Infinity>(), 1e-5);
}

TEST(DihedralSolver, StopsAtEitherTolerance)
{
    const Problem p = problem(test::bumpy_sphere(2, 0.3, 1), 0.05);
    const auto solve = [&](const LbfgsOptions& options) {
        return solve_dihedrals(p.mesh.topology, p.corners, p.initial, options);
    };
    const DihedralSolution by_gradient =
        solve({.gradient_tolerance = 1e-2, .decrease_tolerance = 0.0});
    EXPECT_TRUE(by_gradient.converged);
    EXPECT_LE(by_gradient.gradient_maximum, 1e-2);
    const DihedralSolution by_decrease =
        solve({.gradient_tolerance = 0.0, .decrease_tolerance = 1e-3});
    EXPECT_TRUE(by_decrease.converged);
    EXPECT_GT(by_decrease.gradient_maximum, 0.0);
    EXPECT_LT(by_decrease.iterations, solve(dihedral_solver_defaults).iterations);
}

TEST(DihedralSolver, SaysWhenItRanOutOfIterations)
{
    const Problem p = problem(test::bumpy_sphere(2, 0.3, 1), 0.05);
    for (const int limit : {0, 3}) {
        const DihedralSolution solution =
            solve_dihedrals(p.mesh.topology, p.corners, p.initial, {.max_iterations = limit});
        EXPECT_FALSE(solution.converged);
        EXPECT_EQ(solution.iterations, limit);
        Eigen::VectorXd gradient(p.own.size());
        EXPECT_EQ(
            solution.energy,
            ClosureEnergy(p.mesh.topology, p.corners).evaluate(solution.dihedral_angles, gradient));
    }
}

TEST(DihedralSolver, ReportsProgressAndCanBeInterrupted)
{
    const Problem p = problem(test::bumpy_sphere(2, 0.3, 1), 0.05);
    std::size_t calls = 0;
    const auto count = [&](std::string_view, std::size_t done, std::size_t total) {
        EXPECT_EQ(done, ++calls);
        EXPECT_EQ(total, 50u);
    };
    const DihedralSolution solution =
        solve_dihedrals(p.mesh.topology, p.corners, p.initial, {.max_iterations = 50}, count);
    EXPECT_EQ(calls, to_size(solution.iterations));
    const auto stop = [](std::string_view, std::size_t, std::size_t) {
        throw Interrupted("stopped");
    };
    EXPECT_THROW((void)solve_dihedrals(p.mesh.topology, p.corners, p.initial, {}, stop),
                 Interrupted);
}

TEST(DihedralSolver, RefusesBrokenArguments)
{
    const Problem p = problem(test::tetrahedron(), 0.05);
    const auto solve = [&](const Eigen::VectorXd& initial, const LbfgsOptions& options) {
        return solve_dihedrals(p.mesh.topology, p.corners, initial, options);
    };
    EXPECT_THROW((void)solve(p.own.head(5), {}), InvalidInput);
    EXPECT_THROW((void)solve_dihedrals(p.mesh.topology, p.corners.topRows(3), p.own), InvalidInput);
    Eigen::VectorXd not_finite = p.own;
    not_finite[4] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)solve(not_finite, {}), InvalidInput);
    EXPECT_THROW((void)solve(p.own, {.memory = 0}), InvalidInput);
}

} // namespace
} // namespace shape
