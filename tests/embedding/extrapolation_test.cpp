// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libshape/base/random.h"
#include "libshape/embedding/embedder.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using std::numbers::pi;

constexpr EmbeddingMethod methods[] = {EmbeddingMethod::Dihedral, EmbeddingMethod::Closure,
                                       EmbeddingMethod::Multiscale};

double rigid_distance(const Points& points, const Points& wanted)
{
    return (best_rigid_motion(points, wanted)(points) - wanted).rowwise().norm().maxCoeff() /
           bounding_box_diagonal(wanted);
}

TEST(Extrapolation, AnglesBeyondHalfATurnMeanThoseWithinIt)
{
    Random random(1);
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        ShapePoint target{edge_lengths(mesh.topology, mesh.points),
                          dihedral_angles(mesh.topology, mesh.points)};
        for (int e = 0; e < mesh.topology.edge_count(); ++e)
            if (!mesh.topology.is_boundary_edge(e))
                target.dihedral_angles[e] +=
                    2.0 * pi * (static_cast<double>(random.index(3)) - 1.0);
        for (const EmbeddingMethod method : methods) {
            const Embedding embedding =
                Embedder(mesh.topology, {mesh.points}, {.method = method}).embed(target);
            EXPECT_LT(rigid_distance(embedding.points, mesh.points), 1e-9) << mesh.name;
            EXPECT_LT(embedding.report.dihedral_max_deg, 1e-5) << mesh.name;
        }
    }
}

/// A strip of two triangles a quad, each quad bent against the one before.
test::TestMesh strip(double bend)
{
    constexpr int quads = 8;
    Faces faces(2 * quads, 3);
    Points points(2 * quads + 2, 3);
    Eigen::RowVector3d place(0.0, 0.0, 0.0);
    for (int i = 0; i <= quads; ++i) {
        points.row(2 * i) = place;
        points.row(2 * i + 1) = place + Eigen::RowVector3d(0.0, 1.0, 0.0);
        place += Eigen::RowVector3d(std::cos(i * bend), 0.0, std::sin(i * bend));
        if (i < quads) {
            faces.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 1;
            faces.row(2 * i + 1) << 2 * i + 1, 2 * i + 2, 2 * i + 3;
        }
    }
    return {"strip", Topology(faces, static_cast<int>(points.rows())), points};
}

TEST(Extrapolation, BendsPastTheFold)
{
    // Bends of 0 and 80 degrees: at t = 2.5 every quad is bent by 200 degrees.
    const test::TestMesh flat = strip(0.0);
    const test::TestMesh bent = strip(80.0 * pi / 180.0);
    const test::TestMesh wanted = strip(200.0 * pi / 180.0);
    const Collection pair{flat.topology, {"flat", "bent"}, {flat.points, bent.points}, {}};
    const ShapePoint target = blend(shape_vectors(pair, Scale::None), Eigen::Vector2d(-1.5, 2.5));
    EXPECT_GT(target.dihedral_angles.cwiseAbs().maxCoeff(), pi);
    for (const EmbeddingMethod method : methods) {
        const Embedding embedding =
            Embedder(pair.topology, pair.points, {.method = method}).embed(target);
        EXPECT_LT(rigid_distance(embedding.points, wanted.points), 1e-6);
    }
}

} // namespace
} // namespace shape
