// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "libshape/base/format.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/mesh_file.h"
#include "tests/tools/program_test.h"

namespace shape::test {
using namespace internal;
namespace {

constexpr int side = 5; ///< Quads along the side of a hat.

/// Hats, sheets of quads with a bump, as polygons (q0.obj, ...) and as triangles of diagonals that are not those of fans
/// (t0.ply, ...); and one whose quads are cut along the others (other.ply).
class Polygons : public ProgramTest
{
protected:
    Polygons()
    {
        static const MadeOnce made(fill);
        made.copy_into(folder_);
    }

    static Points hat(int number)
    {
        Points points((side + 1) * (side + 1), 3);
        for (int v = 0; v < points.rows(); ++v) {
            const double x = v % (side + 1), y = v / (side + 1);
            points.row(v) << x + 0.1 * std::sin(3.0 * y + number), y,
                (2.0 + 0.3 * std::cos(2.0 * number)) *
                    std::exp(-0.4 * ((x - 2.2) * (x - 2.2) + (y - 2.7) * (y - 2.7)));
        }
        return points;
    }

    static Faces triangles(bool is_other)
    {
        Faces faces(2 * side * side, 3);
        for (int i = 0, f = 0; i < side; ++i)
            for (int j = 0; j < side; ++j, f += 2) {
                const int a = i * (side + 1) + j, b = a + 1, d = a + side + 1, c = d + 1;
                if (((i + j) % 3 == 0) != is_other)
                    faces.middleRows(f, 2) << a, b, c, a, c, d;
                else
                    faces.middleRows(f, 2) << a, b, d, b, c, d;
            }
        return faces;
    }

    static std::string quads(const Points& points)
    {
        std::string text;
        for (const auto& row : points.rowwise())
            text += join("v ", row[0], " ", row[1], " ", row[2], "\n");
        for (int i = 0; i < side; ++i)
            for (int j = 0; j < side; ++j) {
                const int a = i * (side + 1) + j + 1;
                text += join("f ", a, " ", a + 1, " ", a + side + 2, " ", a + side + 1, "\n");
            }
        return text;
    }

    static void fill(const Folder& folder)
    {
        std::string labels = "mesh,pair,ex\n";
        for (int i = 0; i < 6; ++i) {
            write_mesh(folder / join("t", i, ".ply"), hat(i), triangles(false));
            folder.write(join("q", i, ".obj"), quads(hat(i)));
            labels += join("t", i, ",", i / 2, ",", i % 2 == 0 ? "a" : "b", "\n");
        }
        folder.write("labels.csv", labels);
        write_mesh(folder / "other.ply", hat(5), triangles(true));
        run_or_throw(folder, {"collect", "t0.ply", "t1.ply", "t2.ply", "t3.ply", "-o", "c.h5"});
        run_or_throw(folder, {"stats", "c.h5", "-o", "m.h5"});
        run_or_throw(
            folder, {"difference", "t0.ply", "t1.ply", "t2.ply", "t3.ply", "--labels", "labels.csv",
                     "--pair-by", "pair", "--from", "ex=a", "--to", "ex=b", "-o", "d.h5"});
    }

    [[nodiscard]] Outcome shape(const Arguments& arguments) const
    {
        return run_shape(folder_.path(), arguments);
    }
};

TEST_F(Polygons, AreCutAsTheMeshesThatTheyComeTo)
{
    for (const Arguments& arguments : std::vector<Arguments>{
             {"collect", "q4.obj", "q5.obj", "--append", "-o", "c.h5"},
             {"project", "m.h5", "q4.obj", "q5.obj", "-o", "scores.csv"},
             {"stats", "q4.obj", "q5.obj", "--update", "m.h5", "-o", "m2.h5"},
             {"remove", "q4.obj", "q5.obj", "--model", "m.h5", "--modes", "1", "-o", "a/"},
             {"remove", "q4.obj", "q5.obj", "--direction", "d.h5", "-o", "b/"},
             {"remove", "t4.ply", "t5.ply", "--model", "m.h5", "--modes", "1", "--like", "q3.obj",
              "-o", "e/"},
             {"difference", "--load", "d.h5", "--onto", "q4.obj", "--mesh", "f.ply"}}) {
        const Outcome outcome = shape(arguments + Arguments{"--triangulate"});
        EXPECT_EQ(outcome.exit_code, 0) << arguments[0] << ' ' << arguments[2] << outcome.err;
        EXPECT_EQ(outcome.err.find("fold"), std::string::npos) << outcome.err;
    }
    const Collection all = read_collection(folder_ / "c.h5");
    EXPECT_EQ(all.size(), 6U);
    EXPECT_EQ(all.topology.faces(), triangles(false));
    EXPECT_EQ(all.points[5].rows(), hat(5).rows());
}

TEST_F(Polygons, AreCutAsTheTrianglesAmongThemWhereverTheseStand)
{
    for (const Arguments& meshes :
         {Arguments{"t0.ply", "q4.obj", "q5.obj"}, Arguments{"q4.obj", "q5.obj", "t0.ply"},
          Arguments{"q4.obj", "c.h5", "q5.obj"}}) {
        const Arguments triangulate{"--triangulate", "--force"};
        const Outcome outcome = shape(Arguments{"collect", "-o", "x.h5"} + meshes + triangulate);
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(read_collection(folder_ / "x.h5").topology.faces(), triangles(false));
        EXPECT_EQ(shape(Arguments{"check"} + meshes + Arguments{"--triangulate"}).exit_code, 0);
        std::filesystem::remove_all(folder_ / "fixed");
        ASSERT_EQ(shape(Arguments{"check", "--fix", "fixed"} + meshes).exit_code, 0);
        EXPECT_EQ(read_mesh(folder_ / "fixed/q5.ply").faces, triangles(false));
    }
}

TEST_F(Polygons, OfOtherDiagonalsAreToldSo)
{
    for (const Arguments& arguments :
         std::vector<Arguments>{{"collect", "t0.ply", "other.ply", "-o", "x.h5"},
                                {"collect", "other.ply", "--append", "-o", "c.h5"},
                                {"project", "m.h5", "other.ply", "-o", "scores.csv"},
                                {"check", "t0.ply", "other.ply"}}) {
        const Outcome outcome = shape(arguments);
        EXPECT_EQ(outcome.exit_code, 3);
        EXPECT_NE(outcome.err.find("25 quads are cut along their other diagonal, first that of "
                                   "vertices 0, 1, 7, 6; read the files that have the polygons"),
                  std::string::npos)
            << outcome.err;
        EXPECT_EQ(outcome.err.find("permuted"), std::string::npos) << outcome.err;
    }
}

TEST_F(Polygons, ThatFoldOverAreInTheWarningsAndThoseThatCrossThemselvesAreRefused)
{
    const std::string start = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 4 0 0\nv 4 2 0\n";
    const std::string faces = "f 1 2 3 4\nf 2 5 6 3\n";
    std::filesystem::create_directory(folder_ / "set");
    folder_.write("set/a.obj", start + faces);
    // A corner of the first lies within it: cut from the opposite one, as in a, it does not fold over, but cut beside it.
    folder_.write("set/b.obj",
                  "v 0 0 0\nv 2 0 0\nv 0.4 0.4 0\nv 0 2 0\nv 4 0 0\nv 4 2 0\n" + faces);
    const auto folded = [](const Json& warnings) {
        return std::ranges::count(warnings, "folded",
                                  [](const Json& warning) { return warning["kind"]; });
    };
    Json figures = run({"check", "set", "--triangulate"});
    EXPECT_EQ(figures["broken"], 0);
    EXPECT_EQ(folded(figures["warnings"]), 0) << figures; // as that fan does
    folder_.write("set/b.obj",
                  "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1.6 0.4 0\nv 4 0 0\nv 4 2 0\n" + faces);
    figures = run({"check", "set", "--triangulate"});
    EXPECT_EQ(folded(figures["warnings"]), 1) << figures;
    EXPECT_EQ(folded(figures["meshes"][0]["warnings"]), 0);
    EXPECT_EQ(folded(figures["meshes"][1]["warnings"]), 1);
    EXPECT_EQ(figures["broken"], 0);
    const Outcome collected = shape({"collect", "set", "--triangulate", "-o", "set.h5"});
    EXPECT_EQ(collected.exit_code, 0);
    EXPECT_NE(collected.err.find("1 polygon cut as in set/a.obj folds over there, first face 0"),
              std::string::npos)
        << collected.err;
    figures = run({"check", "set", "--fix", "folded"});
    EXPECT_NE(figures["fix"]["kept"].dump().find("folds over there"), std::string::npos) << figures;
    // One that crosses itself has no cut that does.
    folder_.write("set/b.obj", "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 2 2 0\nv 4 0 0\nv 4 2 0\n" + faces);
    for (const Arguments& arguments :
         {Arguments{"check", "set", "--triangulate"}, Arguments{"check", "set", "--fix", "crossed"},
          Arguments{"collect", "set", "--triangulate", "-o", "y.h5"}}) {
        const Outcome outcome = shape(arguments);
        EXPECT_EQ(outcome.exit_code, 3) << arguments[0] << outcome.out;
        EXPECT_NE((outcome.out + outcome.err).find("face 0 (vertices 0, 1, 2, 3) crosses itself"),
                  std::string::npos)
            << outcome.out << outcome.err;
    }
    EXPECT_TRUE(std::filesystem::exists(folder_ / "crossed/a.ply"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "crossed/b.ply"));
}

} // namespace
} // namespace shape::test
