// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "libshape/edge_space/procrustes.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/model_file.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/tools/program.h"

namespace shape::test {
namespace {

using Json = nlohmann::json;
using Arguments = std::vector<std::string>;

Arguments operator+(Arguments a, const Arguments& b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// A folder with three meshes, where every run must succeed.
class Spaces : public testing::Test
{
protected:
    Spaces() { write_bumpy_spheres(folder_); }

    /// Runs and returns the JSON on stdout; stderr stays empty.
    [[nodiscard]] Json run(const Arguments& arguments) const
    {
        const Outcome outcome = run_shape(folder_.path(), arguments + Arguments{"--json"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        return outcome.exit_code == 0 ? Json::parse(outcome.out) : Json();
    }
    [[nodiscard]] Points points(const std::string& file) const
    {
        return read_mesh(folder_ / file).points;
    }

    const Folder folder_;
};

TEST_F(Spaces, AProcrustesModelGivesItsMeshesBackWithoutEmbedding)
{
    const Json figures =
        run({"stats", "a.ply", "b.ply", "c.ply", "-o", "m.h5", "--space", "procrustes"});
    EXPECT_EQ(figures["space"], "procrustes");
    EXPECT_EQ(figures["scale"], "unit");
    EXPECT_EQ(run({"info", "m.h5"})["space"], "procrustes");
    (void)run({"project", "m.h5", "a.ply", "b.ply", "c.ply", "-o", "s.csv"});
    const Json made = run({"generate", "m.h5", "--scores-file", "s.csv", "-o", "again"});
    for (const char* mesh : {"a.ply", "b.ply", "c.ply"}) {
        const Points before = points(mesh);
        const Points after = points(std::string("again/") + mesh);
        const Points centred = before.rowwise() - before.colwise().mean();
        EXPECT_LT((aligned_with(centred, after, Scale::None) - centred).norm(),
                  1e-9 * centred.norm());
    }
    EXPECT_EQ(made["embeddings"][0]["method"], "procrustes");
    EXPECT_EQ(made["embeddings"][0]["status"], "exact");
    EXPECT_EQ(made["embeddings"][0]["edge_max"], 0.0);
}

TEST_F(Spaces, AProcrustesModelMakesMeshesOfTheSizeAskedFor)
{
    (void)run({"stats", "a.ply", "b.ply", "c.ply", "-o", "m.h5", "--space", "procrustes"});
    (void)run({"generate", "m.h5", "--mean", "-o", "one.ply", "--size", "1"});
    (void)run({"generate", "m.h5", "--mean", "-o", "three.ply", "--size", "3"});
    EXPECT_LT((3.0 * points("one.ply") - points("three.ply")).norm(), 1e-12);
    EXPECT_NEAR(centroid_size(points("one.ply")), 1.0, 0.05); // the mean of unit meshes is smaller
}

TEST_F(Spaces, EveryChoiceOfCoordinatesComesBackFromItsScores)
{
    const std::vector<Arguments> choices = {{"--coordinates", "squared"},
                                            {"--coordinates", "log", "--area-weighted"},
                                            {"--with-dihedrals", "0.3"},
                                            {"--area-weighted", "--scale", "none"}};
    for (const Arguments& choice : choices) {
        SCOPED_TRACE(choice.front());
        const Json figures =
            run(Arguments{"stats", "a.ply", "b.ply", "c.ply", "--force", "-o", "m.h5"} + choice);
        EXPECT_EQ(figures["space"], "edge");
        (void)run({"project", "m.h5", "a.ply", "b.ply", "-o", "s.csv", "--force"});
        const Json made = run({"generate", "m.h5", "--scores-file", "s.csv", "-o", "n", "--force"});
        for (const Json& embedding : made["embeddings"])
            EXPECT_EQ(embedding["status"], "exact");
        const NamedMesh before = read_mesh(folder_ / "b.ply");
        const Topology topology(before.faces, static_cast<int>(before.points.rows()));
        const Eigen::VectorXd lengths = edge_lengths(topology, before.points);
        EXPECT_LT((edge_lengths(topology, points("n/b.ply")) - lengths).norm(),
                  1e-6 * lengths.norm());
    }
    EXPECT_EQ(run({"info", "m.h5"})["area_weighted"], true);
}

} // namespace
} // namespace shape::test
