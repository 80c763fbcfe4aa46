// SPDX-License-Identifier: MIT

#include "libshape/mesh/topology.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

TEST(Topology, CountsOfKnownSurfaces)
{
    EXPECT_EQ(test::icosphere(2).topology.euler_characteristic(), 2);
    EXPECT_EQ(test::torus(9, 16).topology.genus(), 1);
    EXPECT_EQ(test::open_patch(5, 1).topology.boundary_loop_count(), 1);
    EXPECT_EQ(test::open_cylinder(6, 4).topology.boundary_loop_count(), 2);
    EXPECT_EQ(test::open_cylinder(6, 4).topology.genus(), 0);
}

TEST(Topology, TablesAgreeWithEachOther)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        for (int e = 0; e < t.edge_count(); ++e) {
            const int h = t.edge_halfedges()(e, 0);
            EXPECT_EQ(t.edge(h), e);
            EXPECT_EQ(t.find_edge(t.edges()(e, 1), t.edges()(e, 0)), e);
            if (t.is_boundary_edge(e))
                continue;
            EXPECT_EQ(t.source(h), t.edges()(e, 0));
            EXPECT_EQ(t.target(h), t.edges()(e, 1));
            EXPECT_EQ(t.opposite(t.opposite(h)), h);
        }
        std::set<int> seen;
        for (int v = 0; v < t.vertex_count(); ++v)
            for (const int h : t.outgoing(v)) {
                EXPECT_EQ(t.source(h), v);
                EXPECT_TRUE(seen.insert(h).second);
            }
        EXPECT_EQ(static_cast<int>(seen.size()), t.halfedge_count());
    }
}

TEST(Topology, SpokesAreTheEdgesAtAVertex)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        std::vector<int> ends(to_size(t.edge_count()), 0);
        for (int v = 0; v < t.vertex_count(); ++v) {
            const auto outgoing = t.outgoing(v);
            const auto spokes = t.spokes(v);
            ASSERT_EQ(spokes.size(), outgoing.size() + (t.is_boundary_vertex(v) ? 1 : 0));
            for (std::size_t i = 0; i < spokes.size(); ++i) {
                EXPECT_EQ(spokes[i].halfedge, i < outgoing.size() ? outgoing[i] : -1);
                EXPECT_EQ(spokes[i].edge, t.find_edge(v, spokes[i].vertex));
                ++ends[to_size(spokes[i].edge)];
            }
        }
        EXPECT_EQ(ends, std::vector<int>(ends.size(), 2));
    }
}

TEST(Topology, OutgoingTurnsCounterClockwiseSeenFromOutside)
{
    const test::TestMesh mesh = test::icosphere(1);
    for (int v = 0; v < mesh.topology.vertex_count(); ++v) {
        const auto ring = mesh.topology.outgoing(v);
        for (std::size_t i = 0; i < ring.size(); ++i)
            EXPECT_EQ(mesh.topology.target(ring[(i + 1) % ring.size()]),
                      mesh.topology.source(Topology::previous(ring[i])));
    }
}

TEST(Topology, RefusesWhatIsNotAConnectedOrientedManifold)
{
    const auto first_kind = [](std::vector<std::array<int, 3>> list, int vertices) {
        Faces faces(static_cast<Eigen::Index>(list.size()), 3);
        for (std::size_t f = 0; f < list.size(); ++f)
            faces.row(static_cast<Eigen::Index>(f)) << list[f][0], list[f][1], list[f][2];
        EXPECT_THROW(Topology(faces, vertices), InvalidInput);
        return find_defects(faces, vertices).at(0).kind;
    };
    EXPECT_EQ(first_kind({}, 3), DefectKind::Empty);
    EXPECT_EQ(first_kind({{0, 1, 3}}, 3), DefectKind::IndexOutOfRange);
    EXPECT_EQ(first_kind({{0, 1, 1}}, 3), DefectKind::DegenerateFace);
    EXPECT_EQ(first_kind({{0, 1, 2}, {1, 2, 0}}, 3), DefectKind::DuplicateFace);
    EXPECT_EQ(first_kind({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}, 5), DefectKind::NonManifoldEdge);
    EXPECT_EQ(first_kind({{0, 1, 2}, {0, 1, 3}}, 4), DefectKind::FlippedFace);
    EXPECT_EQ(first_kind({{0, 1, 2}, {0, 3, 4}}, 5), DefectKind::BowTie);
    EXPECT_EQ(first_kind({{0, 1, 2}}, 4), DefectKind::IsolatedVertex);
    EXPECT_EQ(first_kind({{0, 1, 2}, {3, 4, 5}}, 6), DefectKind::SeveralComponents);
}

TEST(DihedralAngles, OfATetrahedronAreTheComplementOfArcCosOneThird)
{
    const test::TestMesh mesh = test::tetrahedron();
    const Eigen::VectorXd angles = dihedral_angles(mesh.topology, mesh.points);
    for (const double angle : angles)
        EXPECT_NEAR(angle, std::numbers::pi - std::acos(1.0 / 3.0), 1e-14);
    const Points mirror = mesh.points * Eigen::Vector3d(-1, 1, 1).asDiagonal();
    EXPECT_NEAR((dihedral_angles(mesh.topology, mirror) + angles).norm(), 0.0, 1e-14);
}

TEST(CornerAngles, SumToPiAndAgreeWithPositions)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.3, 3);
    const Points angles = corner_angles(mesh.topology, edge_lengths(mesh.topology, mesh.points));
    for (int f = 0; f < mesh.topology.face_count(); ++f) {
        EXPECT_NEAR(angles.row(f).sum(), std::numbers::pi, 1e-14);
        const auto p = [&](int c) { return mesh.points.row(mesh.topology.faces()(f, c)); };
        const Eigen::RowVector3d u = p(1) - p(0);
        const Eigen::RowVector3d w = p(2) - p(0);
        EXPECT_NEAR(angles(f, 0), std::acos(u.dot(w) / u.norm() / w.norm()), 1e-12);
    }
}

} // namespace
} // namespace shape
