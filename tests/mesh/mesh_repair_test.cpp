// SPDX-License-Identifier: MIT

#include "libshape/mesh/mesh_repair.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/seams.h"

namespace shape {
using namespace internal;
namespace {

using test::TestMesh;

TestMesh sphere(unsigned seed)
{
    return test::bumpy_sphere(2, 0.1, seed);
}

NamedMesh named(const std::string& name, const Points& points, const Faces& faces)
{
    return {name, name + ".ply", points, faces};
}

std::vector<NamedMesh> spheres(int count)
{
    std::vector<NamedMesh> meshes;
    for (int i = 0; i < count; ++i) {
        const TestMesh mesh = sphere(static_cast<unsigned>(i));
        meshes.push_back(
            named(std::string(1, static_cast<char>('a' + i)), mesh.points, mesh.topology.faces()));
    }
    return meshes;
}

/// What was made is the sound meshes, after one change.
void expect_repaired(const RepairedMeshes& repaired, const std::string& change)
{
    ASSERT_EQ(repaired.changes.size(), 1U) << repaired.changes.size();
    EXPECT_NE(repaired.changes[0].find(change), std::string::npos) << repaired.changes[0];
    const std::vector<NamedMesh> sound = spheres(static_cast<int>(repaired.meshes.size()));
    for (std::size_t i = 0; i < sound.size(); ++i) {
        SCOPED_TRACE(sound[i].name);
        EXPECT_EQ(repaired.meshes[i].name, sound[i].name);
        EXPECT_EQ(repaired.meshes[i].faces, sound[i].faces);
        ASSERT_EQ(repaired.meshes[i].points.rows(), sound[i].points.rows());
        EXPECT_TRUE(repaired.meshes[i].points.isApprox(sound[i].points, 1e-12));
    }
}

TEST(MeshRepair, LeavesSoundMeshesAsTheyAre)
{
    const RepairedMeshes repaired = repair_meshes(spheres(5));
    EXPECT_TRUE(repaired.changes.empty());
    EXPECT_EQ(repaired.meshes.size(), 5U);
    EXPECT_EQ(repaired.meshes[3].points, spheres(5)[3].points);
    EXPECT_TRUE(repair_meshes({}).meshes.empty());
}

/// Spheres with a seam along the equator.
std::vector<NamedMesh> cut_spheres(int count, const test::CutMesh& cut)
{
    std::vector<NamedMesh> meshes = spheres(count);
    for (NamedMesh& mesh : meshes) {
        mesh.points = cut.points(mesh.points);
        mesh.faces = cut.faces;
    }
    return meshes;
}

TEST(MeshRepair, WeldsSeamsAlikeInAllMeshes)
{
    const test::CutMesh cut = test::cut_along_the_equator(sphere(0));
    std::vector<NamedMesh> meshes = cut_spheres(5, cut);
    std::vector<NamedMesh> apart = meshes;
    expect_repaired(repair_meshes(std::move(meshes)), "vertices welded");
    apart[2].points.bottomRows(cut.doubled(sphere(0).points)) *= 1.01; // open in one: meant
    EXPECT_TRUE(repair_meshes(std::move(apart)).changes.empty());
}

TEST(MeshRepair, WeldsSoupsOfSingleTriangles)
{
    std::vector<NamedMesh> meshes = spheres(2);
    for (NamedMesh& mesh : meshes) {
        Points points(3 * mesh.faces.rows(), 3);
        Faces faces(mesh.faces.rows(), 3);
        for (Eigen::Index f = 0; f < faces.rows(); ++f)
            for (int c = 0; c < 3; ++c) {
                points.row(3 * f + c) = mesh.points.row(mesh.faces(f, c));
                faces(f, c) = static_cast<int>(3 * f) + c;
            }
        mesh.points = points;
        mesh.faces = faces;
    }
    const RepairedMeshes repaired = repair_meshes(std::move(meshes));
    const Collection collection = collect(repaired.meshes);
    EXPECT_EQ(collection.topology.vertex_count(), sphere(0).topology.vertex_count());
    EXPECT_TRUE(collection.topology.is_closed());
}

TEST(MeshRepair, KeepsTouchingPartsApartWhereWeldingBreaksTheSurface)
{
    // Two tetrahedra that touch at a corner: as one vertex it would be a bow-tie.
    const TestMesh one = test::tetrahedron();
    Points points(8, 3);
    points << one.points, -one.points;
    points.bottomRows(4).rowwise() += one.points.row(0) * 2.0;
    Faces faces(8, 3);
    faces << one.topology.faces(), test::reversed_faces(one.topology.faces()).array() + 4;
    const RepairedMeshes repaired =
        repair_meshes({named("a", points, faces)}, {.components = Components::Split});
    ASSERT_EQ(repaired.meshes.size(), 2U);
    EXPECT_EQ(repaired.meshes[0].name, "a_part1");
    EXPECT_EQ(repaired.meshes[0].points, one.points);
    EXPECT_EQ(repaired.meshes[1].faces.rows(), 4);
    EXPECT_NE(repaired.changes[0].find("split into 2 pieces"), std::string::npos);
}

TEST(MeshRepair, SplitsAThousandPiecesAtMost)
{
    const auto pieces = [](int count) {
        Points points(3 * count, 3);
        Faces faces(count, 3);
        for (int k = 0; k < count; ++k) {
            points.middleRows(3 * k, 3) << 2 * k, 0, 0, 2 * k + 1, 0, 0, 2 * k, 1, 0;
            faces.row(k) << 3 * k, 3 * k + 1, 3 * k + 2;
        }
        return std::vector<NamedMesh>{named("crumbs", points, faces)};
    };
    const MeshRepairOptions split{.components = Components::Split};
    EXPECT_EQ(repair_meshes(pieces(20), split).meshes.size(), 20U);
    try {
        (void)repair_meshes(pieces(1001), split);
        FAIL() << "nothing was thrown";
    } catch (const LimitExceeded& error) {
        EXPECT_STREQ(error.what(), "crumbs: the surface has 1001 pieces; at most 1000 are split");
    }
    EXPECT_EQ(repair_meshes(pieces(1001)).meshes.front().faces.rows(), 1);
}

TEST(MeshRepair, KeepsTheLargerOfPiecesWithEquallyManyFaces)
{
    Points points(6, 3);
    points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 5, 3, 0, 5, 0, 3, 5;
    Faces faces(2, 3);
    for (const bool large_first : {false, true}) {
        faces << 0, 1, 2, 3, 4, 5;
        if (large_first)
            faces.row(0).swap(faces.row(1));
        const NamedMesh kept = repair_meshes({named("two", points, faces)}).meshes.front();
        ASSERT_EQ(kept.points.rows(), 3);
        EXPECT_EQ(kept.points.col(2), Eigen::Vector3d::Constant(5.0));
    }
}

TEST(MeshRepair, TakesAwayWhatBelongsToNoSurface)
{
    std::vector<NamedMesh> loose = spheres(3);
    for (NamedMesh& mesh : loose) {
        mesh.points.conservativeResize(mesh.points.rows() + 2, 3);
        mesh.points.bottomRows(2).setConstant(9.0);
        mesh.points(mesh.points.rows() - 1, 0) = 8.0;
    }
    expect_repaired(repair_meshes(std::move(loose)), "2 vertices without a face");

    std::vector<NamedMesh> crumbs = spheres(3);
    for (NamedMesh& mesh : crumbs) {
        const auto first = static_cast<int>(mesh.points.rows());
        mesh.points.conservativeResize(first + 3, 3);
        mesh.points.bottomRows(3) = 7.0 * Eigen::Matrix3d::Identity();
        mesh.faces.conservativeResize(mesh.faces.rows() + 1, 3);
        mesh.faces.bottomRows(1) << first, first + 1, first + 2;
    }
    expect_repaired(repair_meshes(std::move(crumbs)), "largest of 2 pieces (320 of 321 faces)");

    std::vector<NamedMesh> repeated = spheres(3);
    for (NamedMesh& mesh : repeated) {
        mesh.faces.conservativeResize(mesh.faces.rows() + 2, 3);
        mesh.faces.bottomRows(2) << 4, 4, 5, mesh.faces(0, 2), mesh.faces(0, 1), mesh.faces(0, 0);
    }
    expect_repaired(repair_meshes(std::move(repeated)), "2 faces taken away");
}

TEST(MeshRepair, TurnsFacesThatDisagree)
{
    std::vector<NamedMesh> meshes = spheres(3);
    for (NamedMesh& mesh : meshes)
        for (const int f : {0, 17, 18, 200})
            std::swap(mesh.faces(f, 1), mesh.faces(f, 2));
    expect_repaired(repair_meshes(std::move(meshes)), "4 faces turned");
}

TEST(MeshRepair, AMeshWhoseFacesWereTurnedGetsThoseOfTheFirst)
{
    std::vector<NamedMesh> meshes = spheres(3);
    std::swap(meshes[1].faces(7, 0), meshes[1].faces(7, 1)); // turned back, it begins elsewhere
    const RepairedMeshes repaired = repair_meshes(std::move(meshes));
    ASSERT_EQ(repaired.changes.size(), 2U);
    EXPECT_EQ(repaired.changes[0], "b: 1 face turned to agree with the others");
    EXPECT_EQ(repaired.changes[1], "b: faces put into the order of a");
    for (const NamedMesh& mesh : repaired.meshes)
        EXPECT_EQ(mesh.faces, spheres(1)[0].faces);
}

TEST(MeshRepair, SaysWhatLiesNearASeamAndStaysApart)
{
    std::vector<NamedMesh> meshes = cut_spheres(2, test::cut_along_the_equator(sphere(0)));
    for (NamedMesh& mesh : meshes)
        mesh.points(mesh.points.rows() - 1, 0) += 3e-7 * bounding_box_diagonal(mesh.points);
    const RepairedMeshes repaired = repair_meshes(std::move(meshes));
    ASSERT_EQ(repaired.changes.size(), 1U);
    EXPECT_NE(repaired.changes[0].find("; 2 more lie near others"), std::string::npos)
        << repaired.changes[0];
}

TEST(MeshRepair, TurnsMirrorImagesAndSurfacesInsideOut)
{
    std::vector<NamedMesh> mirrored = spheres(5);
    mirrored[1].points = test::mirror_image(mirrored[1].points);
    expect_repaired(repair_meshes(std::move(mirrored)), "b: x taken times -1");

    std::vector<NamedMesh> inside_out = spheres(5);
    for (NamedMesh& mesh : inside_out)
        mesh.faces = test::reversed_faces(mesh.faces);
    expect_repaired(repair_meshes(std::move(inside_out)), "faces reversed (inside out)");

    std::vector<NamedMesh> one_reversed = spheres(5);
    one_reversed[2].faces = test::reversed_faces(one_reversed[2].faces);
    expect_repaired(repair_meshes(std::move(one_reversed)),
                    "c: faces reversed (it was inside out)");

    std::vector<NamedMesh> sound_mirror_image = spheres(5);
    sound_mirror_image[3].faces = test::reversed_faces(sound_mirror_image[3].faces);
    sound_mirror_image[3].points = test::mirror_image(sound_mirror_image[3].points);
    expect_repaired(repair_meshes(std::move(sound_mirror_image)), "it was a mirror image");

    std::vector<NamedMesh> shuffled = spheres(5);
    shuffled[4].faces = shuffled[4].faces.colwise().reverse().eval();
    expect_repaired(repair_meshes(std::move(shuffled)), "e: faces put into the order of a");
}

TEST(MeshRepair, ScalesByRatiosOfUnitsAlone)
{
    std::vector<NamedMesh> meshes = spheres(9);
    meshes[0].points *= 1e-3;
    meshes[3].points *= 10.0;
    const RepairedMeshes repaired = repair_meshes(std::move(meshes));
    EXPECT_EQ(repaired.changes.size(), 2U);
    EXPECT_TRUE(repaired.kept.empty());
    for (int i : {0, 3})
        EXPECT_TRUE(
            repaired.meshes[to_size(i)].points.isApprox(spheres(9)[to_size(i)].points, 1e-12));
    std::vector<NamedMesh> odd = spheres(5);
    odd[1].points *= 6.0;
    const RepairedMeshes kept = repair_meshes(std::move(odd));
    EXPECT_TRUE(kept.changes.empty());
    ASSERT_EQ(kept.kept.size(), 1U);
    EXPECT_NE(kept.kept[0].find("that is the ratio of no two units"), std::string::npos)
        << kept.kept[0];
}

TEST(MeshRepair, LeavesSizesOfWhichTheUnitsAreInDoubt)
{
    // Sizes that vary as those of bones do: one mesh, 12 times larger, may be in millimetres or in inches.
    const std::vector<double> scales{1.0, 1.1, 0.9, 1.05, 0.93, 1.12, 0.88, 1.02, 0.97};
    const auto repaired_by = [&](double factor, std::size_t count) {
        std::vector<NamedMesh> meshes = spheres(9);
        for (std::size_t i = 0; i < meshes.size(); ++i)
            meshes[i].points *= scales[i] * (i < count ? factor : 1.0);
        return repair_meshes(std::move(meshes));
    };
    for (const double factor : {11.0, 12.0}) {
        const RepairedMeshes doubtful = repaired_by(factor, 1);
        EXPECT_TRUE(doubtful.changes.empty()) << factor;
        ASSERT_EQ(doubtful.kept.size(), 1U);
        EXPECT_NE(doubtful.kept[0].find("millimetres and centimetres (10)"), std::string::npos)
            << doubtful.kept[0];
        EXPECT_NE(doubtful.kept[0].find("inches and feet (12)"), std::string::npos)
            << doubtful.kept[0];
        EXPECT_NEAR(doubtful.meshes[0].points.norm(), factor * spheres(9)[0].points.norm(), 1e-9);
    }
    const RepairedMeshes plain = repaired_by(1000.0, 2);
    ASSERT_EQ(plain.changes.size(), 1U);
    EXPECT_TRUE(plain.kept.empty());
    EXPECT_NEAR(plain.meshes[0].points.norm(), spheres(9)[0].points.norm(), 1e-9);
}

TEST(MeshRepair, LeavesMoebiusStripsAndThreeFacesAtAnEdge)
{
    Faces strip(10, 3);
    Points points(10, 3);
    for (int i = 0; i < 5; ++i) {
        const double angle = 0.4 * 3.14159265358979 * i;
        const Eigen::RowVector3d radial(std::cos(angle), std::sin(angle), 0.0);
        const Eigen::RowVector3d across =
            std::cos(angle / 2) * radial + std::sin(angle / 2) * Eigen::RowVector3d::UnitZ();
        points.row(2 * i) = 3.0 * radial - across;
        points.row(2 * i + 1) = 3.0 * radial + across;
        const int a = 2 * i;
        const int b = 2 * i + 1;
        const int c = i < 4 ? a + 2 : 1;
        const int d = i < 4 ? b + 2 : 0;
        strip.row(2 * i) << a, c, b;
        strip.row(2 * i + 1) << b, c, d;
    }
    ASSERT_FALSE(find_defects(strip, 10).empty());
    const RepairedMeshes repaired = repair_meshes({named("a", points, strip)});
    EXPECT_TRUE(repaired.changes.empty());
    EXPECT_EQ(repaired.meshes[0].faces, strip);

    const Points fan = (Points(5, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, -1).finished();
    const Faces three = (Faces(3, 3) << 0, 1, 2, 1, 0, 3, 0, 1, 4).finished();
    EXPECT_TRUE(repair_meshes({named("a", fan, three)}).changes.empty());
}

} // namespace
} // namespace shape
