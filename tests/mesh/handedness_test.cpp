// SPDX-License-Identifier: MIT

#include "libshape/mesh/handedness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "tests/support/files.h"
#include "tests/support/seams.h"

namespace shape {
namespace {

using Indices = std::vector<std::size_t>;
using test::mirror_image;
using test::TestMesh;

/// A cube of side 2, its top open.
TestMesh box()
{
    const Points points = (Points(8, 3) << 0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, //
                           0, 0, 2, 2, 0, 2, 2, 2, 2, 0, 2, 2)
                              .finished();
    const Faces faces = (Faces(10, 3) << 0, 2, 1, 0, 3, 2, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, //
                         2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7)
                            .finished();
    return {"box", Topology(faces, 8), points};
}

TEST(Handedness, VolumesOfKnownSolids)
{
    const TestMesh tetrahedron = test::tetrahedron();
    EXPECT_NEAR(std::abs(signed_volume(tetrahedron.topology, tetrahedron.points)), 8.0 / 3.0,
                1e-12);
    const TestMesh sphere = test::icosphere(4);
    EXPECT_NEAR(signed_volume(sphere.topology, sphere.points), 4.0 / 3.0 * std::numbers::pi, 0.02);
    EXPECT_NEAR(signed_volume(box().topology, box().points), 8.0, 1e-12);
}

TEST(Handedness, VolumesMoveAndScaleWithTheMeshAndChangeSignInAMirror)
{
    for (const TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const double volume = signed_volume(mesh.topology, mesh.points);
        const double tolerance = 1e-9 * (1.0 + std::abs(volume));
        EXPECT_NEAR(signed_volume(mesh.topology, test::moved(mesh.points, 2)), volume, tolerance);
        EXPECT_NEAR(signed_volume(mesh.topology, 2.0 * mesh.points), 8.0 * volume, 8 * tolerance);
        EXPECT_NEAR(signed_volume(mesh.topology, mirror_image(mesh.points)), -volume, tolerance);
    }
}

TEST(Handedness, NamesTheMirrorImagesOfOpenAndClosedMeshes)
{
    for (const TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        std::vector<Points> meshes;
        for (unsigned i = 0; i < 7; ++i)
            meshes.push_back(test::moved(mesh.points, i));
        const Handedness sound = compare_handedness(mesh.topology, meshes);
        EXPECT_EQ(sound.mirrored, Indices{});
        meshes[2] = mirror_image(meshes[2]);
        meshes[5] = mirror_image(meshes[5]);
        EXPECT_EQ(compare_handedness(mesh.topology, meshes).mirrored, (Indices{2, 5}));
        for (Points& points : meshes)
            points = mirror_image(points);
        EXPECT_EQ(compare_handedness(mesh.topology, meshes).mirrored, (Indices{2, 5}));
    }
}

TEST(Handedness, OfTwoEqualHalvesThoseInsideOutAreMirrored)
{
    for (const TestMesh& mesh : {test::bumpy_sphere(2, 0.3, 1), box()}) {
        const Points mirrored = mirror_image(mesh.points);
        const Handedness first =
            compare_handedness(mesh.topology, std::vector{mirrored, mesh.points});
        EXPECT_EQ(first.mirrored, Indices{0});
        EXPECT_FALSE(first.inside_out);
        const Handedness second =
            compare_handedness(mesh.topology, std::vector{mesh.points, mirrored});
        EXPECT_EQ(second.mirrored, Indices{1});
    }
}

TEST(Handedness, TellsWhenAllAreInsideOut)
{
    for (const TestMesh& mesh : {test::bumpy_sphere(2, 0.3, 1), test::torus(12, 20), box()}) {
        EXPECT_FALSE(compare_handedness(mesh.topology, std::vector{mesh.points}).inside_out);
        const Topology reversed(test::reversed_faces(mesh.topology.faces()),
                                mesh.topology.vertex_count());
        EXPECT_TRUE(compare_handedness(reversed, std::vector{mesh.points}).inside_out);
        const Handedness mixed = compare_handedness(
            reversed, std::vector{mesh.points, mirror_image(mesh.points), mesh.points});
        EXPECT_EQ(mixed.mirrored, Indices{1});
        EXPECT_TRUE(mixed.inside_out);
    }
}

TEST(Handedness, SaysNothingOfFlatSheets)
{
    TestMesh sheet = test::open_patch(6, 1);
    sheet.points.col(2).setZero();
    const Handedness found = compare_handedness(
        sheet.topology, std::vector{sheet.points, mirror_image(sheet.points), sheet.points});
    EXPECT_EQ(found.mirrored, Indices{});
    EXPECT_FALSE(found.inside_out);
}

TEST(Handedness, SaysNothingOfBowlsWhichHaveNoInside)
{
    const TestMesh bowl = test::open_patch(24, 1);
    for (const Points& points : {bowl.points, mirror_image(bowl.points)}) {
        EXPECT_GT(std::abs(signed_volume(bowl.topology, points)), 0.1);
        EXPECT_FALSE(compare_handedness(bowl.topology, std::vector{points}).inside_out);
    }
}

TEST(Handedness, RefusesOtherNumbersOfVertices)
{
    const TestMesh mesh = test::tetrahedron();
    EXPECT_THROW((void)signed_volume(mesh.topology, Points::Ones(3, 3)), InvalidInput);
    EXPECT_THROW((void)compare_handedness(mesh.topology,
                                          std::vector<Points>{mesh.points, Points::Ones(5, 3)}),
                 InvalidInput);
    EXPECT_EQ(compare_handedness(mesh.topology, {}).mirrored, Indices{});
}

} // namespace
} // namespace shape
