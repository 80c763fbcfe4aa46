// SPDX-License-Identifier: MIT

#include "libshape/registration/growth_energy.h"

#include <gtest/gtest.h>

#include "libshape/mesh/vertex_normals.h"
#include "tests/support/meshes.h"

namespace shape::internal {
namespace {

/// E after one step from vertices that slid along the surface, held across it alone.
double energy_after_step(bool slides_freely)
{
    const test::TestMesh mesh = test::bumpy_sphere(4, 0.2, 1);
    const Points normals = vertex_normals(mesh.points, mesh.topology.faces());
    Points slid = mesh.points;
    for (Eigen::Index v = 0; v < slid.rows(); ++v) {
        const Eigen::Vector3d n = normals.row(v);
        const Eigen::Vector3d move = 0.05 * mesh.points(v, 0) * Eigen::Vector3d::UnitY();
        slid.row(v) += (move - move.dot(n) * n).transpose();
    }
    GrowthEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points),
                        {.slides_freely = slides_freely});
    energy.clear_pulls(slid);
    for (int v = 0; v < slid.rows(); ++v) {
        const Eigen::Vector3d n = normals.row(v);
        energy.add_pull(v, n, n.dot((mesh.points.row(v) - slid.row(v)).transpose()), 20.0);
    }
    energy.prepare();
    Eigen::VectorXd growth = Eigen::VectorXd::Zero(slid.rows());
    return energy.step(slid, growth, 15);
}

TEST(GrowthEnergy, AStepThatSlidesFreelyComesNearerTheMinimum)
{
    EXPECT_LT(energy_after_step(true), 0.5 * energy_after_step(false));
}

} // namespace
} // namespace shape::internal
