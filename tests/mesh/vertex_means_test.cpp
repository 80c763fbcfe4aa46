// SPDX-License-Identifier: MIT

#include "libshape/mesh/vertex_means.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

TEST(VertexMeans, AreTheMeansOverTheEdgesOfEachVertex)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        const Eigen::VectorXd values =
            Eigen::VectorXd::LinSpaced(mesh.topology.edge_count(), -1.0, 5.0);
        const Eigen::VectorXd means = vertex_means(mesh.topology, values);
        for (int v = 0; v < mesh.topology.vertex_count(); ++v) {
            double sum = 0.0;
            int count = 0;
            for (int u = 0; u < mesh.topology.vertex_count(); ++u)
                if (const int e = mesh.topology.find_edge(u, v); e >= 0) {
                    sum += values[e];
                    ++count;
                }
            EXPECT_NEAR(means[v], sum / count, 1e-13) << mesh.name;
        }
    }
}

TEST(VertexMeans, RefuseValuesOfAnotherMesh)
{
    EXPECT_THROW((void)vertex_means(test::tetrahedron().topology, Eigen::VectorXd::Zero(5)),
                 InvalidInput);
}

} // namespace
} // namespace shape
