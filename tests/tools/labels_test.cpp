// SPDX-License-Identifier: MIT

#include <algorithm>
#include <functional>

#include "libshape/base/format.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/table_file.h"
#include "tests/support/matrices.h"
#include "tests/support/meshes.h"
#include "tests/tools/program_test.h"

namespace shape::test {
using namespace internal;
namespace {

using Values = std::vector<std::string>;

/// Ten spheres m0 to m9.
class LabelledMeshes : public ProgramTest
{
protected:
    LabelledMeshes()
    {
        std::filesystem::create_directory(folder_ / "set");
        for (unsigned i = 0; i < 10; ++i) {
            const TestMesh mesh = bumpy_sphere(1, 0.2, i);
            write_mesh(folder_ / join("set/m", i, ".ply"), mesh.points, mesh.topology.faces(),
                       MeshFormat::Ply);
        }
    }
    /// A table with one label of the ten meshes.
    void write_labels(const std::string& name, const Values& values) const
    {
        std::string text = "mesh," + name + "\n";
        for (std::size_t i = 0; i < values.size(); ++i)
            text += join("m", i, ",", values[i], "\n");
        folder_.write("l.csv", text);
    }
    [[nodiscard]] Outcome shape(const Arguments& arguments) const
    {
        return run_shape(folder_.path(), arguments);
    }
};

TEST_F(LabelledMeshes, MissingValuesAreNotAGroupAndCanBeLeftOut)
{
    write_labels("sex", {"f", " f ", "m", "m ", "NA", "nan", "NULL", "#N/A", ".", ""});
    const Arguments groups{"groups", "set", "--labels", "l.csv", "--by", "sex", "-o", "g.csv"};
    const Outcome refused = shape(groups);
    EXPECT_EQ(refused.exit_code, 3);
    EXPECT_NE(refused.err.find("and 5 others have no value of label"), std::string::npos)
        << refused.err;
    EXPECT_NE(refused.err.find("--only sex"), std::string::npos) << refused.err;
    const Json found = run(groups + Arguments{"--only", "sex"});
    EXPECT_EQ(found["meshes"], 4);
    ASSERT_EQ(found["groups"].size(), 2U);
    EXPECT_EQ(found["groups"][0]["name"], "f");
    EXPECT_EQ(found["groups"][1]["meshes"], 2);
}

TEST_F(LabelledMeshes, MissingValuesDoNotCountAsAValue)
{
    write_labels("sex", {"f", "f", "m", "m", "NA", "", "f", "m", "f", "m"});
    (void)run({"collect", "set", "--labels", "l.csv", "-o", "c.h5"});
    EXPECT_EQ(run({"info", "c.h5"})["labels"]["sex"], 2);
}

TEST_F(LabelledMeshes, MissingValuesNeverPair)
{
    folder_.write("l.csv",
                  "mesh,subject,mood\nm0,x,calm\nm1,x,glad\nm2,,calm\nm3,NA,glad\nm4,.,calm\n"
                  "m5, ,glad\nm6,y,calm\nm7,y,glad\nm8,z,calm\nm9,z,NA\n");
    const Arguments difference{"difference", "set", "--labels", "l.csv", "--pair-by",
                               "subject",    "-o",  "d.h5",     "--to",  "mood=glad"};
    EXPECT_EQ(run(difference + Arguments{"--from", "mood=calm"})["pairs"], 2);
    for (const char* from : {"mood=", "mood=NA", "mood= ", "mood=nan"}) {
        const Outcome outcome = shape(difference + Arguments{"--from", from, "--force"});
        EXPECT_EQ(outcome.exit_code, 2) << from;
        EXPECT_NE(outcome.err.find("names no value"), std::string::npos) << outcome.err;
    }
    EXPECT_EQ(
        shape({"collect", "set", "--labels", "l.csv", "--only", "mood=", "-o", "x.h5"}).exit_code,
        2);
    EXPECT_EQ(run({"collect", "set", "--labels", "l.csv", "--only", "mood", "--only", "subject",
                   "-o", "x.h5"})["meshes"],
              5);
}

TEST_F(LabelledMeshes, TablesMayBeOfALargerStudyWithANote)
{
    folder_.write("l.csv", "mesh,k\nm0.ply,1\nM77,9\nm1.PLY,2\nm99,9\n");
    const Outcome outcome =
        shape({"collect", "set/m0.ply", "set/m1.ply", "--labels", "l.csv", "-o", "c.h5"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(
        outcome.err.find("l.csv: 2 rows of meshes that are not among these left out, first 'M77'"),
        std::string::npos)
        << outcome.err;
    EXPECT_EQ(find_label(read_collection(folder_ / "c.h5").labels, "k").values, (Values{"1", "2"}));
}

TEST_F(LabelledMeshes, ValuesThatDifferInCaseAloneAreSaid)
{
    folder_.write("l.csv", "mesh,sex\nm0,f\nm1,F\n");
    const Outcome outcome =
        shape({"collect", "set/m0.ply", "set/m1.ply", "--labels", "l.csv", "-o", "c.h5"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("l.csv: label 'sex' has the values 'f' and 'F'"), std::string::npos)
        << outcome.err;
}

TEST_F(LabelledMeshes, ValuesThatLookAlikeAreSaid)
{
    folder_.write("l.csv", "mesh,site,visit\nm0,New York,pre-op\nm1,New  York,pre\u2013op\n");
    const Outcome outcome =
        shape({"collect", "set/m0.ply", "set/m1.ply", "--labels", "l.csv", "-o", "c.h5"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    for (const char* said : {"label 'site' has the values 'New York' and 'New  York', which differ "
                             "in blanks and are two groups",
                             "which differ in characters that look alike (U+002D and U+2013)"})
        EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
}

TEST_F(LabelledMeshes, DirectoriesNamedLikeMeshesArePassedOver)
{
    folder_.write("set/old.ply/m9.ply", folder_.read("set/m0.ply"));
    EXPECT_EQ(run({"collect", "set", "-o", "c.h5"})["meshes"], 10);
}

TEST_F(LabelledMeshes, AccentsMatchInEitherSpelling)
{
    const std::string composed = "Ren\xC3\xA9";
    const std::string decomposed = "Rene\xCC\x81";
    folder_.write("n/" + decomposed + ".ply", folder_.read("set/m0.ply"));
    folder_.write("n/o.ply", folder_.read("set/m1.ply"));
    folder_.write("l.csv", "mesh,who\n" + composed + "," + decomposed + "\no,o\n");
    (void)run({"collect", "n", "--labels", "l.csv", "-o", "c.h5"});
    EXPECT_EQ(run({"collect", "c.h5", "--only", "who=" + composed, "-o", "d.h5"})["meshes"], 1);
    EXPECT_EQ(run({"collect", "c.h5", "--only", "who=" + decomposed, "-o", "e.h5"})["meshes"], 1);
}

TEST_F(LabelledMeshes, NamesThatATableTakesForOneAreWarnedOf)
{
    const Arguments collect{"collect", "n", "-o", "c.h5", "--force"};
    folder_.write("n/u\xCC\x88x.ply", folder_.read("set/m0.ply"));
    EXPECT_EQ(shape(collect).err.find("composition"), std::string::npos);
    folder_.write("n/\xC3\xBCx.ply", folder_.read("set/m1.ply"));
    const Outcome outcome = shape(collect);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("composition of accents alone"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("n/\xC3\xBCx.ply"), std::string::npos) << outcome.err;
}

TEST_F(LabelledMeshes, NamesThatAreAddedAreComparedWithThoseThatAreThere)
{
    (void)run({"collect", "set/m0.ply", "set/m1.ply", "-o", "c.h5"});
    folder_.write("n/m1 .ply", folder_.read("set/m2.ply"));
    const Outcome outcome = shape({"collect", "n", "--append", "-o", "c.h5"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("the names of 'c.h5: mesh m1' and 'm1 ' differ by outer blanks"),
              std::string::npos)
        << outcome.err;
}

TEST_F(LabelledMeshes, IndividualsAreKnownByTheNameOfTheirColumn)
{
    const Arguments groups{"groups", "set",   "--labels",       "l.csv", "--by",   "sex",
                           "-o",     "g.csv", "--permutations", "10",    "--force"};
    const auto said_of = [&](const std::string& name) {
        std::string text = "mesh,sex," + name + "\n";
        for (int i = 0; i < 10; ++i) // four individuals are too few for labels of other names
            text += join("m", i, ",", i < 5 ? "f" : "m", ",p", i < 5 ? i % 2 : 2 + i % 2, "\n");
        folder_.write("l.csv", text);
        const Outcome outcome = shape(groups);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err.find("those of one " + name + " (4 of them) are repeated") !=
               std::string::npos;
    };
    for (const char* name : {"RID", "PTID", "mrn", "case", "Mouse_no", "rats", "indiv", "name",
                             "ID_person", "id-subject", "Patienten-ID", "Tier", "sujet", "sujetos",
                             "paciente", "soggetto", "paziente"})
        EXPECT_TRUE(said_of(name)) << name;
    for (const char* name : {"site", "idea", "rating", "casual", "frontier"})
        EXPECT_FALSE(said_of(name)) << name;
}

TEST_F(LabelledMeshes, RepeatedScansAreRegressedByTheirMeansAndElseWarnedOf)
{
    std::string text = "mesh,person,age,dose,grams\n";
    for (int i = 0; i < 10; ++i)
        text += join("m", i, ",p", i / 2, ",", 20 + 3 * (i / 2) + (i / 2) % 2, ",", i % 2, ",",
                     2 * (i % 2) + 1, "\n");
    folder_.write("l.csv", text);
    const Arguments regress{"regress", "set", "--labels", "l.csv", "-o", "r.csv", "--force"};
    const Json nested = run(regress + Arguments{"--on", "age", "--within", "person"});
    EXPECT_EQ(nested["design"], "nested");
    EXPECT_EQ(nested["covariates"][0]["residual_df"], 3); // five means, a constant, a slope
    EXPECT_EQ(run(regress + Arguments{"--on", "dose", "--within", "person"})["design"], "crossed");
    const Outcome both =
        shape(regress + Arguments{"--on", "age", "--on", "dose", "--within", "person"});
    EXPECT_EQ(both.exit_code, 3);
    for (const char* said : {"--on age: is the same for all meshes of a value of person, dose is "
                             "not",
                             "one of them at a time"})
        EXPECT_NE(both.err.find(said), std::string::npos) << both.err;
    (void)run({"collect", "set", "-o", "set.h5"});
    for (const Arguments& memory : {Arguments{}, Arguments{"--memory", "100M"}}) {
        const Outcome twice = shape(Arguments{"regress", "set.h5", "--labels", "l.csv", "--on",
                                              "dose", "--on", "grams", "-o", "t.csv"} +
                                    memory);
        EXPECT_EQ(twice.exit_code, 3);
        EXPECT_NE(twice.err.find("--on grams: is a combination of the covariates before it (dose)"),
                  std::string::npos)
            << twice.err;
    }
    const Outcome plain = shape(regress + Arguments{"--on", "age"});
    EXPECT_EQ(plain.exit_code, 0) << plain.err;
    EXPECT_NE(plain.err.find("not independent"), std::string::npos) << plain.err;
    EXPECT_NE(plain.err.find("--within person"), std::string::npos) << plain.err;
    EXPECT_EQ(shape(regress + Arguments{"--on", "dose"}).err.find("not independent"),
              std::string::npos);
}

TEST_F(LabelledMeshes, RepeatedScansAreWarnedOfWhereverTheyCount)
{
    std::string text = "mesh,person,sex,session\n";
    for (int i = 0; i < 10; ++i)
        text += join("m", i, ",p", i / 2, ",", i / 2 % 2 == 0 ? "f" : "m", ",", i % 2, "\n");
    folder_.write("l.csv", text);
    const auto warns = [&](const Arguments& arguments, const std::string& advice) {
        const Outcome outcome = shape(arguments + Arguments{"set", "--labels", "l.csv", "--force"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const bool is_warned = outcome.err.find("not independent") != std::string::npos;
        EXPECT_TRUE(!is_warned || outcome.err.find(advice + " person") != std::string::npos)
            << outcome.err;
        return is_warned;
    };
    const Arguments stats{"stats", "-o", "x.h5", "--modes", "2", "--bootstrap", "5"};
    EXPECT_TRUE(warns(stats, "--within"));
    EXPECT_FALSE(warns(stats + Arguments{"--within", "person"}, ""));
    const Arguments quality{"quality", "-o", "q.csv",     "--modes", "1",
                            "--tests", "1",  "--samples", "1"};
    EXPECT_TRUE(warns(quality, "--leave-out"));
    EXPECT_FALSE(warns(quality + Arguments{"--leave-out", "person"}, ""));
    const Arguments sexes{"difference", "--from", "sex=f", "--to", "sex=m", "-o", "x.h5"};
    EXPECT_FALSE(warns(sexes, "")); // a mean, and no test
    EXPECT_TRUE(warns(sexes + Arguments{"--effects", "e.ply"}, "of each"));
    EXPECT_FALSE(warns({"difference", "--pair-by", "person", "--from", "session=0", "--to",
                        "session=1", "-o", "x.h5", "--effects", "e.ply"},
                       ""));
    // Who was scanned more often weighs more in the mean.
    text = "mesh,person,sex\n";
    for (int i = 0; i < 10; ++i) {
        const int person = std::max(i / 2 - 1, 0);
        text += join("m", i, ",p", person, ",", person % 2 == 0 ? "f" : "m", "\n");
    }
    folder_.write("l.csv", text);
    EXPECT_TRUE(warns(sexes, "weigh more. Take one mesh, or the mean, of each"));
}

/// Twelve scans under scans/ of four people, three of each: two of either sex (sex.csv), each of another age
/// (age.csv).
class FewPeople : public LabelledMeshes
{
protected:
    /// @param name  Of a scan, by its number and that of its person.
    /// @param noise  Standard deviation of a scan's positions.
    /// @param column  A further label that is the same for all scans of a person.
    void scan(const std::function<std::string(int, int)>& name, double noise,
              const std::string& column = "") const
    {
        std::filesystem::remove_all(folder_ / "scans");
        std::filesystem::create_directory(folder_ / "scans");
        const std::string end = column.empty() ? "" : "," + column;
        std::string sexes = "mesh,sex" + end + "\n";
        std::string ages = "mesh,age" + end + "\n";
        for (int i = 0; i < 12; ++i) {
            const int person = i / 3;
            TestMesh mesh = bumpy_sphere(1, 0.2, static_cast<unsigned>(person));
            mesh.points += noise * random_matrix(mesh.points.rows(), 3, static_cast<unsigned>(i));
            write_mesh(folder_ / join("scans/", name(i, person), ".ply"), mesh.points,
                       mesh.topology.faces(), MeshFormat::Ply);
            const std::string value = column.empty() ? "" : join(",w", person);
            sexes += join(name(i, person), person < 2 ? ",f" : ",m", value, "\n");
            ages += join(name(i, person), ",", 20 + 5 * person, value, "\n");
        }
        folder_.write("sex.csv", sexes);
        folder_.write("age.csv", ages);
    }

    /// The warning that rows are not independent, or nothing.
    [[nodiscard]] std::string said(const Arguments& question) const
    {
        const bool is_of_age = std::find(question.begin(), question.end(), "age") != question.end();
        const Outcome outcome =
            shape(question +
                  Arguments{"scans", "--labels", is_of_age ? "age.csv" : "sex.csv", "--force"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const std::size_t begin = outcome.err.find("the 12 meshes are not independent");
        return begin == std::string::npos
                   ? std::string()
                   : outcome.err.substr(begin, outcome.err.find('\n', begin) - begin);
    }

    const Arguments groups_{"groups",         "--by", "sex",         "-o", "x.csv",
                            "--permutations", "9",    "--bootstrap", "9"};
    const Arguments classify_{"classify", "--by", "sex", "-o", "x.csv"};
    const Arguments difference_{"difference", "--from", "sex=f",     "--to", "sex=m",
                                "-o",         "x.h5",   "--effects", "x.ply"};
    const Arguments regress_{"regress", "--on", "age", "-o", "x.csv", "--permutations", "9"};
    const std::function<std::string(int, int)> numbered_ = [](int i, int) { return join("m", i); };
    const std::function<std::string(int, int)> named_ = [](int i, int person) {
        return join("w", person, "_", i);
    };
};

TEST_F(FewPeople, AreToldByTheNameOfALabelWhateverTheirShapes)
{
    scan(numbered_, 0.12, "Patient_ID");
    for (const Arguments& question : {groups_, classify_, difference_, regress_})
        EXPECT_TRUE(
            said(question).starts_with("the 12 meshes are not independent if those of one "
                                       "Patient_ID (4 of them) are repeated"))
            << question.front() << said(question);
    EXPECT_TRUE(said(groups_).ends_with("Give --within Patient_ID"));
    EXPECT_EQ(said(regress_ + Arguments{"--within", "Patient_ID"}), "");
    EXPECT_EQ(said(classify_ + Arguments{"--leave-out", "Patient_ID"}), "");
    // Four values of something else, and shapes that say nothing.
    for (const char* column : {"room", "patient_group", "idle"}) {
        scan(numbered_, 0.12, column);
        for (const Arguments& question : {groups_, classify_, difference_, regress_})
            EXPECT_EQ(said(question), "") << column << question.front();
    }
}

TEST_F(FewPeople, AreToldByScansThatAreMuchAlike)
{
    const auto expect = [&](const std::string& which, const std::string& advice) {
        for (const Arguments& question : {groups_, regress_}) {
            EXPECT_TRUE(
                said(question).starts_with("the 12 meshes are not independent if those " + which))
                << said(question);
            EXPECT_TRUE(said(question).ends_with("Give --within " + advice)) << said(question);
        }
        EXPECT_TRUE(said(classify_).find("Give --leave-out " + advice) != std::string::npos)
            << said(classify_);
        EXPECT_TRUE(said(difference_).find("or the mean, of each ") != std::string::npos)
            << said(difference_);
    };
    scan(numbered_, 0.002, "room");
    expect("of one room (4 of them), whose shapes are much alike, are repeated", "room");
    scan(named_, 0.002);
    expect(
        "whose names begin alike and whose shapes are much alike, such as w0_0, w0_1 and w0_2 (4 "
        "such sets), are",
        "a label that names them");
    scan(numbered_, 0.002);
    expect("whose shapes are much alike, such as m0, m1 and m2 (4 such sets), are",
           "a label that names them");
}

TEST_F(FewPeople, AreNoGroupsThatDifferMuch)
{
    scan(named_, 0.002, "room");
    const Arguments by_age{"groups",         "--by", "age",         "-o", "x.csv",
                           "--permutations", "9",    "--bootstrap", "9"};
    EXPECT_EQ(said(by_age), ""); // of each group one person: it may be what a group is
    scan(named_, 0.12, "room");
    for (const Arguments& question : {groups_, classify_, difference_, regress_})
        EXPECT_EQ(said(question), "") << question.front();
}

TEST_F(FewPeople, AreToldFromShapesByThresholdsOfNearness)
{
    // What names begin with has distances of 0.21, 0.31, 0.45 and 0.58 times those between people, give or take 0.02.
    scan(named_, 0.004);
    EXPECT_NE(said(groups_), "");
    EXPECT_NE(said(regress_), "");
    scan(named_, 0.006);
    EXPECT_NE(said(groups_), "");
    EXPECT_EQ(said(regress_), ""); // age may be what makes them differ
    scan(named_, 0.009);
    EXPECT_NE(said(groups_), "");
    scan(named_, 0.013);
    EXPECT_EQ(said(groups_), "");
}

TEST_F(FewPeople, AreToldWhereShapeIsRegressedOnSize)
{
    const std::string rule = "the 12 meshes are not independent if those ";
    const std::string advice = "Take one mesh, or the mean, of each ";
    const Arguments by_size{"regress", "--on", "size", "-o", "x.csv", "--permutations", "9"};
    scan(named_, 0.002);
    EXPECT_TRUE(said(by_size).starts_with(rule + "whose names begin alike")) << said(by_size);
    EXPECT_TRUE(said(by_size).ends_with(advice + "set")) << said(by_size);
    const Outcome bare = shape(by_size + Arguments{"scans", "--force"}); // no table of labels
    EXPECT_NE(bare.err.find(rule + "whose names begin alike"), std::string::npos) << bare.err;
    (void)run({"collect", "scans", "-o", "scans.h5", "--force"});
    const Outcome passes = shape(by_size + Arguments{"scans.h5", "--force", "--memory", "100M"});
    EXPECT_NE(passes.err.find(rule + "whose names begin alike"), std::string::npos) << passes.err;
    scan(numbered_, 0.02, "Patient_ID");
    EXPECT_TRUE(said(by_size).starts_with(rule + "of one Patient_ID (4 of them)")) << said(by_size);
    EXPECT_TRUE(said(by_size).ends_with(advice + "Patient_ID")) << said(by_size);
    // People that grow: sizes differ as much within them as between them.
    scan(named_, 0.002, "Patient_ID");
    for (int i = 0; i < 12; ++i) {
        const std::string file = "scans/" + named_(i, i / 3) + ".ply";
        write_mesh(folder_ / file, (1.0 + 0.2 * (i % 3)) * points(file),
                   read_mesh(folder_ / file).faces);
    }
    EXPECT_EQ(said(by_size), "");
}

TEST_F(LabelledMeshes, SizesOfRepeatedScansAreNearlyTheSame)
{
    // Sizes 1, 1.1, ... 1.4 of five people, give or take `error`.
    const auto is_told = [&](const std::string& name, double error) {
        Values people;
        for (int i = 0; i < 10; ++i) {
            people.push_back(join("p", i / 2));
            const std::string file = join("set/m", i, ".ply");
            const double size = 1.0 + 0.1 * (i / 2) + (i % 2 == 0 ? error : -error);
            write_mesh(folder_ / file, size / lengths(file).sum() * points(file),
                       read_mesh(folder_ / file).faces);
        }
        write_labels(name, people);
        const Outcome outcome = shape({"regress", "set", "--labels", "l.csv", "--on", "size", "-o",
                                       "x.csv", "--permutations", "9", "--force"});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.err.find("not independent if those of one " + name) != std::string::npos;
    };
    // Standard deviations within people of 0.15, 0.35 and 0.6 of that of all.
    EXPECT_TRUE(is_told("site", 0.016));
    EXPECT_FALSE(is_told("site", 0.038));
    EXPECT_TRUE(is_told("person", 0.038));
    EXPECT_FALSE(is_told("person", 0.072));
}

TEST_F(LabelledMeshes, ValuesThatDifferInSpellingAloneAreWarnedOf)
{
    write_labels("g", {"f", "F", "m", "m", "f", "m", "f", "m", "f", "m"});
    const Outcome outcome = shape({"collect", "set", "--labels", "l.csv", "-o", "c.h5"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_NE(outcome.err.find("label 'g' has the values 'f' and 'F'"), std::string::npos)
        << outcome.err;
    const Outcome none = shape({"stats", "c.h5", "-o", "m.h5", "--only", "g=M"});
    EXPECT_EQ(none.exit_code, 3);
    EXPECT_NE(none.err.find("no mesh has g = 'M', there are F, f and m"), std::string::npos)
        << none.err;
}

TEST_F(LabelledMeshes, ColumnsOfAnyNameAreKept)
{
    std::string text = "mesh,M/F,kg/m2,., ,NA\n";
    for (int i = 0; i < 10; ++i)
        text += join("m", i, i % 2 == 0 ? ",f," : ",m,", 20 + i, ",a,b,c\n");
    folder_.write("l.csv", text);
    const Outcome outcome = shape({"collect", "set", "--labels", "l.csv", "-o", "c.h5"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("l.csv: 1 column without a name left out, first column 5"),
              std::string::npos)
        << outcome.err;
    (void)run({"stats", "set", "--labels", "l.csv", "-o", "m.h5"});
    (void)run({"collect", "c.h5", "--only", "kg/m2=21", "--only", "NA", "-o", "e.h5"});
    const Json kept{{"M/F", 2}, {"kg/m2", 10}, {".", 1}, {"NA", 1}};
    EXPECT_EQ(run({"info", "c.h5"})["labels"], kept);
    EXPECT_EQ(run({"info", "m.h5"})["labels"], kept);
    EXPECT_EQ(run({"info", "e.h5"})["labels"]["M/F"], 1);
    (void)run({"groups", "c.h5", "--by", "M/F", "-o", "g.csv", "--means", "means", "--permutations",
               "9", "--bootstrap", "9", "--quality", "preview"});
    (void)run({"regress", "c.h5", "--on", "kg/m2", "-o", "r.csv", "--at", "25", "--expected",
               "expected", "--quality", "preview"});
    EXPECT_EQ(files_in(folder_ / "expected"), Values{"kg_m2_25.ply"});
}

TEST_F(LabelledMeshes, CodesOfMissingValuesAreWarnedOf)
{
    write_labels("age", {"20", "-999", "21", "25", "30", "-999", "22", "23", "35", "39"});
    const std::string doubt =
        "label 'age' is -999 in 2 meshes, apart from all other numbers (20 to 39)";
    const Arguments regress{"regress", "-o", "r.csv", "--permutations", "9", "--force"};
    const auto said = [&](const Arguments& arguments) {
        const Outcome outcome = shape(arguments);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        const std::size_t first = outcome.err.find(doubt);
        EXPECT_EQ(outcome.err.find(doubt, first + 1), std::string::npos) << outcome.err;
        return first != std::string::npos;
    };
    EXPECT_TRUE(said(regress + Arguments{"set", "--labels", "l.csv", "--on", "age"}));
    EXPECT_TRUE(said({"collect", "set", "--labels", "l.csv", "-o", "c.h5"}));
    EXPECT_TRUE(said(regress + Arguments{"c.h5", "--on", "age"}));
    EXPECT_TRUE(said(regress + Arguments{"c.h5", "--on", "age", "--memory", "100M"}));
    EXPECT_FALSE(said(regress + Arguments{"c.h5", "--on", "size"}));
    std::string text = "mesh,age,sex\n";
    for (int i = 0; i < 10; ++i)
        text += join("m", i, ",", i < 2 ? 9999 : 20 + i, i % 2 == 0 ? ",f\n" : ",m\n");
    folder_.write("l.csv", text);
    (void)run({"collect", "set", "--labels", "l.csv", "-o", "c.h5", "--force"});
    const Outcome outcome = shape({"groups", "c.h5", "--by", "sex", "--adjust-for", "age", "-o",
                                   "g.csv", "--permutations", "9", "--bootstrap", "9"});
    EXPECT_NE(outcome.err.find("label 'age' is 9999 in 2 meshes"), std::string::npos)
        << outcome.err;
}

TEST_F(LabelledMeshes, NumbersWhoseSquaresOverflowOrUnderflowAreToldFromConstantOnes)
{
    for (const char* exponent : {"e300", "e-300"}) {
        Values values;
        for (int i = 1; i <= 10; ++i)
            values.push_back(join(i, exponent));
        write_labels("dose", values);
        const Outcome outcome =
            shape({"regress", "set", "--labels", "l.csv", "--on", "dose", "-o", "r.csv"});
        EXPECT_EQ(outcome.exit_code, 3);
        EXPECT_NE(outcome.err.find("label 'dose': the squares of numbers as "), std::string::npos)
            << outcome.err;
        EXPECT_NE(outcome.err.find("give them in another unit"), std::string::npos);
    }
}

TEST_F(LabelledMeshes, GroupsOfAnyNameBecomeFiles)
{
    write_labels("g", {"a/b", "a/b", "a_b", "a_b", "../c", "../c", "a/b", "A_B", "A_B", "../c"});
    (void)run({"groups", "set", "--labels", "l.csv", "--by", "g", "-o", "g.csv", "--means", "means",
               "--permutations", "9", "--bootstrap", "9", "--quality", "preview"});
    EXPECT_EQ(files_in(folder_ / "means"),
              (Values{"A_B_3.ply", "_.._c.ply", "a_b.ply", "a_b_2.ply"}));
}

TEST_F(LabelledMeshes, ClassifyUsesAsManyModesAsFewMeshesAllow)
{
    write_labels("g", {"a", "a", "a", "a", "a", "b", "b", "b", "b", "b"});
    const Arguments classify{"classify", "set", "--labels", "l.csv", "--by", "g", "-o", "c.csv"};
    const Outcome outcome = shape(classify);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("7 modes are used"), std::string::npos) << outcome.err;
    EXPECT_EQ(run(classify + Arguments{"--force"})["modes"], 7);
}

} // namespace
} // namespace shape::test
