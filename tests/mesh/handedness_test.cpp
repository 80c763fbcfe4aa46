// SPDX-License-Identifier: MIT

#include "libshape/mesh/handedness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/mesh/dihedral_angles.h"
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

/// The mirror images, or what may be such, as of simple open surfaces.
Indices odd_ones(const TestMesh& mesh, const std::vector<Points>& meshes)
{
    const Handedness found = compare_handedness(mesh.topology, meshes);
    EXPECT_TRUE(found.bent.empty() || found.mirrored.empty());
    EXPECT_TRUE(found.bent.empty() || !mesh.topology.is_closed());
    return found.mirrored.empty() ? found.bent : found.mirrored;
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
        EXPECT_EQ(odd_ones(mesh, meshes), (Indices{2, 5}));
        for (Points& points : meshes)
            points = mirror_image(points);
        EXPECT_EQ(odd_ones(mesh, meshes), (Indices{2, 5}));
    }
}

TEST(Handedness, OfTwoEqualHalvesThoseInsideOutAreMirrored)
{
    TestMesh deep = box();
    deep.points.col(2) *= 5.0;
    for (const TestMesh& mesh : {test::bumpy_sphere(2, 0.3, 1), deep}) {
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
        const std::vector<Points> three{mesh.points, mirror_image(mesh.points), mesh.points};
        const Handedness mixed = compare_handedness(reversed, three);
        EXPECT_EQ(odd_ones({mesh.name, reversed, mesh.points}, three), Indices{1});
        EXPECT_TRUE(mixed.inside_out);
    }
}

TEST(Handedness, SaysNothingOfClosedMeshesWhoseVerticesArePermuted)
{
    const TestMesh mesh = test::bumpy_sphere(2, 0.1, 1);
    std::vector<Points> meshes;
    for (unsigned i = 0; i < 6; ++i)
        meshes.push_back(test::bumpy_sphere(2, 0.1, i).points);
    meshes[1] = mirror_image(meshes[1]);
    const auto count = static_cast<int>(mesh.points.rows());
    for (const int step : {5, 7, 11, 13, 17, 19, 23}) { // none divides 162
        std::vector<int> order;
        for (int v = 0; v < count; ++v)
            order.push_back(v * step % count);
        meshes[4] = test::bumpy_sphere(2, 0.1, 4).points(order, Eigen::all);
        const Handedness found = compare_handedness(mesh.topology, meshes);
        EXPECT_EQ(found.mirrored, Indices{1}) << step;
        EXPECT_FALSE(found.inside_out);
        // The rest are inside out, whatever the volume of that one is.
        const Topology reversed(test::reversed_faces(mesh.topology.faces()), count);
        EXPECT_TRUE(compare_handedness(reversed, meshes).inside_out) << step;
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

/// A sheet whose vertices are scattered about a plane: such sheets have nothing in common.
Points rough_sheet(const TestMesh& sheet, unsigned seed)
{
    internal::Random random(seed);
    Points points = sheet.points;
    for (double& z : points.col(2))
        z = 0.01 * random.normal();
    return points;
}

TEST(Handedness, SaysNothingOfRoughSheets)
{
    const TestMesh sheet = test::open_patch(20, 1);
    for (unsigned seed = 1; seed <= 20; ++seed)
        EXPECT_FALSE(is_mirror_image(sheet.topology, rough_sheet(sheet, seed),
                                     rough_sheet(sheet, 100 + seed)))
            << seed;
    for (const unsigned count : {3U, 5U, 8U}) {
        std::vector<Points> sheets;
        for (unsigned i = 0; i < count; ++i)
            sheets.push_back(rough_sheet(sheet, 200 + i));
        EXPECT_EQ(compare_handedness(sheet.topology, sheets).mirrored, Indices{}) << count;
    }
    const Points one = rough_sheet(sheet, 1);
    EXPECT_TRUE(is_mirror_image(sheet.topology, mirror_image(one), one));
}

/// A strip along a polyline that turns by these angles at its inner points.
TestMesh strip(const std::vector<double>& turns)
{
    const auto count = static_cast<int>(turns.size()) + 2;
    Points points(2 * count, 3);
    double heading = 0.0;
    Eigen::RowVector3d at(0, 0, 0);
    for (int i = 0; i < count; ++i) {
        points.row(2 * i) = at;
        points.row(2 * i + 1) = at + Eigen::RowVector3d(0, 1, 0);
        if (i > 0 && i + 1 < count)
            heading += turns[static_cast<std::size_t>(i - 1)];
        at += Eigen::RowVector3d(std::cos(heading), 0, std::sin(heading));
    }
    Faces faces(2 * (count - 1), 3);
    for (int i = 0; i + 1 < count; ++i) {
        faces.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 3;
        faces.row(2 * i + 1) << 2 * i, 2 * i + 3, 2 * i + 1;
    }
    return {"strip", Topology(faces, 2 * count), points};
}

TEST(Handedness, AFoldThatPassesFlatTellsNothing)
{
    std::vector<double> turns(21, 0.2);
    turns[10] = 3.1;
    const TestMesh up = strip(turns);
    turns[10] = -3.1;
    const Points down = strip(turns).points;
    EXPECT_FALSE(is_mirror_image(up.topology, down, up.points));
    EXPECT_TRUE(is_mirror_image(up.topology, mirror_image(down), up.points));
}

/// A sheet of an outline without symmetry that curls about one axis, with some noise.
Points leaf(const TestMesh& sheet, double curl, unsigned seed)
{
    internal::Random random(seed);
    Points points = sheet.points;
    points.col(1).array() *= 1.0 + 0.3 * points.col(0).array();
    points.col(2) = curl * points.col(0).array() * (points.col(0) + 0.3 * points.col(1)).array();
    for (double& z : points.col(2))
        z += 0.002 * random.normal();
    return points;
}

std::vector<Points> leaves(const TestMesh& sheet, const std::vector<double>& curls)
{
    std::vector<Points> meshes;
    for (const double curl : curls)
        meshes.push_back(leaf(sheet, curl, static_cast<unsigned>(meshes.size()) + 1));
    return meshes;
}

TEST(Handedness, SheetsThatCurlTheOtherWayMayBeMirrorImages)
{
    const TestMesh sheet = test::open_patch(11, 1);
    const Handedness found = compare_handedness(
        sheet.topology, leaves(sheet, {.1, .16, .06, .14, .09, .16, .1, -.09, -.12, .06}));
    EXPECT_EQ(found.mirrored, Indices{});
    EXPECT_EQ(found.bent, (Indices{7, 8}));
    // Those that curl alike and as far to the other side may have curled there as well.
    EXPECT_EQ(compare_handedness(sheet.topology, leaves(sheet, {.2, .2, .2, -.2})).bent,
              Indices{3});
    const std::vector<double> alike{.12, .122, .118, .121, .119, .12};
    std::vector<Points> sides = leaves(sheet, alike);
    sides[4] = mirror_image(sides[4]);
    EXPECT_EQ(compare_handedness(sheet.topology, sides).mirrored, Indices{});
    EXPECT_EQ(compare_handedness(sheet.topology, sides).bent, Indices{4});
}

/// A membrane that domes.
Points dome(const TestMesh& sheet, double height, double noise = 0.0, unsigned seed = 1)
{
    internal::Random random(seed);
    Points points = sheet.points;
    for (auto point : points.rowwise())
        point[2] =
            height * std::exp(-3.0 * point.head<2>().squaredNorm()) + noise * random.normal();
    return points;
}

TEST(Handedness, MembranesThatDomeTheOtherWayMayBeMirrorImagesWhateverTheirStrain)
{
    const TestMesh sheet = test::open_patch(14, 1);
    for (const double largest : {0.1, 0.6, 2.0})
        for (const double noise : {0.0, 0.0002}) {
            std::vector<Points> swinging;
            for (int i = 0; i < 21; ++i)
                swinging.push_back(
                    dome(sheet, largest * (i - 10) / 10.0, noise, static_cast<unsigned>(i)));
            const Handedness found = compare_handedness(sheet.topology, swinging);
            EXPECT_EQ(found.mirrored, Indices{}) << largest;
            EXPECT_GE(found.bent.size(), 8U) << largest;
            const std::vector<Points> few{dome(sheet, largest), dome(sheet, 0.7 * largest),
                                          dome(sheet, -0.5 * largest)};
            EXPECT_EQ(compare_handedness(sheet.topology, few).bent, Indices{2}) << largest;
        }
}

TEST(Handedness, CapsThatSnapThroughEvenlyAreNoMirrorImages)
{
    const TestMesh sheet = test::open_patch(14, 1);
    for (const double height : {0.3, 0.6, 2.0, 4.0})
        for (const std::size_t count : {2U, 4U, 7U, 12U}) {
            std::vector<Points> caps;
            for (std::size_t i = 0; i < count; ++i)
                caps.push_back(dome(sheet, height * (1.0 + 0.01 * static_cast<double>(i % 3))));
            caps[1] = dome(sheet, -height);
            const Handedness found = compare_handedness(sheet.topology, caps);
            EXPECT_EQ(found.mirrored, Indices{}) << height << " " << count;
            EXPECT_EQ(found.bent.size(), 1U) << height << " " << count;
        }
    // Noise that gives a fine cap any amount of curvature says nothing else.
    const TestMesh fine = test::open_patch(40, 1);
    std::vector<Points> noisy;
    for (unsigned i = 0; i < 8; ++i)
        noisy.push_back(dome(fine, i == 3 ? -2.0 : 2.0, 0.002, i));
    EXPECT_EQ(compare_handedness(fine.topology, noisy).bent, Indices{3});
}

/// A surface of many bumps, without a symmetry, over a bent rim.
Points landscape(const TestMesh& sheet, double middle, double rim)
{
    Points points = sheet.points;
    for (auto point : points.rowwise()) {
        const double x = point[0];
        const double y = point[1];
        const double edge = std::max(std::abs(x), std::abs(y));
        const double share = edge < 0.8 ? 1.0 : (1.0 - edge) / 0.2;
        point[2] = rim * 0.4 * (x * y + x) +
                   middle * share * 0.25 * std::sin(6.0 * x + y) * std::cos(7.0 * y - x);
    }
    return points;
}

TEST(Handedness, SurfacesOfMuchCurvatureAreMirrorImagesUnlessTheirRimStayed)
{
    const TestMesh sheet = test::open_patch(48, 1);
    std::vector<Points> meshes;
    for (int i = 0; i < 6; ++i)
        meshes.push_back(landscape(sheet, 1.0 + 0.05 * i, 1.0 + 0.1 * i));
    meshes[4] = mirror_image(meshes[4]);
    EXPECT_EQ(compare_handedness(sheet.topology, meshes).mirrored, Indices{4});
    meshes[4] = landscape(sheet, -1.0, 1.0); // pushed through within the rim
    EXPECT_EQ(compare_handedness(sheet.topology, meshes).mirrored, Indices{});
    EXPECT_EQ(compare_handedness(sheet.topology, meshes).bent, Indices{4});
}

TEST(Handedness, VolumesTellOfOpenMeshesThatHaveAnInsideHoweverMuchTheyVary)
{
    std::vector<Points> boxes;
    for (const double height : {3.0, 5.0, 9.0, 4.0, 6.0, 12.0}) {
        boxes.push_back(box().points);
        boxes.back().col(2) *= 2.0 * height;
    }
    boxes[3] = mirror_image(boxes[3]);
    EXPECT_EQ(compare_handedness(box().topology, boxes).mirrored, Indices{3});
    EXPECT_EQ(compare_handedness(box().topology, boxes).bent, Indices{});
    for (Points& points : boxes) // now bags that may have been pulled inside out
        points.col(2) *= 0.25;
    EXPECT_EQ(compare_handedness(box().topology, boxes).mirrored, Indices{});
    EXPECT_EQ(compare_handedness(box().topology, boxes).bent, Indices{3});
}

TEST(Handedness, SheetsBendOverAndTubesBowlsAndClosedSurfacesDoNot)
{
    const TestMesh sheet = test::open_patch(11, 1);
    EXPECT_TRUE(may_bend_over(sheet.topology, leaf(sheet, 0.3, 1)));
    EXPECT_FALSE(may_bend_over(sheet.topology, sheet.points));
    Points rolled = sheet.points; // far from flat, but it unrolls
    rolled.col(2) = (2.0 * sheet.points.col(0)).array().sin();
    rolled.col(0) = (2.0 * sheet.points.col(0)).array().cos();
    EXPECT_TRUE(may_bend_over(sheet.topology, rolled));
    EXPECT_TRUE(may_bend_over(strip({0.2, 1.0}).topology, strip({0.2, 1.0}).points));
    const TestMesh tube = test::open_cylinder(40, 20);
    EXPECT_FALSE(may_bend_over(tube.topology, tube.points));
    Points ring = tube.points; // the same between two circles of a plane
    for (auto point : ring.rowwise())
        point.head(2) *= 1.0 + point[2];
    ring.col(2).setZero();
    EXPECT_TRUE(may_bend_over(tube.topology, ring));
    EXPECT_FALSE(may_bend_over(box().topology, box().points));
    EXPECT_FALSE(may_bend_over(test::tetrahedron().topology, test::tetrahedron().points));
    EXPECT_THROW((void)may_bend_over(sheet.topology, Points::Ones(3, 3)), InvalidInput);
}

TEST(Handedness, IsComparedWithMeanAnglesWhereTheyAreGiven)
{
    const TestMesh patch = test::open_patch(10, 1);
    const Eigen::VectorXd mean =
        0.5 * (dihedral_angles(patch.topology, patch.points) +
               dihedral_angles(patch.topology, test::open_patch(10, 2).points));
    Points flat = patch.points;
    flat.col(2).setZero();
    const Points other = test::open_patch(10, 3).points;
    EXPECT_FALSE(is_mirror_image(patch.topology, mirror_image(other), flat));
    EXPECT_TRUE(is_mirror_image(patch.topology, mirror_image(other), flat, mean));
    EXPECT_FALSE(is_mirror_image(patch.topology, other, flat, mean));
    EXPECT_FALSE(is_mirror_image(patch.topology, mirror_image(other), flat, 0.0 * mean));
    // Volumes tell of closed ones, whatever the angles are.
    const TestMesh sphere = test::bumpy_sphere(2, 0.3, 1);
    EXPECT_FALSE(is_mirror_image(sphere.topology, sphere.points, sphere.points,
                                 -dihedral_angles(sphere.topology, sphere.points)));
    EXPECT_THROW((void)is_mirror_image(patch.topology, other, flat, mean.head(3)), InvalidInput);
    EXPECT_THROW((void)is_mirror_image(patch.topology, Points::Ones(3, 3), flat, mean),
                 InvalidInput);
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
