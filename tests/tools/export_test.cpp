// SPDX-License-Identifier: MIT

#include "tests/tools/program_test.h"

// What the files hold is read by tests/ecosystem; here is what the program does about them.

namespace shape::test {
namespace {

class Export : public ProgramTest
{
protected:
    Export()
    {
        write_bumpy_spheres(folder_);
        (void)run({"stats", "a.ply", "b.ply", "c.ply", "-o", "model.h5"});
    }
    [[nodiscard]] Outcome outcome(const Arguments& arguments) const
    {
        return run_shape(folder_.path(), arguments);
    }
};

TEST_F(Export, WritesAFileOrAFolderAsAWhole)
{
    EXPECT_EQ(run({"export", "model.h5", "--to", "statismo", "-o", "s.h5"})["modes"], 2);
    for (const std::string client : {"csv", "shapeworks", "slicermorph"}) {
        const Json figures = run({"export", "model.h5", "--to", client, "-o", client + "/"});
        EXPECT_EQ(figures["outputs"], Json({client + "/"}));
        EXPECT_EQ(figures["linearised"], true);
        const Outcome again = outcome({"export", "model.h5", "--to", client, "-o", client});
        EXPECT_EQ(again.exit_code, 5);
        EXPECT_NE(again.err.find("--force writes into it"), std::string::npos) << again.err;
        EXPECT_EQ(
            outcome({"export", "model.h5", "--to", client, "-o", client, "--force"}).exit_code, 0);
        EXPECT_FALSE(folder_.has(client + ".unfinished"));
        EXPECT_FALSE(folder_.has(client + "/export.unfinished"));
    }
    EXPECT_TRUE(folder_.has("csv/read.R"));
    EXPECT_TRUE(folder_.has("shapeworks/model.swproj"));
    EXPECT_TRUE(folder_.has("slicermorph/analysis.json"));
}

TEST_F(Export, NamesALabelThatIsCalledAsAColumnOfItsTables)
{
    folder_.write("l.csv", "mesh,size\na,small\nb,large\nc,small\n");
    (void)run({"stats", "a.ply", "b.ply", "c.ply", "--labels", "l.csv", "-o", "sized.h5"});
    const Outcome refused = outcome({"export", "sized.h5", "--to", "csv", "-o", "csv"});
    EXPECT_EQ(refused.exit_code, 3);
    EXPECT_NE(refused.err.find("the label 'size' has the name of another column"),
              std::string::npos)
        << refused.err;
    EXPECT_FALSE(folder_.has("csv"));
    EXPECT_EQ(outcome({"export", "sized.h5", "--to", "slicermorph", "-o", "s"}).exit_code, 0);
}

TEST_F(Export, LeavesAloneWhatItDoesNotWrite)
{
    folder_.write("precious/thesis.txt", "x");
    folder_.write("precious/scores.csv", "old");
    EXPECT_EQ(outcome({"export", "model.h5", "--to", "csv", "-o", "precious"}).exit_code, 5);
    EXPECT_EQ(folder_.read("precious/scores.csv"), "old");
    EXPECT_EQ(outcome({"export", "model.h5", "--to", "csv", "-o", "precious", "--force"}).exit_code,
              0);
    EXPECT_EQ(folder_.read("precious/thesis.txt"), "x");
    EXPECT_NE(folder_.read("precious/scores.csv"), "old");
    // The folder that the program stands in, and that of its input.
    EXPECT_EQ(outcome({"export", "model.h5", "--to", "csv", "-o", ".", "--force"}).exit_code, 0);
    EXPECT_TRUE(folder_.has("model.h5"));
    EXPECT_TRUE(folder_.has("a.ply"));
    EXPECT_TRUE(folder_.has("landmarks.csv"));
    // A file is not replaced by a folder, nor a folder by a file.
    EXPECT_EQ(outcome({"export", "model.h5", "--to", "csv", "-o", "a.ply", "--force"}).exit_code,
              5);
    EXPECT_TRUE(std::filesystem::is_regular_file(folder_.path() / "a.ply"));
    std::filesystem::create_directories(folder_.path() / "blocked" / "faces.csv");
    EXPECT_EQ(outcome({"export", "model.h5", "--to", "csv", "-o", "blocked", "--force"}).exit_code,
              5);
    EXPECT_FALSE(folder_.has("blocked/landmarks.csv"));
    for (const std::string name : {"-", "x.h5"})
        EXPECT_EQ(outcome({"export", "model.h5", "--to", "csv", "-o", name}).exit_code, 2) << name;
}

TEST_F(Export, RefusesWhatDoesNotGoTogether)
{
    const std::vector<std::tuple<int, std::string, Arguments>> cases = {
        {2, ".h5", {"export", "model.h5", "--to", "statismo", "-o", "s.vtk"}},
        {2, "--to", {"export", "model.h5", "-o", "s.h5"}},
        {3, "2 modes", {"export", "model.h5", "--to", "csv", "-o", "x", "--modes", "3"}},
        {5, "", {"export", "none.h5", "--to", "csv", "-o", "x"}},
        {5, "", {"export", "model.h5", "--to", "csv", "-o", "no/where"}}};
    for (const auto& [exit_code, words, arguments] : cases) {
        const Outcome refused = outcome(arguments);
        EXPECT_EQ(refused.exit_code, exit_code) << refused.err;
        EXPECT_NE(refused.err.find(words), std::string::npos) << refused.err;
    }
    EXPECT_FALSE(folder_.has("x"));
}

TEST_F(Export, MeshesOfEveryFormatGoInAndOut)
{
    for (const std::string ending : {"stl", "vtk", "vtp", "glb"}) {
        (void)run(
            {"interpolate", "a.ply", "b.ply", "--frames", "2", "-o", ending, "--format", ending});
        const Outcome read = outcome({"collect", ending, "-o", ending + ".h5"});
        if (read.err.find("libpugixml-dev") != std::string::npos)
            continue; // a build without it says so
        EXPECT_EQ(read.exit_code, 0) << read.err;
        const bool is_single = ending == "stl" || ending == "glb";
        EXPECT_EQ(read.err.find("single precision (float32, about 7 digits) in 2 files") !=
                      std::string::npos,
                  is_single)
            << read.err;
        EXPECT_EQ(read.err.find("order of first appearance") != std::string::npos, ending == "stl");
    }
    (void)run({"interpolate", "a.ply", "b.ply", "--frames", "5", "-o", "walk.glb",
               "--glb-tolerance", "1e-12"});
    EXPECT_EQ(run({"collect", "walk.glb", "-o", "walk.h5"})["meshes"], 5);
    EXPECT_EQ(outcome({"generate", "model.h5", "--mean", "-o", "x.obj", "--float"}).exit_code, 2);
    EXPECT_EQ(outcome({"generate", "model.h5", "--mean", "-o", "x.glb", "--ascii"}).exit_code, 2);
    EXPECT_EQ(outcome({"generate", "model.h5", "--mean", "-o", "x.stl", "--float"}).exit_code, 0);
    EXPECT_EQ(outcome({"generate", "model.h5", "--mean", "-o", "x.off", "--ascii"}).exit_code, 0);
    const Outcome plain =
        outcome({"generate", "model.h5", "--mean", "-o", "coloured.ply", "--colors"});
    EXPECT_EQ(plain.exit_code, 0);
    EXPECT_NE(plain.err.find("add --residuals"), std::string::npos) << plain.err;
    EXPECT_EQ(
        outcome({"generate", "model.h5", "--mean", "-o", "x.ply", "--template", "t.obj"}).exit_code,
        2);
}

TEST_F(Export, ColoursFollowTheChosenValue)
{
    for (const std::string flag : {"--colors", "--colors=dihedral_drift"}) {
        (void)run({"generate", "model.h5", "--mode", "1", "--sigma", "2", "-o", "m/", "--residuals",
                   "--ascii", "--force", flag});
        const std::string text = folder_.read("m/residuals/mode01_2.00_residuals.ply");
        EXPECT_NE(text.find("property double quality\nproperty uchar red\n"), std::string::npos);
    }
    const Outcome refused =
        outcome({"generate", "model.h5", "--mean", "-o", "n/", "--residuals", "--colors=beauty"});
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_NE(refused.err.find("edge_error dihedral_drift"), std::string::npos) << refused.err;
}

} // namespace
} // namespace shape::test
