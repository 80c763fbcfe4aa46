// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/gauss_newton.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

Points rows(const VectorXd& points)
{
    return Eigen::Map<const Points>(points.data(), points.size() / 3, 3);
}

TEST(GaussNewton, FoldsAHingeInOneStepThatKeepsItsLengths)
{
    // Two flat triangles. To fold them by theta, tips leave the plane by h theta / 2: on a straight step their
    // edges of length 1 would grow by (3 / 4) (theta / 2)^2 / 2, 2.3 % at theta = 1/2.
    Faces faces(2, 3);
    faces << 0, 1, 2, 1, 0, 3;
    const double height = std::sqrt(0.75);
    Points flat(4, 3);
    flat << 0, 0, 0, 1, 0, 0, 0.5, height, 0, 0.5, -height, 0;
    const Topology topology(faces, 4);
    ShapePoint target = test::shape_of(topology, flat);
    for (int e = 0; e < topology.edge_count(); ++e)
        if (!topology.is_boundary_edge(e))
            target.dihedral_angles[e] = 0.5;
    const LengthDihedralEnergy energy(topology, target, 1e-2);
    const GaussNewtonResult folded =
        GaussNewton(topology, graded_unknowns(topology, target.edge_lengths))
            .minimize(energy, flat.reshaped<Eigen::RowMajor>(), {.max_iterations = 1});
    EXPECT_EQ(folded.last_step, 1.0);
    const Points points = rows(folded.points);
    EXPECT_LE((edge_lengths(topology, points) - target.edge_lengths).lpNorm<Eigen::Infinity>(),
              2e-3);
    EXPECT_LE(
        (dihedral_angles(topology, points) - target.dihedral_angles).lpNorm<Eigen::Infinity>(),
        0.02);
}

TEST(GaussNewton, HoldsVerticesThatNoUnknownMoves)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.3, 1);
    const ShapePoint target = test::shape_of(mesh.topology, test::bumpy_sphere(2, 0.4, 1).points);
    GradedUnknowns unknowns{{3, 40}, {}};
    unknowns.rows.resize(static_cast<std::size_t>(mesh.topology.vertex_count()));
    unknowns.rows[3] = {0};
    unknowns.rows[40] = {1};
    const LengthDihedralEnergy energy(mesh.topology, target, 1e-2);
    const GaussNewtonResult found = GaussNewton(mesh.topology, unknowns)
                                        .minimize(energy, mesh.points.reshaped<Eigen::RowMajor>());
    const Points points = rows(found.points);
    for (int v = 0; v < mesh.topology.vertex_count(); ++v)
        EXPECT_EQ(points.row(v) == mesh.points.row(v), v != 3 && v != 40) << v;
    EXPECT_TRUE(found.converged);
}

TEST(GaussNewton, SaysThatNoStepLowersTheEnergyOfAMinimum)
{
    const test::TestMesh mesh = test::icosphere(1);
    const LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points),
                                      1e-2);
    const VectorXd points = mesh.points.reshaped<Eigen::RowMajor>();
    const GaussNewtonResult found =
        GaussNewton(mesh.topology, graded_unknowns(mesh.topology, energy.target().edge_lengths))
            .minimize(energy, points, {.max_iterations = 40, .decrease_tolerance = 0.0});
    EXPECT_TRUE(found.converged);
    EXPECT_EQ(found.last_step, 0.0);
    EXPECT_LE(found.value, 1e-25);
    EXPECT_LE((found.points - points).lpNorm<Eigen::Infinity>(), 1e-12);
}

} // namespace
} // namespace shape
