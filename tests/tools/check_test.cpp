// SPDX-License-Identifier: MIT

#include <Eigen/Geometry>
#include <fstream>

#include "libshape/base/format.h"
#include "libshape/io/collection_file.h"
#include "tests/support/seams.h"
#include "tests/tools/program_test.h"

namespace shape::test {
using namespace internal;
namespace {

const std::string repair = "`shape check MESHES --fix DIR`";

class Check : public ProgramTest
{
protected:
    /// Seven bumpy spheres in the folder `set`.
    Check()
    {
        std::filesystem::create_directory(folder_ / "set");
        for (unsigned i = 0; i < 7; ++i)
            write(i, sphere(i).points, sphere(i).topology.faces());
    }
    static TestMesh sphere(unsigned i) { return bumpy_sphere(2, 0.1, i); }

    void write(unsigned i, const Points& points, const Faces& faces) const
    {
        write_mesh(folder_ / join("set/m", i, ".ply"), points, faces, MeshFormat::Ply);
    }
    [[nodiscard]] Outcome shape(const Arguments& arguments) const
    {
        return run_shape(folder_.path(), arguments);
    }
    /// What `check` and `collect` both say of a set that both take.
    void expect_said(const std::string& kind, const std::vector<std::string>& said) const
    {
        const Outcome checked = shape({"check", "set"});
        EXPECT_EQ(checked.exit_code, 0) << checked.err;
        EXPECT_NE(checked.out.find("warning: " + kind), std::string::npos) << checked.out;
        const Outcome collected = shape({"collect", "set", "-o", "c.h5", "--force"});
        EXPECT_EQ(collected.exit_code, 0) << collected.err;
        EXPECT_NE(collected.err.find("warning: "), std::string::npos) << collected.err;
        for (const std::string& word : said) {
            EXPECT_NE(checked.out.find(word), std::string::npos) << word << "\n" << checked.out;
            EXPECT_NE(collected.err.find(word), std::string::npos) << word << "\n" << collected.err;
        }
        const Json figures = run({"check", "set"});
        EXPECT_EQ(figures["warnings"][0]["kind"], kind);
        EXPECT_GT(figures["suspicious"], 0);
    }
    /// After --fix the set is sound and in correspondence.
    [[nodiscard]] Collection fixed(const Arguments& more = {}) const
    {
        const Outcome outcome = shape(Arguments{"check", "set", "--fix", "repaired"} + more);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const Outcome again = shape({"check", "repaired"});
        EXPECT_NE(again.out.find(" ok, 0 with warnings, 0 broken"), std::string::npos) << again.out;
        EXPECT_EQ(shape({"collect", "repaired", "-o", "repaired.h5"}).exit_code, 0);
        return read_collection(folder_ / "repaired.h5");
    }
};

TEST_F(Check, GoodMeshesAreAFewLinesAndOnRequestOneEach)
{
    const Outcome outcome = shape({"check", "set"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_EQ(outcome.out,
              "7 meshes: 7 ok, 0 with warnings, 0 broken\n"
              "surface: 162 vertices, 480 edges, 320 faces, closed, genus 0\n"
              "conformal map to the sphere: qualifies\n");
    const Outcome verbose = shape({"check", "set", "--verbose"});
    for (int i = 0; i < 7; ++i)
        EXPECT_NE(verbose.out.find(join("m", i, ".ply: ok\n")), std::string::npos) << verbose.out;
}

TEST_F(Check, MeshesThatAreBrokenAlikeAreSaidTogether)
{
    for (unsigned i = 1; i < 6; ++i) {
        Points loose = sphere(i).points; // one vertex more, without a face
        loose.conservativeResize(loose.rows() + (i == 5 ? 2 : 1), 3);
        loose.bottomRows(loose.rows() - sphere(i).points.rows()).setOnes();
        write(i, loose, sphere(i).topology.faces());
    }
    const Outcome outcome = shape({"check", "set"});
    EXPECT_NE(outcome.out.find("m1.ply: broken\n"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("and 3 more, alike: set/m2.ply, set/m3.ply and set/m4.ply\n"),
              std::string::npos)
        << outcome.out;
    EXPECT_NE(outcome.out.find("m5.ply: broken\n"), std::string::npos) << outcome.out;
    const Outcome verbose = shape({"check", "set", "--verbose"});
    for (int i = 1; i < 6; ++i)
        EXPECT_NE(verbose.out.find(join("m", i, ".ply: broken\n")), std::string::npos);
    EXPECT_EQ(run_shape(folder_.path(), {"check", "set", "--json"}).exit_code, outcome.exit_code);
}

TEST_F(Check, AFileBeyondALimitDoesNotKeepTheOthersFromBeingChecked)
{
    std::string deep = "<VTKFile type=\"PolyData\"><PolyData>";
    for (int i = 0; i < 120'000; ++i)
        deep += "<a>";
    std::ofstream(folder_ / "set/deep.vtp") << deep;
    const Outcome outcome = shape({"check", "set/deep.vtp", "set/m0.ply", "set/m1.ply"});
    EXPECT_NE(outcome.out.find("3 meshes: 2 ok"), std::string::npos) << outcome.out << outcome.err;
    EXPECT_NE(outcome.out.find("tags of XML"), std::string::npos) << outcome.out;
}

TEST_F(Check, SeamsAreSaidAndRepaired)
{
    const CutMesh cut = cut_along_the_equator(sphere(0));
    for (unsigned i = 0; i < 7; ++i)
        write(i, cut.points(sphere(i).points), cut.faces);
    expect_said("seam",
                {"boundary vertices lie on one another", "m0", "UV", "weld them: " + repair});
    const Collection repaired = fixed();
    EXPECT_EQ(repaired.topology.faces(), sphere(0).topology.faces());
    EXPECT_EQ(repaired.points[5], sphere(5).points);
}

TEST_F(Check, PatchesThatMeetWithinRoundingAreWeldedAndNoneIsThrownAway)
{
    const CutMesh cut = cut_along_the_equator(sphere(0), true);
    const int doubled = cut.doubled(sphere(0).points);
    for (unsigned i = 0; i < 7; ++i)
        write_mesh(folder_ / join("set/m", i, ".stl"),
                   in_scanner_coordinates(8.0 * cut.points(sphere(i).points), doubled), cut.faces,
                   MeshFormat::Stl);
    for (unsigned i = 0; i < 7; ++i)
        std::filesystem::remove(folder_ / join("set/m", i, ".ply"));
    const Outcome outcome = shape({"check", "set"});
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_NE(outcome.out.find(join(2 * doubled, " of ", 162 + doubled, " vertices lie on others")),
              std::string::npos)
        << outcome.out;
    const Collection repaired = fixed();
    EXPECT_TRUE(repaired.topology.is_closed());
    EXPECT_EQ(repaired.topology.face_count(), 320);
}

TEST_F(Check, PatchesThatNearlyMeetAreSaidAndNoneIsThrownAway)
{
    const CutMesh cut = cut_along_the_equator(sphere(0), true);
    for (unsigned i = 0; i < 7; ++i) {
        Points points = cut.points(sphere(i).points);
        points.bottomRows(cut.doubled(sphere(0).points)).array() += 1e-5;
        write(i, points, cut.faces);
    }
    EXPECT_NE(shape({"check", "set"}).out.find("vertices lie near others, up to "),
              std::string::npos);
    const Outcome outcome = shape({"check", "set", "--fix", "repaired"});
    EXPECT_EQ(outcome.exit_code, 3);
    for (const char* said : {"0 meshes written, 0 changes", "all 2 pieces, as 1 meets the largest",
                             "left to repair: m0 (not written): several_components"})
        EXPECT_NE(outcome.err.find(said), std::string::npos) << said << "\n" << outcome.err;
    EXPECT_FALSE(folder_.has("repaired"));
}

TEST_F(Check, ASeamThatNearlyCloses)
{
    const CutMesh cut = cut_along_the_equator(sphere(0));
    const auto write_apart = [&](unsigned i, double share) {
        Points points = cut.points(sphere(i).points);
        points.bottomRows(cut.doubled(sphere(0).points)).col(0).array() +=
            share * bounding_box_diagonal(points);
        write(i, points, cut.faces);
    };
    for (unsigned i = 0; i < 7; ++i)
        write_apart(i, 1e-6);
    expect_said("near_seam", {"boundary vertices lie near one another, up to 1e-06 of the diagonal",
                              "merge vertices by that distance"});
    for (unsigned i = 0; i < 5; ++i)
        write_apart(i, 0.01);
    const Json figures = run({"check", "set"});
    EXPECT_TRUE(figures["warnings"].empty()) << figures["warnings"].dump();
    EXPECT_EQ(figures["suspicious"], 2);
    EXPECT_EQ(figures["meshes"][6]["warnings"][0]["kind"], "touching");
    EXPECT_NE(figures["meshes"][6]["warnings"][0]["message"].get<std::string>().find(
                  "lie on others or up to 1e-06 of the diagonal away in this mesh"),
              std::string::npos);
}

TEST_F(Check, TheSlitDoublePyramidOfTwoMeshesIsASeam)
{
    const std::string faces =
        "3 0 1 2\n3 0 6 3\n3 0 3 4\n3 0 4 1\n3 5 2 1\n3 5 3 6\n3 5 4 3\n3 5 1 4\n";
    const auto pyramids = [&](const std::string& top) {
        return "OFF\n7 8 0\n0 0 " + top + "\n1 0 0\n0 1 0\n-1 0 0\n0 -1 0\n0 0 -1\n0 1 0\n" + faces;
    };
    folder_.write("p.off", pyramids("1"));
    folder_.write("q.off", pyramids("2"));
    const Outcome blended =
        shape({"interpolate", "p.off", "q.off", "--weights", "0.5,0.5", "-o", "x.off"});
    EXPECT_EQ(blended.exit_code, 0) << blended.err;
    EXPECT_NE(blended.err.find("2 boundary vertices lie on one another"), std::string::npos)
        << blended.err;
    EXPECT_NE(blended.err.find("vertices 2 and 6"), std::string::npos) << blended.err;
}

TEST_F(Check, SplitPartsOfASharpSolidAreSaidToBeDoubled)
{
    folder_.write("cube.obj",
                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 0\nv 1 0 0\nv 0 0 -1\nv 1 0 -1\n"
                  "f 1 2 3\nf 3 2 4\nf 6 5 7\nf 6 7 8\n");
    const Outcome outcome = shape({"check", "cube.obj"});
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_NE(outcome.out.find("4 of 8 vertices lie on others"), std::string::npos) << outcome.out;
    const Outcome collected = shape({"collect", "cube.obj", "-o", "c.h5"});
    for (const char* part : {"4 of 8 vertices lie on others", "`shape check --fix DIR` welds them"})
        EXPECT_NE(collected.err.find(part), std::string::npos) << collected.err;
    folder_.write("turned.obj",
                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 1 1 0\nv 2 1 0\nv 1 2 0\nf 1 2 3\nf 2 3 "
                  "4\nf 5 6 7\n");
    const Outcome turned = shape({"collect", "turned.obj", "-o", "c.h5"});
    EXPECT_NE(turned.err.find("flip one"), std::string::npos) << turned.err;
    EXPECT_EQ(turned.err.find("welds them"), std::string::npos) << turned.err;
    EXPECT_EQ(shape({"check", "cube.obj", "--fix", "repaired"}).exit_code, 0);
    EXPECT_EQ(read_mesh(folder_ / "repaired/cube.ply").points.rows(), 6);
}

TEST_F(Check, ASeamThatBreaksTheSurfaceIsSaidToBeOne)
{
    // Two tetrahedra that share vertex 0, which one of them has twice.
    folder_.write("bow.obj",
                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv -1 0 0\nv 0 -1 0\nv 0 0 -1\nv 1 0 0\n"
                  "f 1 3 2\nf 1 2 4\nf 8 3 4\nf 1 4 3\nf 1 5 6\nf 1 7 5\nf 5 7 6\nf 1 6 7\n");
    const Outcome outcome = shape({"check", "bow.obj"});
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_NE(outcome.out.find("2 of 8 vertices lie on others"), std::string::npos) << outcome.out;
    EXPECT_EQ(outcome.out.find("lie on others"), outcome.out.rfind("lie on others"));
}

TEST_F(Check, OffersRepairsToWhatCanBeReadAlone)
{
    folder_.write("bad.obj", "v 0 0 zero\n");
    EXPECT_EQ(shape({"check", "bad.obj"}).err.find("--fix"), std::string::npos);
    write(3, sphere(3).points, reversed_faces(sphere(3).topology.faces()));
    EXPECT_NE(shape({"check", "set"}).err.find("--fix DIR"), std::string::npos);
}

TEST_F(Check, MirrorImagesAreSaidAndRepaired)
{
    write(2, mirror_image(sphere(2).points), sphere(2).topology.faces());
    expect_said("mirrored", {"m2 is a mirror image", "inside out", "leave it out: " + repair});
    EXPECT_EQ(fixed().points[2], sphere(2).points);
}

TEST_F(Check, ASoundMirrorImageIsNotAdvisedToReverseItsFacesAlone)
{
    const Faces reversed = reversed_faces(sphere(4).topology.faces());
    write(4, mirror_image(sphere(4).points), reversed);
    Outcome outcome = shape({"collect", "set", "-o", "c.h5"});
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_NE(outcome.err.find("mirror image: mirror it back"), std::string::npos) << outcome.err;
    EXPECT_EQ(fixed().points[4], sphere(4).points);
    write(4, sphere(4).points, reversed);
    outcome = shape({"collect", "set", "-o", "c.h5"});
    EXPECT_NE(outcome.err.find("inside out: reverse its faces"), std::string::npos) << outcome.err;
}

TEST_F(Check, AllInsideOutIsSaidAndRepaired)
{
    for (unsigned i = 0; i < 7; ++i)
        write(i, sphere(i).points, reversed_faces(sphere(i).topology.faces()));
    expect_said("inside_out", {"all meshes are inside out", "on export), or " + repair});
    EXPECT_EQ(fixed().topology.faces(), sphere(0).topology.faces());
}

TEST_F(Check, OtherUnitsAreSaidAndRepaired)
{
    write(1, 1000.0 * sphere(1).points, sphere(1).topology.faces());
    write(6, 1000.0 * sphere(6).points, sphere(6).topology.faces());
    expect_said("size", {"m1 and m6 are ", "millimetres and metres",
                         "(" + repair + " scales by 10, 100 and 1000 where that leaves no doubt)"});
    EXPECT_TRUE(fixed().points[6].isApprox(sphere(6).points, 1e-12));
}

TEST_F(Check, CopiesUnderOtherNamesAreSaid)
{
    write(3, sphere(5).points, sphere(5).topology.faces());
    write(4, sphere(5).points.rowwise() + Eigen::RowVector3d(3, 0, 1), sphere(5).topology.faces());
    const Json figures = run({"check", "set"});
    ASSERT_EQ(figures["warnings"].size(), 1U) << figures["warnings"].dump();
    EXPECT_EQ(figures["warnings"][0]["kind"], "copies");
    EXPECT_EQ(figures["suspicious"], 2);
    const std::string said = figures["warnings"][0]["message"];
    EXPECT_TRUE(said.starts_with("m3, m4 and m5 are copies of one mesh")) << said;
}

TEST_F(Check, NamesThatATableTakesForOneAreSaid)
{
    const TestMesh other = sphere(9);
    write_mesh(folder_ / "set/m0 .ply", other.points, other.topology.faces(), MeshFormat::Ply);
    expect_said("names_alike", {"set/m0.ply", "set/m0 .ply", "composition of accents alone"});
    EXPECT_EQ(run({"check", "set"})["suspicious"], 2);
}

TEST_F(Check, CopiesThatWereRoundedAreSaidByAppendingToo)
{
    EXPECT_EQ(shape({"collect", "set", "-o", "c.h5"}).exit_code, 0);
    std::filesystem::create_directory(folder_ / "more");
    const Points text = (1e4 * sphere(5).points).array().round() / 1e4;
    write_mesh(folder_ / "more/text.obj", text, sphere(5).topology.faces(), MeshFormat::Obj);
    Points single = sphere(4).points.rowwise() + Eigen::RowVector3d(0, 0, 900);
    single = single.cast<float>().cast<double>();
    write_mesh(folder_ / "more/moved.ply", single, sphere(4).topology.faces(), MeshFormat::Ply);
    write_mesh(folder_ / "more/other.ply", sphere(9).points, sphere(9).topology.faces(),
               MeshFormat::Ply);
    const Outcome together = shape({"check", "set", "more"});
    const Outcome appended = shape({"collect", "more", "--append", "-o", "c.h5"});
    EXPECT_EQ(appended.exit_code, 0) << appended.err;
    for (const char* copies : {"m4 and moved are copies of one mesh, in place or moved, up to ",
                               "m5 and text are copies of one mesh, in place or moved, up to "}) {
        EXPECT_NE(together.out.find(copies), std::string::npos) << together.out;
        EXPECT_NE(appended.err.find(copies), std::string::npos) << appended.err;
    }
    // What the collection held before is not said again.
    write_mesh(folder_ / "late.ply", sphere(10).points, sphere(10).topology.faces(),
               MeshFormat::Ply);
    const Outcome late = shape({"collect", "late.ply", "--append", "-o", "c.h5"});
    EXPECT_EQ(late.err.find("copies"), std::string::npos) << late.err;
}

TEST_F(Check, ExchangedVerticesAreSaid)
{
    Points points = sphere(3).points;
    points.row(7).swap(points.row(99));
    write(3, points, sphere(3).topology.faces());
    const Json figures = run({"check", "set"});
    ASSERT_EQ(figures["warnings"].size(), 1U) << figures["warnings"].dump();
    EXPECT_EQ(figures["warnings"][0]["kind"], "outlier");
    EXPECT_EQ(figures["meshes"][3]["warnings"].size(), 1U);
    EXPECT_TRUE(figures["warnings"][0]["message"].get<std::string>().starts_with("m3 is far"));
}

TEST_F(Check, FixNamesTheMeshesThatAreRepairedLast)
{
    write(2, test::mirror_image(sphere(2).points), sphere(2).topology.faces());
    Points swelled = 1000.0 * sphere(5).points;
    write(5, swelled, sphere(5).topology.faces());
    const Outcome outcome = shape({"check", "set", "--fix", "repaired"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_TRUE(
        outcome.err.ends_with("  repaired: m2 and m5 of 7 meshes; the others are as they were\n"))
        << outcome.err;
    EXPECT_EQ(run({"check", "set", "--fix", "again"})["fix"]["repaired"], Json({"m2", "m5"}));
    // Nothing is said of none.
    EXPECT_EQ(shape({"check", "repaired", "--fix", "third"}).err.find("repaired: "),
              std::string::npos);
}

TEST_F(Check, FixWritesWhatIsSoundAndSaysWhatIsLeft)
{
    folder_.write("set/n0.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 5 5\nf 1 2 3 4\n");
    folder_.write("set/n1.obj", "v 0 0 zero\n");
    folder_.write("set/n2.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 4 3 2\n");
    const Outcome outcome = shape({"check", "set", "--fix", "repaired", "--json"});
    EXPECT_EQ(outcome.exit_code, 3);
    const Json fix = Json::parse(outcome.out)["fix"];
    EXPECT_EQ(files_in(folder_ / "repaired").size(), 8U); // the spheres and the split square
    const NamedMesh square = read_mesh(folder_ / "repaired/n0.ply");
    EXPECT_EQ(square.points.rows(), 4);
    EXPECT_EQ(square.faces.rows(), 2);
    EXPECT_GE(fix["changes"].size(), 2U);
    ASSERT_EQ(fix["left"].size(), 3U) << fix["left"].dump();
    EXPECT_EQ(fix["left"][0]["name"], "n1");
    EXPECT_EQ(fix["left"][1]["written"], true);
    EXPECT_EQ(fix["left"][2]["written"], false);
    EXPECT_FALSE(folder_.has("set/n0.ply"));
}

TEST_F(Check, FixSplitsIntoPartsThatCorrespondToTheSamePartAlone)
{
    const std::string text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\n"
        "f 1 2 3\nf 3 2 4\nf 5 6 7\n";
    folder_.write("pieces/a.obj", text);
    folder_.write("pieces/b.obj", text);
    const Outcome outcome =
        shape({"check", "pieces", "--fix", "parts", "--components", "split", "--json"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(Json::parse(outcome.out)["fix"]["left"].empty()) << outcome.out;
    EXPECT_EQ(
        files_in(folder_ / "parts"),
        (std::vector<std::string>{"a_part1.ply", "a_part2.ply", "b_part1.ply", "b_part2.ply"}));
}

TEST_F(Check, FixAsksWhichOfTwoLikePiecesIsMeant)
{
    folder_.write("halves/a.obj",
                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\nf 4 5 6\n");
    const Outcome asked = shape({"check", "halves", "--fix", "parts"});
    EXPECT_EQ(asked.exit_code, 3);
    for (const char* said : {"left as it is: a: all 2 pieces, as the largest has 1 of 2 faces and "
                             "the next one 1: which of them is meant is a guess",
                             "--components largest or split chooses"})
        EXPECT_NE(asked.err.find(said), std::string::npos) << asked.err;
    EXPECT_FALSE(folder_.has("parts"));
    EXPECT_EQ(shape({"check", "halves", "--fix", "parts", "--components", "largest"}).exit_code, 0);
    EXPECT_TRUE(folder_.has("parts/a.ply"));
}

TEST_F(Check, SheetsThatBendTheOtherWayAreSaidAndLeft)
{
    const TestMesh sheet = open_patch(8, 1);
    for (unsigned i = 0; i < 7; ++i) {
        Points points = sheet.points;
        points.col(2) = (i == 4 ? -0.1 : 0.05 + 0.02 * i) * points.col(0).cwiseAbs2();
        write(i, points, sheet.topology.faces());
    }
    const Json figures = run({"check", "set"});
    ASSERT_EQ(figures["warnings"].size(), 1U) << figures["warnings"].dump();
    EXPECT_EQ(figures["warnings"][0]["kind"], "bent");
    const std::string message = figures["warnings"][0]["message"];
    EXPECT_TRUE(message.starts_with("m4 bends the other way than the other 6 meshes")) << message;
    EXPECT_EQ(message.find("--fix"), std::string::npos) << message;
    const Outcome outcome = shape({"check", "set", "--fix", "repaired"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_NE(outcome.err.find("left as it is: m4: not mirrored, it bends"), std::string::npos)
        << outcome.err;
}

TEST_F(Check, FixLeavesWhatItWouldHaveToGuess)
{
    // Permuted vertices under the same faces, mirrored and in another unit, and two kinds that differ by 2.5.
    std::vector<int> order;
    for (int v = 0; v < 162; ++v)
        order.push_back(v * 7 % 162);
    const Points permuted = 1000.0 * sphere(3).points(order, Eigen::all);
    write(3, permuted, sphere(3).topology.faces());
    EXPECT_EQ(shape({"check", "set"}).out.find("mirror image"), std::string::npos);
    Outcome outcome = shape({"check", "set", "--fix", "repaired"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("7 meshes written, 0 changes"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("left as it is: m3: far from all others"), std::string::npos)
        << outcome.err;
    EXPECT_EQ(read_mesh(folder_ / "repaired/m3.ply").points, permuted);
    for (unsigned i = 0; i < 7; ++i)
        write(i, (i < 3 ? 2.54 : 1.0) * sphere(i).points, sphere(i).topology.faces());
    outcome = shape({"check", "set", "--fix", "kinds"});
    EXPECT_NE(outcome.err.find("7 meshes written, 0 changes"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("m0, m1 and m2: not scaled, 2.5"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("centimetres and inches (times 0.394), or a real difference"),
              std::string::npos)
        << outcome.err;
}

TEST_F(Check, FixKeepsTheLabelsOfACollectionInATableBesideItsMeshes)
{
    EXPECT_EQ(shape({"collect", "set", "-o", "c.h5"}).exit_code, 0);
    Collection collection = read_collection(folder_ / "c.h5");
    collection.names[2] = "a/b";
    collection.labels = {{"sex", {"f", "m", "f", "m", "f", "m", ""}}};
    write_collection(folder_ / "l.h5", collection);
    const Json fix = run({"check", "l.h5", "set/m2.ply", "--fix", "repaired"})["fix"];
    EXPECT_EQ(fix["outputs"].back(), "repaired/labels.csv");
    EXPECT_EQ(folder_.read("repaired/labels.csv"),
              "mesh,sex\nm0,f\nm1,m\na_b,f\nm3,m\nm4,f\nm5,m\nm6,\nm2,\n");
    EXPECT_NE(shape({"check", "l.h5", "--fix", "again"}).err.find("labels: again/labels.csv"),
              std::string::npos);
    EXPECT_EQ(
        shape({"collect", "repaired", "-o", "r.h5", "--labels", "repaired/labels.csv"}).exit_code,
        0);
    EXPECT_EQ(read_collection(folder_ / "r.h5").names[0], "a_b");
    EXPECT_EQ(read_collection(folder_ / "r.h5").labels[0].values[0], "f");
    (void)run({"check", "set", "--fix", "plain"});
    EXPECT_FALSE(folder_.has("plain/labels.csv"));
}

TEST_F(Check, FixKeepsTheLabelsOfTheParts)
{
    const TestMesh whole = sphere(0);
    Points points(whole.points.rows() + 3, 3);
    points << whole.points, 9.0 * Eigen::Matrix3d::Identity();
    Faces faces(whole.topology.face_count() + 1, 3);
    faces << whole.topology.faces(), Eigen::RowVector3i(162, 163, 164);
    write_mesh(folder_ / "two.ply", points, faces, MeshFormat::Ply);
    Collection collection{whole.topology, {"one_part1"}, {whole.points}, {{"sex", {"m"}}}};
    write_collection(folder_ / "l.h5", collection);
    (void)shape({"check", "l.h5", "two.ply", "--fix", "parts", "--components", "split"});
    EXPECT_EQ(folder_.read("parts/labels.csv"), "mesh,sex\none_part1,m\ntwo_part1,\ntwo_part2,\n");
}

TEST_F(Check, FixNamesWhatHasNoNameOfItsOwnByItsPath)
{
    std::filesystem::create_directory(folder_ / "other");
    write_mesh(folder_ / "other/m1.ply", sphere(9).points,
               reversed_faces(sphere(9).topology.faces()), MeshFormat::Ply);
    const Outcome outcome = shape({"check", "set", "other", "--fix", "repaired"});
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_NE(outcome.err.find("7 meshes written, 0 changes"), std::string::npos) << outcome.err;
    EXPECT_NE(
        outcome.err.find("left to repair: other/m1.ply (not written): repeated_name: the mesh "
                         "of set/m1.ply is called 'm1' too; rename one of the files"),
        std::string::npos)
        << outcome.err;
    EXPECT_EQ(read_mesh(folder_ / "repaired/m1.ply").points, sphere(1).points);
}

TEST_F(Check, FixTakesADirectoryAndNoFile)
{
    const auto before = folder_.content();
    for (const char* file : {"f.h5", "f.PLY", "repaired/f.obj", "f.csv"}) {
        const Outcome outcome = shape({"check", "set", "--fix", file});
        EXPECT_EQ(outcome.exit_code, 2) << file;
        EXPECT_NE(outcome.err.find(join("--fix: '", file,
                                        "' has the ending of a file; name a "
                                        "directory")),
                  std::string::npos)
            << outcome.err;
    }
    EXPECT_EQ(folder_.content(), before);
    for (const char* directory : {"v1.2", "g.ply/"})
        EXPECT_EQ(shape({"check", "set", "--fix", directory}).exit_code, 0) << directory;
    EXPECT_EQ(files_in(folder_ / "g.ply").size(), 7U);
    EXPECT_EQ(shape({"check", "set", "--fix", "g.ply", "--force"}).exit_code, 0); // it is one
}

TEST_F(Check, FixNeverWritesBesideTheInput)
{
    const auto before = folder_.content();
    const Outcome outcome = shape({"check", "set", "--fix", "set", "--force"});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("another directory"), std::string::npos) << outcome.err;
    EXPECT_EQ(folder_.content(), before);
    EXPECT_EQ(shape({"check", "set", "--components", "split"}).exit_code, 2);
}

TEST_F(Check, CoarseCoordinatesAreSaid)
{
    for (unsigned i = 0; i < 7; ++i)
        write(i, (sphere(i).points.array() + 8e5).cast<float>().cast<double>(),
              sphere(i).topology.faces());
    expect_said("coarse", {"multiples of 0.0625", "% of the median edge", "local origin"});
}

TEST_F(Check, ConcavePolygonsOfACollectionAreCutAlikeAndWithoutFolds)
{
    std::filesystem::create_directory(folder_ / "polygons");
    // A box over an L, its floor and its lid polygons of six corners.
    for (const double height : {1.0, 1.5, 2.0}) {
        std::string text;
        for (const double z : {0.0, height})
            for (const char* xy : {"2 0", "2 1", "1 1", "1 2", "0 2", "0 0"})
                text += join("v ", xy, " ", z, "\n");
        for (int i = 0; i < 6; ++i)
            text += join("f ", i + 1, " ", (i + 1) % 6 + 1, " ", (i + 1) % 6 + 7, " ", i + 7, "\n");
        folder_.write(join("polygons/m", height, ".obj"),
                      text + "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n");
    }
    ASSERT_EQ(shape({"check", "polygons", "--fix", "cut"}).exit_code, 0);
    ASSERT_EQ(shape({"collect", "cut", "-o", "cut.h5"}).exit_code, 0);
    ASSERT_EQ(shape({"collect", "polygons", "--triangulate", "-o", "read.h5"}).exit_code, 0);
    for (const char* file : {"cut.h5", "read.h5"}) {
        const Collection boxes = read_collection(folder_ / file);
        ASSERT_EQ(boxes.size(), 3U);
        double area = 0.0;
        for (const auto& face : boxes.topology.faces().rowwise()) {
            const Eigen::RowVector3d at = boxes.points[0].row(face[0]);
            area += 0.5 * (boxes.points[0].row(face[1]) - at)
                              .cross(Eigen::RowVector3d(boxes.points[0].row(face[2]) - at))
                              .norm();
        }
        EXPECT_NEAR(area, 2.0 * 3.0 + 8.0, 1e-12) << file;
    }
}

} // namespace
} // namespace shape::test
