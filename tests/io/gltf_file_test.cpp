// SPDX-License-Identifier: MIT

#include "libshape/io/gltf_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/io/mesh_file.h"
#include "tests/support/files.h"
#include "tests/support/glb.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using test::Glb;
using test::TemporaryDirectory;
using test::TestMesh;

constexpr double single_precision = 1.2e-7; // 2^-23, of what is stored

/// The mesh swinging about: frame k is twisted by an angle that changes its course.
std::vector<Points> swinging(const Points& points, int count)
{
    std::vector<Points> frames;
    for (int k = 0; k < count; ++k) {
        const double twist = 0.4 * std::sin(0.1 * k);
        Points& frame = frames.emplace_back(points);
        for (auto row : frame.rowwise()) {
            const double angle = twist * row.z();
            row.head<2>() << std::cos(angle) * row.x() - std::sin(angle) * row.y(),
                std::sin(angle) * row.x() + std::cos(angle) * row.y();
        }
    }
    return frames;
}

void write_glb(const std::filesystem::path& path, const TestMesh& mesh)
{
    write_mesh(path, mesh.points, mesh.topology.faces(), MeshFormat::Glb);
}

TEST(GltfFile, AMeshComesBackInSinglePrecisionWithItsBounds)
{
    const TemporaryDirectory directory;
    for (const TestMesh& mesh : test::sample_meshes()) {
        write_glb(directory / "mesh.glb", mesh);
        const Glb glb(directory / "mesh.glb");
        EXPECT_EQ(glb.faces(), mesh.topology.faces()) << mesh.name;
        EXPECT_LE((glb.positions() - mesh.points).cwiseAbs().maxCoeff(),
                  single_precision * bounding_box_diagonal(mesh.points));
        const std::size_t accessor = glb.primitive().at("attributes").at("POSITION");
        const auto& bounds = glb.description().at("accessors").at(accessor);
        const Eigen::MatrixXd stored = glb.numbers(accessor);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(bounds.at("min").at(to_size(axis)), stored.col(axis).minCoeff());
            EXPECT_EQ(bounds.at("max").at(to_size(axis)), stored.col(axis).maxCoeff());
        }
    }
}

TEST(GltfFile, AMeshFarFromTheOriginLosesNoPrecision)
{
    const TemporaryDirectory directory;
    TestMesh mesh = test::bumpy_sphere(2, 0.2, 1);
    mesh.points.rowwise() += Eigen::RowVector3d(1e7, -2e7, 3e6);
    write_glb(directory / "mesh.glb", mesh);
    EXPECT_LE((Glb(directory / "mesh.glb").positions() - mesh.points).cwiseAbs().maxCoeff(),
              single_precision * bounding_box_diagonal(mesh.points));
}

TEST(GltfFile, NormalsPointOutAndHaveLengthOne)
{
    const TemporaryDirectory directory;
    const TestMesh sphere = test::icosphere(3);
    write_glb(directory / "sphere.glb", sphere);
    const Points normals = Glb(directory / "sphere.glb").normals();
    EXPECT_LE((normals.rowwise().norm().array() - 1.0).abs().maxCoeff(), 1e-6);
    EXPECT_GE(normals.cwiseProduct(sphere.points).rowwise().sum().minCoeff(), 0.999);
}

TEST(GltfFile, AVertexWithoutAnAreaHasANormalAllTheSame)
{
    const TemporaryDirectory directory;
    const Faces faces{{0, 1, 2}};
    write_mesh(directory / "line.glb", Points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, faces,
               MeshFormat::Glb);
    const Points normals = Glb(directory / "line.glb").normals();
    EXPECT_EQ(normals.rowwise().norm(), Eigen::Vector3d::Ones());
}

TEST(GltfFile, OnlyAMeshWithABoundaryShowsBothSides)
{
    const TemporaryDirectory directory;
    for (const TestMesh& mesh : test::sample_meshes()) {
        write_glb(directory / "mesh.glb", mesh);
        bool is_open = false;
        for (int e = 0; e < mesh.topology.edge_count(); ++e)
            is_open = is_open || mesh.topology.is_boundary_edge(e);
        const auto description = Glb(directory / "mesh.glb").description();
        EXPECT_EQ(description.at("materials").at(0).at("doubleSided"), is_open) << mesh.name;
    }
}

TEST(GltfFile, AnAnimationShowsEveryFrameWithinTheErrorThatItStates)
{
    const TemporaryDirectory directory;
    const TestMesh mesh = test::open_patch(8, 1);
    const std::vector<Points> frames = swinging(mesh.points, 40);
    const double diagonal = bounding_box_diagonal(frames.front());
    std::size_t before = 41;
    for (const double tolerance : {1e-9, 1e-3, 5e-3}) {
        const GlbAnimation animation =
            write_glb_animation(directory / "swing.glb", frames, mesh.topology.faces(),
                                {.tolerance = tolerance, .frames_per_second = 8.0});
        EXPECT_EQ(animation.seconds, 39.0 / 8.0);
        EXPECT_LE(animation.error, tolerance);
        EXPECT_LT(animation.keyframes.size(), before);
        before = animation.keyframes.size();
        const Glb glb(directory / "swing.glb");
        double worst = 0.0;
        for (std::size_t k = 0; k < frames.size(); ++k) {
            const Points shown = glb.positions(static_cast<double>(k) / 8.0);
            worst = std::max(worst, (shown - frames[k]).cwiseAbs().maxCoeff() / diagonal);
        }
        EXPECT_NEAR(worst, animation.error, 4.0 * single_precision);
    }
}

TEST(GltfFile, AnAnimationMorphsItsNormals)
{
    const TemporaryDirectory directory;
    const TestMesh mesh = test::bumpy_sphere(2, 0.3, 1);
    const std::vector<Points> frames = swinging(mesh.points, 4);
    const Faces& faces = mesh.topology.faces();
    (void)write_glb_animation(directory / "all.glb", frames, faces,
                              {.tolerance = 0.0, .frames_per_second = 1.0});
    const Glb all(directory / "all.glb");
    for (std::size_t k = 0; k < frames.size(); ++k) {
        write_mesh(directory / "one.glb", frames[k], faces, MeshFormat::Glb);
        EXPECT_LE((all.normals(static_cast<double>(k)) - Glb(directory / "one.glb").normals())
                      .cwiseAbs()
                      .maxCoeff(),
                  4.0 * single_precision);
    }
}

TEST(GltfFile, AStillSequenceIsAnAnimationToo)
{
    const TemporaryDirectory directory;
    const TestMesh mesh = test::tetrahedron();
    const GlbAnimation animation = write_glb_animation(directory / "still.glb", {3, mesh.points},
                                                       mesh.topology.faces(), {.tolerance = 0.0});
    EXPECT_EQ(animation.keyframes, (std::vector<std::size_t>{0, 2}));
    EXPECT_EQ(animation.error, 0.0);
}

TEST(GltfFile, SameFramesSameBytes)
{
    const TemporaryDirectory directory;
    const TestMesh mesh = test::torus(12, 8);
    for (const char* name : {"a.glb", "b.glb"})
        (void)write_glb_animation(directory / name, swinging(mesh.points, 10),
                                  mesh.topology.faces());
    EXPECT_EQ(test::read_bytes(directory / "a.glb"), test::read_bytes(directory / "b.glb"));
}

TEST(GltfFile, TheKhronosValidatorFindsNothing)
{
    if (!test::has_gltf_validator())
        GTEST_SKIP() << "node or its package gltf-validator is missing";
    const TemporaryDirectory directory;
    for (const TestMesh& mesh : test::sample_meshes()) {
        write_glb(directory / "mesh.glb", mesh);
        EXPECT_EQ(test::gltf_issues(directory / "mesh.glb"), "") << mesh.name;
        (void)write_glb_animation(directory / "animation.glb", swinging(mesh.points, 12),
                                  mesh.topology.faces());
        EXPECT_EQ(test::gltf_issues(directory / "animation.glb"), "") << mesh.name;
    }
    // The validator itself: a changed word of the description is found.
    std::string bytes = test::read_bytes(directory / "mesh.glb");
    bytes.replace(bytes.find("VEC3"), 4, "VEC2");
    test::write_bytes(directory / "bad.glb", bytes);
    EXPECT_NE(test::gltf_issues(directory / "bad.glb"), "");
}

TEST(GltfFile, OfSeveralMeshesIsACollection)
{
    const TemporaryDirectory directory;
    const TestMesh mesh = test::icosphere(1);
    const std::vector<Points> frames = swinging(mesh.points, 5);
    const GlbAnimation written = write_glb_animation(directory / "swing.glb", frames,
                                                     mesh.topology.faces(), {.tolerance = 0.0});
    const MeshFileContent read = read_mesh_members(directory / "swing.glb");
    EXPECT_TRUE(read.single_precision);
    ASSERT_EQ(read.meshes.size(), written.keyframes.size());
    EXPECT_EQ(read.meshes[0].name, "swing");
    EXPECT_EQ(read.meshes[1].name, "swing_frame " + std::to_string(written.keyframes[1]));
    for (std::size_t k = 0; k < read.meshes.size(); ++k) {
        EXPECT_EQ(read.meshes[k].faces, mesh.topology.faces());
        EXPECT_LE((read.meshes[k].points - frames[written.keyframes[k]]).cwiseAbs().maxCoeff(),
                  2e-7 * bounding_box_diagonal(mesh.points));
    }
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)read_mesh(directory / "swing.glb");
              }).find("one is wanted"),
              std::string::npos);
}

TEST(GltfFile, RefusesWhatIsNotAnAnimation)
{
    const TemporaryDirectory directory;
    const TestMesh mesh = test::tetrahedron();
    const Faces& faces = mesh.topology.faces();
    const auto message = [&](const std::vector<Points>& frames, const Faces& corners,
                             const GlbAnimationOptions& options = {}) {
        return test::message_of<InvalidInput>(
            [&] { (void)write_glb_animation(directory / "x.glb", frames, corners, options); });
    };
    const auto expect = [](const std::string& said, const char* word) {
        EXPECT_NE(said.find(word), std::string::npos) << said;
    };
    const std::vector<Points> good{mesh.points, 2.0 * mesh.points};
    expect(message({mesh.points}, faces), "two");
    expect(message(good, faces, {.frames_per_second = 0.0}), "frames_per_second");
    for (const double rate :
         {1e-300, 1e-7, 2e6, 1e300}) // times beyond single precision, or all one
        expect(message(good, faces, {.frames_per_second = rate}), "[1e-6, 1e6]");
    expect(message(good, faces, {.tolerance = -1.0}), "tolerance");
    expect(message({mesh.points, Points::Zero(3, 3)}, faces), "frames[1]");
    expect(message({mesh.points, mesh.points * std::numeric_limits<double>::infinity()}, faces),
           "finite");
    expect(message({mesh.points, mesh.points * 1e60}, faces), "single precision");
    expect(message(good, faces.array() + 1), "faces: row");
    EXPECT_TRUE(directory.names().empty());
    EXPECT_THROW((void)write_glb_animation(directory / "no" / "x.glb", good, faces), FileError);
}

} // namespace
} // namespace shape
