// SPDX-License-Identifier: MIT

#include "libshape/embedding/repair/rigid_filling.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/to_size.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

TEST(RigidFilling, PutsAReferenceInAnotherPoseWhereItBelongs)
{
    const test::TestMesh mesh = test::open_patch(12, 4);
    const RegionMesh region(mesh.topology, {70, 71, 83, 84, 85, 97});
    const VectorXd wanted = edge_lengths(mesh.topology, mesh.points);
    std::vector<float> lengths;
    Eigen::MatrixXd laplacian =
        Eigen::MatrixXd::Zero(region.moving_vertices, region.moving_vertices);
    for (std::size_t e = 0; e < region.edges.size(); ++e) {
        lengths.push_back(static_cast<float>(wanted[region.edges[e]]));
        const double weight = 1.0 / (wanted[region.edges[e]] * wanted[region.edges[e]]);
        const int a = region.ends[2 * e];
        const int b = region.ends[2 * e + 1];
        for (const int end : {a, b})
            if (end < region.moving_vertices)
                laplacian(end, end) += weight;
        if (a < region.moving_vertices && b < region.moving_vertices) {
            laplacian(a, b) -= weight;
            laplacian(b, a) -= weight;
        }
    }
    // Eight turns about the x axis by up to 70 degrees.
    EightLanePoints references(region.vertices.size());
    EightLanePoints points(region.vertices.size());
    for (std::size_t v = 0; v < points.size(); ++v)
        for (int k = 0; k < EightLanes::lanes; ++k) {
            const Eigen::RowVector3f p = mesh.points.row(region.vertices[v]).cast<float>();
            const auto angle = static_cast<float>(0.175 * k);
            references[v].x.of[k] = p[0];
            references[v].y.of[k] = std::cos(angle) * p[1] - std::sin(angle) * p[2];
            references[v].z.of[k] = std::sin(angle) * p[1] + std::cos(angle) * p[2];
            if (static_cast<int>(v) < region.moving_vertices)
                continue;
            points[v].x.of[k] = p[0];
            points[v].y.of[k] = p[1];
            points[v].z.of[k] = p[2];
        }
    fill_rigidly(region, lengths, EightLaneSolve(laplacian.sparseView()), references, 10, points);
    for (std::size_t v = 0; v < to_size(region.moving_vertices); ++v)
        for (int k = 0; k < EightLanes::lanes; ++k) {
            const Eigen::RowVector3f found(points[v].x.of[k], points[v].y.of[k], points[v].z.of[k]);
            EXPECT_LT((found - mesh.points.row(region.vertices[v]).cast<float>()).norm(),
                      1e-4F * static_cast<float>(wanted.mean()))
                << k;
        }
}

} // namespace
} // namespace shape
