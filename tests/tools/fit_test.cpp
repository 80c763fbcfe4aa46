// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <filesystem>

#include "libshape/io/table_file.h"
#include "libshape/io/vertex_scalars.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"
#include "tests/tools/program_test.h"

namespace shape::test {
namespace {

class Fit : public ProgramTest
{
protected:
    Fit()
    {
        const TestMesh pattern = bumpy_sphere(3, 0.3, 5);
        write("pattern.ply", pattern.points, pattern.topology.faces());
        std::filesystem::create_directory(folder_ / "scans");
        const TestMesh scan = bumpy_sphere(4, 0.3, 5);
        for (int i = 0; i < 2; ++i) {
            Points points = scan.points;
            points.col(i) *= 1.1;
            write(join("scans/s", i, ".ply"), points, scan.topology.faces());
        }
    }
    static std::string join(const std::string& a, int i, const std::string& b)
    {
        return a + std::to_string(i) + b;
    }
    void write(const std::string& file, const Points& points, const Faces& faces) const
    {
        write_mesh(folder_ / file, points, faces, MeshFormat::Ply);
    }
    [[nodiscard]] Outcome outcome(const Arguments& arguments) const
    {
        return run_shape(folder_.path(), arguments);
    }
};

TEST_F(Fit, WritesMeshesReportAndPicture)
{
    const Json figures = run({"fit", "pattern.ply", "scans", "-o", "fitted"});
    EXPECT_EQ(figures["good"], 2);
    EXPECT_EQ(figures["failed"], 0);
    EXPECT_EQ(figures["scans"][1]["scan"], "s1");
    EXPECT_EQ(points("fitted/s0.ply").rows(), 642);
    EXPECT_EQ(read_vertex_scalar(folder_ / "fitted/s0.ply", "distance").size(), 642);
    EXPECT_EQ(read_table(folder_ / "fitted/fit.csv").rows.size(), 2U);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "fitted/fit.svg"));
    EXPECT_NE(outcome({"fit", "pattern.ply", "scans", "-o", "fitted"}).exit_code, 0); // exists
    // What is there is taken over; another setting is refused.
    std::filesystem::remove(folder_ / "scans/s1.ply");
    write_bytes(folder_ / "scans/s1.ply", "not a mesh");
    EXPECT_EQ(run({"fit", "pattern.ply", "scans", "-o", "fitted", "--resume"})["good"], 2);
    EXPECT_EQ(
        outcome({"fit", "pattern.ply", "scans", "-o", "fitted", "--resume", "--smoothness", "2"})
            .exit_code,
        3);
}

TEST_F(Fit, ScansWithoutLandmarksAreNamedWithThoseOfNoScan)
{
    const Points scan = points("scans/s0.ply");
    std::string marks = "scan,name,x,y,z,vertex\n";
    for (const char* name : {"s0.ply", "S1"})
        for (const int v : {0, 100, 300, 500})
            marks += std::string(name) + ",l" + std::to_string(v) + "," +
                     std::to_string(scan(v, 0)) + "," + std::to_string(scan(v, 1)) + "," +
                     std::to_string(scan(v, 2)) + "," + std::to_string(v) + "\n";
    folder_.write("marks.csv", marks);
    const Outcome told = outcome({"fit", "pattern.ply", "scans", "-o", "marked", "--landmarks",
                                  "marks.csv", "--keep-failed"});
    EXPECT_EQ(told.exit_code, 0) << told.err;
    EXPECT_NE(told.err.find("no landmarks: s1; landmarks of no scan: S1"), std::string::npos)
        << told.err;
}

TEST_F(Fit, VerticesCountedFromOneAreSaid)
{
    const Points scan = points("scans/s0.ply");
    const auto said = [&](int first, const std::string& to) {
        std::string marks = "scan,name,vertex,x,y,z\n";
        for (const int v : {10, 100, 200, 300, 400, 600}) {
            marks += "s0,l" + std::to_string(v) + "," + std::to_string(v + first);
            for (int k = 0; k < 3; ++k)
                marks +=
                    "," + print_number(scan(v, k)); // both spheres begin with the same vertices
            marks += "\n";
        }
        folder_.write("marks.csv", marks);
        return outcome({"fit", "pattern.ply", "scans/s0.ply", "-o", to, "--landmarks", "marks.csv",
                        "--keep-failed"})
            .err;
    };
    EXPECT_EQ(said(0, "zero").find("counted from 0"), std::string::npos);
    const std::string one = said(1, "one");
    EXPECT_NE(one.find("vertices of the template are counted from 0. Those of s0 miss by "),
              std::string::npos)
        << one;
    EXPECT_NE(one.find("with 1 taken from each"), std::string::npos) << one;
}

TEST_F(Fit, PassesOverLandmarksThatAreNotToBeSeen)
{
    const Points pattern = points("pattern.ply"), scan = points("scans/s0.ply");
    const auto row = [](const std::string& start, const Points& of, int v) {
        std::string text = start;
        for (int k = 0; k < 3; ++k)
            text += "," + print_number(of(v, k));
        return text + "\n";
    };
    std::string marks = "scan, name,vertex,x,y,z\n";
    // Of the template: by place, by vertex alone, and one that it does not have.
    for (const int v : {0, 100, 200})
        marks += row("pattern,l" + std::to_string(v) + ",", pattern, v);
    marks += "pattern,l300,300,,,\npattern,l400,NA,NA,NA,NA\n";
    for (const int v : {0, 100, 200, 300, 400})
        marks += row(" s0 , l" + std::to_string(v) + ",", scan, v);
    marks += "s0,l500,500,NaN,NA, \n,,,,,\n";
    folder_.write("marks.csv", marks);
    const Arguments arguments{"fit",    "pattern.ply", "scans/s0.ply", "-o",
                              "marked", "--landmarks", "marks.csv"};
    const Outcome told = outcome(arguments);
    EXPECT_EQ(told.exit_code, 0) << told.err;
    EXPECT_NE(told.err.find("2 landmarks have no coordinates and are passed over, first 'l400' of "
                            "pattern"),
              std::string::npos)
        << told.err;
    const Json report = Json::parse(folder_.read("marked/fit.json"));
    EXPECT_EQ(report["scans"][0]["landmarks"], 4);
    EXPECT_EQ(report["scans"][0]["status"], "good");
}

TEST_F(Fit, ALandmarkInTheWrongPlaceOfTheTemplateIsNamed)
{
    const TestMesh scan = bumpy_sphere(4, 0.3, 5);
    Points longer = scan.points;
    longer.col(2) *= 1.1;
    write("scans/s2.ply", longer, scan.topology.faces());
    const auto row = [](const std::string& start, const Points& of, int v) {
        std::string text = start;
        for (int k = 0; k < 3; ++k)
            text += "," + print_number(of(v, k));
        return text + "\n";
    };
    const Points pattern = points("pattern.ply");
    Eigen::Index wrong = 0;
    ((pattern.rowwise() - pattern.row(200)).rowwise().norm().array() -
     0.2 * bounding_box_diagonal(pattern))
        .abs()
        .minCoeff(&wrong);
    std::string marks = "scan,name,x,y,z\n";
    for (const int v : {0, 100, 200, 300, 400, 500}) {
        const std::string name = ",l" + std::to_string(v);
        marks += row("pattern" + name, pattern, v == 200 ? static_cast<int>(wrong) : v);
        for (int i = 0; i < 3; ++i)
            marks += row(join("s", i, name), points(join("scans/s", i, ".ply")), v);
    }
    folder_.write("marks.csv", marks);
    const Outcome told =
        outcome({"fit", "pattern.ply", "scans", "-o", "marked", "--landmarks", "marks.csv"});
    EXPECT_EQ(told.exit_code, 0) << told.err;
    EXPECT_NE(told.err.find("landmark 'l200' is doubted in 3 of 3 scans; is its place on the "
                            "template, pattern, the wrong one?"),
              std::string::npos)
        << told.err;
    const Json report = Json::parse(folder_.read("marked/fit.json"));
    EXPECT_EQ(report["scans"][0]["status"], "check");
    EXPECT_EQ(report["scans"][0]["doubted_landmarks"][0]["landmark"], "l200");
    // And when an interrupted run goes on.
    EXPECT_NE(outcome({"fit", "pattern.ply", "scans", "-o", "marked", "--landmarks", "marks.csv",
                       "--resume"})
                  .err.find("is doubted in 3 of 3 scans"),
              std::string::npos);
}

TEST_F(Fit, WritesACollectionWithoutWhatFailed)
{
    Points corners(3, 3);
    corners << 0, 0, 0, 1, 0, 0, 0, 1, 0;
    Faces one(1, 3);
    one << 0, 1, 2;
    write("scans/s2.ply", corners, one);
    write("scans/s3.ply", corners, Faces(0, 3));
    const Json figures = run({"fit", "pattern.ply", "scans", "-o", "c.h5"});
    EXPECT_EQ(figures["failed"], 2);
    EXPECT_EQ(run({"info", "c.h5"})["meshes"], 2);
}

TEST_F(Fit, WritesACollectionWhoseEndingIsInCapitals)
{
    (void)run({"fit", "pattern.ply", "scans/s0.ply", "-o", "M.H5", "--no-search"});
    EXPECT_EQ(run({"info", "M.H5"})["kind"], "collection");
    EXPECT_EQ(read_table(folder_ / "M_fit/fit.csv").rows.size(), 1U);
}

TEST_F(Fit, FitsAGroupAgainAndAModelWithItsScores)
{
    const TestMesh scan = bumpy_sphere(4, 0.3, 5);
    for (int i = 2; i < 5; ++i) {
        Points points = scan.points;
        points.col(i - 2) *= 1.0 + 0.05 * i;
        write(join("scans/s", i, ".ply"), points, scan.topology.faces());
    }
    const Json first =
        run({"fit", "pattern.ply", "scans", "-o", "group.h5", "--rounds", "2", "--no-search"});
    ASSERT_EQ(first["rounds"].size(), 2U);
    EXPECT_EQ(first["rounds"][0]["fits"], 5);
    EXPECT_EQ(first["good"], 5);
    const Arguments again{"fit",      "pattern.ply", "scans",       "-o",      "group.h5",
                          "--rounds", "2",           "--no-search", "--resume"};
    EXPECT_EQ(run(again)["rounds"], first["rounds"]); // nothing was left to do
    const Json model = run({"stats", "group.h5", "-o", "model.h5"});
    const Json held = run({"fit", "model.h5", "scans/s3.ply", "-o", "held", "--no-search"});
    EXPECT_EQ(held["good"], 1);
    const Table scores = read_table(folder_ / "held/scores.csv");
    ASSERT_EQ(scores.rows.size(), 1U);
    EXPECT_EQ(scores.columns.size(), 3U + model["modes"].size()); // mesh, size, residual
    EXPECT_LT(held["scans"][0]["model_residual_rms"].get<double>(), 0.05);
    (void)run({"generate", "model.h5", "--scores-file", "held/scores.csv", "-o", "made.ply"});
    EXPECT_EQ(outcome({"fit", "model.h5", "scans", "-o", "out", "--rounds", "1"}).exit_code, 2);
    EXPECT_EQ(outcome({"fit", "group.h5", "scans", "-o", "out"}).exit_code, 3);
}

TEST_F(Fit, FitsScansThatWereMadeUp)
{
    (void)run({"synth", "faces", "--count", "1", "--vertices", "400", "-o", "faces"});
    const Json made = run({"synth", "scans", "--of", "faces", "--vertices", "600", "--noise", "0.1",
                           "--holes", "1", "-o", "raw"});
    EXPECT_EQ(made["scans"], 3);
    const Json fits = run({"fit", "raw/template.ply", "raw/scans", "--landmarks",
                           "raw/landmarks.csv", "-o", "fitted"});
    EXPECT_EQ(fits["failed"], 0);
    EXPECT_EQ(fits["scans"][0]["landmarks"], 8);
    EXPECT_EQ(outcome({"synth", "torus", "--noise", "0.1", "-o", "t"}).exit_code, 2);
    EXPECT_EQ(outcome({"synth", "scans", "--of", "faces", "--count", "3", "-o", "t"}).exit_code, 2);
}

TEST_F(Fit, SaysWhichScansHaveNamesThatATableTakesForOne)
{
    write("scans/s0 .ply", points("scans/s1.ply"), read_mesh(folder_ / "scans/s1.ply").faces);
    const Outcome told = outcome({"fit", "pattern.ply", "scans", "-o", "fitted"});
    EXPECT_EQ(told.exit_code, 0) << told.err;
    for (const char* said : {"'scans/s0.ply'", "'scans/s0 .ply'", "differ by outer blanks"})
        EXPECT_NE(told.err.find(said), std::string::npos) << told.err;
    // Equal names are refused, also those of scans of another shard.
    std::filesystem::create_directory(folder_ / "more");
    write("more/s0.ply", points("scans/s1.ply"), read_mesh(folder_ / "scans/s1.ply").faces);
    const Outcome refused = outcome(
        {"fit", "pattern.ply", "scans/s0.ply", "more/s0.ply", "-o", "out", "--shard", "1/2"});
    EXPECT_EQ(refused.exit_code, 3);
    EXPECT_NE(refused.err.find("more/s0.ply: two scans are named 's0'"), std::string::npos)
        << refused.err;
}

TEST_F(Fit, NamesNoReportThatIsNotKept)
{
    const Outcome piped = outcome({"fit", "pattern.ply", "scans/s0.ply", "-o", "-"});
    EXPECT_EQ(piped.exit_code, 0) << piped.err;
    EXPECT_NE(piped.err.find("no report is kept with `-o -`"), std::string::npos) << piped.err;
    EXPECT_EQ(piped.err.find("/shape-"), std::string::npos) << piped.err;
}

TEST_F(Fit, SaysInOneLineWhatItCannotUse)
{
    const auto expect = [&](const Arguments& arguments, int code, const std::string& part) {
        const Outcome result = outcome(arguments);
        EXPECT_EQ(result.exit_code, code) << result.err;
        EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
    };
    const std::string scan = "scans/s0.ply";
    write("empty.ply", Points(0, 3), Faces(0, 3));
    expect({"fit", "pattern.ply", "empty.ply", "-o", "out"}, 3,
           "error: empty.ply: the file has 0 vertices");
    expect({"fit", "pattern.ply", scan, "-o", "out.obj"}, 2, "directory or a collection");
    expect({"fit", "empty.ply", scan, "-o", "out"}, 3, "empty.ply");
    expect({"fit", "pattern.ply", scan, "-o", "out", "--boundary", "mouth"}, 2, "--landmarks");
    write_bytes(folder_ / "marks.csv", "scan,name,x,y,z\ns0,nose,1,0,0\n");
    expect({"fit", "pattern.ply", scan, "-o", "out", "--landmarks", "marks.csv"}, 3,
           "is not on the template");
    write_bytes(folder_ / "marks.csv", "scan,name,vertex,x,y,z\ns0,nose,7000,1,0,0\n");
    expect({"fit", "pattern.ply", scan, "-o", "out", "--landmarks", "marks.csv"}, 3, "vertex 7000");
    const Points places = points("pattern.ply");
    std::string marks = "scan,name,x,y,z\n";
    for (const int v : {0, 100, 200, 300, 400})
        for (const auto& [mesh, factor] : {std::pair{"pattern", 0.1}, {"s0", 1.0}}) {
            marks += std::string(mesh) + ",l" + std::to_string(v);
            for (int k = 0; k < 3; ++k)
                marks += "," + print_number(factor * places(v, k));
            marks += "\n";
        }
    write_bytes(folder_ / "marks.csv", marks);
    expect({"fit", "pattern.ply", "scans", "-o", "out", "--landmarks", "marks.csv"}, 3,
           "error: marks.csv: the landmarks of the template look as if");
    std::string coded = "scan,name,x,y,z\npattern,gone,-9999,-9999,-9999\n";
    for (const int v : {0, 100, 200, 300, 400})
        for (const char* mesh : {"pattern", "s0"})
            coded += std::string(mesh) + ",l" + std::to_string(v) + "," +
                     print_number(places(v, 0)) + "," + print_number(places(v, 1)) + "," +
                     print_number(places(v, 2)) + "\n";
    write_bytes(folder_ / "marks.csv", coded);
    expect({"fit", "pattern.ply", "scans", "-o", "out", "--landmarks", "marks.csv"}, 3,
           "error: marks.csv: landmarks of the template: 'gone' lies ");
}

} // namespace
} // namespace shape::test
