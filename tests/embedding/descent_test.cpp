// SPDX-License-Identifier: MIT

#include "libshape/embedding/descent.h"

#include <gtest/gtest.h>

#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/embedding/edge_laplacian.h"
#include "libshape/embedding/gauss_newton.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

using Eigen::VectorXd;

constexpr double mu = 5e-3;

struct Problem
{
    test::TestMesh mesh;
    ShapePoint target; ///< Of no mesh unless `reachable`.
    VectorXd start;
    SinglePrecisionSolve preconditioner;
};

Problem shaken(const test::TestMesh& mesh, bool reachable, unsigned seed)
{
    Random random(seed);
    const VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
    ShapePoint target{lengths, dihedral_angles(mesh.topology, mesh.points)};
    if (!reachable)
        for (int e = 0; e < mesh.topology.edge_count(); ++e)
            target.edge_lengths[e] *= 1.0 + random.uniform(-0.02, 0.02);
    const double reach = 0.05 * lengths.mean();
    const Points moved = mesh.points + Points::NullaryExpr(mesh.points.rows(), 3, [&] {
                             return random.uniform(-reach, reach);
                         });
    return {mesh, target, moved.reshaped<Eigen::RowMajor>(),
            EdgeLaplacian(mesh.topology, lengths).single_precision()};
}

TEST(Descent, FindsAMeshThatIsThere)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Problem p = shaken(mesh, true, 1);
        LengthDihedralEnergy energy(mesh.topology, p.target, mu);
        const Descent descent = descend(
            energy, p.preconditioner, p.start,
            {.max_linear_steps = 2000, .decrease_tolerance = 0.0, .value_tolerance = 1e-20});
        EXPECT_TRUE(descent.converged);
        EXPECT_LE(descent.energy, 1e-20);
    }
}

TEST(Descent, EndsWhereGaussNewtonWithADirectSolverEnds)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Problem p = shaken(mesh, false, 2);
        LengthDihedralEnergy energy(mesh.topology, p.target, mu);
        const Descent descent = descend(energy, p.preconditioner, p.start,
                                        {.max_linear_steps = 3000, .decrease_tolerance = 1e-10});
        std::vector<int> all(static_cast<std::size_t>(mesh.topology.vertex_count()));
        for (std::size_t v = 0; v < all.size(); ++v)
            all[v] = static_cast<int>(v);
        const GaussNewtonResult direct =
            GaussNewton(mesh.topology, all)
                .minimize(energy, p.start, {.max_iterations = 200, .decrease_tolerance = 1e-10});
        EXPECT_NEAR(descent.energy, direct.value, 1e-4 * direct.value);
    }
}

TEST(Descent, NeverRisesAndCountsItsSteps)
{
    const Problem p = shaken(test::sample_meshes().back(), false, 3);
    LengthDihedralEnergy energy(p.mesh.topology, p.target, mu);
    double last = std::numeric_limits<double>::infinity();
    for (const int steps : {0, 1, 4, 8, 12, 20}) {
        const Descent descent = descend(energy, p.preconditioner, p.start,
                                        {.max_linear_steps = steps, .decrease_tolerance = 0.0});
        VectorXd gradient;
        EXPECT_EQ(descent.energy, energy.evaluate(descent.points, gradient));
        EXPECT_EQ(descent.linear_steps, steps);
        EXPECT_FALSE(descent.converged);
        EXPECT_LT(descent.energy, last);
        last = descent.energy;

        const test::ThreadScope threads(3);
        EXPECT_EQ(descend(energy, p.preconditioner, p.start,
                          {.max_linear_steps = steps, .decrease_tolerance = 0.0})
                      .points,
                  descent.points);
    }
}

TEST(Descent, RefusesBadOptionsAndStarts)
{
    const Problem p = shaken(test::sample_meshes().front(), true, 4);
    LengthDihedralEnergy energy(p.mesh.topology, p.target, mu);
    EXPECT_THROW((void)descend(energy, p.preconditioner, p.start, {.max_linear_steps = -1}),
                 InvalidInput);
    EXPECT_THROW((void)descend(energy, p.preconditioner, p.start, {.first_linear_steps = 1}),
                 InvalidInput);
    VectorXd broken = p.start;
    broken[0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)descend(energy, p.preconditioner, broken), NumericalError);
}

} // namespace
} // namespace shape
