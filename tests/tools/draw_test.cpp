// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "libshape/base/format.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/table_file.h"
#include "libshape/io/vertex_scalars.h"
#include "tests/tools/program.h"

namespace shape::test {
using namespace internal;
namespace {

using Arguments = std::vector<std::string>;
using Json = nlohmann::json;

/// Values at vertices: where they come from and how they are drawn.
class ColouredMeshes : public testing::Test
{
protected:
    ColouredMeshes() { write_bumpy_spheres(folder_); }

    [[nodiscard]] Outcome run(const Arguments& arguments) const
    {
        return run_shape(folder_.path(), arguments);
    }
    [[nodiscard]] Json figures(Arguments arguments) const
    {
        arguments.emplace_back("--json");
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.exit_code == 0 ? Json::parse(outcome.out) : Json();
    }
    void expect_refused(const Arguments& arguments, int code, const char* said) const
    {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.exit_code, code) << outcome.err;
        EXPECT_EQ(line_count(outcome.err), 1) << outcome.err;
        EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
        EXPECT_FALSE(folder_.has("x.svg"));
    }

    /// a.ply with a property `heat` that runs evenly over its vertices.
    void write_heat(const std::string& file, double low, double high) const
    {
        const NamedMesh mesh = read_mesh(folder_ / "a.ply");
        write_vertex_scalars(folder_ / file, mesh.points, mesh.faces,
                             {{"heat", Eigen::VectorXd::LinSpaced(mesh.points.rows(), low, high)}});
    }

    const Folder folder_;
};

TEST_F(ColouredMeshes, SpanTheRangeOfTheirValues)
{
    write_heat("cold.ply", 1.0, 2.0);
    write_heat("hot.ply", 2.0, 5.0);
    const auto range = [&](const Arguments& rest) {
        Arguments draw{"draw", "--color-by", "heat", "-o", "x.svg", "--force"};
        draw.insert(draw.end(), rest.begin(), rest.end());
        return figures(draw)["color_range"];
    };
    EXPECT_EQ(range({"cold.ply", "hot.ply"}), Json({1.0, 5.0}));
    EXPECT_NE(folder_.read("x.svg").find(">heat<"), std::string::npos);
    EXPECT_EQ(range({"cold.ply", "--color-range", "-3:4"}), Json({-3.0, 4.0}));
    write_heat("signed.ply", -1.0, 4.0);
    EXPECT_EQ(range({"signed.ply"}), Json({-4.0, 4.0}));
    write_heat("even.ply", 3.0, 3.0);
    EXPECT_EQ(range({"even.ply"}), Json({3.0, 6.0}));
}

TEST_F(ColouredMeshes, DifferFromPlainOnes)
{
    write_heat("hot.ply", 2.0, 5.0);
    (void)figures({"draw", "hot.ply", "--color-by", "heat", "-o", "coloured.png"});
    (void)figures({"draw", "hot.ply", "-o", "plain.png"});
    EXPECT_NE(folder_.read("coloured.png"), folder_.read("plain.png"));
}

TEST_F(ColouredMeshes, AreRefusedWithoutValues)
{
    write_heat("hot.ply", 2.0, 5.0);
    const NamedMesh mesh = read_mesh(folder_ / "a.ply");
    write_mesh(folder_ / "a.obj", mesh.points, mesh.faces, MeshFormat::Obj);
    ASSERT_EQ(run({"collect", "a.ply", "-o", "f.h5"}).exit_code, 0);
    const Arguments draw{"draw", "--color-by", "heat", "-o", "x.svg"};
    const auto with = [&](const Arguments& rest) {
        Arguments all = draw;
        all.insert(all.end(), rest.begin(), rest.end());
        return all;
    };
    expect_refused(with({"a.ply"}), 3, "'heat'");
    expect_refused(with({"a.obj"}), 3, "PLY files alone");
    expect_refused(with({"f.h5"}), 3, "--color-by needs PLY");
    expect_refused(with({"hot.ply", "--color-range", "3"}), 2, "LOW:HIGH");
    expect_refused(with({"hot.ply", "--color-range", "3:x"}), 2, "--color-range");
    expect_refused(with({"hot.ply", "--color-range", "3:2"}), 2, "below");
    expect_refused({"draw", "hot.ply", "-o", "x.svg", "--color-range", "1:2"}, 2, "--color-by");
}

TEST_F(ColouredMeshes, MayBeColouredByACoordinate)
{
    const NamedMesh mesh = read_mesh(folder_ / "a.ply");
    (void)figures({"draw", "a.ply", "--color-by", "z", "-o", "z.svg"});
    const double low = mesh.points.col(2).minCoeff();
    const double high = mesh.points.col(2).maxCoeff();
    const double reach = std::max(-low, high);
    EXPECT_EQ(figures({"draw", "a.ply", "--color-by", "z", "-o", "z.png"})["color_range"],
              Json({-reach, reach}));
    expect_refused({"draw", "a.ply", "--color-by", "heat", "-o", "x.svg"}, 3,
                   "'heat'; they have x, y and z");
}

TEST_F(ColouredMeshes, AreGreyWhereThereIsNoValue)
{
    const auto write = [&](const std::string& file, const std::string& first,
                           const std::string& rest) {
        folder_.write(file,
                      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                      "property float y\nproperty float z\nproperty float heat\n"
                      "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
                      "0 0 0 " +
                          first + "\n1 0 0 " + rest + "\n0 1 0 " + rest + "\n0 0 1 " + rest +
                          "\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    };
    write("some.ply", "-nan(ind)", "3");
    write("none.ply", "nan", "nan");
    const Outcome some = run({"draw", "some.ply", "none.ply", "--color-by", "heat", "-o", "s.svg"});
    EXPECT_EQ(some.exit_code, 0) << some.err;
    EXPECT_NE(some.err.find("heat: 5 of 8 vertices have no finite value and are grey"),
              std::string::npos)
        << some.err;
    EXPECT_NE(some.err.find("colours from 3 to 6"), std::string::npos) << some.err;
    const Json none = figures({"draw", "none.ply", "--color-by", "heat", "-o", "n.svg"});
    EXPECT_FALSE(none.contains("color_range"));
    EXPECT_EQ(folder_.read("n.svg").find(">heat<"), std::string::npos); // no bar of colours
}

/// A picture of two meshes above a plot of scores.
class DrawnScores : public ColouredMeshes
{
protected:
    [[nodiscard]] Outcome draw(const std::string& table, const std::string& color_by = "") const
    {
        folder_.write("s.csv", table);
        Arguments arguments{"draw", "a.ply", "b.ply", "--scores", "s.csv", "-o", "x.svg"};
        if (!color_by.empty())
            arguments.insert(arguments.end(), {"--color-by", color_by});
        return run(arguments);
    }
    void expect_legend(const std::vector<std::string>& there,
                       const std::vector<std::string>& missing) const
    {
        const std::string picture = folder_.read("x.svg");
        for (const std::string& text : there)
            EXPECT_NE(picture.find(">" + text + "<"), std::string::npos) << text;
        for (const std::string& text : missing)
            EXPECT_EQ(picture.find(">" + text + "<"), std::string::npos) << text;
        std::filesystem::remove(folder_ / "x.svg");
    }
    void expect_refused_scores(const std::string& table, const char* said,
                               const std::string& color_by = "") const
    {
        const Outcome outcome = draw(table, color_by);
        EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
        EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
        EXPECT_FALSE(folder_.has("x.svg"));
    }
};

TEST_F(DrawnScores, AreColouredByTheRulesOfLabels)
{
    EXPECT_EQ(draw("mesh, sex ,size,residual,pc1,pc2\na,NA,1,0,1,2\nb,nan,1,0,2,1\nc, f,1,0,0,1\n"
                   "d,f ,1, 0 , 3 ,1\ne,.,1,0,3,2\nf,m,1,0,3,3\n,,,,,\n",
                   "sex")
                  .exit_code,
              0);
    expect_legend({"no value", "f", "m"}, {"NA", "nan", ".", " f"});
    std::string ages = "mesh,size,residual,pc1,pc2,age\n"; // behind the scores, as people add it
    for (int i = 0; i < 9; ++i)
        ages += join("m", i, ",1,0,", i, ",", i * i, ",", i == 4 ? "NA" : join(20 + i), "\n");
    const Outcome scale = draw(ages, "age");
    EXPECT_EQ(scale.exit_code, 0) << scale.err;
    expect_legend({"age"}, {"21", "NA", "no value"});
    const Outcome alike = draw("mesh,sex,residual,pc1,pc2\na,f,0,1,2\nb,F,0,2,1\n", "sex");
    EXPECT_NE(alike.err.find("s.csv: label 'sex' has the values 'f' and 'F'"), std::string::npos)
        << alike.err;
    expect_legend({"f", "F"}, {});
}

TEST_F(DrawnScores, AreOfOneRowAMesh)
{
    const std::string head = "mesh,residual,pc1,pc2\n";
    expect_refused_scores(head + "a,0,1,2\nb,0,2,1\n a ,0,1,2\n", "s.csv: mesh 'a' occurs twice");
    expect_refused_scores(head + "a,0,1,x\n", "s.csv, mesh a, column pc2: 'x'");
    expect_refused_scores(head + "a,0,NA,1\n", "s.csv, mesh a, column pc1: the number is missing");
    expect_refused_scores(head, "no scores");
    expect_refused_scores(head + "a,0,1,2\n", "no column 'sex'; there are mesh, residual, pc1",
                          "sex");
}

/// Effects of four subjects with two moods each.
class Effects : public ColouredMeshes
{
protected:
    Effects()
    {
        std::string labels = "mesh,subject,mood\n";
        for (const std::string mesh : {"a", "b", "c"}) {
            const NamedMesh read = read_mesh(folder_ / (mesh + ".ply"));
            Points glad = read.points;
            glad.col(2) *= 1.1 + 0.01 * (mesh.front() - 'a');
            write_mesh(folder_ / (mesh + "_glad.ply"), glad, read.faces, MeshFormat::Ply);
            labels += mesh + "," + mesh + ",calm\n" + mesh + "_glad," + mesh + ",glad\n";
        }
        folder_.write("moods.csv", labels);
    }

    const Arguments difference_{"difference", "a.ply",      "a_glad.ply", "b.ply",     "b_glad.ply",
                                "c.ply",      "c_glad.ply", "--labels",   "moods.csv", "--pair-by",
                                "subject",    "--from",     "mood=calm",  "--to",      "mood=glad",
                                "-o",         "d.h5",       "--effects"};

    [[nodiscard]] Arguments with(const Arguments& rest) const
    {
        Arguments all = difference_;
        all.insert(all.end(), rest.begin(), rest.end());
        return all;
    }
};

TEST_F(Effects, AreATableOfEdgesAndColoursOfTheMeanMesh)
{
    const Json found = figures(with({"effects.ply"}));
    EXPECT_EQ(found["outputs"], Json({"d.h5"}));
    EXPECT_EQ(found["effects"]["outputs"], Json({"effects.ply", "effects.csv"}));
    EXPECT_EQ(found["effects"]["edges"], 120);
    const Table table = read_table(folder_ / "effects.csv");
    EXPECT_EQ(table.columns, (Arguments{"v0", "v1", "effect", "p", "q"}));
    ASSERT_EQ(table.rows.size(), 120U);
    int significant = 0;
    double largest = 0.0;
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(42);
    Eigen::VectorXd counts = Eigen::VectorXd::Zero(42);
    for (const std::vector<std::string>& row : table.rows) {
        const double effect = std::stod(row[2]);
        significant += std::stod(row[4]) <= 0.05 ? 1 : 0;
        largest = std::max(largest, std::abs(effect));
        EXPECT_LE(std::stod(row[3]), std::stod(row[4]));
        for (const int v : {std::stoi(row[0]), std::stoi(row[1])}) {
            sums[v] += effect;
            counts[v] += 1.0;
        }
    }
    EXPECT_EQ(found["effects"]["significant_edges"], significant);
    EXPECT_EQ(found["effects"]["largest_effect"], largest);
    const Eigen::VectorXd drawn = read_vertex_scalar(folder_ / "effects.ply", "effect");
    EXPECT_LE((drawn - sums.cwiseQuotient(counts)).norm(), 1e-9 * drawn.norm());
    EXPECT_GE(read_vertex_scalar(folder_ / "effects.ply", "magnitude").minCoeff(), 0.0);
    EXPECT_LE(read_vertex_scalar(folder_ / "effects.ply", "significant").maxCoeff(), 1.0);
    (void)figures({"draw", "effects.ply", "--color-by", "effect", "-o", "effects.svg"});
}

TEST_F(Effects, AreRefusedBeforeAnyWork)
{
    const auto refused = [&](const Arguments& arguments, int code, const char* said) {
        const auto before = folder_.content();
        expect_refused(arguments, code, said);
        EXPECT_TRUE(folder_.content() == before);
    };
    refused(with({"effects.csv"}), 2, "--effects");
    folder_.write("effects.csv", "old");
    refused(with({"effects.ply"}), 5, "effects.csv");
    refused(with({"a.ply", "--force"}), 2, "a.ply");
    folder_.write("labels.csv", "mesh,subject,mood\na,x,calm\na_glad,x,glad\nb,y,calm\nc,z,calm\n");
    refused({"difference", "a.ply", "a_glad.ply", "b.ply", "c.ply", "--labels", "labels.csv",
             "--pair-by", "subject", "--from", "mood=calm", "--to", "mood=glad", "-o", "e.h5",
             "--effects", "e.ply"},
            3, "two or more");
}

} // namespace
} // namespace shape::test
