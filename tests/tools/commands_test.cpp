// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>

#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/rounded.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/model_file.h"
#include "libshape/io/table_file.h"
#include "libshape/io/vertex_scalars.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"
#include "tests/tools/program_test.h"

namespace shape::test {
using namespace internal;
namespace {

class Commands : public SilentProgramTest
{
protected:
    void collect_labelled() const
    {
        (void)run({"collect", "a.ply", "b.ply", "c.ply", "--labels", "labels.csv", "-o", "f.h5"});
    }
    void fit() const
    {
        collect_labelled();
        (void)run({"stats", "f.h5", "-o", "model.h5"});
    }
    /// One mesh in several sizes under set/, where copies would be warned of.
    void write_set(const Arguments& names) const
    {
        std::filesystem::create_directory(folder_ / "set");
        const NamedMesh mesh = read_mesh(folder_ / "a.ply");
        for (std::size_t i = 0; i < names.size(); ++i)
            write_mesh(folder_ / join("set/", names[i], ".ply"),
                       (1.0 + 0.01 * static_cast<double>(i + 1)) * mesh.points, mesh.faces);
    }
};

TEST_F(Commands, CollectKeepsPositionsNamesAndLabels)
{
    const Json figures =
        run({"collect", "a.ply", "b.ply", "c.ply", "--labels", "labels.csv", "-o", "f.h5"});
    EXPECT_EQ(figures["command"], "collect");
    EXPECT_EQ(figures["outputs"], Json({"f.h5"}));
    EXPECT_EQ(figures["meshes"], 3);
    EXPECT_EQ(figures["vertices"], 42);
    const Collection collection = read_collection(folder_ / "f.h5");
    EXPECT_EQ(collection.names, (std::vector<std::string>{"a", "b", "c"}));
    EXPECT_EQ(collection.points[1], read_mesh(folder_ / "b.ply").points);
    EXPECT_EQ(find_label(collection.labels, "mood").values,
              (std::vector<std::string>{"calm", "glad", "calm"}));
}

TEST_F(Commands, ADirectoryIsReadInNaturalNameOrder)
{
    write_set({"s10", "s2", "s1", "t"});
    folder_.write("set/notes.txt", "not a mesh");
    folder_.write("set/labels.csv", "neither");
    (void)run({"collect", "set", "-o", "f.h5"});
    EXPECT_EQ(run({"info", "f.h5"})["names"], Json({"s1", "s2", "s10", "t"}));
}

TEST_F(Commands, MeshFilesOfOtherFormatsAreNotPassedOverInSilence)
{
    folder_.write("set/x.ply", folder_.read("a.ply"));
    folder_.write("set/y.fbx", "Kaydara");
    folder_.write("set/z.DAE", "# dae");
    for (const Arguments& arguments :
         {Arguments{"collect", "set", "-o", "f.h5"}, Arguments{"check", "set"}}) {
        const Outcome outcome = run_shape(folder_.path(), arguments);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_NE(outcome.err.find("set: 2 mesh files of other formats passed over, first y.fbx"),
                  std::string::npos)
            << outcome.err;
    }
}

TEST_F(Commands, CompressedMeshesAndCollectionsAreNotPassedOverInSilence)
{
    const std::string mesh = folder_.read("a.ply");
    folder_.write("set/x.ply", mesh);
    folder_.write("y.ply", folder_.read("b.ply"));
    for (const char* name : {"set/a.PLY.gz", "set/b.obj.zip", "set/c.vtk.xz", "set/d.stl.bz2",
                             "set/notes.txt.gz", "set/all.zip"})
        folder_.write(name, "packed");
    (void)run({"collect", "y.ply", "-o", "set/more.h5"});
    const auto said = [&](const Arguments& paths) {
        const Outcome outcome = run_shape(
            folder_.path(), Arguments{"collect"} + paths + Arguments{"-o", "f.h5", "--force"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err;
    };
    const std::string first = said({"set"});
    EXPECT_NE(first.find("set: 4 compressed mesh files passed over, first a.PLY.gz; unpack them"),
              std::string::npos)
        << first;
    EXPECT_NE(first.find("set: 1 collection or model, more.h5, is not taken"), std::string::npos)
        << first;
    EXPECT_EQ(said({"set", "set/more.h5"}).find("is not taken"), std::string::npos);
}

TEST_F(Commands, MeshesInSubfoldersAreNotPassedOverInSilence)
{
    folder_.write("set/x.ply", folder_.read("a.ply"));
    const auto collect = [&](const Arguments& paths) {
        const Outcome outcome = run_shape(
            folder_.path(), Arguments{"collect"} + paths + Arguments{"-o", "f.h5", "--force"});
        EXPECT_EQ(outcome.exit_code, outcome.err.find("itself") == std::string::npos ? 0 : 3);
        return outcome.err;
    };
    const auto mentions = [](const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    };
    // What libshape writes, what is hidden, and what is no mesh.
    for (const char* other : {"residuals/x_residuals.ply", ".git/x.ply", "unfinished/x.ply",
                              "out.shard-1-of-2/x.ply", "notes/x.txt", "notes/._x.ply"})
        folder_.write(join("set/", other), folder_.read("b.ply"));
    EXPECT_FALSE(mentions(collect({"set"}), "subfolder"));
    folder_.write("set/s2/y.ply", folder_.read("b.ply"));
    EXPECT_TRUE(mentions(collect({"set"}),
                         "set: 1 mesh file in 1 subfolder (s2) not taken; to "
                         "take them too, name it: set/s2"));
    folder_.write("set/s10/deep/z.OBJ", "v 0 0 0\n");
    folder_.write("set/s2/w.ply", folder_.read("c.ply"));
    const std::string both = collect({"set/"});
    EXPECT_TRUE(mentions(both, "3 mesh files in 2 subfolders (s2 and s10/deep) not taken")) << both;
    EXPECT_TRUE(mentions(both, "each of them, such as set/s2\n")) << both;
    // Those that are named beside it are taken.
    std::filesystem::remove_all(folder_ / "set/s10");
    EXPECT_FALSE(mentions(collect({"set", "set/s2"}), "subfolder"));
    EXPECT_FALSE(mentions(collect({"set", "set/s2/y.ply", "set/s2/w.ply"}), "subfolder"));
    // Nothing in the directory itself.
    std::filesystem::remove(folder_ / "set/x.ply");
    const std::string none = collect({"set"});
    EXPECT_TRUE(mentions(none,
                         ".glb) itself, but 2 mesh files in 1 subfolder (s2): name it: "
                         "set/s2"))
        << none;
    std::filesystem::remove_all(folder_ / "set/s2");
    EXPECT_TRUE(mentions(collect({"set"}), "itself; other formats must be exported"));
}

TEST_F(Commands, SubfoldersThatCannotBeReadAreNamed)
{
    folder_.write("set/x.ply", folder_.read("a.ply"));
    for (const char* shut : {"set/locked/y.ply", "set/s2/locked/z.ply", "set/.git/locked/z.ply"})
        folder_.write(shut, folder_.read("b.ply"));
    const auto said = [&](const Arguments& arguments) {
        const std::vector<std::string> shut{"set/locked", "set/s2/locked", "set/.git/locked"};
        for (const std::string& name : shut)
            std::filesystem::permissions(folder_ / name, std::filesystem::perms::none);
        const Outcome outcome = run_shape(folder_.path(), arguments, {.as_ordinary_user = true});
        for (const std::string& name : shut)
            std::filesystem::permissions(folder_ / name, std::filesystem::perms::owner_all);
        return outcome;
    };
    if (said({"check", "set"}).exit_code == 127)
        GTEST_SKIP() << "root cannot give up reading everything here";
    for (const Arguments& command :
         {Arguments{"check", "set"}, Arguments{"collect", "set", "-o", "f.h5"}}) {
        const Outcome outcome = said(command);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_NE(outcome.err.find("warning: set: 2 subfolders (locked and s2/locked) cannot be "
                                   "read (permission denied); to take meshes in them, `chmod u+rx` "
                                   "each, such as set/locked, and name them\n"),
                  std::string::npos)
            << outcome.err;
    }
    std::filesystem::remove_all(folder_ / "set/s2");
    std::filesystem::remove(folder_ / "set/x.ply");
    std::filesystem::create_directories(folder_ / "set/s2/locked");
    const Outcome none = said({"check", "set"});
    EXPECT_EQ(none.exit_code, 3);
    EXPECT_NE(none.err.find("itself, and 2 subfolders (locked and s2/locked) cannot be read"),
              std::string::npos)
        << none.err;
}

TEST_F(Commands, NaturalOrder)
{
    const auto order = [&](const Arguments& names) {
        std::filesystem::remove_all(folder_ / "set");
        write_set(names);
        (void)run({"collect", "set", "-o", "f.h5", "--force"});
        return run({"info", "f.h5"})["names"];
    };
    for (
        const Arguments& sorted : std::vector<Arguments>{
            {"mode01_-10.00", "mode01_-2.00", "mode01_-1.50", "mode01_-1.00", "mode01_-0.50",
             "mode01_0.00", "mode01_0.50", "mode01_2.00", "mode01_10.00", "mode02_-3.00"},
            {"-1", "-0.5", "0", "+0.25", "0.3", "1"},
            {"2020-01-05", "2020-01-10", "2020-02-01"}, // no signs after digits
            {"s-1", "s-2", "s-10"},
            {"age_2.5", "age_12.25", "age_12.5"},
            {"v1.2.9", "v1.2.10"},
            // Two points and more are none of a decimal, nor is one where others have two.
            {"v1.2.3", "v1.10.1"},
            {"v1.2", "v1.10", "v1.10.1", "v1.11"},
            {"2024.1.5", "2024.2.10", "2024.10.2"},
            // Nor is one behind the word.
            {"v1.2.9", "v1.9", "v1.10"},
            {"v1.9", "v1.10"},
            {"rev1.9", "rev1.10"},
            {"model_V2.9", "model_V2.10", "model_V2.11"},
            {"face-version 0.9", "face-version 0.10"},
            {"v2.9_-2.00", "v2.9_-1.00", "v2.9_0.25", "v2.9_0.5", "v2.10_-2.00"},
            // But one with a sign is a decimal, and so are those at its place; or with a zero behind the point.
            {"scan_-2.00", "scan_-1.5", "scan_0.25", "scan_0.5", "scan_1.2.3"},
            {"v-0.5", "v-0.25", "v0.05", "v0.25", "v0.5"},
            {"v0.05", "v0.25", "v0.5"},
            {"lev0.25", "lev0.5"},
            {"v1.2.3_t-0.5", "v1.2.3_t-0.25", "v1.2.3_t0.1", "v1.10.0_t-0.5"},
            {"a", "a1", "a2", "a_1", "ab"},
            {"t=-1", "t=0", "t=1"},
            // Endings are not compared.
            {"walk", "walk (1)", "walk (2)", "walk (10)"},
            {"s", "s-1", "s-2", "s-10"},
            {"x.v2", "x.v10"},
            // Behind a letter or a hyphen a hyphen is a sign if a number stands there without it.
            {"t-0.5", "t-0.25", "t0", "t0.25"},
            {"t-0.25", "t-0.5"},
            {"s1_t-2", "s1_t-1", "s1_t0", "s10_t-2", "s10_t-1"},
            {"x-2", "x-1", "x+1", "x+2"},
            {"a--1", "a--2"},
            {"temp--5", "temp--1", "temp-0", "temp-5"},
            {"walk2", "walk2-1", "walk2-2"},
            {"F\u22122", "F\u22121", "F1"},
            {"F\u22122", "F\u22121"}}) {
        Arguments shuffled(sorted.rbegin(), sorted.rend());
        EXPECT_EQ(order(shuffled), Json(sorted));
    }
}

TEST_F(Commands, FilesDirectoriesAndCollectionsMix)
{
    collect_labelled();
    write_set({"d", "e"});
    const Outcome outcome =
        run_shape(folder_.path(), {"collect", "set/e.ply", "f.h5", "set/d.ply", "-o", "all.h5"});
    EXPECT_NE(outcome.err.find("are left empty for 2 of 5 meshes (e and d)"), std::string::npos)
        << outcome.err;
    const Collection all = read_collection(folder_ / "all.h5");
    EXPECT_EQ(all.names, (std::vector<std::string>{"e", "a", "b", "c", "d"}));
    EXPECT_EQ(find_label(all.labels, "subject").values,
              (std::vector<std::string>{"", "x", "x", "y", ""}));
}

TEST_F(Commands, PolygonsAreSplitOnRequest)
{
    folder_.write("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    EXPECT_EQ(run({"collect", "quad.obj", "-o", "q.h5", "--triangulate"})["faces"], 2);
}

TEST_F(Commands, CheckPassesGoodMeshes)
{
    const Json figures = run({"check", "a.ply", "b.ply", "c.ply"});
    EXPECT_EQ(figures["broken"], 0);
    EXPECT_EQ(figures["meshes"].size(), 3U);
    EXPECT_EQ(figures["meshes"][2]["name"], "c");
    EXPECT_EQ(figures["meshes"][2]["ok"], true);
}

TEST_F(Commands, OneMeshIsNotMeshes)
{
    folder_.write("bad.obj", "v 0 0 zero\n");
    const Outcome checked = run_shape(folder_.path(), {"check", "bad.obj"});
    EXPECT_NE(checked.err.find("1 of 1 mesh is broken"), std::string::npos) << checked.err;
    const Outcome collected = run_shape(folder_.path(), {"collect", "a.ply", "-o", "one.h5"});
    EXPECT_EQ(collected.err, "one.h5: 1 mesh of 42 vertices\n");
}

TEST_F(Commands, CheckListsEveryDefectOfEveryMesh)
{
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 2 2 2\n";
    folder_.write("bad.obj", vertices + "f 1 2 3\nf 2 3 4\nf 1 2 3\n");
    folder_.write("worse.obj", "v 0 0 zero\n");
    const Outcome outcome =
        run_shape(folder_.path(), {"check", "a.ply", "bad.obj", "worse.obj", "--json"});
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_EQ(line_count(outcome.err), 1) << outcome.err;
    EXPECT_NE(outcome.err.find("2 of 3 meshes are broken, first bad.obj"), std::string::npos);
    const Json figures = Json::parse(outcome.out);
    EXPECT_EQ(figures["broken"], 2);
    std::set<std::string> kinds;
    for (const Json& defect : figures["meshes"][1]["defects"])
        kinds.insert(defect["kind"]);
    const std::set<std::string> expected{"duplicate_face", "non_manifold_edge", "isolated_vertex",
                                         "correspondence"};
    EXPECT_TRUE(std::includes(kinds.begin(), kinds.end(), expected.begin(), expected.end()))
        << figures["meshes"][1].dump();
    EXPECT_EQ(figures["meshes"][2]["defects"][0]["kind"], "unreadable");
}

TEST_F(Commands, CheckPrintsTheSameForPeople)
{
    folder_.write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3\n");
    const Outcome outcome = run_shape(folder_.path(), {"check", "a.ply", "bad.obj", "--verbose"});
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_NE(outcome.out.find("a.ply: ok\n"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("duplicate_face: face 1"), std::string::npos) << outcome.out;
}

TEST_F(Commands, InfoCountsWhatIsInACollection)
{
    collect_labelled();
    const Json figures = run({"info", "f.h5"});
    EXPECT_EQ(figures["kind"], "collection");
    EXPECT_EQ(figures["meshes"], 3);
    EXPECT_EQ(figures["vertices"], 42);
    EXPECT_EQ(figures["edges"], 120);
    EXPECT_EQ(figures["faces"], 80);
    EXPECT_EQ(figures["genus"], 0);
    EXPECT_EQ(figures["labels"], Json({{"subject", 2}, {"mood", 2}}));
    const double mean =
        (lengths("a.ply").sum() + lengths("b.ply").sum() + lengths("c.ply").sum()) / 3.0;
    EXPECT_NEAR(figures["mean_size"].get<double>(), mean, 1e-12 * mean);
}

TEST_F(Commands, InfoHasARowForEveryMode)
{
    fit();
    const Json modes = run({"info", "model.h5"})["modes"];
    ASSERT_EQ(modes.size(), 2U);
    EXPECT_GE(modes[0]["variance"].get<double>(), modes[1]["variance"].get<double>());
    EXPECT_NEAR(modes[1]["cumulative"].get<double>(), 1.0, 1e-12);
    EXPECT_LT(modes[0]["feasible_low"].get<double>(), 0.0);
    EXPECT_GT(modes[0]["feasible_high"].get<double>(), 0.0);
    const Outcome text = run_shape(folder_.path(), {"info", "model.h5"});
    EXPECT_NE(text.out.find("\n   2 "), std::string::npos) << text.out;
    EXPECT_EQ(text.err, "");
}

TEST_F(Commands, StatsKeepsAsManyModesAsAskedFor)
{
    EXPECT_EQ(run({"stats", "a.ply", "b.ply", "c.ply", "-o", "all.h5"})["modes"].size(), 2U);
    const std::vector<std::string> meshes{"stats", "a.ply", "b.ply", "c.ply", "-o"};
    auto one = meshes;
    one.insert(one.end(), {"one.h5", "--modes", "1"});
    EXPECT_EQ(run(one)["modes"].size(), 1U);
    auto share = meshes;
    share.insert(share.end(), {"share.h5", "--variance", "0.01"});
    EXPECT_EQ(run(share)["modes"].size(), 1U);
}

TEST_F(Commands, StatsTakesLengthsAsTheyAreOnRequest)
{
    (void)run({"stats", "a.ply", "b.ply", "c.ply", "-o", "model.h5", "--scale", "none"});
    const ShapeModel model = read_model(folder_ / "model.h5");
    EXPECT_EQ(scale_of(model.space), Scale::None);
    const Eigen::VectorXd mean = (lengths("a.ply") + lengths("b.ply") + lengths("c.ply")) / 3.0;
    EXPECT_LT(difference(model.mean, mean), 1e-12);
}

TEST_F(Commands, ProjectReproducesTheScoresOfTheModel)
{
    fit();
    (void)run({"project", "model.h5", "f.h5", "-o", "scores.csv"});
    const Table table = read_table(folder_ / "scores.csv");
    EXPECT_EQ(table.columns, (std::vector<std::string>{"mesh", "subject", "mood", "size",
                                                       "residual", "pc1", "pc2"}));
    const ShapeModel model = read_model(folder_ / "model.h5");
    ASSERT_EQ(table.rows.size(), 3U);
    for (Eigen::Index i = 0; i < 3; ++i) {
        const std::vector<std::string>& row = table.rows[to_size(i)];
        EXPECT_EQ(row[0], model.names[to_size(i)]);
        EXPECT_NEAR(parse_number(row[3], "size"), model.sizes[i], 1e-12 * model.sizes[i]);
        EXPECT_LT(parse_number(row[4], "residual"), 1e-12);
        EXPECT_NEAR(parse_number(row[5], "pc1"), model.scores(i, 0), 1e-12);
        EXPECT_NEAR(parse_number(row[6], "pc2"), model.scores(i, 1), 1e-12);
    }
}

TEST_F(Commands, ProjectDrawsTheScoresWithAColourForEveryLabelValue)
{
    fit();
    const Json figures = run({"project", "model.h5", "f.h5", "-o", "scores.csv", "--plot",
                              "scores.svg", "--color-by", "mood"});
    EXPECT_EQ(figures["outputs"], Json({"scores.csv", "scores.svg"}));
    const std::string svg = folder_.read("scores.svg");
    EXPECT_NE(svg.find("<svg"), std::string::npos);
    for (const char* value : {"calm", "glad"})
        EXPECT_NE(svg.find(value), std::string::npos) << value;
}

TEST_F(Commands, PlotsAreDrawnAsAskedFor)
{
    fit();
    const Arguments project{"project", "model.h5", "f.h5", "-o", "s.csv", "--force", "--plot"};
    (void)run(project + Arguments{"s.svg", "--axes", "2,1", "--label"});
    const std::string svg = folder_.read("s.svg");
    EXPECT_LT(svg.find("mode 2 ("), svg.find("mode 1 ("));
    EXPECT_NE(svg.find(">a</text>"), std::string::npos) << svg;
    (void)run(project + Arguments{"e.svg", "--axes", "2,1", "--label", "--equal-scales"});
    EXPECT_NE(folder_.read("e.svg"), svg);
    for (const char* axes : {"1", "1,1", "0,1", "1,3", "1,2,3", "a,b", "1.5,2"})
        EXPECT_EQ(run_shape(folder_.path(), project + Arguments{"x.svg", "--axes", axes}).exit_code,
                  2)
            << axes;
    EXPECT_EQ(
        run_shape(folder_.path(), project + Arguments{"x.svg", "--outline", "hull"}).exit_code, 2);
    EXPECT_EQ(run_shape(folder_.path(), project + Arguments{"x.pdf"}).exit_code, 2);
    (void)run({"quality", "f.h5", "-o", "q.csv", "--plot", "q.svg", "--modes", "1", "--tests", "2",
               "--samples", "2"});
    EXPECT_NE(folder_.read("q.svg").find("stroke=\"#0072b2\""), std::string::npos);
}

TEST_F(Commands, PlotsMayBePng)
{
    if (std::system("rsvg-convert --version > /dev/null 2>&1") != 0)
        GTEST_SKIP() << "no rsvg-convert (librsvg2-bin)";
    fit();
    (void)run({"project", "model.h5", "f.h5", "-o", "s.csv", "--plot", "s.png"});
    const std::string png = folder_.read("s.png");
    ASSERT_TRUE(png.starts_with("\x89PNG"));
    EXPECT_EQ(png.substr(16, 8), std::string("\0\0\5\0\0\0\3\xc0", 8)); // 1280 by 960
}

TEST_F(Commands, PngWithoutAConverterSaysWhatToInstall)
{
    fit();
    const Arguments project{"project", "model.h5", "f.h5", "-o", "s.csv", "--plot", "s.png"};
    const Outcome missing = run_shape(folder_.path(), project,
                                      {.environment = {join("PATH=", folder_.path().string())}});
    EXPECT_EQ(missing.exit_code, 5);
    EXPECT_NE(missing.err.find("rsvg-convert, which draws PNG, cannot be started"),
              std::string::npos);
    EXPECT_NE(missing.err.find("librsvg2-bin"), std::string::npos);
    EXPECT_FALSE(folder_.has("s.png"));

    folder_.write("rsvg-convert", "#!/bin/sh\necho no fonts >&2\nexit 1\n");
    std::filesystem::permissions(folder_ / "rsvg-convert", std::filesystem::perms::owner_all);
    const Outcome failed =
        run_shape(folder_.path(), project + Arguments{"--force"},
                  {.environment = {join("PATH=", folder_.path().string(), ":/bin")}});
    EXPECT_EQ(failed.exit_code, 5);
    EXPECT_NE(failed.err.find("rsvg-convert failed: no fonts"), std::string::npos);
}

TEST_F(Commands, GenerateFromProjectedScoresGivesTheMeshesBack)
{
    fit();
    (void)run({"project", "model.h5", "f.h5", "-o", "scores.csv"});
    const Json figures =
        run({"generate", "model.h5", "--scores-file", "scores.csv", "-o", "again"});
    EXPECT_EQ(files_in(folder_ / "again"), (std::vector<std::string>{"a.ply", "b.ply", "c.ply"}));
    for (const char* mesh : {"a.ply", "b.ply", "c.ply"})
        EXPECT_LT(difference(lengths(join("again/", mesh)), lengths(mesh)), 1e-6) << mesh;
    EXPECT_EQ(figures["embeddings"][2]["name"], "c");
    EXPECT_EQ(figures["embeddings"][2]["status"], "exact");
}

TEST_F(Commands, GenerateMeanHasTheMeanSizeOrTheOneAskedFor)
{
    fit();
    const double mean_size = read_model(folder_ / "model.h5").mean_size();
    (void)run({"generate", "model.h5", "--mean", "-o", "mean.ply"});
    EXPECT_NEAR(lengths("mean.ply").sum(), mean_size, 0.01 * mean_size);
    (void)run({"generate", "model.h5", "--mean", "--size", "7", "-o", "seven"});
    EXPECT_NEAR(lengths("seven/mean.ply").sum(), 7.0, 0.07);
}

/// Largest difference of coordinates, of those at a size divided by it [1].
double difference_of_shapes(const Points& a, double size_of_a, const Points& b, double size_of_b)
{
    return (a / size_of_a - b / size_of_b).cwiseAbs().maxCoeff();
}

TEST_F(Commands, GenerateMakesTheSameShapeAtEverySize)
{
    fit();
    const double mean_size = read_model(folder_ / "model.h5").mean_size();
    const std::map<std::string, Arguments> asked{
        {"far", {"--scores", "6,-5"}}, // which no mesh has: several are about as near
        {"samples", {"--sample", "3"}},
        {"feasible", {"--sample", "3", "--feasible"}},
        {"sweep", {"--mode", "1", "--sigma", "-4:4:31"}}};
    for (const auto& [name, what] : asked) {
        const Arguments generate = Arguments{"generate", "model.h5", "--residuals"} + what;
        const Json usual =
            json_of(run_shape(folder_.path(), generate + Arguments{"-o", name + "/", "--json"}));
        for (const double size : {7.3, 1e-5, 3e7}) {
            const std::string at = join(name, "_at/");
            const Outcome outcome = run_shape(
                folder_.path(),
                generate + Arguments{"-o", at, "--force", "--json", "--size", join(size)});
            const Json resized = json_of(outcome);
            for (std::size_t i = 0; i < usual["outputs"].size(); ++i) {
                const std::string file =
                    std::filesystem::path(usual["outputs"][i].get<std::string>()).filename();
                if (file.find("_residuals") != std::string::npos)
                    continue;
                EXPECT_LT(difference_of_shapes(points(name + "/" + file), mean_size,
                                               points(at + file), size),
                          1e-12)
                    << file << " at " << size;
            }
            for (std::size_t i = 0; i < usual["embeddings"].size(); ++i)
                for (const char* figure : {"edge_rms", "dihedral_rms_deg", "iterations", "status"})
                    EXPECT_EQ(usual["embeddings"][i][figure], resized["embeddings"][i][figure]);
            const auto residuals = [&](const std::string& folder) {
                const auto files = files_in(folder_ / (folder + "residuals"));
                return read_vertex_scalar(folder_ / (folder + "residuals/" + files.front()),
                                          "edge_error");
            };
            EXPECT_LT((residuals(name + "/") - residuals(at)).cwiseAbs().maxCoeff(), 1e-9);
        }
    }
    // The sizes of a table: every mesh has its own.
    (void)run({"project", "model.h5", "f.h5", "-o", "scores.csv"});
    Table table = read_table(folder_ / "scores.csv");
    const auto column = static_cast<std::size_t>(
        std::find(table.columns.begin(), table.columns.end(), "size") - table.columns.begin());
    for (auto& row : table.rows) // far away
        row.back() = print_number(9.0 * parse_number(row.back(), "score"));
    write_table(folder_ / "own.csv", table);
    const Arguments of_table{"generate", "model.h5", "--scores-file", "own.csv"};
    ASSERT_EQ(run_shape(folder_.path(), of_table + Arguments{"-o", "own/"}).exit_code, 0);
    ASSERT_EQ(
        run_shape(folder_.path(), of_table + Arguments{"-o", "one/", "--size", "1"}).exit_code, 0);
    for (const auto& row : table.rows)
        EXPECT_LT(difference_of_shapes(points("own/" + row.front() + ".ply"),
                                       parse_number(row[column], "size"),
                                       points("one/" + row.front() + ".ply"), 1.0),
                  1e-12);
    const Outcome large = run_shape(
        folder_.path(), {"generate", "model.h5", "--mean", "--size", "1e70", "-o", "x.ply"});
    EXPECT_EQ(large.exit_code, 3);
    EXPECT_NE(large.err.find("the longest edge of the target is"), std::string::npos) << large.err;
}

TEST_F(Commands, GenerateNamesTheMeshesOfAMode)
{
    fit();
    (void)run({"generate", "model.h5", "--mode", "2", "--sigma", "-1:1:3", "-o", "two"});
    EXPECT_EQ(files_in(folder_ / "two"),
              (std::vector<std::string>{"mode02_-1.00.ply", "mode02_0.00.ply", "mode02_1.00.ply"}));
    (void)run({"generate", "model.h5", "--mode", "1", "--sigma", "-0.001:0.001:3", "-o", "fine",
               "--format", "obj"});
    EXPECT_EQ(
        files_in(folder_ / "fine"),
        (std::vector<std::string>{"mode01_-0.001.obj", "mode01_0.000.obj", "mode01_0.001.obj"}));
}

TEST_F(Commands, GenerateScoresAreStandardDeviations)
{
    fit();
    (void)run({"generate", "model.h5", "--scores", "0.5", "-o", "scores.ply"});
    (void)run({"generate", "model.h5", "--mode", "1", "--sigma", "0.5", "-o", "mode.ply"});
    EXPECT_EQ(folder_.read("scores.ply"), folder_.read("mode.ply"));
    (void)run({"generate", "model.h5", "--scores", " 0.5, 0", "-o", "blanks.ply"});
    EXPECT_EQ(folder_.read("blanks.ply"), folder_.read("mode.ply"));
    (void)run({"project", "model.h5", "scores.ply", "-o", "s.csv"});
    const ShapeModel model = read_model(folder_ / "model.h5");
    const Table table = read_table(folder_ / "s.csv");
    EXPECT_NEAR(parse_number(table.rows[0][3], "pc1"), 0.5 * std::sqrt(model.variances[0]),
                0.01 * std::sqrt(model.variances[0]));
}

TEST_F(Commands, GenerateSamplesDependOnTheSeedAlone)
{
    fit();
    (void)run({"generate", "model.h5", "--sample", "2", "--seed", "5", "-o", "one"});
    (void)run({"generate", "model.h5", "--sample", "3", "--seed", "5", "-o", "same"});
    (void)run({"generate", "model.h5", "--sample", "2", "--seed", "6", "-o", "other"});
    EXPECT_EQ(files_in(folder_ / "one"),
              (std::vector<std::string>{"sample_0000.ply", "sample_0001.ply"}));
    for (const std::string name : {"sample_0000.ply", "sample_0001.ply"}) {
        EXPECT_EQ(folder_.read("one/" + name), folder_.read("same/" + name));
        EXPECT_NE(folder_.read("one/" + name), folder_.read("other/" + name));
    }
}

TEST_F(Commands, InfeasibleTargetsAreWrittenWithAWarning)
{
    fit();
    const double beyond = 1.1 * feasible_range(read_model(folder_ / "model.h5"), 0, 100.0).high;
    const Outcome outcome = run_shape(folder_.path(), {"generate", "model.h5", "--mode", "1",
                                                       "--sigma", join(beyond), "-o", "far.ply"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("shape: warning: mode01_")) << outcome.err;
    EXPECT_NE(outcome.err.find("infeasible target"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("worst face"), std::string::npos) << outcome.err;
    // Over different lengths: the first may be larger than the second.
    EXPECT_NE(outcome.err.find("edge errors: RMS "), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find(" % of the mean length, largest "), std::string::npos)
        << outcome.err;
    EXPECT_TRUE(read_mesh(folder_ / "far.ply").points.allFinite());
}

TEST_F(Commands, PublishedMethodsGiveTheNearestMeshOfAnInfeasibleTargetToo)
{
    fit();
    const double beyond = 1.1 * feasible_range(read_model(folder_ / "model.h5"), 0, 100.0).high;
    const auto made = [&](const std::string& method) {
        return json_of(run_shape(folder_.path(), {"generate", "model.h5", "--mode", "1", "--sigma",
                                                  join(beyond), "--method", method, "-o",
                                                  method + ".ply", "--json"}))["embeddings"][0];
    };
    EXPECT_EQ(made("dihedral")["method"], "dihedral");
    for (const std::string method : {"multiscale", "closure"}) {
        const Json figures = made(method);
        EXPECT_EQ(figures["method"], "dihedral");
        EXPECT_EQ(figures["status"], "infeasible");
        EXPECT_EQ(folder_.read(method + ".ply"), folder_.read("dihedral.ply"));
    }
    EXPECT_EQ(run({"generate", "model.h5", "--mean", "--method", "multiscale", "-o",
                   "m.ply"})["embeddings"][0]["method"],
              "multiscale");
}

TEST_F(Commands, ManyInfeasibleTargetsAreOneLineAndFeasibleSamplesNone)
{
    fit();
    const double beyond = 2.0 * feasible_range(read_model(folder_ / "model.h5"), 0, 100.0).high;
    const Arguments far{"generate", "model.h5", "--mode", "1", "--sigma", join("0:", beyond, ":7"),
                        "-o"};
    const Outcome brief = run_shape(folder_.path(), far + Arguments{"far"});
    EXPECT_EQ(brief.exit_code, 0) << brief.err;
    std::size_t warnings = 0;
    for (std::size_t at = brief.err.find("warning:"); at != std::string::npos;
         at = brief.err.find("warning:", at + 1))
        ++warnings;
    EXPECT_EQ(warnings, 1U) << brief.err;
    EXPECT_NE(brief.err.find(" of 7 targets are infeasible"), std::string::npos) << brief.err;
    const Outcome verbose = run_shape(folder_.path(), far + Arguments{"verbose", "--verbose"});
    EXPECT_NE(verbose.err.find("worst face"), std::string::npos) << verbose.err;
    const Json figures =
        json_of(run_shape(folder_.path(), far + Arguments{"json", "--json", "--quiet"}));
    EXPECT_FALSE(figures["embeddings"][6]["reason"].get<std::string>().empty());
    EXPECT_FALSE(figures["embeddings"][0].contains("reason"));

    const Json samples =
        run({"generate", "model.h5", "--sample", "30", "--feasible", "-o", "samples"});
    for (const Json& sample : samples["embeddings"])
        EXPECT_NE(sample["status"], "infeasible") << sample.dump();
}

TEST_F(Commands, FeasibleSamplesSayHowFarTheyWereMoved)
{
    Arguments stats{"stats", "-o", "rough.h5"};
    for (unsigned i = 1; i <= 6; ++i) {
        const TestMesh mesh = bumpy_sphere(1, 0.9, i);
        stats.push_back(join("rough", i, ".ply"));
        write_mesh(folder_ / stats.back(), mesh.points, mesh.topology.faces());
    }
    (void)run(stats);
    const ShapeModel model = read_model(folder_ / "rough.h5");
    const Arguments sample{"generate", "rough.h5", "--sample", "30"};
    const Json kept = run(sample + Arguments{"-o", "kept", "--feasible"});
    const Json drawn =
        json_of(run_shape(folder_.path(), sample + Arguments{"-o", "drawn", "--json", "--quiet"}));
    const auto is_feasible = [&](const Eigen::VectorXd& scores) {
        const auto point = std::get<ShapePoint>(model_point(model, scores, model.mean_size()));
        return (point.edge_lengths.array() > 0.0).all() &&
               check_admissibility(model.topology, point.edge_lengths).admissible();
    };
    Random random(1);
    std::size_t moved = 0;
    double squares = 0.0;
    double all_squares = 0.0;
    for (std::size_t i = 0; i < 30; ++i) {
        Eigen::VectorXd scores(model.mode_count());
        for (Eigen::Index k = 0; k < scores.size(); ++k)
            scores[k] = std::sqrt(model.variances[k]) * random.normal();
        const Json& sample_kept = kept["embeddings"][i];
        const double share = sample_kept["share"];
        EXPECT_FALSE(drawn["embeddings"][i].contains("moved"));
        EXPECT_EQ(sample_kept["moved"], drawn["embeddings"][i]["status"] == "infeasible") << i;
        EXPECT_EQ(sample_kept["moved"], share < 1.0);
        EXPECT_TRUE(is_feasible(share * scores));
        if (share < 1.0) {
            ++moved;
            EXPECT_FALSE(is_feasible((share / 0.99 + 1e-6) * scores));
        }
        squares += share * share * scores.squaredNorm();
        all_squares += scores.squaredNorm();
    }
    ASSERT_GT(moved, 0U);
    ASSERT_LT(moved, 30U);
    const std::string told =
        run_shape(folder_.path(), sample + Arguments{"-o", "told", "--feasible"}).err;
    EXPECT_NE(told.find(join("--feasible: ", moved,
                             " of 30 samples had lengths that no mesh has: "
                             "moved towards the mean, to ")),
              std::string::npos)
        << told;
    EXPECT_NE(told.find(join("sum up to ", rounded(100.0 * squares / all_squares),
                             " % of what was drawn")),
              std::string::npos)
        << told;
    EXPECT_EQ(told.find(": moved to "), std::string::npos) << told;
    EXPECT_NE(
        run_shape(folder_.path(), sample + Arguments{"-o", "verbose", "--feasible", "--verbose"})
            .err.find(": moved to "),
        std::string::npos);
    fit();
    EXPECT_NE(run_shape(folder_.path(),
                        {"generate", "model.h5", "--sample", "1", "--feasible", "-o", "one/"})
                  .err.find("--feasible: "),
              std::string::npos);
}

TEST_F(Commands, ProjectSaysHowTheTriangulationDiffers)
{
    fit();
    NamedMesh mesh = read_mesh(folder_ / "a.ply");
    mesh.faces.col(1).swap(mesh.faces.col(2));
    write_mesh(folder_ / "turned.ply", mesh.points, mesh.faces, MeshFormat::Ply);
    const Outcome outcome =
        run_shape(folder_.path(), {"project", "model.h5", "turned.ply", "-o", "s.csv"});
    EXPECT_EQ(outcome.exit_code, 3);
    for (const char* said : {"turned", "face 0", "flipped", "inside out"})
        EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
}

TEST_F(Commands, EmbeddingsHaveTheFieldsOfTheContract)
{
    fit();
    const Json figures = run({"generate", "model.h5", "--mean", "-o", "mean.ply"});
    EXPECT_EQ(figures["outputs"], Json({"mean.ply"}));
    ASSERT_EQ(figures["embeddings"].size(), 1U);
    const Json& embedding = figures["embeddings"][0];
    std::set<std::string> fields;
    for (const auto& [field, value] : embedding.items())
        fields.insert(field);
    EXPECT_EQ(fields, (std::set<std::string>{"name",
                                             "method",
                                             "vertices",
                                             "status",
                                             "edge_rms",
                                             "edge_max",
                                             "edge_p999",
                                             "edge_p99",
                                             "dihedral_rms_deg",
                                             "dihedral_p99_deg",
                                             "dihedral_max_deg",
                                             "inverted_faces",
                                             "self_intersections",
                                             "new_self_intersections",
                                             "companion_rms",
                                             "closure_energy",
                                             "iterations",
                                             "converged",
                                             "seconds",
                                             "setup_seconds"}));
    EXPECT_EQ(embedding["name"], "mean");
    EXPECT_EQ(embedding["method"], "dihedral");
    EXPECT_EQ(embedding["vertices"], 42);
    EXPECT_TRUE(embedding["converged"].is_boolean());
}

TEST_F(Commands, EmbeddingErrorsAreThoseOfTheWrittenMesh)
{
    const Json figures =
        run({"interpolate", "a.ply", "b.ply", "--weights", "0.5,0.5", "-o", "half.ply"});
    const Eigen::VectorXd target = 0.5 * (lengths("a.ply") + lengths("b.ply"));
    const Eigen::VectorXd error = lengths("half.ply") - target;
    const double rms = std::sqrt(error.squaredNorm() / static_cast<double>(error.size()));
    EXPECT_NEAR(figures["embeddings"][0]["edge_rms"].get<double>(), rms / target.mean(), 1e-12);
    EXPECT_NEAR(figures["embeddings"][0]["edge_max"].get<double>(),
                error.cwiseAbs().cwiseQuotient(target).maxCoeff(), 1e-12);
}

TEST_F(Commands, EveryMethodCanBeChosen)
{
    for (const std::string method : {"dihedral", "closure", "multiscale"}) {
        const Json figures = run({"interpolate", "a.ply", "b.ply", "--weights", "0,1", "-o",
                                  method + ".ply", "--method", method});
        EXPECT_EQ(figures["embeddings"][0]["method"], method);
        EXPECT_LT(difference(lengths(method + ".ply"), lengths("b.ply")), 1e-6) << method;
    }
}

TEST_F(Commands, InterpolationEndsAtItsInputs)
{
    const Json figures = run({"interpolate", "a.ply", "b.ply", "--frames", "3", "-o", "frames"});
    EXPECT_EQ(files_in(folder_ / "frames"),
              (std::vector<std::string>{"frame_0000.ply", "frame_0001.ply", "frame_0002.ply"}));
    EXPECT_LT(difference(lengths("frames/frame_0000.ply"), lengths("a.ply")), 1e-6);
    EXPECT_LT(difference(lengths("frames/frame_0002.ply"), lengths("b.ply")), 1e-6);
    EXPECT_EQ(figures["outputs"][1], "frames/frame_0001.ply");
}

TEST_F(Commands, InterpolationTakesWeightsOfManyMeshesManyTimes)
{
    (void)run({"interpolate", "a.ply", "b.ply", "c.ply", "--weights", "0,1,0", "--weights", "0,0,1",
               "-o", "frames", "--format", "off"});
    EXPECT_LT(difference(lengths("frames/frame_0000.off"), lengths("b.ply")), 1e-6);
    EXPECT_LT(difference(lengths("frames/frame_0001.off"), lengths("c.ply")), 1e-6);
}

TEST_F(Commands, ExtrapolationNeedsItsOption)
{
    (void)run(
        {"interpolate", "a.ply", "b.ply", "--weights", "1.1,-0.1", "--extrapolate", "-o", "x.ply"});
    const Eigen::VectorXd target = 1.1 * lengths("a.ply") - 0.1 * lengths("b.ply");
    EXPECT_LT(difference(lengths("x.ply"), target), 0.05);
    EXPECT_GT(difference(lengths("x.ply"), lengths("a.ply")), 1e-3);
}

TEST_F(Commands, SquaredLengthsBlendToLongerEdges)
{
    (void)run({"interpolate", "a.ply", "b.ply", "--weights", "0.5,0.5", "-o", "plain.ply"});
    (void)run({"interpolate", "a.ply", "b.ply", "--weights", "0.5,0.5", "-o", "squared.ply",
               "--lengths", "squared"});
    EXPECT_GT(lengths("squared.ply").sum(), lengths("plain.ply").sum());
}

TEST_F(Commands, ReconstructMakesTheMeshOfGivenLengths)
{
    const NamedMesh b = read_mesh(folder_ / "b.ply");
    const Topology topology(b.faces, static_cast<int>(b.points.rows()));
    const Eigen::VectorXd wanted = lengths("b.ply");
    Table table{{"v0", "v1", "length"}, {}};
    for (int e = topology.edge_count() - 1; e >= 0; --e) // any order, any direction
        table.rows.push_back(
            {join(topology.edges()(e, 1)), join(topology.edges()(e, 0)), print_number(wanted[e])});
    write_table(folder_ / "lengths.csv", table);
    const Json figures = run({"reconstruct", "--reference", "a.ply", "b.ply", "--lengths",
                              "lengths.csv", "-o", "b2.ply"});
    EXPECT_LT(difference(lengths("b2.ply"), wanted), 0.02);
    EXPECT_LT(figures["embeddings"][0]["edge_max"].get<double>(), 0.02);
}

TEST_F(Commands, ReconstructTakesTheReferencesOwnLengths)
{
    (void)run({"reconstruct", "--reference", "c.ply", "-o", "c2.ply"});
    EXPECT_LT(difference(lengths("c2.ply"), lengths("c.ply")), 1e-6);
}

TEST_F(Commands, DifferenceAppliedToItsOnlyPairGivesTheOtherMesh)
{
    collect_labelled();
    const Json figures =
        run({"difference", "f.h5", "--pair-by", "subject", "--from", "mood=calm", "--to",
             "mood=glad", "--scale", "none", "-o", "diff.h5", "--apply", "--mesh", "glad.ply"});
    EXPECT_EQ(figures["pairs"], 1);
    EXPECT_EQ(figures["outputs"], Json({"glad.ply", "diff.h5"}));
    EXPECT_LT(difference(lengths("glad.ply"), lengths("b.ply")), 1e-6);
    EXPECT_EQ(run({"info", "diff.h5"})["kind"], "difference");
    (void)run({"difference", "f.h5", "--pair-by", "subject", "--from", "mood=calm", "--to",
               "mood=glad", "--scale", "none", "-o", "again.h5", "--apply", "--amount", "0",
               "--mesh", "calm.ply"});
    EXPECT_LT(difference(lengths("calm.ply"), lengths("a.ply")), 1e-6);
}

/// Whether the program was built with the page.
bool has_page()
{
    return SHAPE_HAS_PAGE;
}

TEST_F(Commands, ExplorePutsAModelOnOnePage)
{
    if (!has_page())
        GTEST_SKIP() << "built without the page";
    fit();
    const Arguments explore{"explore", "model.h5",       "--color-by", "mood",      "--modes", "5",
                            "--title", "Three <meshes>", "--about",    "of nobody", "-o"};
    const Json figures = run(explore + Arguments{"page.html"});
    EXPECT_EQ(figures["outputs"], Json({"page.html"}));
    EXPECT_EQ(figures["modes"], 2); // the model has no more
    const std::string page = folder_.read("page.html");
    EXPECT_EQ(figures["bytes"], page.size());
    EXPECT_LT(page.size(), 2U << 20U);
    for (const char* part : {"<title>Three &lt;meshes&gt;</title>", ">calm</text>", ">glad</text>",
                             "<dd>of nobody</dd>", "id=\"block\"", "id=\"wasm\""})
        EXPECT_NE(page.find(part), std::string::npos) << part;
    (void)run(explore + Arguments{"again.html", "--threads", "1"});
    EXPECT_TRUE(folder_.read("again.html") == page);
    (void)run({"report", "model.h5", "-o", "report.html"});
    EXPECT_NE(folder_.read("report.html").find("id=\"block\""), std::string::npos);
}

TEST_F(Commands, ExploreRegressesOnMeshesThatHaveAValue)
{
    if (!has_page())
        GTEST_SKIP() << "built without the page";
    (void)run({"synth", "faces", "-o", "faces", "--vertices", "300"});
    const std::vector<std::string> files = files_in(folder_ / "faces");
    std::string labels = "mesh,age,few\n";
    int count = 0;
    for (const std::string& file : files)
        if (file.ends_with(".ply")) {
            labels += join(file, ",", count == 1 ? "NA" : std::to_string(20 + count * count), ",",
                           count < 2 ? "1" : "", "\n");
            ++count;
        }
    ASSERT_GE(count, 4);
    folder_.write("l.csv", labels);
    (void)run({"stats", "faces", "--labels", "l.csv", "-o", "faces.h5"});
    const Outcome outcome =
        run_shape(folder_.path(), {"explore", "faces.h5", "--regress", "age", "-o", "p.html"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find(join(" has no value of it; scores are regressed on those of the "
                                    "other ",
                                    count - 1, " meshes")),
              std::string::npos)
        << outcome.err;
    EXPECT_NE(folder_.read("p.html").find("\"low\":20.0"), std::string::npos);
    const Outcome few =
        run_shape(folder_.path(), {"explore", "faces.h5", "--regress", "few", "-o", "q.html"});
    EXPECT_EQ(few.exit_code, 3);
    EXPECT_NE(few.err.find("--regress few: 2 meshes have a value of it, at least 3 are needed"),
              std::string::npos)
        << few.err;
    // As `regress` says it.
    std::string coded = "mesh,age,same\n";
    count = 0;
    for (const std::string& file : files)
        if (file.ends_with(".ply"))
            coded += join(file, ",", count++ == 1 ? -999 : 20 + count, ",7\n");
    folder_.write("l.csv", coded);
    ASSERT_EQ(run_shape(folder_.path(),
                        {"stats", "faces", "--labels", "l.csv", "-o", "faces.h5", "--force"})
                  .exit_code,
              0);
    const Outcome doubtful = run_shape(
        folder_.path(), {"explore", "faces.h5", "--regress", "age", "-o", "p.html", "--force"});
    EXPECT_EQ(doubtful.exit_code, 0);
    EXPECT_NE(doubtful.err.find("warning: label 'age' is -999 in 1 mesh, apart from all other"),
              std::string::npos)
        << doubtful.err;
    const Outcome same =
        run_shape(folder_.path(), {"explore", "faces.h5", "--regress", "same", "-o", "q.html"});
    EXPECT_EQ(same.exit_code, 3);
    EXPECT_NE(same.err.find(join("--regress same: is constant, 7 for all ", count, " meshes")),
              std::string::npos)
        << same.err;
}

TEST_F(Commands, ExploreTakesModelsOfPositionsAndOfOneMode)
{
    if (!has_page())
        GTEST_SKIP() << "built without the page";
    (void)run({"stats", "a.ply", "b.ply", "--space", "procrustes", "-o", "model.h5"});
    EXPECT_EQ(run({"explore", "model.h5", "-o", "page.html"})["modes"], 1);
    EXPECT_NE(folder_.read("page.html").find("\"space\":\"procrustes\""), std::string::npos);
}

TEST_F(Commands, SynthMakesADirectoryThatCanBeCollected)
{
    const Json figures = run({"synth", "torus", "-o", "torus", "--vertices", "100"});
    EXPECT_EQ(figures["meshes"], 2);
    EXPECT_TRUE(folder_.has("torus/labels.csv"));
    const Json collected = run({"collect", "torus", "-o", "t.h5", "--labels", "torus/labels.csv"});
    EXPECT_EQ(collected["vertices"], figures["vertices"]);
}

TEST_F(Commands, SynthListsItsDatasets)
{
    const Json datasets = run({"synth", "--list"})["datasets"];
    std::set<std::string> names;
    for (const Json& dataset : datasets)
        names.insert(dataset["name"]);
    for (const char* name : {"arm", "helix", "barbells", "torus", "femurs", "icosahedron", "faces"})
        EXPECT_TRUE(names.contains(name)) << name;
    const Outcome text = run_shape(folder_.path(), {"synth", "--list"});
    EXPECT_NE(text.out.find("torus: "), std::string::npos) << text.out;
}

} // namespace
} // namespace shape::test
