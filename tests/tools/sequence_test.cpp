// SPDX-License-Identifier: MIT

#include <filesystem>

#include "libshape/io/mesh_file.h"
#include "libshape/io/vertex_scalars.h"
#include "libshape/mesh/alignment.h"
#include "tests/support/data.h"
#include "tests/support/glb.h"
#include "tests/tools/program_test.h"

namespace shape::test {
namespace {

/// What comes beside and out of many meshes: animations, residuals and jumps.
class Sequences : public SilentProgramTest
{
protected:
    [[nodiscard]] double largest(const std::string& file, const std::string& scalar) const
    {
        return read_vertex_scalar(folder_ / file, scalar).maxCoeff();
    }
};

TEST_F(Sequences, OneAnimationShowsWhatTheSeparateMeshesAre)
{
    const Arguments blend{"interpolate", "a.ply", "b.ply", "--frames", "21"};
    const auto to = [&](const Arguments& rest) {
        Arguments all = blend;
        all.insert(all.end(), rest.begin(), rest.end());
        return run(all);
    };
    (void)to({"-o", "frames"});
    const Json figures = to({"-o", "walk.glb", "--fps", "10", "--glb-tolerance", "1e-4"});
    EXPECT_EQ(figures["outputs"], Json({"walk.glb"}));
    EXPECT_EQ(figures["animation"]["frames"], 21);
    EXPECT_EQ(figures["animation"]["seconds"], 2.0);
    EXPECT_LT(figures["animation"]["keyframes"].size(), 21U);
    const double error = figures["animation"]["error"];
    EXPECT_LE(error, 1e-4);
    const Glb glb(folder_ / "walk.glb");
    const NamedMesh first = read_mesh(folder_ / "frames/frame_0000.ply");
    EXPECT_EQ(glb.faces(), first.faces);
    const double diagonal = bounding_box_diagonal(first.points);
    double worst = 0.0;
    for (int k = 0; k < 21; ++k) {
        char file[40];
        std::snprintf(file, sizeof file, "frames/frame_%04d.ply", k);
        const Points shown = glb.positions(0.1 * k);
        worst = std::max(
            worst, (shown - read_mesh(folder_ / file).points).cwiseAbs().maxCoeff() / diagonal);
    }
    EXPECT_NEAR(worst, error, 1e-6);
}

TEST_F(Sequences, FramesDoNotDependOnWhichPartIsAskedFor)
{
    const auto frames = [&](const std::string& to, const Arguments& rest) {
        Arguments all{"interpolate", "a.ply", "b.ply", "-o", to};
        all.insert(all.end(), rest.begin(), rest.end());
        EXPECT_EQ(run(all)["jumps"], Json::array());
    };
    frames("whole", {"--frames", "61"});
    frames("part", {"--frames", "31", "--range", "0.25:0.75"});
    for (const int k : {0, 7, 15, 30}) {
        char part[40];
        char whole[40];
        std::snprintf(part, sizeof part, "part/frame_%04d.ply", k);
        std::snprintf(whole, sizeof whole, "whole/frame_%04d.ply", k + 15);
        const Points a = read_mesh(folder_ / part).points;
        const Points b = read_mesh(folder_ / whole).points;
        const double worst = (best_rigid_motion(a, b)(a) - b).cwiseAbs().maxCoeff();
        EXPECT_LT(worst, 1e-6 * bounding_box_diagonal(b));
    }
}

TEST_F(Sequences, AModeIsAnAnimationToo)
{
    (void)run({"stats", "a.ply", "b.ply", "c.ply", "-o", "model.h5"});
    const Json figures =
        run({"generate", "model.h5", "--mode", "1", "--sigma", "-1:1:9", "-o", "mode.glb"});
    EXPECT_EQ(figures["animation"]["frames"], 9);
    EXPECT_EQ(figures["animation"]["seconds"], 8.0 / 25.0);
    EXPECT_EQ(figures["jumps"], Json::array());
    EXPECT_FALSE(run({"generate", "model.h5", "--sample", "3", "-o", "new"}).contains("jumps"));
}

TEST_F(Sequences, AModeGoesThroughTheMeshesOfWholeNumbers)
{
    for (const Arguments& space : std::vector<Arguments>{{}, {"--with-positions", "5"}}) {
        const std::string model = space.empty() ? "model" : "placed";
        (void)run(Arguments{"stats", "a.ply", "b.ply", "c.ply", "-o", model + ".h5"} + space);
        const auto along = [&](const std::string& sigma, const std::string& to) {
            return run({"generate", model + ".h5", "--mode", "1", "--sigma", sigma, "-o", to});
        };
        EXPECT_EQ(along("1.5:-1.5:61", model + "_dense")["jumps"], Json::array());
        (void)along("-1:1:3", model + "_alone");
        for (const char* sigma : {"-1.00", "0.00", "1.00"}) {
            const std::string name = std::string("/mode01_") + sigma + ".ply";
            const Points a = read_mesh(folder_ / (model + "_dense" + name)).points;
            const Points b = read_mesh(folder_ / (model + "_alone" + name)).points;
            EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-6 * bounding_box_diagonal(b)) << sigma;
        }
    }
}

TEST_F(Sequences, PartsAndShardsOfAModeAreThoseOfTheWhole)
{
    (void)run({"stats", "a.ply", "b.ply", "c.ply", "-o", "model.h5"});
    const auto along = [&](const std::string& sigma, const std::string& to, const Arguments& more) {
        (void)run(Arguments{"generate", "model.h5", "--mode", "1", "--sigma", sigma, "-o", to} +
                  more);
    };
    along("-1:1:61", "whole", {});
    along("0.2:0.9:22", "part", {});
    along("-1:1:61", "shared", {"--shard", "1/2"});
    along("-1:1:61", "shared", {"--shard", "2/2"});
    (void)run_shape(folder_.path(), {"merge", "shared"});
    ASSERT_EQ(files_in(folder_ / "shared"), files_in(folder_ / "whole"));
    for (const char* sigma : {"0.20", "0.50", "0.90"}) {
        const std::string name = std::string("/mode01_") + sigma + ".ply";
        const Points a = read_mesh(folder_ / ("whole" + name)).points;
        const Points b = read_mesh(folder_ / ("part" + name)).points;
        EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-6 * bounding_box_diagonal(a)) << sigma;
        EXPECT_EQ(a, read_mesh(folder_ / ("shared" + name)).points) << sigma;
    }
}

TEST_F(Sequences, AModeOfAnArmDoesNotJump)
{
    const std::filesystem::path arms = data_dir() / "mh_arm";
    if (!std::filesystem::exists(arms))
        GTEST_SKIP() << "no data";
    (void)run({"stats", arms.string(), "-o", "model.h5"});
    const auto jumps = [&](const std::string& quality) {
        return json_of(
            run_shape(folder_.path(), {"generate", "model.h5", "--mode", "1", "--sigma", "-1:1:61",
                                       "--quality", quality, "-o", quality, "--json"}))["jumps"];
    };
    EXPECT_GE(jumps("preview").size(), 1U); // frame by frame
    EXPECT_EQ(jumps("fine"), Json::array());
}

TEST_F(Sequences, SeparateMeshesCanBeGlbFiles)
{
    const Json figures =
        run({"interpolate", "a.ply", "b.ply", "--frames", "2", "-o", "frames", "--format", "glb"});
    EXPECT_EQ(files_in(folder_ / "frames"), (Arguments{"frame_0000.glb", "frame_0001.glb"}));
    EXPECT_FALSE(figures.contains("animation"));
    const Glb glb(folder_ / "frames/frame_0001.glb");
    EXPECT_FALSE(glb.description().contains("animations"));
    (void)run({"reconstruct", "--reference", "c.ply", "-o", "c.glb"});
    EXPECT_EQ(Glb(folder_ / "c.glb").faces(), read_mesh(folder_ / "c.ply").faces);
}

TEST_F(Sequences, TheKhronosValidatorFindsNothingInAnAnimation)
{
    if (!has_gltf_validator())
        GTEST_SKIP() << "node or its package gltf-validator is missing";
    (void)run({"interpolate", "a.ply", "b.ply", "--frames", "9", "-o", "walk.glb"});
    EXPECT_EQ(gltf_issues(folder_ / "walk.glb"), "");
}

TEST_F(Sequences, ResidualsLieBesideEveryMeshAndHaveTheFiguresOfTheReport)
{
    const Json figures =
        run({"interpolate", "a.ply", "b.ply", "--frames", "3", "-o", "frames", "--residuals"});
    EXPECT_EQ(files_in(folder_ / "frames"),
              (Arguments{"frame_0000.ply", "frame_0001.ply", "frame_0002.ply", "residuals"}));
    EXPECT_EQ(files_in(folder_ / "frames/residuals"),
              (Arguments{"frame_0000_residuals.ply", "frame_0001_residuals.ply",
                         "frame_0002_residuals.ply"}));
    EXPECT_EQ(run({"collect", "frames", "-o", "frames.h5"})["meshes"], 3);
    EXPECT_EQ(figures["outputs"].size(), 6U);
    EXPECT_EQ(figures["outputs"][3], "frames/residuals/frame_0000_residuals.ply");
    for (std::size_t i = 0; i < 3; ++i) {
        const std::string file = figures["outputs"][3 + i];
        const Json& report = figures["embeddings"][i];
        // Up to the rounding of the motion that places the frame.
        EXPECT_NEAR(largest(file, "edge_error"), report["edge_max"], 1e-13);
        EXPECT_NEAR(largest(file, "dihedral_drift"), report["dihedral_max_deg"], 1e-11);
        EXPECT_EQ(read_mesh(folder_ / file).points,
                  read_mesh(folder_ / std::string(figures["outputs"][i])).points);
    }
}

TEST_F(Sequences, ResidualsLieBesideASingleFileAsWell)
{
    folder_.write("new/mine.txt", "mine");
    for (const std::string place : {"", "new/"}) {
        const Json figures = run({"interpolate", "a.ply", "b.ply", "--weights", "0.5,0.5", "-o",
                                  place + "half.obj", "--residuals"});
        EXPECT_EQ(figures["outputs"].size(), 2U);
        EXPECT_TRUE(folder_.has(place + "half.obj"));
        EXPECT_NEAR(largest(place + "residuals/half_residuals.ply", "edge_error"),
                    figures["embeddings"][0]["edge_max"], 1e-13);
    }
    EXPECT_EQ(files_in(folder_ / "new"), (Arguments{"half.obj", "mine.txt", "residuals"}));
}

TEST_F(Sequences, ResidualsOfTheOtherCommands)
{
    (void)run({"reconstruct", "--reference", "a.ply", "b.ply", "-o", "r.ply", "--residuals"});
    EXPECT_GT(largest("residuals/r_residuals.ply", "edge_error"), 0.0);
    (void)run({"conformal", "a.ply", "--steps", "2", "-o", "morph", "--residuals"});
    EXPECT_TRUE(folder_.has("morph/residuals/frame_0001_residuals.ply"));
    (void)run({"collect", "a.ply", "b.ply", "c.ply", "--labels", "labels.csv", "-o", "f.h5"});
    (void)run({"difference", "f.h5", "--pair-by", "subject", "--from", "mood=calm", "--to",
               "mood=glad", "-o", "d.h5", "--apply", "--mesh", "glad.ply", "--residuals"});
    EXPECT_TRUE(folder_.has("residuals/glad_residuals.ply"));
    (void)run({"stats", "f.h5", "-o", "model.h5"});
    (void)run({"generate", "model.h5", "--mean", "-o", "mean.ply", "--residuals"});
    EXPECT_TRUE(folder_.has("residuals/mean_residuals.ply"));
}

TEST_F(Sequences, ResidualsAreNotOverwritten)
{
    const Arguments blend{"interpolate", "a.ply", "b.ply",  "--weights",
                          "0,1",         "-o",    "b2.ply", "--residuals"};
    folder_.write("residuals/b2_residuals.ply", "old");
    const Outcome refused = run_shape(folder_.path(), blend);
    EXPECT_EQ(refused.exit_code, 5);
    EXPECT_NE(refused.err.find("b2_residuals.ply"), std::string::npos) << refused.err;
    EXPECT_FALSE(folder_.has("b2.ply"));
    Arguments forced = blend;
    forced.emplace_back("--force");
    EXPECT_EQ(run_shape(folder_.path(), forced).exit_code, 0);
    EXPECT_EQ(largest("residuals/b2_residuals.ply", "edge_error") < 1e-6, true);
}

TEST_F(Sequences, ASmoothSequenceHasNoJumps)
{
    const Json figures = run(
        {"interpolate", "a.ply", "b.ply", "--frames", "9", "-o", "frames", "--quality", "preview"});
    EXPECT_EQ(figures["jumps"], Json::array());
    EXPECT_FALSE(run({"interpolate", "a.ply", "b.ply", "--weights", "0,1", "-o", "x.ply"})
                     .contains("jumps"));
}

} // namespace
} // namespace shape::test
