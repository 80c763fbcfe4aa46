// SPDX-License-Identifier: MIT

#include "libshape/mesh/renumbering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "libshape/base/to_size.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

TEST(Renumbering, KeepsTheSurface)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Renumbering r = renumber_for_locality(mesh.topology);
        for (const auto& [numbers, count] : {std::pair(r.vertices, mesh.topology.vertex_count()),
                                             std::pair(r.edges, mesh.topology.edge_count())}) {
            std::vector<int> sorted = numbers;
            std::sort(sorted.begin(), sorted.end());
            std::vector<int> all(to_size(count));
            std::iota(all.begin(), all.end(), 0);
            EXPECT_EQ(sorted, all);
        }
        const Points points = renumbered(r, mesh.points);
        EXPECT_EQ(edge_lengths(r.topology, points),
                  edge_lengths(mesh.topology, mesh.points)(r.edges));
        EXPECT_LT((dihedral_angles(r.topology, points) -
                   dihedral_angles(mesh.topology, mesh.points)(r.edges))
                      .cwiseAbs()
                      .maxCoeff(),
                  1e-12);
        EXPECT_EQ(restored(r, points), mesh.points);
    }
}

TEST(Renumbering, BringsNeighboursTogether)
{
    // A strip of 2 by 1000 vertices, numbered badly.
    constexpr int length = 1000;
    const auto number = [](int row, int column) { return (2 * column + row) * 777 % (2 * length); };
    Faces faces(2 * (length - 1), 3);
    for (int c = 0; c + 1 < length; ++c) {
        faces.row(2 * c) << number(0, c), number(0, c + 1), number(1, c);
        faces.row(2 * c + 1) << number(1, c), number(0, c + 1), number(1, c + 1);
    }
    const Renumbering r = renumber_for_locality(Topology(faces, 2 * length));
    const Edges& edges = r.topology.edges();
    EXPECT_LE((edges.col(1) - edges.col(0)).maxCoeff(), 6);
}

} // namespace
} // namespace shape
