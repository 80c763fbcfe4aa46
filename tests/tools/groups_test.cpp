// SPDX-License-Identifier: MIT

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/table_file.h"
#include "tests/support/matrices.h"
#include "tests/support/meshes.h"
#include "tests/tools/program_test.h"

namespace shape::test {
using namespace internal;
namespace {

/// Six subjects, calm and glad (longer along z), in people/ and people.h5. Three are of each sex;
/// one mesh has no value of `gap`, `word` is not a number, and `same` is one for all.
class Groups : public ProgramTest
{
protected:
    Groups()
    {
        static const MadeOnce made(fill);
        made.copy_into(folder_);
    }

    static void fill(const Folder& folder)
    {
        folder.write("people/.keep", "");
        std::string labels = "mesh,subject,mood,sex,age,gap,word,same\n";
        for (unsigned i = 0; i < 6; ++i)
            for (const char* mood : {"calm", "glad"}) {
                TestMesh mesh = bumpy_sphere(1, 0.2, i + 1);
                if (mood == std::string("glad"))
                    mesh.points.col(2) *= 1.2;
                const std::string name = join("s", i, "_", mood);
                write_mesh(folder / ("people/" + name + ".ply"), mesh.points, mesh.topology.faces(),
                           MeshFormat::Ply);
                labels += join(name, ",s", i, ",", mood, ",", i % 2 == 0 ? "f" : "m", ",",
                               20 + (7 * i) % 11, ",", name == "s5_glad" ? "" : "1", ",old,1\n");
            }
        write_bumpy_spheres(folder);
        folder.write("few.csv", folder.read("labels.csv")); // of a.ply, b.ply and c.ply
        folder.write("labels.csv", labels);
        run_or_throw(folder, {"collect", "people", "--labels", "labels.csv", "-o", "people.h5"});
    }

    /// Runs what must fail with one line that names these things, and writes nothing.
    void expect_failure(int exit_code, const Arguments& arguments, const Arguments& said) const
    {
        const std::map<std::string, std::string> before = folder_.content();
        const Outcome outcome = run_shape(folder_.path(), arguments);
        const std::string line = testing::PrintToString(arguments);
        EXPECT_EQ(outcome.exit_code, exit_code) << line << "\n" << outcome.err;
        EXPECT_EQ(line_count(outcome.err), 1) << line << "\n" << outcome.err;
        for (const std::string& part : said)
            EXPECT_NE(outcome.err.find(part), std::string::npos)
                << line << "\n'" << part << "' in: " << outcome.err;
        EXPECT_TRUE(folder_.content() == before) << line << ": a file was made or changed";
    }

    /// Edge lengths of a mesh divided by their sum.
    [[nodiscard]] Eigen::VectorXd shape_of(const std::string& file) const
    {
        const Eigen::VectorXd all = lengths(file);
        return all / all.sum();
    }
};

TEST_F(Groups, AreComparedWithinSubjects)
{
    const Json figures = run({"groups", "people.h5", "--by", "mood", "--within", "subject", "-o",
                              "groups.csv", "--means", "means"});
    EXPECT_EQ(figures["design"], "crossed");
    EXPECT_EQ(figures["overall"]["df"], 1);
    EXPECT_EQ(figures["overall"]["residual_df"], 5);
    EXPECT_LT(figures["overall"]["p_value"], 0.06); // of 64 arrangements two are as extreme
    ASSERT_EQ(figures["pairs"].size(), 1u);
    EXPECT_EQ(figures["pairs"][0]["first"], "calm");
    EXPECT_LT(figures["pairs"][0]["radius"], figures["pairs"][0]["distance"]);
    EXPECT_EQ(figures["groups"][1]["meshes"], 6);
    EXPECT_EQ(figures["outputs"], Json({"means/calm.ply", "means/glad.ply", "groups.csv"}));
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(120);
    for (int i = 0; i < 6; ++i)
        mean += shape_of(join("people/s", i, "_glad.ply")) / 6.0;
    EXPECT_LT(difference(shape_of("means/glad.ply"), mean), 0.02);
    EXPECT_NEAR(lengths("means/glad.ply").sum(), figures["groups"][1]["mean_size"],
                0.01 * lengths("means/glad.ply").sum());

    const Table table = read_table(folder_ / "groups.csv");
    ASSERT_EQ(table.rows.size(), 2u);
    EXPECT_EQ(table.columns.front(), "first");
    EXPECT_EQ(table.columns.back(), "p_adjusted");
    EXPECT_EQ(table.rows[1][1], "glad");
    EXPECT_EQ(parse_number(table.rows[1][2], "distance"), figures["pairs"][0]["distance"]);
}

TEST_F(Groups, WithoutPermutationsHaveNoPValue)
{
    const Json figures =
        run({"groups", "people.h5", "--by", "mood", "--permutations", "0", "-o", "g.csv"});
    EXPECT_TRUE(figures["overall"]["p_value"].is_null());
    EXPECT_GT(figures["overall"]["f"], 0.0);
    const Table table = read_table(folder_ / "g.csv");
    for (const std::vector<std::string>& row : table.rows)
        EXPECT_EQ(row.back(), "");
    EXPECT_TRUE(figures["pairs"][0]["p_adjusted"].is_null());
    EXPECT_TRUE(figures["overall"]["smallest_p"].is_null());
    const Outcome told = run_shape(
        folder_.path(),
        {"groups", "people.h5", "--by", "mood", "--permutations", "0", "-o", "g.csv", "--force"});
    EXPECT_EQ(told.out.find("p ="), std::string::npos) << told.out;
}

TEST_F(Groups, PairsWithoutATestAreNullAndNotCounted)
{
    Table labels = read_table(folder_ / "labels.csv");
    labels.columns = {"mesh", "part"};
    for (std::size_t i = 0; i < labels.rows.size(); ++i)
        labels.rows[i] = {labels.rows[i][0], i == 0 ? "a" : i == 1 ? "b" : "c"};
    write_table(folder_ / "parts.csv", labels);
    const Json pairs =
        run({"groups", "people", "--labels", "parts.csv", "--by", "part", "-o", "g.csv"})["pairs"];
    const std::vector<std::string> row = read_table(folder_ / "g.csv").rows[1]; // a - b
    const Arguments columns = read_table(folder_ / "g.csv").columns;
    for (const char* figure :
         {"sum_of_squares", "residual_sum_of_squares", "r_squared", "f", "p_value", "p_adjusted"}) {
        EXPECT_TRUE(pairs[0][figure].is_null()) << figure;
        EXPECT_EQ(row[to_size(std::ranges::find(columns, figure) - columns.begin())], "") << figure;
        EXPECT_FALSE(pairs[1][figure].is_null()) << figure;
    }
    EXPECT_GT(pairs[0]["distance"], 0.0);
    const auto smaller = [&](const char* figure) {
        return std::min(pairs[1][figure].get<double>(), pairs[2][figure].get<double>());
    };
    EXPECT_EQ(smaller("p_adjusted"), std::min(1.0, 2.0 * smaller("p_value")));
}

TEST_F(Groups, SayTheSmallestPValueThatTheyAllow)
{
    const Arguments groups{"groups",    "people.h5", "--by",  "sex",    "--only",
                           "mood=calm", "-o",        "g.csv", "--force"};
    EXPECT_NEAR(run(groups)["overall"]["smallest_p"], 0.1, 1e-12); // three against three
    EXPECT_NE(run_shape(folder_.path(), groups)
                  .err.find("(so few meshes or blocks allow none below 0.1)"),
              std::string::npos);
    // More permutations than the design has would not help; fewer do count.
    EXPECT_NEAR(run(groups + Arguments{"--permutations", "4"})["overall"]["smallest_p"], 0.2,
                1e-12);
    const Json many = run({"groups", "people.h5", "--by", "mood", "-o", "g.csv", "--force"});
    EXPECT_NEAR(many["overall"]["smallest_p"], 1.0 / 462.0, 1e-12); // 12! / 6!^2 / 2
}

TEST_F(Groups, OfTooFewReplicatesHaveNoIntervals)
{
    const Arguments groups{"groups", "people.h5", "--by",        "mood", "-o",
                           "g.csv",  "--force",   "--bootstrap", "1"};
    const Json figures = run(groups);
    EXPECT_TRUE(figures["groups"][0]["variance_low"].is_null());
    EXPECT_GT(figures["groups"][0]["variance"], 0.0);
    EXPECT_TRUE(figures["pairs"][0]["radius"].is_null());
    const std::string err = run_shape(folder_.path(), groups).err;
    EXPECT_NE(err.find("warning: --bootstrap: a 95 % interval takes 39 replicates, here is 1: of "
                       "fewer even the smallest and the largest span less"),
              std::string::npos)
        << err;
    EXPECT_NE(err.find("(95 %: not determined)"), std::string::npos) << err;
    const Json modes =
        run({"stats", "people.h5", "--modes", "2", "--bootstrap", "38", "-o", "model.h5"})["modes"];
    for (const char* figure : {"variance_low", "variance_high", "variance_outside"})
        EXPECT_TRUE(modes[0][figure].is_null()) << figure;
}

TEST_F(Groups, OfSubjectsAreComparedByTheirMeans)
{
    const Arguments by_sex{"groups", "people.h5", "--by", "sex", "--within", "subject"};
    const Json figures = run(by_sex + Arguments{"-o", "sex.csv"});
    EXPECT_EQ(figures["design"], "nested");
    EXPECT_EQ(figures["overall"]["residual_df"], 4);
    const Json adjusted = run(
        by_sex + Arguments{"-o", "adjusted.csv", "--adjust-for", "age", "--adjust-for", "size"});
    EXPECT_EQ(adjusted["overall"]["residual_df"], 2);
    const Json calm = run({"groups", "people.h5", "--by", "sex", "--only", "mood=calm", "-o",
                           "calm.csv", "--space", "procrustes"});
    EXPECT_EQ(calm["meshes"], 6);
    EXPECT_EQ(calm["space"], "procrustes");
}

TEST_F(Groups, OfRepeatedScansCountEverySubjectOnceInAllFigures)
{
    folder_.write("scans/.keep", "");
    std::string labels = "mesh,person,sex\n";
    RowMatrix people(6, 120);
    Eigen::VectorXd sizes(6);
    const std::vector<int> counts{3, 1, 1, 2, 2, 4};
    for (unsigned person = 0; person < 6; ++person) {
        people.row(person).setZero();
        sizes[person] = 0.0;
        for (int k = 0; k < counts[person]; ++k) {
            TestMesh mesh = bumpy_sphere(1, 0.2, person + 1);
            mesh.points +=
                0.01 * random_matrix(mesh.points.rows(), 3, 10 * person + static_cast<unsigned>(k));
            const std::string name = join("p", person, "_", k);
            write_mesh(folder_ / ("scans/" + name + ".ply"), mesh.points, mesh.topology.faces(),
                       MeshFormat::Ply);
            labels += join(name, ",p", person, person % 2 == 0 ? ",f\n" : ",m\n");
            people.row(person) += shape_of("scans/" + name + ".ply").transpose() / counts[person];
            sizes[person] += lengths("scans/" + name + ".ply").sum() / counts[person];
        }
    }
    folder_.write("scans.csv", labels);
    const Arguments groups{"groups",   "scans",  "--labels", "scans.csv", "--by",   "sex",
                           "--within", "person", "-o",       "g.csv",     "--force"};
    const Json figures = run(groups + Arguments{"--means", "m"});
    EXPECT_EQ(figures["design"], "nested");
    EXPECT_EQ(figures["left_out"], 0);
    EXPECT_EQ(figures["groups"][0]["meshes"], 6);
    EXPECT_EQ(figures["groups"][0]["blocks"], 3);
    const std::vector<int> women{0, 2, 4}, men{1, 3, 5};
    const Eigen::RowVectorXd f = people(women, Eigen::all).colwise().mean();
    const Eigen::RowVectorXd m = people(men, Eigen::all).colwise().mean();
    EXPECT_NEAR(figures["pairs"][0]["distance"], (f - m).norm(), 1e-9 * (f - m).norm());
    const double variance = (people(women, Eigen::all).rowwise() - f).squaredNorm() / 2.0;
    EXPECT_NEAR(figures["groups"][0]["variance"], variance, 1e-9 * variance);
    EXPECT_NEAR(figures["groups"][0]["mean_size"], sizes(women).mean(), 1e-9 * sizes[0]);
    EXPECT_EQ(figures["spread"]["residual_df"], 4);
    const Eigen::RowVectorXd of_meshes =
        (3.0 * people.row(0) + people.row(2) + 2.0 * people.row(4)) / 6.0;
    const Eigen::RowVectorXd mean = shape_of("m/f.ply").transpose();
    EXPECT_LT((mean - f).norm(), (mean - of_meshes).norm());
    EXPECT_NE(run_shape(folder_.path(), groups).err.find("each person counts once, by its mean"),
              std::string::npos);
}

TEST_F(Groups, AreComparedWithinSubjectsThatHaveBothAlone)
{
    Table labels = read_table(folder_ / "labels.csv");
    labels.rows.back()[2] = "calm"; // s5 has no glad mesh
    write_table(folder_ / "gaps.csv", labels);
    const Arguments groups{"groups",   "people",  "--labels", "gaps.csv", "--by",   "mood",
                           "--within", "subject", "-o",       "g.csv",    "--force"};
    const Json figures = run(groups);
    EXPECT_EQ(figures["design"], "crossed");
    EXPECT_EQ(figures["left_out"], 2);
    EXPECT_EQ(figures["groups"][0]["meshes"], 7);
    EXPECT_EQ(figures["groups"][0]["blocks"], 5);
    Eigen::VectorXd difference = Eigen::VectorXd::Zero(120);
    for (int i = 0; i < 5; ++i)
        difference += (shape_of(join("people/s", i, "_glad.ply")) -
                       shape_of(join("people/s", i, "_calm.ply"))) /
                      5.0;
    EXPECT_NEAR(figures["pairs"][0]["distance"], difference.norm(), 1e-9 * difference.norm());
    const std::string err =
        run_shape(folder_.path(), groups + Arguments{"--adjust-for", "age"}).err;
    for (const char* said :
         {"means and distances within each subject", "2 meshes are left out, whose subject lies",
          "calm: 7 meshes, subject counted: 5, variance",
          "--adjust-for age changes nothing: it is the same in all meshes of each subject"})
        EXPECT_NE(err.find(said), std::string::npos) << said << "\n" << err;
}

TEST_F(Groups, OfOneOrTwoHaveNoSpread)
{
    Table labels = read_table(folder_ / "labels.csv");
    labels.columns = {"mesh", "few"};
    for (std::size_t i = 0; i < labels.rows.size(); ++i)
        labels.rows[i] = {labels.rows[i][0], i == 0 ? "one" : i < 3 ? "two" : "rest"};
    write_table(folder_ / "few.csv", labels);
    const Arguments groups{"groups", "people", "--labels", "few.csv", "--by",
                           "few",    "-o",     "g.csv",    "--force"};
    const Json figures = run(groups);
    EXPECT_TRUE(figures["groups"][0]["variance"].is_null());
    EXPECT_TRUE(figures["groups"][0]["variance_low"].is_null());
    EXPECT_GT(figures["groups"][1]["variance"], 0.0);
    EXPECT_TRUE(figures["groups"][1]["variance_high"].is_null());
    EXPECT_GT(figures["groups"][2]["variance_high"], 0.0);
    const Table table = read_table(folder_ / "g.csv");
    for (std::size_t pair = 0; pair < 3; ++pair) {
        EXPECT_GT(figures["pairs"][pair]["distance"], 0.0);
        EXPECT_TRUE(figures["pairs"][pair]["radius"].is_null());
        EXPECT_EQ(table.rows[pair + 1][3], "");
    }
    const std::string err = run_shape(folder_.path(), groups).err;
    for (const char* said : {"one: 1 mesh, variance not determined\n", "two: 2 meshes, variance ",
                             " (95 %: not determined)\n", " (radius not determined), F("})
        EXPECT_NE(err.find(said), std::string::npos) << said << "\n" << err;
}

TEST_F(Groups, BlocksThatMakeADesignCrossedByASlipAreNamed)
{
    Table labels = read_table(folder_ / "labels.csv");
    labels.rows[4][3] = "m"; // of s2, of whom the other mesh is f
    write_table(folder_ / "slip.csv", labels);
    const Outcome outcome =
        run_shape(folder_.path(), {"groups", "people", "--labels", "slip.csv", "--by", "sex",
                                   "--within", "subject", "-o", "g.csv"});
    EXPECT_NE(outcome.err.find("warning: 10 of 12 meshes are left out: as s2, 1 of 6 blocks of "
                               "--within subject, has meshes of several groups"),
              std::string::npos)
        << outcome.err;
    EXPECT_NE(outcome.err.find("correct the values of sex or subject"), std::string::npos);
    EXPECT_NE(outcome.err.find("error: groups: 1 block has members of several groups ('s2'), 2 "
                               "means in all, as each counts once in a group; to compare 2 groups "
                               "within it takes 3"),
              std::string::npos)
        << outcome.err;
}

TEST_F(Groups, BlocksWhoseCovariateDiffersByASlipAreNamed)
{
    Table labels = read_table(folder_ / "labels.csv");
    const std::size_t age = 4;
    const auto err = [&](const Arguments& arguments, int exit_code = 0) {
        write_table(folder_ / "slip.csv", labels);
        const Outcome outcome =
            run_shape(folder_.path(), arguments + Arguments{"--labels", "slip.csv", "--within",
                                                            "subject", "-o", "g.csv", "--force"});
        EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
        return outcome.err;
    };
    const auto expect_said = [](const std::string& text, const std::string& said) {
        EXPECT_NE(text.find(said), std::string::npos) << said << "\n" << text;
    };
    labels.rows[4][age] = "30"; // of s2, whose other mesh has 23
    expect_said(err({"regress", "people", "--on", "age"}, 3),
                "error: --on age: differs within 1 of 6 blocks of --within subject (s2), too few "
                "to tell slopes within blocks from chance. If that is a slip, correct it");
    const std::string adjusted = err({"groups", "people", "--by", "mood", "--adjust-for", "age"});
    expect_said(adjusted,
                "warning: --adjust-for age is the same in all meshes of each block of "
                "--within subject but for 1 of 6: s2, which alone determines its slope");
    expect_said(adjusted, "variances and spread are not determined\n");
    expect_said(adjusted, "calm: 6 meshes, subject counted: 6, variance not determined\n");
    labels.rows[8][age] = "50"; // of s4
    const std::string two = err({"regress", "people", "--on", "age"});
    expect_said(two,
                "warning: --on age is the same in all meshes of each block of --within "
                "subject but for 2 of 6: s2 and s4, which alone determine its slope");
    EXPECT_EQ(two.find("determines the slope ("), std::string::npos) << two;
    for (std::size_t i = 1; i < 12; i += 2) // all are a year older when they are glad, s2 many
        labels.rows[i][age] = std::to_string(std::stoi(labels.rows[i - 1][age]) + 1);
    labels.rows[5][age] = "3000";
    expect_said(err({"regress", "people", "--on", "age"}),
                "warning: --on age: subject s2 alone determines the slope (100 % of what it rests "
                "on), from 30 to 3000 where the others lie from 20 to ");
}

TEST_F(Groups, AMeshThatAloneDeterminesASlopeIsNamed)
{
    Table labels = read_table(folder_ / "labels.csv");
    for (std::size_t i = 0; i < labels.rows.size(); ++i)
        labels.rows[i][4] = std::to_string(20 + i);
    labels.rows[7][4] = "2300";
    write_table(folder_ / "far.csv", labels);
    for (const Arguments& command :
         {Arguments{"regress", "people", "--on", "age"},
          Arguments{"groups", "people", "--by", "mood", "--adjust-for", "age"}}) {
        const Outcome outcome = run_shape(
            folder_.path(), command + Arguments{"--labels", "far.csv", "-o", "g.csv", "--force"});
        EXPECT_NE(outcome.err.find(" age: s3_glad alone determines the slope (100 % of what it "
                                   "rests on), at 2300 where the others lie from 20 to 31"),
                  std::string::npos)
            << outcome.err;
    }
}

TEST_F(Groups, CovariatesThatDifferByRoundingAreNamed)
{
    Table labels = read_table(folder_ / "labels.csv");
    labels.columns.insert(labels.columns.end(), {"near", "big", "more"});
    for (std::size_t i = 0; i < labels.rows.size(); ++i) {
        const std::vector<std::string> cells{join("5.0000000000000", 10 + i),
                                             join("10000000000000", 10 + i), // 1e15
                                             std::to_string(std::stoul(labels.rows[i][4]) + i % 2)};
        labels.rows[i].insert(labels.rows[i].end(), cells.begin(), cells.end());
    }
    write_table(folder_ / "near.csv", labels);
    const Arguments regress{"regress", "people", "--labels", "near.csv", "-o", "x.csv"};
    expect_failure(3, regress + Arguments{"--on", "near"},
                   {"--on near: is constant but for rounding, 5 for all 12 meshes up to "});
    expect_failure(3, regress + Arguments{"--on", "big"},
                   {"--on big: is constant but for rounding, ", "subtract what"});
    // Size, and a number that is one more for the glad ones, differ by other things within subjects.
    for (std::size_t i = 0; i < labels.rows.size(); ++i)
        labels.rows[i][8] = std::to_string(i % 2 == 0 ? 3 : 4);
    labels.columns[8] = "state";
    write_table(folder_ / "near.csv", labels);
    expect_failure(3, regress + Arguments{"--on", "state", "--on", "more", "--within", "subject"},
                   {"--on more: is a combination of the covariates before it (state) where it is "
                    "tested"});
}

TEST_F(Groups, OfNumbersThatAreNearlyAllDifferentAreDoubted)
{
    Table labels = read_table(folder_ / "labels.csv");
    for (std::size_t i = 0; i < labels.rows.size(); ++i)
        labels.rows[i][4] = i == 1 ? "20.5" : join(20 + i, ".5");
    write_table(folder_ / "ages.csv", labels);
    const Outcome outcome = run_shape(
        folder_.path(), {"groups", "people", "--labels", "ages.csv", "--by", "age", "-o", "g.csv"});
    EXPECT_NE(outcome.err.find("warning: --by age: its 11 values in 12 meshes are numbers, nearly "
                               "all different, and each is a group here; shape regress --on age"),
              std::string::npos)
        << outcome.err;
}

TEST_F(Groups, PairsOfRepeatedScansCountOnce)
{
    Table labels = read_table(folder_ / "labels.csv");
    labels.rows[2][1] = "s0"; // s1_calm: a second scan of s0
    write_table(folder_ / "again.csv", labels);
    const Outcome outcome = run_shape(
        folder_.path(), {"difference", "people", "--labels", "again.csv", "--pair-by", "subject",
                         "--from", "mood=calm", "--to", "mood=glad", "-o", "d.h5"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_NE(outcome.err.find("mean difference of 5 pairs, of which 1 (subject s0) has several "
                               "meshes on a side, which count once, by their mean"),
              std::string::npos)
        << outcome.err;
}

TEST_F(Groups, SlopesWithinSubjectsAreTestedAgainstTheirDifferences)
{
    Table labels = read_table(folder_ / "labels.csv");
    for (std::size_t i = 0; i < labels.rows.size(); ++i) {
        labels.rows[i][1] = join("t", i / 4); // three subjects of four visits
        labels.rows[i][4] = std::to_string(20 + i);
    }
    write_table(folder_ / "visits.csv", labels);
    const Arguments regress{"regress",  "people",  "--labels", "visits.csv", "--on",   "age",
                            "--within", "subject", "-o",       "g.csv",      "--force"};
    const Json figures = run(regress);
    EXPECT_EQ(figures["together"]["residual_df"], 2);
    EXPECT_EQ(figures["together"]["smallest_p"], 0.25);
    const std::string err = run_shape(folder_.path(), regress).err;
    EXPECT_NE(err.find("within each subject, against how much slopes differ between them:\n"),
              std::string::npos)
        << err;
}

TEST_F(Groups, PairsThatNoBlockHasAreSaidToBeComparedOtherwise)
{
    Table labels = read_table(folder_ / "labels.csv");
    for (std::size_t i = 0; i < labels.rows.size(); ++i) // s0 to s2: calm, glad; s3 to s5: c, d
        if (i >= 6)
            labels.rows[i][2] = i % 2 == 0 ? "c" : "d";
    write_table(folder_ / "parts.csv", labels);
    const Arguments groups{"groups", "people",   "--labels", "parts.csv",    "--by",
                           "mood",   "--within", "subject",  "--adjust-for", "age",
                           "-o",     "g.csv",    "--force"};
    const Json figures = run(groups);
    EXPECT_EQ(figures["pairs"][0]["design"], "crossed"); // calm - glad
    EXPECT_EQ(figures["pairs"][1]["design"], "nested");  // calm - c
    const std::string err = run_shape(folder_.path(), groups).err;
    EXPECT_NE(err.find(" (not within: no subject has both, its means are tested)"),
              std::string::npos)
        << err;
    EXPECT_NE(err.find("changes nothing of what is compared within them"), std::string::npos)
        << err;
}

TEST_F(Groups, CovariatesThatTellNothingAreNamed)
{
    const Arguments groups{"groups", "people.h5", "--by", "sex", "-o", "g.csv", "--force"};
    const auto err = [&](const Arguments& adjusted) {
        return run_shape(folder_.path(), groups + adjusted).err;
    };
    EXPECT_NE(err({"--adjust-for", "same"})
                  .find("warning: --adjust-for same changes nothing: it is 1 in all meshes\n"),
              std::string::npos);
    EXPECT_NE(err({"--adjust-for", "age", "--adjust-for", "age"})
                  .find("--adjust-for age changes nothing the second time"),
              std::string::npos);
    Table labels = read_table(folder_ / "labels.csv");
    for (Arguments& row : labels.rows)
        row[4] = row[3] == "f" ? "30" : "40";
    write_table(folder_ / "ages.csv", labels);
    expect_failure(3,
                   {"groups", "people", "--labels", "ages.csv", "--by", "sex", "--only",
                    "mood=calm", "--adjust-for", "age", "-o", "x.csv"},
                   {"--adjust-for age: it is 30 in all meshes of sex = f and 40 in all of m",
                    "leave --adjust-for age out"});
}

TEST_F(Groups, CovariatesThatTellTheSameTogetherAreNamed)
{
    Table labels = read_table(folder_ / "labels.csv");
    labels.columns = {"mesh", "sex", "mood", "subject", "age", "months", "mix", "later"};
    for (std::size_t i = 0; i < labels.rows.size(); ++i) {
        const std::vector<std::string> row = labels.rows[i];
        const bool is_f = row[3] == "f";
        const auto age = static_cast<int>(20 + (3 * i * i) % 17);
        labels.rows[i] = {row[0],
                          row[3],
                          row[2],
                          row[1],
                          std::to_string(age),
                          std::to_string(12 * age + 5),
                          std::to_string(2 * age + (is_f ? 7 : 0)),
                          std::to_string(10 * static_cast<int>(i / 2) + (i % 2 == 0 ? 0 : 3))};
    }
    write_table(folder_ / "more.csv", labels);
    const Arguments by_sex{"groups", "people", "--labels", "more.csv", "--by",
                           "sex",    "-o",     "g.csv",    "--force"};
    const Outcome same = run_shape(
        folder_.path(), by_sex + Arguments{"--adjust-for", "age", "--adjust-for", "months"});
    EXPECT_EQ(same.exit_code, 0);
    EXPECT_NE(same.err.find("warning: --adjust-for months changes nothing beside age, of which it "
                            "is a multiple but for a constant"),
              std::string::npos)
        << same.err;
    const Outcome mixed = run_shape(
        folder_.path(),
        by_sex + Arguments{"--adjust-for", "size", "--adjust-for", "mix", "--adjust-for", "age"});
    EXPECT_EQ(mixed.exit_code, 3);
    EXPECT_NE(mixed.err.find("--adjust-for mix and age: together they tell sex = f from m"),
              std::string::npos)
        << mixed.err;
    // Later by the same time in all subjects: within them that is what the state is.
    const Outcome later = run_shape(
        folder_.path(), {"groups", "people", "--labels", "more.csv", "--by", "mood", "--within",
                         "subject", "--adjust-for", "later", "-o", "g.csv", "--force"});
    EXPECT_EQ(later.exit_code, 3);
    EXPECT_NE(later.err.find("--adjust-for later: it tells mood = calm from glad where these are "
                             "compared (--within subject)"),
              std::string::npos)
        << later.err;
}

TEST_F(Groups, HaveAdjustedMeansDistancesAndVariances)
{
    const Arguments groups{"groups",       "people.h5", "--by", "sex",   "--only", "mood=calm",
                           "--adjust-for", "age",       "-o",   "g.csv", "--force"};
    const Json figures = run(groups + Arguments{"--means", "adjusted"});
    RowMatrix data(6, 120);
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(6, 3);
    Eigen::VectorXd sizes(6);
    for (int i = 0; i < 6; ++i) {
        data.row(i) = shape_of(join("people/s", i, "_calm.ply")).transpose();
        sizes[i] = lengths(join("people/s", i, "_calm.ply")).sum();
        columns(i, i % 2) = 1.0;
        columns(i, 2) = 20 + (7 * i) % 11;
    }
    const double age = columns.col(2).mean();
    columns.col(2).array() -= age;
    const Eigen::MatrixXd solve = columns.completeOrthogonalDecomposition().pseudoInverse();
    const Eigen::MatrixXd fitted = solve * data;
    const double distance = (fitted.row(0) - fitted.row(1)).norm();
    EXPECT_EQ(figures["adjusted_for"][0]["label"], "age");
    EXPECT_NEAR(figures["adjusted_for"][0]["at"], age, 1e-12 * age);
    EXPECT_NEAR(figures["pairs"][0]["distance"], distance, 1e-9 * distance);
    EXPECT_NEAR(figures["groups"][1]["mean_size"], (solve * sizes)[1], 1e-9 * sizes[0]);
    const Eigen::MatrixXd left = data - columns * fitted;
    const Eigen::VectorXd leverages = (columns * solve).diagonal();
    double squares = 0.0, freedom = 0.0;
    for (const int i : {0, 2, 4}) {
        squares += left.row(i).squaredNorm();
        freedom += 1.0 - leverages[i];
    }
    EXPECT_NEAR(figures["groups"][0]["variance"], squares / freedom, 1e-9 * squares / freedom);
    const Eigen::RowVectorXd mean = shape_of("adjusted/f.ply").transpose();
    const Eigen::RowVectorXd raw = (data.row(0) + data.row(2) + data.row(4)) / 3.0;
    EXPECT_LT((mean - fitted.row(0)).norm(), (mean - raw).norm());
    EXPECT_NE(run_shape(folder_.path(), groups)
                  .err.find("means and distances at age = 24.6667, variances about the slopes"),
              std::string::npos);
}

TEST_F(Groups, AreChosenByTheirLabels)
{
    const Arguments only{"--only", "mood=calm", "--only", "sex=f"};
    (void)run(Arguments{"collect", "people.h5", "-o", "chosen.h5"} + only);
    Table labels = read_table(folder_ / "labels.csv");
    labels.rows = {labels.rows[0], labels.rows[4], labels.rows[8]};
    write_table(folder_ / "chosen.csv", labels);
    (void)run({"collect", "people/s0_calm.ply", "people/s2_calm.ply", "people/s4_calm.ply",
               "--labels", "chosen.csv", "-o", "named.h5"});
    EXPECT_EQ(folder_.read("chosen.h5"), folder_.read("named.h5"));

    (void)run({"stats", "named.h5", "-o", "named_model.h5"});
    (void)run(Arguments{"stats", "people.h5", "-o", "chosen_model.h5"} + only);
    EXPECT_EQ(folder_.read("chosen_model.h5"), folder_.read("named_model.h5"));
    (void)run({"project", "named_model.h5", "named.h5", "-o", "named_scores.csv"});
    (void)run(Arguments{"project", "named_model.h5", "people", "--labels", "labels.csv", "-o",
                        "chosen_scores.csv"} +
              only);
    EXPECT_EQ(folder_.read("chosen_scores.csv"), folder_.read("named_scores.csv"));
    (void)run({"distance", "named.h5", "-o", "named.csv"});
    (void)run(Arguments{"distance", "people.h5", "-o", "distances.csv"} + only);
    EXPECT_EQ(folder_.read("distances.csv"), folder_.read("named.csv"));
}

TEST_F(Groups, DependOnTheSeedButNotOnTheThreads)
{
    const Arguments compare{"groups", "people.h5", "--by", "sex"};
    (void)run(compare + Arguments{"-o", "one.csv", "--threads", "1"});
    (void)run(compare + Arguments{"-o", "three.csv", "--threads", "3"});
    (void)run(compare + Arguments{"-o", "other.csv", "--seed", "7"});
    EXPECT_EQ(folder_.read("one.csv"), folder_.read("three.csv"));
    EXPECT_NE(folder_.read("one.csv"), folder_.read("other.csv"));
}

TEST_F(Groups, VariancesOfModesHaveIntervals)
{
    const Arguments stats{"stats", "people.h5", "--modes", "3", "--bootstrap", "200"};
    const Json figures = run(stats + Arguments{"-o", "model.h5", "--within", "subject"});
    for (const Json& mode : figures["modes"]) {
        EXPECT_LT(mode["variance_low"], mode["variance"]);
        EXPECT_GT(mode["variance_high"], mode["variance_low"]);
    }
    expect_failure(3, stats + Arguments{"-o", "x.h5", "--within", "gap"}, {"s5_glad"});
    expect_failure(2, {"stats", "people.h5", "-o", "x.h5", "--within", "subject"}, {"--bootstrap"});
    expect_failure(3, stats + Arguments{"-o", "x.h5", "--within", "sex"}, {"2", "at least 3"});
    expect_failure(2, stats + Arguments{"-o", "x.h5", "--bootstrap", "-1"}, {"--bootstrap"});
}

TEST_F(Groups, EstimatesOutsideTheirIntervalAreExplained)
{
    // The last modes of few meshes: a resample has fewer different ones.
    const Arguments stats{"stats", "people.h5", "--bootstrap", "100", "-o", "m.h5", "--force"};
    const Json figures = run(stats);
    std::string outside;
    for (const Json& mode : figures["modes"]) {
        const bool is_above = mode["variance"] > mode["variance_high"];
        const bool is_below = mode["variance"] < mode["variance_low"];
        EXPECT_EQ(mode["variance_outside"], is_above ? "above" : is_below ? "below" : "no");
        outside += is_above ? "a" : "";
    }
    ASSERT_GE(outside.size(), 2U);
    const Outcome outcome = run_shape(folder_.path(), stats);
    EXPECT_NE(outcome.err.find("lies above its interval: a resampled collection repeats"),
              std::string::npos)
        << outcome.err;
    EXPECT_NE(outcome.err.find("(above its interval)"), std::string::npos);
}

TEST_F(Groups, AreToldApartInSubjectsThatWereLeftOut)
{
    for (const char* space : {"edge", "procrustes"}) {
        const std::string stem = space;
        const Json figures = run({"classify", "people.h5", "--by", "mood", "--leave-out", "subject",
                                  "--modes", "3", "--space", space, "-o", stem + ".csv",
                                  "--predictions", stem + "_mesh.csv", "--plot", stem + ".svg"});
        EXPECT_EQ(figures["folds"], 6);
        EXPECT_EQ(figures["chance"], 0.5);
        const Table confusion = read_table(folder_ / (stem + ".csv"));
        EXPECT_EQ(confusion.columns, (Arguments{"true mood", "calm", "glad"}));
        const Table predictions = read_table(folder_ / (stem + "_mesh.csv"));
        ASSERT_EQ(predictions.rows.size(), 12u);
        int right = 0;
        for (const Arguments& row : predictions.rows)
            right += row[2] == row[3];
        EXPECT_DOUBLE_EQ(figures["accuracy"], right / 12.0);
        EXPECT_EQ(std::stoi(confusion.rows[0][1]) + std::stoi(confusion.rows[1][2]), right);
        EXPECT_NE(folder_.read(stem + ".svg").find("canonical variate 1"), std::string::npos);
    }
}

/// Meshes that grow longer with t, which is 0, 1, ..., 5.
void write_bent(const Folder& folder)
{
    folder.write("bent/.keep", "");
    std::string labels = "mesh,t,other\n";
    const TestMesh mesh = bumpy_sphere(1, 0.2, 1);
    for (int t = 0; t < 6; ++t) {
        Points points = mesh.points;
        points.col(0) *= 1.0 + 0.04 * t;
        write_mesh(folder / join("bent/t", t, ".ply"), points, mesh.topology.faces(),
                   MeshFormat::Ply);
        labels += join("t", t, ",", t, ",", (5 * t) % 7, "\n");
    }
    folder.write("bent.csv", labels);
}

TEST_F(Groups, RegressionKnowsShapesAtAnyValueAndWithoutTheEffect)
{
    write_bent(folder_);
    const Json figures =
        run({"regress", "bent", "--labels", "bent.csv", "--on", "t", "-o", "s.csv", "--at", "3,6",
             "--expected", "at", "--corrected", "without", "--plot", "s.svg"});
    EXPECT_GT(figures["covariates"][0]["r_squared"], 0.99);
    EXPECT_LT(figures["covariates"][0]["p_value"], 0.02); // of 720 orders two are as extreme
    EXPECT_EQ(figures["together"]["p_value"], figures["covariates"][0]["p_value"]);
    EXPECT_EQ(files_in(folder_ / "at"), (Arguments{"t_3.ply", "t_6.ply"}));
    EXPECT_LT(difference(shape_of("at/t_3.ply"), shape_of("bent/t3.ply")), 0.005);
    for (int t = 0; t < 6; ++t) {
        const std::string file = join("t", t, ".ply");
        EXPECT_LT(difference(shape_of("without/" + file), shape_of("without/t2.ply")), 0.015);
        EXPECT_NEAR(lengths("without/" + file).sum() / lengths("bent/" + file).sum(), 1.0, 1e-3);
    }
    const Table scores = read_table(folder_ / "s.csv");
    EXPECT_EQ(scores.columns, (Arguments{"mesh", "t", "score"}));
    EXPECT_NEAR(parse_number(scores.rows[4][2], "score"), 4.0, 0.1);
    EXPECT_NE(folder_.read("s.svg").find("score along the regression"), std::string::npos);
}

TEST_F(Groups, RegressionWarnsOutsideTheData)
{
    write_bent(folder_); // t runs from 0 to 5
    const auto err = [&](const std::string& at) {
        const Outcome outcome =
            run_shape(folder_.path(), {"regress", "bent", "--labels", "bent.csv", "--on", "t", "-o",
                                       "s.csv", "--at", at, "--expected", "at", "--force"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err;
    };
    EXPECT_EQ(err("0,2.5,5").find("warning"), std::string::npos);
    EXPECT_NE(err("0,7.5").find("--at 7.5 is outside the data: t is measured from 0 to 5, and this "
                                "lies 0.5 times that range beyond it"),
              std::string::npos);
    EXPECT_NE(err("-5").find("1 times that range beyond"), std::string::npos);
}

TEST_F(Groups, SpreadOfTheGroupsIsPrinted)
{
    const Arguments groups{"groups", "people.h5", "--by", "mood", "-o", "g.csv", "--force"};
    const Outcome outcome = run_shape(folder_.path(), groups);
    for (const char* said : {"spread of the groups: F(1, 10) = ", "calm: 6 meshes, variance ",
                             "glad: 6 meshes, variance ", " (95 %: "})
        EXPECT_NE(outcome.err.find(said), std::string::npos) << said << "\n" << outcome.err;
    const Json figures = run(groups);
    EXPECT_EQ(figures["spread"]["residual_df"], 10);
    EXPECT_EQ(figures["spread"]["permutations"], 999);
}

TEST_F(Groups, WithoutPairsHaveADifferenceAndAMapOfEffects)
{
    const Json figures = run({"difference", "people.h5", "--from", "sex=f", "--to", "sex=m", "-o",
                              "d.h5", "--effects", "e.ply"});
    EXPECT_EQ(figures["pairs"], 0);
    EXPECT_EQ(figures["effects"]["edges"], 120);
    EXPECT_TRUE(folder_.has("e.csv"));
    (void)run({"difference", "--load", "d.h5", "--onto", "a.ply", "--mesh", "out.ply"});
    EXPECT_EQ(run({"info", "d.h5"})["pairs"], 0);
    const Outcome outcome = run_shape(folder_.path(), {"difference", "people.h5", "--from", "sex=f",
                                                       "--to", "sex=m", "-o", "x.h5"});
    EXPECT_NE(outcome.err.find("means of two groups without pairs"), std::string::npos);
}

TEST_F(Groups, RegressionTestsEachCovariateBeyondTheOthers)
{
    write_bent(folder_);
    const Json figures = run(
        {"regress", "bent", "--labels", "bent.csv", "--on", "t", "--on", "other", "-o", "s.csv"});
    ASSERT_EQ(figures["covariates"].size(), 2u);
    EXPECT_LT(figures["covariates"][0]["p_value"], 0.05);
    EXPECT_GT(figures["covariates"][1]["p_value"], 0.05);
    EXPECT_EQ(figures["together"]["df"], 2);
    const Json allometry =
        run({"regress", "bent", "--on", "size", "--at", "60", "--expected", "at", "-o", "a.csv"});
    EXPECT_NEAR(lengths("at/size_60.ply").sum(), 60.0, 0.05);
    EXPECT_EQ(run({"regress", "people.h5", "--on", "size", "--within", "subject", "-o",
                   "w.csv"})["together"]["residual_df"],
              5);
}

TEST_F(Groups, AreToldApartInAsManyModesAsTheMeshesHave)
{
    std::string labels = "mesh,half\n";
    folder_.write("copies/.keep", "");
    for (unsigned i = 0; i < 24; ++i) { // of three shapes, which vary in two modes
        const TestMesh mesh = bumpy_sphere(1, 0.2, i % 3 + 1);
        write_mesh(folder_ / join("copies/m", i, ".ply"), mesh.points, mesh.topology.faces(),
                   MeshFormat::Ply);
        labels += join("m", i, i < 12 ? ",first\n" : ",second\n");
    }
    folder_.write("copies.csv", labels);
    const Arguments copies{"copies", "--labels", "copies.csv"};
    const Arguments classify = Arguments{"classify"} + copies + Arguments{"--by", "half"};
    EXPECT_EQ(run(classify + Arguments{"-o", "c.csv", "--plot", "c.svg"})["modes"], 2);
    const Outcome told = run_shape(folder_.path(), classify + Arguments{"-o", "d.csv"});
    EXPECT_NE(told.err.find("2 modes are used, as many as the meshes allow"), std::string::npos)
        << told.err;
    const Outcome more =
        run_shape(folder_.path(), classify + Arguments{"-o", "e.csv", "--modes", "3"});
    EXPECT_EQ(more.exit_code, 3);
    EXPECT_NE(more.err.find("23 observations of 2 components in 2 groups; it must be at most 2"),
              std::string::npos)
        << more.err;
    EXPECT_EQ(run(Arguments{"quality", "-o", "q.csv", "--tests", "3", "--samples", "2"} +
                  copies)["modes"],
              (std::vector<int>{1, 2}));
}

TEST_F(Groups, RemovingAllModesLeavesOneShape)
{
    (void)run({"remove", "a.ply", "b.ply", "c.ply", "--modes", "2", "-o", "mean"});
    EXPECT_LT(difference(shape_of("mean/b.ply"), shape_of("mean/a.ply")), 1e-3);
    EXPECT_LT(std::abs(lengths("mean/b.ply").sum() / lengths("b.ply").sum() - 1.0), 0.01);
    (void)run({"remove", "a.ply", "b.ply", "c.ply", "--modes", "2", "--like", "a", "-o", "like"});
    EXPECT_LT(difference(shape_of("like/c.ply"), shape_of("a.ply")), 1e-6);
    (void)run({"stats", "a.ply", "b.ply", "c.ply", "-o", "model.h5"});
    const Json figures = run({"remove", "b.ply", "--model", "model.h5", "--modes", "2", "--like",
                              "a.ply", "-o", "b_like_a.ply"});
    EXPECT_LT(difference(shape_of("b_like_a.ply"), shape_of("a.ply")), 1e-6);
    EXPECT_EQ(figures["removed"][0].size(), 2u);
}

/// Arguments that find the difference of the one pair, from a to b.
Arguments smile(const Arguments& further)
{
    return Arguments{"difference", "a.ply",   "b.ply",  "c.ply",     "--labels", "few.csv",
                     "--pair-by",  "subject", "--from", "mood=calm", "--to",     "mood=glad"} +
           further;
}

TEST_F(Groups, RemovingADifferenceTakesItsEndBackToItsStart)
{
    (void)run(smile({"-o", "smile.h5"}));
    (void)run({"remove", "a.ply", "b.ply", "--direction", "smile.h5", "-o", "calm"});
    EXPECT_LT(difference(shape_of("calm/b.ply"), shape_of("a.ply")), 1e-6);
    EXPECT_LT(difference(lengths("calm/a.ply"), lengths("a.ply")), 1e-6);
}

TEST_F(Groups, DifferencesAreTransferredToAnyMesh)
{
    const Json figures =
        run(smile({"-o", "smile.h5", "--apply", "--onto", "a", "--mesh", "glad_a.ply"}));
    EXPECT_EQ(figures["embeddings"][0]["name"], "a");
    EXPECT_LT(difference(shape_of("glad_a.ply"), shape_of("b.ply")), 1e-6);
    EXPECT_NEAR(lengths("glad_a.ply").sum(), lengths("a.ply").sum(), 1e-5);
    // A saved one, onto several meshes; c is still what it was once it is added and taken away.
    (void)run({"difference", "--load", "smile.h5", "--onto", "a.ply", "c.ply", "--mesh", "out"});
    EXPECT_LT(difference(lengths("out/a.ply"), lengths("glad_a.ply")), 1e-6);
    const Json both = run({"difference", "--load", "smile.h5", "smile.h5", "--amounts", "0.7,-0.7",
                           "--onto", "c.ply", "--mesh", "same.ply"});
    EXPECT_EQ(both["amounts"], Json({0.7, -0.7}));
    EXPECT_LT((points("same.ply") - points("c.ply")).cwiseAbs().maxCoeff(), 1e-5); // in its place
    (void)run({"difference", "--load", "smile.h5", "--amount", "1", "--mesh", "mean.ply"});
    EXPECT_LT(difference(shape_of("mean.ply"), shape_of("b.ply")), 1e-6);
    (void)run({"difference", "--load", "smile.h5", "--onto", "c.ply", "--size", "50", "--amount",
               "0", "--mesh", "small.ply"});
    EXPECT_LT(difference(shape_of("small.ply"), shape_of("c.ply")), 1e-6);
    EXPECT_NEAR(lengths("small.ply").sum(), 50.0, 1e-4);
    const Json chosen =
        run({"difference", "people.h5", "--pair-by", "subject", "--from", "mood=calm", "--to",
             "mood=glad", "--only", "subject=s1", "--only", "subject=s4", "-o", "two.h5"});
    EXPECT_EQ(chosen["pairs"], 2);
}

TEST_F(Groups, ShapesAreTheSameAtEverySize)
{
    const auto same = [&](const std::string& a, double size_of_a, const std::string& b,
                          double size_of_b) {
        EXPECT_LT((points(a) / size_of_a - points(b) / size_of_b).cwiseAbs().maxCoeff(), 1e-12)
            << a << " " << b;
    };
    const auto shape = [&](const Arguments& arguments) {
        const Outcome outcome = run_shape(folder_.path(), arguments); // which may warn
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    };
    // A difference far beyond what any mesh has, at the size of its start and at others.
    const Json figures = run(smile({"-o", "smile.h5"}));
    const double from_size = figures["from_size"];
    const Arguments load{"difference", "--load", "smile.h5", "--amount", "-9", "--mesh"};
    shape(load + Arguments{"own.ply"});
    for (const double size : {0.7, 1e6}) {
        shape(load + Arguments{"at.ply", "--size", join(size), "--force"});
        same("own.ply", from_size, "at.ply", size);
    }
    const auto centred = [&](const std::string& file) -> Points {
        const Points mesh = points(file);
        return mesh.rowwise() - mesh.colwise().mean();
    };
    shape(load + Arguments{"c_own.ply", "--onto", "c.ply"});
    shape(load + Arguments{"c_at.ply", "--onto", "c.ply", "--size", "0.7"});
    EXPECT_LT((centred("c_own.ply") / lengths("c.ply").sum() - centred("c_at.ply") / 0.7)
                  .cwiseAbs()
                  .maxCoeff(),
              1e-12);
    // Shapes that are expected at a size have it; those at the same number of a label the mean size.
    Table table = read_table(folder_ / "labels.csv");
    table.columns.emplace_back("number");
    double sum = 0.0;
    for (auto& row : table.rows) {
        const double size = lengths("people/" + row.front() + ".ply").sum();
        sum += size;
        row.push_back(print_number(size));
    }
    write_table(folder_ / "sizes.csv", table);
    const double mean_size = sum / static_cast<double>(table.rows.size());
    const Arguments regress{"regress", "people", "--labels", "sizes.csv", "--permutations", "9",
                            "--at",    "90",     "--force",  "-o",        "r.csv",          "--on"};
    shape(regress + Arguments{"size", "--expected", "by_size/"});
    shape(regress + Arguments{"number", "--expected", "by_number/"});
    same("by_size/size_90.ply", 90.0, "by_number/number_90.ply", mean_size);
    expect_failure(
        2, {"regress", "people", "--on", "size", "-o", "x.csv", "--at", "-3", "--expected", "at"},
        {"--at -3: a size must be > 0"});
}

TEST_F(Groups, BadInputIsNamed)
{
    const Arguments groups{"groups", "people.h5", "-o", "out.csv"};
    expect_failure(3, groups + Arguments{"--by", "gap"},
                   {"s5_glad", "'gap' (1 of 12 meshes); leave it out"});
    expect_failure(3, groups + Arguments{"--by", "mood", "--within", "gap"}, {"s5_glad", "gap"});
    expect_failure(3, groups + Arguments{"--by", "none"}, {"none", "subject, mood"});
    expect_failure(3, groups + Arguments{"--by", "same"}, {"one group"});
    expect_failure(3,
                   {"groups", "people.h5", "--by", "subject", "--only", "mood=calm", "-o", "x.csv"},
                   {"6 observations in 6 groups"});
    expect_failure(3, groups + Arguments{"--by", "sex", "--within", "sex"},
                   {"2 blocks in 2 groups"});
    expect_failure(3, groups + Arguments{"--by", "mood", "--adjust-for", "word"},
                   {"word", "s0_calm", "old"});
    expect_failure(3, groups + Arguments{"--by", "mood", "--only", "sex=x"}, {"--only"});
    expect_failure(3, {"groups", "people", "--by", "mood", "-o", "x.csv"}, {"mood", "no labels"});

    const Arguments classify{"classify", "people.h5", "-o", "out.csv", "--by", "mood"};
    expect_failure(3, classify + Arguments{"--modes", "11"}, {"modes", "9"});
    expect_failure(3, classify + Arguments{"--modes", "2", "--leave-out", "mood"},
                   {"'calm'", "nothing is left"});
    expect_failure(3, classify + Arguments{"--modes", "2", "--leave-out", "gap"}, {"s5_glad"});
    expect_failure(3, {"classify", "people.h5", "-o", "x.csv", "--by", "same", "--modes", "2"},
                   {"1 group,"});

    const Arguments regress{"regress", "people.h5", "-o", "out.csv"};
    expect_failure(3, regress + Arguments{"--on", "word"}, {"word", "s0_calm", "old", "number"});
    expect_failure(3, regress + Arguments{"--on", "gap"}, {"s5_glad", "gap"});
    expect_failure(3, regress + Arguments{"--on", "same"}, {"--on same: is constant, "});
    expect_failure(3, {"regress", "a.ply", "b.ply", "--on", "size", "-o", "x.csv"},
                   {"2 observations"});
}

TEST_F(Groups, CellsThatAreNoNumbersAreNamedWithWhatToDo)
{
    const std::vector<std::array<std::string, 2>> cells{
        {"inf", "'inf' is not a finite number; correct it"},
        {"\"1,5\"", "'1,5' is not a finite number (decimal point, no comma); correct it"},
        {"1e400", "'1e400' is not a finite number: double precision ends at 1.8e308"},
        {"2024-05-01", "'2024-05-01' is not a finite number, but a date or a time; write how long"},
        {"old", "'old' is not a finite number; correct it"}};
    for (const auto& [cell, said] : cells) {
        Table table = read_table(folder_ / "labels.csv");
        std::string text = "mesh,dose,mood\n";
        for (std::size_t i = 0; i < table.rows.size(); ++i)
            text +=
                join(table.rows[i][0], ",", i == 4 ? cell : join(1.5 * static_cast<double>(i % 5)),
                     ",", table.rows[i][2], "\n");
        folder_.write("doses.csv", text);
        const std::string mesh = table.rows[4][0];
        const std::string place = join("doses.csv: label 'dose' of mesh ", mesh, ": ");
        const std::string leave = "leave the cell empty and the mesh out (--only dose)";
        const Arguments labelled{"people", "--labels", "doses.csv", "-o", "x.csv"};
        expect_failure(3, Arguments{"regress", "--on", "dose"} + labelled, {place + said, leave});
        expect_failure(3, Arguments{"groups", "--by", "mood", "--adjust-for", "dose"} + labelled,
                       {place + said, leave});
        // What takes it for a name goes on.
        (void)run({"stats", "people", "--labels", "doses.csv", "-o", "dosed.h5", "--force"});
        expect_failure(3, {"explore", "dosed.h5", "--regress", "dose", "-o", "x.html"},
                       {join("--regress: dosed.h5: label 'dose' of mesh ", mesh, ": ") +
                            said.substr(0, said.find(';')),
                        "and make the model again"});
    }
}

TEST_F(Groups, BadInputToRemovalAndTransferIsNamed)
{
    (void)run(smile({"-o", "smile.h5"}));
    const TestMesh finer = icosphere(2);
    write_mesh(folder_ / "finer.ply", finer.points, finer.topology.faces(), MeshFormat::Ply);
    (void)run({"stats", "a.ply", "b.ply", "-o", "model.h5"});
    expect_failure(3, {"remove", "a.ply", "b.ply", "--modes", "2", "-o", "x"}, {"modes is 2"});
    expect_failure(3, {"remove", "a.ply", "--modes", "2", "--model", "model.h5", "-o", "x"},
                   {"2 modes"});
    expect_failure(3, {"remove", "finer.ply", "--modes", "1", "--model", "model.h5", "-o", "x"},
                   {"another triangulation"});
    expect_failure(3, {"remove", "finer.ply", "--direction", "smile.h5", "-o", "x"},
                   {"another triangulation"});
    expect_failure(3, {"remove", "a.ply", "b.ply", "--modes", "1", "--like", "z", "-o", "x"},
                   {"--like", "'z'"});
    expect_failure(3, {"remove", "a.ply", "--direction", "model.h5", "-o", "x"}, {"model.h5"});

    const Arguments load{"difference", "--load", "smile.h5", "--mesh", "x.ply"};
    expect_failure(3, load + Arguments{"--onto", "z"}, {"--onto", "'z'"});
    expect_failure(3, load + Arguments{"--onto", "finer.ply"}, {"finer.ply", "triangulation"});
    (void)run(smile({"-o", "plain.h5", "--scale", "none"}));
    expect_failure(3, load + Arguments{"--load", "plain.h5"}, {"plain.h5", "scale"});
    expect_failure(3, {"difference", "--load", "model.h5", "--mesh", "x.ply"}, {"model.h5"});
    expect_failure(5, {"difference", "--load", "no.h5", "--mesh", "x.ply"}, {"no.h5"});
}

TEST_F(Groups, WrongUsageIsNamed)
{
    (void)run(smile({"-o", "smile.h5"}));
    const Arguments groups{"groups", "people.h5", "--by", "mood"};
    expect_failure(2, groups, {"--output"});
    expect_failure(2, {"groups", "people.h5", "-o", "x.csv"}, {"--by"});
    expect_failure(2, groups + Arguments{"-o", "x.h5"}, {".csv"});
    expect_failure(2, groups + Arguments{"-o", "x.csv", "--permutations", "-1"}, {"--permut"});
    expect_failure(2, groups + Arguments{"-o", "x.csv", "--bootstrap", "0"}, {"--bootstrap"});
    expect_failure(2, groups + Arguments{"-o", "x.csv", "--space", "procrustes", "--area-weighted"},
                   {"--area-weighted"});
    const Arguments classify{"classify", "people.h5", "--by", "mood", "-o", "x.csv"};
    expect_failure(2, classify + Arguments{"--modes", "0"}, {"--modes"});
    expect_failure(2, classify + Arguments{"--plot", "x.pdf"}, {"--plot"});
    expect_failure(2, classify + Arguments{"--predictions", "./x.csv"}, {"--predictions"});
    const Arguments regress{"regress", "people.h5", "-o", "x.csv"};
    expect_failure(2, regress, {"--on"});
    expect_failure(2, regress + Arguments{"--on", "age", "--at", "3"}, {"--expected"});
    expect_failure(2, regress + Arguments{"--on", "age", "--expected", "d"}, {"--at"});
    expect_failure(2, regress + Arguments{"--on", "age", "--expected", "d", "--at", "old"},
                   {"--at", "old"});
    expect_failure(
        2, regress + Arguments{"--on", "age", "--on", "size", "--expected", "d", "--at", "3"},
        {"--at"});
    expect_failure(
        2, regress + Arguments{"--on", "age", "--expected", "d", "--at", "3", "--corrected", "./d"},
        {"--corrected"});
    const Arguments remove{"remove", "a.ply", "b.ply", "-o", "x"};
    expect_failure(2, remove, {"--modes"});
    expect_failure(2, remove + Arguments{"--modes", "1", "--direction", "smile.h5"}, {"--"});
    expect_failure(2, remove + Arguments{"--direction", "smile.h5", "--model", "m.h5"},
                   {"--modes"});
    for (const Arguments& space :
         {Arguments{"--space", "procrustes"}, Arguments{"--scale", "none"},
          Arguments{"--coordinates", "log"}, Arguments{"--area-weighted"},
          Arguments{"--with-dihedrals", "1"}, Arguments{"--with-positions", "5"}}) {
        // A model, and a difference, have a space already.
        expect_failure(2, remove + Arguments{"--modes", "1", "--model", "m.h5"} + space,
                       {"--model", space.front()});
        expect_failure(2, remove + Arguments{"--direction", "smile.h5"} + space,
                       {"--direction", space.front()});
        expect_failure(2, Arguments{"stats", "a.ply", "-o", "x.h5", "--update", "m.h5"} + space,
                       {"--update", space.front()});
    }
    expect_failure(2, {"stats", "a.ply", "-o", "x.h5", "--variance", "95"}, {"--variance", "0.95"});
    expect_failure(2, {"stats", "a.ply", "-o", "x.h5", "-o", "y.h5"}, {"--output", "2 times"});

    const Arguments load{"difference", "--load", "smile.h5"};
    expect_failure(2, load, {"--mesh"});
    expect_failure(2, {"difference", "a.ply", "--load", "smile.h5", "--mesh", "x.ply"}, {"MESHES"});
    expect_failure(2, load + Arguments{"--mesh", "x.ply", "--amounts", "1,2"}, {"--amount"});
    expect_failure(2, load + Arguments{"--mesh", "x.ply", "--amount", "nan"}, {"--amount"});
    expect_failure(2, load + Arguments{"--mesh", "x.ply", "--from", "mood=calm"}, {"--load"});
    expect_failure(2, load + Arguments{"--mesh", "x.ply", "--onto", "a.ply", "b.ply"}, {"x.ply"});
    expect_failure(2, load + Arguments{"--mesh", "x.ply", "--only", "mood=calm"}, {"--load"});
    expect_failure(2, smile({}), {"-o"});
    expect_failure(2, smile({"-o", "x.h5", "--mesh", "x.ply"}), {"--apply"});
    expect_failure(
        2, {"difference", "people.h5", "-o", "x.h5", "--from", "mood=calm", "--to", "mood=calm"},
        {"--from and --to are both mood=calm"});
    expect_failure(2, {"difference", "a.ply", "-o", "x.h5", "--pair-by", "k", "--to", "k=2"},
                   {"--from"});
    expect_failure(2,
                   {"difference", "-o", "x.h5", "--pair-by", "k", "--from", "k=1", "--to", "k=2"},
                   {"MESHES"});
}

} // namespace
} // namespace shape::test
