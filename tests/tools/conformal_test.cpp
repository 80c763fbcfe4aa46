// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "libshape/base/to_size.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"
#include "tests/tools/program.h"

namespace shape::test {
using namespace internal;
namespace {

using Json = nlohmann::json;

class Conformal : public testing::Test
{
protected:
    Conformal() { write("head.ply", bumpy_sphere(2, 0.3, 1)); }

    void write(const std::string& file, const TestMesh& mesh) const
    {
        write_mesh(folder_ / file, mesh.points, mesh.topology.faces(), MeshFormat::Ply);
    }

    [[nodiscard]] Eigen::VectorXd lengths(const std::string& file) const
    {
        const NamedMesh mesh = read_mesh(folder_ / file);
        return edge_lengths(Topology(mesh.faces, static_cast<int>(mesh.points.rows())),
                            mesh.points);
    }

    [[nodiscard]] Outcome run(const std::vector<std::string>& arguments) const
    {
        return run_shape(folder_.path(), arguments);
    }

    const Folder folder_;
};

TEST_F(Conformal, WritesTheSphereAndTheFactorsThatLeadToIt)
{
    const Outcome outcome =
        run({"conformal", "head.ply", "-o", "sphere.ply", "--factors", "u.csv", "--json"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    const Json figures = Json::parse(outcome.out);
    EXPECT_EQ(figures["outputs"], Json({"sphere.ply", "u.csv"}));
    EXPECT_EQ(figures["conformal"]["certificate"], "exact");
    EXPECT_EQ(figures["conformal"]["flipped_edges"], 0);
    EXPECT_EQ(figures["conformal"]["kept_share"], 1.0);
    EXPECT_LE(figures["conformal"]["residual"], 1e-10);

    const NamedMesh sphere = read_mesh(folder_ / "sphere.ply");
    const Eigen::RowVector3d centre =
        0.5 * (sphere.points.colwise().maxCoeff() + sphere.points.colwise().minCoeff());
    const double radius = figures["conformal"]["radius"];
    for (Eigen::Index v = 0; v < sphere.points.rows(); ++v)
        EXPECT_NEAR((sphere.points.row(v) - centre).norm(), radius, 0.05 * radius);

    const Table table = read_table(folder_ / "u.csv");
    EXPECT_EQ(table.columns, (std::vector<std::string>{"vertex", "u"}));
    const Topology topology(sphere.faces, static_cast<int>(sphere.points.rows()));
    ASSERT_EQ(table.rows.size(), to_size(topology.vertex_count()));
    const auto u = [&](int v) { return parse_number(table.rows[to_size(v)][1], "u.csv"); };
    const Eigen::VectorXd before = lengths("head.ply");
    const Eigen::VectorXd after = lengths("sphere.ply");
    for (int e = 0; e < topology.edge_count(); ++e)
        EXPECT_NEAR(after[e] / before[e],
                    std::exp(0.5 * (u(topology.edges()(e, 0)) + u(topology.edges()(e, 1)))), 1e-10);
}

TEST_F(Conformal, MorphsFromTheMeshToTheSphere)
{
    ASSERT_EQ(run({"conformal", "head.ply", "-o", "sphere.ply"}).exit_code, 0);
    const Outcome outcome = run({"conformal", "head.ply", "-o", "morph", "--steps", "5", "--json"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const Json figures = Json::parse(outcome.out);
    ASSERT_EQ(figures["frames"].size(), 5u);
    EXPECT_EQ(figures["frames"][2]["k"], 0.5);
    EXPECT_EQ(figures["frames"][2]["name"], "frame_0002");
    EXPECT_EQ(figures["frames"][2]["corrected_faces"], 0);
    for (const Json& embedding : figures["embeddings"])
        EXPECT_LE(embedding["edge_max"], 5e-3);
    EXPECT_LE((lengths("morph/frame_0000.ply") - lengths("head.ply")).lpNorm<Eigen::Infinity>(),
              1e-12);
    EXPECT_LE((lengths("morph/frame_0004.ply") - lengths("sphere.ply")).lpNorm<Eigen::Infinity>(),
              1e-12);
}

TEST_F(Conformal, FollowsAPathThatEndsAtTheSphere)
{
    TestMesh egg = icosphere(2);
    egg.points.col(0) *= 1.5;
    write("egg.ply", egg);
    const auto gap = [&](const std::string& mesh) -> double {
        return Json::parse(
            run({"conformal", mesh + ".ply", "-o", mesh, "--steps", "2", "--end-gap", "--json"})
                .out)["end_gap"];
    };
    EXPECT_LE(gap("egg"), 1e-3);
    EXPECT_LE(gap("head"), 1e-3); // its dents turn over on the way
}

TEST_F(Conformal, WalksToTheEndOnRequestAlone)
{
    const Outcome frames = run({"conformal", "head.ply", "-o", "frames", "--steps", "3", "--json"});
    EXPECT_FALSE(Json::parse(frames.out).contains("end_gap"));
    EXPECT_EQ(run({"conformal", "head.ply", "-o", "sphere.ply", "--end-gap"}).exit_code, 2);
    EXPECT_EQ(run({"conformal", "head.ply", "-o", "preview", "--steps", "3", "--end-gap",
                   "--quality", "preview"})
                  .exit_code,
              2);
}

TEST_F(Conformal, AFrameIsTheSameWhateverTheOthersAre)
{
    ASSERT_EQ(run({"conformal", "head.ply", "-o", "three", "--steps", "3"}).exit_code, 0);
    ASSERT_EQ(run({"conformal", "head.ply", "-o", "five", "--steps", "5"}).exit_code, 0);
    EXPECT_EQ(folder_.read("three/frame_0001.ply"), folder_.read("five/frame_0002.ply"));
}

TEST_F(Conformal, MakesTheMorphByAnyMethod)
{
    for (const char* method : {"closure", "multiscale"})
        EXPECT_EQ(run({"conformal", "head.ply", "-o", method, "--steps", "2", "--method", method})
                      .exit_code,
                  0);
}

TEST_F(Conformal, WritesTheFactorsOfACollectionOneRowAMesh)
{
    write("other.ply", bumpy_sphere(2, 0.3, 2));
    ASSERT_EQ(run({"conformal", "other.ply", "-o", "one.ply", "--factors", "one.csv"}).exit_code,
              0);
    const Outcome outcome = run(
        {"conformal", "head.ply", "other.ply", "-o", "spheres", "--factors", "u.csv", "--json"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const Json figures = Json::parse(outcome.out);
    EXPECT_EQ(figures["outputs"], Json({"spheres/head.ply", "spheres/other.ply", "u.csv"}));
    EXPECT_EQ(figures["conformal"][1]["name"], "other");
    EXPECT_EQ(folder_.read("spheres/other.ply"), folder_.read("one.ply"));
    const Table one = read_table(folder_ / "one.csv");
    const Table all = read_table(folder_ / "u.csv");
    ASSERT_EQ(all.rows.size(), 2u);
    ASSERT_EQ(all.columns.size(), 1 + one.rows.size());
    EXPECT_EQ(all.columns[0], "mesh");
    EXPECT_EQ(all.columns[1], "u0");
    EXPECT_EQ(all.rows[1][0], "other");
    for (std::size_t v = 0; v < one.rows.size(); ++v)
        EXPECT_EQ(all.rows[1][v + 1], one.rows[v][1]);
}

TEST_F(Conformal, CheckSaysWhichMeshesQualify)
{
    write("patch.ply", open_patch(4, 1));
    write("torus.ply", torus(9, 16));
    const auto check = [&](const char* mesh) {
        const Outcome outcome = run({"check", mesh});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.out;
    };
    EXPECT_NE(check("head.ply").find("conformal map to the sphere: qualifies"), std::string::npos);
    EXPECT_NE(check("patch.ply").find("close the holes"), std::string::npos);
    EXPECT_NE(check("torus.ply").find("genus 1"), std::string::npos);
    const Json figures = Json::parse(run({"check", "torus.ply", "--json"}).out);
    EXPECT_EQ(figures["meshes"][0]["conformal_sphere"], false);
}

TEST_F(Conformal, RefusesWhatHasNoSphereAndSaysWhatToDo)
{
    write("patch.ply", open_patch(4, 1));
    write("torus.ply", torus(9, 16));
    const auto refusal = [&](const std::vector<std::string>& meshes) {
        std::vector<std::string> arguments{"conformal"};
        arguments.insert(arguments.end(), meshes.begin(), meshes.end());
        arguments.insert(arguments.end(), {"-o", "x.ply", "--steps", "2"});
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.exit_code, 3);
        return outcome.err;
    };
    EXPECT_NE(refusal({"patch.ply"}).find("close the holes"), std::string::npos);
    EXPECT_NE(refusal({"torus.ply"}).find("genus 1"), std::string::npos);
    write("other.ply", bumpy_sphere(2, 0.3, 2));
    EXPECT_NE(refusal({"head.ply", "other.ply"}).find("one mesh, not 2"), std::string::npos);
    folder_.write("two.off",
                  "OFF\n8 8 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n5 0 0\n6 0 0\n5 1 0\n5 0 1\n"
                  "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n3 4 6 5\n3 4 5 7\n3 5 6 7\n3 6 4 7\n");
    EXPECT_NE(refusal({"two.off"}).find("2 components"), std::string::npos);
    folder_.write("fan.off",
                  "OFF\n5 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 -1 0\n3 0 1 2\n3 1 0 3\n3 0 1 4\n");
    EXPECT_NE(refusal({"fan.off"}).find("at most 2"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "x.ply"));
}

} // namespace
} // namespace shape::test
