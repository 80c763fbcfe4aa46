// SPDX-License-Identifier: MIT

#include <cmath>
#include <filesystem>

#include "libshape/base/format.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/model_file.h"
#include "libshape/io/table_file.h"
#include "tests/support/collections.h"
#include "tests/support/meshes.h"
#include "tests/tools/program_test.h"

namespace shape::test {
namespace {

/// Collections in passes, and what is kept of them.
class Scale : public ProgramTest
{
protected:
    Scale() { write_collection(folder_ / "c.h5", bumpy_spheres(60, 3)); }

    /// l.csv: two sides, ages that vary in them, and three meshes of each subject.
    void write_labels() const
    {
        std::string labels = "mesh,side,age,subject\n";
        int mesh = 0;
        for (const std::string& name : bumpy_spheres(60, 3).names) {
            labels += name + (mesh % 5 < 2 ? ",left," : ",right,") + std::to_string(mesh % 7) +
                      ",s" + std::to_string(mesh / 3) + "\n";
            ++mesh;
        }
        folder_.write("l.csv", labels);
    }

    /// The meshes of c.h5 in two files: the first 40 in `early`, the others in late.h5.
    void write_early_and_late(const std::string& early) const
    {
        const Collection all = bumpy_spheres(60, 3);
        std::vector<std::size_t> first(40);
        std::vector<std::size_t> others(20);
        for (std::size_t i = 0; i < 60; ++i)
            (i < 40 ? first[i] : others[i - 40]) = i;
        write_collection(folder_ / early, subset(all, first));
        write_collection(folder_ / "late.h5", subset(all, others));
    }

    [[nodiscard]] Outcome outcome(const Arguments& arguments) const
    {
        return run_shape(folder_.path(), arguments);
    }
};

void expect_near(const ShapeModel& a, const ShapeModel& b, double tolerance)
{
    const auto near = [&](const auto& x, const auto& y, const char* what) {
        ASSERT_EQ(x.rows(), y.rows()) << what;
        ASSERT_EQ(x.cols(), y.cols()) << what;
        EXPECT_LE((x - y).cwiseAbs().maxCoeff(), tolerance * y.cwiseAbs().maxCoeff()) << what;
    };
    near(a.mean, b.mean, "mean");
    near(a.mean_dihedral_angles, b.mean_dihedral_angles, "mean angles");
    near(a.variances, b.variances, "variances");
    near(a.modes, b.modes, "modes");
    near(a.mode_dihedral_angles, b.mode_dihedral_angles, "mode angles");
    near(a.scores, b.scores, "scores");
    near(a.sizes, b.sizes, "sizes");
    EXPECT_EQ(a.names, b.names);
}

TEST_F(Scale, PassesGiveTheModelOfTheRunInMemoryAndSayHow)
{
    const Json memory = run({"stats", "c.h5", "--modes", "5", "-o", "memory.h5"});
    EXPECT_EQ(memory["passes"], 0);
    EXPECT_EQ(memory["algorithm"], "gram");
    const Json gram =
        run({"stats", "c.h5", "--modes", "5", "-o", "gram.h5", "--algorithm", "gram"});
    EXPECT_EQ(gram["algorithm"], "gram");
    EXPECT_EQ(gram["variance_error"], 0.0);
    EXPECT_EQ(gram["passes"], 2); // one for inner products, one for modes
    expect_near(read_model(folder_ / "gram.h5"), read_model(folder_ / "memory.h5"), 1e-10);
    const Json krylov = run({"stats", "c.h5", "--modes", "5", "-o", "krylov.h5", "--algorithm",
                             "krylov", "--tolerance", "1e-8"});
    EXPECT_EQ(krylov["algorithm"], "krylov");
    EXPECT_LE(krylov["variance_error"], 1e-8);
    for (std::size_t k = 0; k < 5; ++k)
        EXPECT_NEAR(krylov["modes"][k]["variance"], memory["modes"][k]["variance"],
                    1e-8 * memory["modes"][k]["variance"].get<double>());
    const Outcome told =
        outcome({"stats", "c.h5", "--modes", "5", "-o", "k.h5", "--algorithm", "krylov"});
    EXPECT_NE(told.err.find("by block Krylov in"), std::string::npos) << told.err;
    EXPECT_NE(told.err.find("as estimated"), std::string::npos) << told.err;
}

TEST_F(Scale, OnlyAndLabelsChooseTheSameMeshesInPasses)
{
    std::string labels = "mesh,side\n";
    for (const std::string& name : bumpy_spheres(60, 3).names)
        labels += name + (name.back() % 2 == 0 ? ",left\n" : ",right\n");
    folder_.write("l.csv", labels);
    const Arguments chosen{"stats",  "c.h5",      "--labels", "l.csv",
                           "--only", "side=left", "--modes",  "3"};
    (void)run(chosen + Arguments{"-o", "a.h5"});
    (void)run(chosen + Arguments{"-o", "b.h5", "--algorithm", "gram"});
    const ShapeModel a = read_model(folder_ / "a.h5");
    EXPECT_EQ(a.names.size(), 30U);
    expect_near(read_model(folder_ / "b.h5"), a, 1e-10);
    EXPECT_EQ(read_model(folder_ / "b.h5").labels[0].values, a.labels[0].values);
}

TEST_F(Scale, AStateThatCannotBeKeptDoesNotEndTheRun)
{
    const Arguments command{"stats",   "c.h5", "--algorithm",  "gram",
                            "--modes", "1",    "--save-every", "0"};
    (void)run(command + Arguments{"-o", "whole.h5"});
    // Room for the model of one mode, not for the inner products of all meshes.
    const Outcome limited =
        run_shape(folder_.path(), command + Arguments{"-o", "m.h5"}, {.largest_file = 25000});
    EXPECT_EQ(limited.exit_code, 0) << limited.err;
    EXPECT_NE(limited.err.find("m.h5.unfinished: cannot"), std::string::npos) << limited.err;
    EXPECT_EQ(folder_.read("m.h5"), folder_.read("whole.h5"));
    EXPECT_FALSE(folder_.has("m.h5.unfinished"));
}

TEST_F(Scale, ARunThatEndedEarlyIsResumedToTheSameBits)
{
    const Arguments command{"stats", "c.h5", "--algorithm", "gram"};
    (void)run(command + Arguments{"-o", "whole.h5"});
    const Arguments kept = command + Arguments{"-o", "m.h5", "--save-every", "1e-9"};
    // There is room for the state after the passes, not for the model of all modes.
    const Outcome stopped = run_shape(folder_.path(), kept, {.largest_file = 60000});
    EXPECT_EQ(stopped.exit_code, 5) << stopped.err;
    EXPECT_FALSE(folder_.has("m.h5"));
    ASSERT_TRUE(folder_.has("m.h5.unfinished"));
    const Outcome refused = outcome(kept);
    EXPECT_EQ(refused.exit_code, 5);
    EXPECT_NE(refused.err.find("--resume goes on"), std::string::npos) << refused.err;
    const Outcome other = outcome(kept + Arguments{"--resume", "--seed", "7"});
    EXPECT_EQ(other.exit_code, 3);
    EXPECT_NE(other.err.find("was another: seed had"), std::string::npos) << other.err;
    const std::string state = folder_.read("m.h5.unfinished");
    std::string damaged = state;
    damaged[damaged.size() / 2] ^= 1;
    folder_.write("m.h5.unfinished", damaged);
    EXPECT_EQ(outcome(kept + Arguments{"--resume"}).exit_code, 3);
    folder_.write("m.h5.unfinished", state.substr(0, state.size() / 2));
    EXPECT_EQ(outcome(kept + Arguments{"--resume"}).exit_code, 3);
    folder_.write("m.h5.unfinished", state);
    // Another memory would change no bit of gram, nor does it who chose gram.
    Arguments automatic{"stats", "c.h5", "--memory", "300M", "--save-every", "1e-9", "--resume"};
    EXPECT_EQ(outcome(automatic + Arguments{"-o", "m.h5"}).exit_code, 0);
    EXPECT_EQ(folder_.read("m.h5"), folder_.read("whole.h5"));
    std::filesystem::remove(folder_ / "m.h5");
    folder_.write("m.h5.unfinished", state);
    const Json resumed = run(kept + Arguments{"--resume"});
    EXPECT_EQ(resumed["passes"], 2); // those of the run before count
    EXPECT_EQ(folder_.read("m.h5"), folder_.read("whole.h5"));
    EXPECT_FALSE(folder_.has("m.h5.unfinished"));
}

TEST_F(Scale, ARunThatIsInterruptedSaysWhereItGoesOn)
{
    const Arguments command{"stats",       "c.h5",  "--algorithm",  "krylov", "--modes", "20",
                            "--tolerance", "1e-13", "--save-every", "1e-9",   "--force"};
    (void)run(command + Arguments{"-o", "whole.h5"});
    Outcome stopped;
    for (int attempt = 0; attempt < 50 && stopped.exit_code != 130; ++attempt) // it may be quicker
        stopped = run_shape(folder_.path(), command + Arguments{"-o", "m.h5"},
                            {.interrupt_at_file = "m.h5.unfinished"});
    ASSERT_EQ(stopped.exit_code, 130);
    EXPECT_NE(stopped.err.find("m.h5.unfinished has the passes before"), std::string::npos)
        << stopped.err;
    const Outcome other =
        outcome(command + Arguments{"-o", "m.h5", "--resume", "--memory", "300M"});
    EXPECT_EQ(other.exit_code, 3); // by the memory krylov restarts
    EXPECT_NE(other.err.find("was another: memory had"), std::string::npos) << other.err;
    (void)run(command + Arguments{"-o", "m.h5", "--resume"});
    EXPECT_EQ(folder_.read("m.h5"), folder_.read("whole.h5"));
}

TEST_F(Scale, MemoryIsABoundThatIsRefusedWhereNothingFits)
{
    const Outcome little = outcome({"stats", "c.h5", "-o", "m.h5", "--memory", "1M"});
    EXPECT_EQ(little.exit_code, 2);
    EXPECT_NE(little.err.find("at least 16M"), std::string::npos) << little.err;
    for (const char* wrong :
         {"much", "", "M", "iB", "500iB", "5 0M", "500MM", "500Mi", "1,5G", "25%"}) {
        const Outcome refused = outcome({"stats", "c.h5", "-o", "m.h5", "--memory", wrong});
        EXPECT_EQ(refused.exit_code, 2) << wrong;
        EXPECT_NE(refused.err.find("is no size such as 500M"), std::string::npos) << refused.err;
    }
    const Outcome mixed =
        outcome({"stats", "c.h5", "-o", "m.h5", "--memory", "1G", "--space", "procrustes"});
    EXPECT_EQ(mixed.exit_code, 2);
    EXPECT_NE(mixed.err.find("are for one collection file"), std::string::npos) << mixed.err;
    EXPECT_EQ(run({"stats", "c.h5", "-o", "m.h5", "--memory", "64M", "--modes", "3"})["passes"], 2);
}

TEST_F(Scale, AppendedMeshesGiveTheFileOfAllOfThem)
{
    write_early_and_late("a.h5");
    EXPECT_EQ(run({"collect", "late.h5", "--append", "-o", "a.h5"})["meshes"], 60);
    EXPECT_EQ(folder_.read("a.h5"), folder_.read("c.h5"));
    const std::string before = folder_.read("a.h5");
    const Outcome twice = outcome({"collect", "late.h5", "--append", "-o", "a.h5"});
    EXPECT_EQ(twice.exit_code, 3);
    EXPECT_NE(twice.err.find("occurs twice"), std::string::npos) << twice.err;
    EXPECT_EQ(outcome({"collect", "a.h5", "--append", "-o", "a.h5"}).exit_code, 2);
    write_bumpy_spheres(folder_);
    folder_.write("bad.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    const Outcome other = outcome({"collect", "bad.off", "--append", "-o", "a.h5"});
    EXPECT_EQ(other.exit_code, 3);
    EXPECT_NE(other.err.find("different counts"), std::string::npos) << other.err;
    EXPECT_EQ(folder_.read("a.h5"), before);
    EXPECT_NE(outcome({"collect", "late.h5", "--append", "-o", "none.h5"}).exit_code, 0);
}

TEST_F(Scale, LabelsThatSomeMeshesLackAreTold)
{
    write_labels();
    write_early_and_late("early.h5");
    (void)run({"collect", "early.h5", "--labels", "l.csv", "-o", "labelled.h5"});
    const auto copy = [&] { folder_.write("a.h5", folder_.read("labelled.h5")); };
    const std::string twenty =
        "20 of 60 meshes (sphere40, sphere41, sphere42, sphere43, sphere44, sphere45, sphere46 "
        "and 13 more)";
    const std::string lacking = "labels 'side', 'age' and 'subject' are left empty for " + twenty +
                                ", as they came without; give them with --labels";
    const auto says = [&](const Arguments& arguments, const std::string& text) {
        const Outcome told = outcome(arguments);
        EXPECT_EQ(told.exit_code, 0) << told.err;
        EXPECT_NE(told.err.find(text), std::string::npos) << told.err;
    };
    const auto says_not = [&](const Arguments& arguments, const std::string& text) {
        const Outcome told = outcome(arguments);
        EXPECT_EQ(told.exit_code, 0) << told.err;
        EXPECT_EQ(told.err.find(text), std::string::npos) << told.err;
    };
    copy();
    says({"collect", "late.h5", "--append", "-o", "a.h5"},
         lacking + ", or label all anew: `shape collect a.h5 --labels FILE -o OTHER.h5`");
    says({"collect", "labelled.h5", "late.h5", "-o", "b.h5"}, lacking);
    says({"stats", "labelled.h5", "late.h5", "-o", "b_model.h5"}, lacking);
    (void)run({"stats", "labelled.h5", "-o", "early_model.h5"});
    says({"stats", "late.h5", "--update", "early_model.h5", "-o", "u.h5"}, lacking);
    says({"stats", "c.h5", "--update", "early_model.h5", "-o", "v.h5"}, lacking);
    // What the new ones alone have, and a name in other letters.
    std::string other = "mesh,Side,age,subject\n";
    for (int i = 40; i < 60; ++i)
        other += "sphere" + std::to_string(i) + ",left,3,s\n";
    folder_.write("other.csv", other);
    copy();
    says({"collect", "late.h5", "--append", "-o", "a.h5", "--labels", "other.csv"},
         "label 'side' is left empty for " + twenty +
             ", label 'Side' is left empty for 40 of 60 meshes (sphere00, sphere01,");
    // With the same labels, with none, and where those that lack them are left out, nothing is said.
    copy();
    for (const Arguments& silent :
         {Arguments{"collect", "late.h5", "--append", "-o", "a.h5", "--labels", "l.csv"},
          Arguments{"collect", "early.h5", "late.h5", "-o", "plain.h5"},
          Arguments{"collect", "labelled.h5", "late.h5", "--only", "side", "-o", "some.h5"},
          Arguments{"stats", "labelled.h5", "late.h5", "--labels", "l.csv", "-o", "w.h5"}})
        says_not(silent, "left empty");
}

TEST_F(Scale, EqualMeshesAreAtDistanceZeroAndOneMeshAtNone)
{
    Collection same = subset(bumpy_spheres(3, 3), {0, 1, 2});
    same.points[1] = same.points[2] = same.points[0];
    write_collection(folder_ / "same.h5", same);
    (void)run({"distance", "same.h5", "-o", "d.csv", "--memory", "64M"});
    EXPECT_EQ(read_table(folder_ / "d.csv").rows[2][1], "0");
    write_collection(folder_ / "one.h5", subset(same, {0}));
    const Outcome one = outcome({"distance", "one.h5", "--mds", "m.csv", "--memory", "64M"});
    EXPECT_EQ(one.exit_code, 3);
    EXPECT_NE(one.err.find("at least 2 meshes"), std::string::npos) << one.err;
}

TEST_F(Scale, AppendingKeepsHowTheFileIsStored)
{
    write_early_and_late("early.h5");
    const Arguments both{"--store-derived", "--compress"};
    for (const Arguments& stored :
         {Arguments{}, Arguments{"--store-derived"}, Arguments{"--compress"}, both}) {
        (void)run(Arguments{"collect", "c.h5", "-o", "all.h5", "--force"} + stored);
        (void)run(Arguments{"collect", "early.h5", "-o", "a.h5", "--force"} + stored);
        (void)run({"collect", "late.h5", "--append", "-o", "a.h5"});
        EXPECT_EQ(folder_.read("a.h5"), folder_.read("all.h5"));
    }
    write_early_and_late("a.h5");
    (void)run(Arguments{"collect", "late.h5", "--append", "-o", "a.h5"} + both);
    EXPECT_EQ(folder_.read("a.h5"), folder_.read("all.h5"));
    // A disk that is full names the file that people know, and changes nothing.
    write_early_and_late("a.h5");
    const auto before = folder_.content();
    const Outcome full = run_shape(folder_.path(), {"collect", "late.h5", "--append", "-o", "a.h5"},
                                   {.largest_file = 20000});
    EXPECT_EQ(full.exit_code, 5);
    EXPECT_NE(full.err.find("cannot write a.h5"), std::string::npos) << full.err;
    EXPECT_EQ(folder_.content(), before);
}

TEST_F(Scale, AnUpdatedModelIsThatOfAFreshRun)
{
    const Collection all = bumpy_spheres(60, 3);
    std::vector<std::size_t> early(50);
    for (std::size_t i = 0; i < 50; ++i)
        early[i] = i;
    write_collection(folder_ / "early.h5", subset(all, early));
    (void)run({"stats", "early.h5", "-o", "early_model.h5"});
    for (const Arguments& kept : {Arguments{}, Arguments{"--modes", "7"}}) {
        (void)run(Arguments{"stats", "c.h5", "-o", "fresh.h5", "--force"} + kept);
        (void)run(Arguments{"stats", "c.h5", "--update", "early_model.h5", "-o", "updated.h5",
                            "--force"} +
                  kept);
        expect_near(read_model(folder_ / "updated.h5"), read_model(folder_ / "fresh.h5"),
                    kept.empty() ? 1e-8 : 1e-10);
    }
    // Files are read, a collection's rows that the model has are not: it says so either way.
    const Outcome of_file = outcome({"stats", "c.h5", "--update", "early_model.h5", "-o", "v.h5"});
    EXPECT_NE(of_file.err.find("; 50 that it has by their names were not read"), std::string::npos)
        << of_file.err;
    Collection corrected = subset(all, {0, 3, 52, 53});
    corrected.points[0] = moved(corrected.points[0], 2).cast<float>().cast<double>(); // saved again
    corrected.points[1].row(5).swap(corrected.points[1].row(6));
    std::filesystem::create_directory(folder_ / "files");
    for (std::size_t i = 0; i < corrected.size(); ++i)
        write_mesh(folder_ / "files" / (corrected.names[i] + ".ply"), corrected.points[i],
                   corrected.topology.faces(), MeshFormat::Ply);
    const Outcome changed = outcome({"stats", "files", "--update", "early_model.h5", "-o", "w.h5"});
    EXPECT_NE(changed.err.find(
                  internal::join("1 mesh of the input is another than in early_model.h5, which "
                                 "keeps those that it has: ",
                                 corrected.names[1])),
              std::string::npos)
        << changed.err;
    write_collection(folder_ / "other.h5", bumpy_spheres(60, 4)); // the same names
    const Outcome other =
        outcome({"stats", "other.h5", "--update", "early_model.h5", "-o", "u.h5"});
    EXPECT_EQ(other.exit_code, 3);
    EXPECT_NE(other.err.find("is another than that of the input"), std::string::npos) << other.err;
    (void)run({"stats", "early.h5", "-o", "few.h5", "--modes", "4"});
    const Outcome few = outcome({"stats", "c.h5", "--update", "few.h5", "-o", "u.h5"});
    EXPECT_EQ(few.exit_code, 3);
    EXPECT_NE(few.err.find("4 modes of 49"), std::string::npos) << few.err;
    const Outcome none = outcome({"stats", "early.h5", "--update", "early_model.h5", "-o", "u.h5"});
    EXPECT_EQ(none.exit_code, 3);
    EXPECT_NE(none.err.find("no mesh to add"), std::string::npos) << none.err;
}

TEST_F(Scale, AnUpdatedModelHasTheLabelsOfTheInput)
{
    write_labels();
    write_early_and_late("early.h5");
    (void)run({"stats", "early.h5", "-o", "plain.h5"});
    (void)run({"collect", "c.h5", "--labels", "l.csv", "-o", "labelled.h5"});
    (void)run({"stats", "labelled.h5", "-o", "fresh.h5"});
    const Outcome updated =
        outcome({"stats", "labelled.h5", "--update", "plain.h5", "-o", "updated.h5"});
    EXPECT_EQ(updated.exit_code, 0) << updated.err;
    EXPECT_EQ(updated.err.find("warning"), std::string::npos) << updated.err;
    const Labels labels = read_model(folder_ / "updated.h5").labels;
    const Labels expected = read_model(folder_ / "fresh.h5").labels;
    ASSERT_EQ(labels.size(), expected.size());
    for (std::size_t i = 0; i < labels.size(); ++i) {
        EXPECT_EQ(labels[i].name, expected[i].name);
        EXPECT_EQ(labels[i].values, expected[i].values);
    }
    std::string other = "mesh,side\n";
    for (const std::string& name : bumpy_spheres(60, 3).names)
        other += name + ",left\n";
    folder_.write("other.csv", other);
    (void)run({"stats", "early.h5", "--labels", "l.csv", "-o", "early_model.h5"});
    const Outcome changed = outcome({"stats", "c.h5", "--labels", "other.csv", "--update",
                                     "early_model.h5", "-o", "changed.h5"});
    EXPECT_NE(changed.err.find("early_model.h5: 24 labels are others than in the input"),
              std::string::npos) // three of five are right
        << changed.err;
    EXPECT_EQ(find_label(read_model(folder_ / "changed.h5").labels, "side").values,
              std::vector<std::string>(60, "left"));
}

TEST_F(Scale, AnUpdateThatDoesNotFitIntoTheMemoryIsRefused)
{
    const TestMesh sphere = icosphere(4);
    const Points points = Points::Random(sphere.points.rows(), 3);
    Collection collection{sphere.topology, {}, {}, {}};
    for (int i = 0; i < 60; ++i) {
        collection.names.push_back("m" + std::to_string(i));
        collection.points.emplace_back(sphere.points + 1e-3 * (i % 5) * points +
                                       1e-3 * (i % 7) * points.colwise().reverse());
    }
    write_collection(folder_ / "all.h5", collection);
    write_collection(folder_ / "two.h5", subset(collection, {0, 1}));
    (void)run({"stats", "two.h5", "-o", "two_model.h5"});
    const Arguments update{"stats", "all.h5", "--update", "two_model.h5", "-o", "u.h5", "--memory"};
    const Outcome refused = outcome(update + Arguments{"16M"});
    EXPECT_EQ(refused.exit_code, 6);
    EXPECT_NE(refused.err.find("--update: the 2 meshes of two_model.h5 and 58 meshes more need"),
              std::string::npos)
        << refused.err;
    EXPECT_FALSE(folder_.has("u.h5"));
    // Sizes as people write them.
    for (const char* size :
         {"16M", "16m", "16 M", "16MiB", "16 mib", "16384K", "16384KiB", "0.015625G", "0.015625GiB",
          "0.000016T", "17MB", "17 mb", "0.017GB", "16777216", "16777216B", "1.7e7"}) {
        const Outcome allowed = outcome(update + Arguments{size});
        EXPECT_NE(allowed.err.find("the memory allowed is 16 MiB"), std::string::npos)
            << size << ": " << allowed.err;
    }
    EXPECT_EQ(outcome(update + Arguments{"1G"}).exit_code, 0);
}

TEST_F(Scale, DerivedValuesAndCompressionAreWrittenOnDemand)
{
    (void)run({"collect", "c.h5", "-o", "derived.h5", "--store-derived"});
    (void)run({"collect", "c.h5", "-o", "packed.h5", "--compress"});
    EXPECT_GT(folder_.read("derived.h5").size(), 2 * folder_.read("c.h5").size());
    EXPECT_LT(folder_.read("packed.h5").size(), folder_.read("c.h5").size());
    for (const char* file : {"derived.h5", "packed.h5"}) {
        (void)run({"collect", file, "-o", "back.h5", "--force"});
        EXPECT_EQ(folder_.read("back.h5"), folder_.read("c.h5"));
    }
}

TEST_F(Scale, ADiskThatIsFullEndsTheRunInALineAndLeavesNothing)
{
    const Outcome full =
        run_shape(folder_.path(), {"collect", "c.h5", "-o", "d.h5"}, {.largest_file = 20000});
    EXPECT_EQ(full.exit_code, 5);
    EXPECT_NE(full.err.find("cannot write d.h5"), std::string::npos) << full.err;
    EXPECT_EQ(line_count(full.err), 1);
    EXPECT_FALSE(folder_.has("d.h5"));
    EXPECT_EQ(folder_.names(), std::vector<std::string>{"c.h5"});
}

TEST_F(Scale, ADamagedBlockEndsEveryWayOfReadingInALine)
{
    std::string bytes = folder_.read("c.h5");
    bytes[bytes.size() / 2] ^= 1;
    folder_.write("d.h5", bytes);
    write_labels();
    const Arguments stats{"stats", "d.h5", "-o", "m.h5", "--modes", "3"};
    const Arguments labels{"--labels", "l.csv", "-o", "m.csv"};
    for (const Arguments& way :
         {stats, stats + Arguments{"--algorithm", "gram"},
          stats + Arguments{"--algorithm", "krylov"},
          Arguments{"classify", "d.h5", "--by", "side", "--memory", "100M"} + labels,
          Arguments{"regress", "d.h5", "--on", "age", "--memory", "100M"} + labels,
          Arguments{"quality", "d.h5", "--memory", "100M", "-o", "m.csv"}}) {
        const Outcome damaged = outcome(way);
        EXPECT_EQ(damaged.exit_code, 3) << way.front();
        EXPECT_NE(damaged.err.find("d.h5: /points: the stored values of rows"), std::string::npos)
            << damaged.err;
        EXPECT_EQ(line_count(damaged.err), 1) << damaged.err;
        EXPECT_FALSE(folder_.has("m.h5") || folder_.has("m.csv"));
    }
}

TEST_F(Scale, AMeshWhosePowersOverflowIsNamedByEveryWayOfReading)
{
    Collection some = subset(bumpy_spheres(60, 3), {0, 1, 2, 3});
    some.points[2] *= 1e200;
    write_collection(folder_ / "huge.h5", some);
    for (const Arguments& way :
         {Arguments{}, Arguments{"--algorithm", "gram"}, Arguments{"--algorithm", "krylov"}}) {
        const Outcome refused =
            outcome(Arguments{"stats", "huge.h5", "-o", "m.h5", "--modes", "2"} + way);
        EXPECT_EQ(refused.exit_code, 3);
        EXPECT_NE(refused.err.find("huge.h5: mesh " + some.names[2] + ": the longest edge, "),
                  std::string::npos)
            << refused.err;
        EXPECT_EQ(line_count(refused.err), 1) << refused.err;
    }
    const Json checked = Json::parse(run_shape(folder_.path(), {"check", "huge.h5", "--json"}).out);
    EXPECT_NE(checked.dump().find("size_out_of_range"), std::string::npos);
}

/// The figures that two ways give alike, to rounding.
void expect_near(const Json& a, const Json& b, const std::vector<std::string>& fields)
{
    for (const std::string& field : fields)
        EXPECT_NEAR(a[field].get<double>(), b[field].get<double>(),
                    1e-9 * std::abs(b[field].get<double>()))
            << field;
}

TEST_F(Scale, GroupsInPassesAreThoseOfTheRunInMemory)
{
    std::string labels = "mesh,side,age\n";
    int age = 0;
    for (const std::string& name : bumpy_spheres(60, 3).names) {
        ++age;
        labels += name + (age % 3 == 0 ? ",left," : ",right,") + std::to_string(age % 7) + "\n";
    }
    folder_.write("l.csv", labels);
    const Arguments groups{"groups",         "c.h5", "--labels",    "l.csv", "--by",         "side",
                           "--permutations", "5",    "--bootstrap", "39",    "--adjust-for", "age",
                           "--adjust-for",   "size"};
    const Json memory = run(groups + Arguments{"-o", "a.csv", "--means", "a"});
    const Json passes = run(groups + Arguments{"-o", "b.csv", "--means", "b", "--memory", "100M"});
    EXPECT_GT(passes["passes"], 1);
    for (const char* test : {"overall", "spread"})
        expect_near(passes[test], memory[test],
                    {"sum_of_squares", "residual_sum_of_squares", "f", "r_squared", "p_value"});
    expect_near(passes["pairs"][0], memory["pairs"][0], {"distance", "radius", "p_adjusted"});
    for (const char* mesh : {"left.ply", "right.ply"}) {
        const Points a = points(std::string("a/") + mesh);
        EXPECT_LE((a - points(std::string("b/") + mesh)).cwiseAbs().maxCoeff(),
                  1e-7 * a.cwiseAbs().maxCoeff());
    }
    const Outcome mixed =
        outcome(groups + Arguments{"-o", "c.csv", "--memory", "100M", "--space", "procrustes"});
    EXPECT_EQ(mixed.exit_code, 2);
    EXPECT_NE(mixed.err.find("one collection file"), std::string::npos) << mixed.err;
}

TEST_F(Scale, ClassificationInPassesIsThatOfTheRunInMemory)
{
    write_labels();
    const Arguments classify{"classify", "c.h5",        "--labels", "l.csv",   "--by",
                             "side",     "--leave-out", "subject",  "--modes", "6"};
    const Json memory = run(classify + Arguments{"-o", "a.csv", "--predictions", "ap.csv"});
    const Json passes = run(classify + Arguments{"-o", "b.csv", "--predictions", "bp.csv", "--plot",
                                                 "b.svg", "--memory", "100M"});
    EXPECT_FALSE(memory.contains("passes"));
    EXPECT_GE(passes["passes"], 1);
    for (const char* figure : {"accuracy", "chance", "confusion", "folds", "modes"})
        EXPECT_EQ(passes[figure], memory[figure]) << figure;
    EXPECT_EQ(folder_.read("a.csv"), folder_.read("b.csv"));
    EXPECT_EQ(folder_.read("ap.csv"), folder_.read("bp.csv"));
    EXPECT_TRUE(folder_.has("b.svg"));
}

TEST_F(Scale, RegressionInPassesIsThatOfTheRunInMemory)
{
    write_labels();
    const Arguments files{"c.h5", "--labels", "l.csv", "--permutations", "5"};
    for (const Arguments& design : {Arguments{"--on", "age", "--within", "subject"},
                                    Arguments{"--on", "age", "--on", "size"}}) {
        const Arguments regress = Arguments{"regress"} + files + design;
        const Json memory = run(regress + Arguments{"-o", "a.csv", "--force"});
        const Json passes = run(regress + Arguments{"-o", "b.csv", "--memory", "100M", "--force"});
        EXPECT_GE(passes["passes"], 1);
        for (std::size_t k = 0; k < memory["covariates"].size(); ++k)
            expect_near(passes["covariates"][k], memory["covariates"][k],
                        {"mean", "slope_norm", "f", "r_squared", "p_value"});
        expect_near(passes["together"], memory["together"], {"sum_of_squares", "f", "r_squared"});
    }
    const Arguments one = Arguments{"regress"} + files + Arguments{"--on", "age", "--at", "2,5"};
    (void)run(one + Arguments{"-o", "a.csv", "--expected", "a", "--force"});
    (void)run(one + Arguments{"-o", "b.csv", "--expected", "b", "--force", "--memory", "100M"});
    for (const char* mesh : {"age_2.ply", "age_5.ply"}) {
        const Points a = points(std::string("a/") + mesh);
        EXPECT_LE((a - points(std::string("b/") + mesh)).cwiseAbs().maxCoeff(),
                  1e-7 * a.cwiseAbs().maxCoeff());
    }
    const Outcome all = outcome(
        one + Arguments{"-o", "c.csv", "--expected", "e", "--memory", "100M", "--corrected", "c"});
    EXPECT_EQ(all.exit_code, 2);
    EXPECT_NE(all.err.find("--corrected makes every mesh"), std::string::npos) << all.err;
}

TEST_F(Scale, QualityInPassesIsThatOfTheRunInMemory)
{
    const Arguments quality{"quality", "c.h5",    "--modes", "1,3",       "--tests",
                            "10",      "--folds", "5",       "--samples", "3"};
    const Json memory = run(quality + Arguments{"-o", "a.csv"});
    const Json passes = run(quality + Arguments{"-o", "b.csv", "--memory", "100M"});
    for (const char* curve : {"compactness", "generalisation_vertex", "specificity_edge"})
        for (std::size_t k = 0; k < 2; ++k)
            EXPECT_NEAR(passes[curve][k].get<double>(), memory[curve][k].get<double>(),
                        1e-6 * memory[curve][k].get<double>())
                << curve;
    EXPECT_EQ(passes["infeasible"], memory["infeasible"]);
}

TEST_F(Scale, DistancesInPassesAreThoseOfTheRunInMemory)
{
    const Arguments files{"--mds", "mds.csv", "--cluster", "tree.csv"};
    const Json memory = run(Arguments{"distance", "c.h5", "-o", "a.csv"} + files);
    const std::string tree = folder_.read("tree.csv").substr(0, 40);
    const Json passes =
        run(Arguments{"distance", "c.h5", "-o", "b.csv", "--memory", "100M", "--force"} + files);
    EXPECT_EQ(passes["outputs"].size(), 3U);
    expect_near(passes, memory, {"mean", "largest", "mds_share"});
    EXPECT_EQ(folder_.read("tree.csv").substr(0, 40).substr(0, 12), tree.substr(0, 12));
    // Without the matrix there is nothing of N by N.
    const Json plane = run({"distance", "c.h5", "--memory", "100M", "--mds", "mds.csv", "--force"});
    EXPECT_EQ(plane["outputs"].size(), 1U);
    EXPECT_FALSE(plane.contains("largest"));
    EXPECT_NEAR(plane["mds_share"].get<double>(), memory["mds_share"].get<double>(), 1e-9);
    EXPECT_EQ(outcome({"distance", "c.h5"}).exit_code, 2);
}

TEST_F(Scale, ShardsAreMergedToTheFilesOfOneRun)
{
    (void)run({"stats", "c.h5", "-o", "m.h5", "--modes", "3"});
    const Arguments generate{"generate", "m.h5", "--sample", "5", "--feasible"};
    (void)run(generate + Arguments{"-o", "whole"});
    const auto shard = [&](const std::string& part) {
        return generate + Arguments{"-o", "parts/", "--shard", part};
    };
    (void)run(shard("1/3"));
    (void)run(shard("3/3"));
    const Outcome early = outcome({"merge", "parts"});
    EXPECT_EQ(early.exit_code, 3);
    EXPECT_NE(early.err.find("of 3 shards these are missing: 2"), std::string::npos) << early.err;
    (void)run(shard("2/3") + Arguments{"--seed", "7"});
    const Outcome other = outcome({"merge", "parts"});
    EXPECT_EQ(other.exit_code, 3);
    EXPECT_NE(other.err.find("parts.shard-2-of-3: was made with other options"), std::string::npos)
        << other.err;
    for (const Arguments& option :
         {Arguments{"--float"}, Arguments{"--ascii"}, Arguments{"--residuals"},
          Arguments{"--residuals", "--colors"}}) {
        (void)run(shard("2/3") + option + Arguments{"--force"});
        EXPECT_EQ(outcome({"merge", "parts"}).exit_code, 3) << option.front();
    }
    std::filesystem::remove_all(folder_ / "parts.shard-2-of-3");
    (void)run(shard("2/3"));
    const std::string kept = folder_.read("parts.shard-2-of-3/sample_0001.ply");
    std::filesystem::remove(folder_ / "parts.shard-2-of-3/sample_0001.ply");
    const Outcome lacking = outcome({"merge", "parts/"});
    EXPECT_EQ(lacking.exit_code, 3);
    EXPECT_NE(lacking.err.find("the file sample_0001.ply is missing"), std::string::npos)
        << lacking.err;
    EXPECT_FALSE(folder_.has("parts"));
    folder_.write("parts.shard-2-of-3/sample_0001.ply", kept);
    EXPECT_EQ(run({"merge", "parts/"})["meshes"], 5);
    EXPECT_EQ(files_in(folder_ / "parts"), files_in(folder_ / "whole"));
    for (const std::string& file : files_in(folder_ / "whole"))
        EXPECT_EQ(folder_.read("parts/" + file), folder_.read("whole/" + file));
    EXPECT_FALSE(folder_.has("parts.shard-1-of-3"));
    EXPECT_EQ(outcome({"merge", "parts"}).exit_code, 5); // it is there already
    EXPECT_EQ(outcome({"merge", "none"}).exit_code, 3);
    for (const char* wrong : {"0/3", "4/3", "1", "1/3/5", "a/b", "1.5/2"})
        EXPECT_EQ(outcome(shard(wrong)).exit_code, 2) << wrong;
    EXPECT_EQ(outcome(shard("1/6")).exit_code, 3);
}

TEST_F(Scale, ShardsThatAreNotAsTheyWereWrittenAreNotMerged)
{
    (void)run({"stats", "c.h5", "-o", "m.h5", "--modes", "3"});
    const Arguments generate{"generate", "m.h5", "--sample", "5", "-o", "parts/", "--shard"};
    for (const char* part : {"1/2", "2/2"})
        (void)run(generate + Arguments{part});
    const auto refused = [&](const std::vector<std::string>& said) {
        const auto before = folder_.content();
        const Outcome merged = outcome({"merge", "parts"});
        EXPECT_EQ(merged.exit_code, 3);
        for (const std::string& words : said)
            EXPECT_NE(merged.err.find(words), std::string::npos) << merged.err;
        EXPECT_EQ(line_count(merged.err), 1);
        EXPECT_EQ(folder_.content(), before);
    };
    const std::string mesh = "parts.shard-1-of-2/sample_0000.ply";
    ASSERT_TRUE(folder_.has(mesh));
    const std::string whole = folder_.read(mesh);
    std::string flipped = whole;
    flipped[flipped.size() / 2] ^= 1;
    for (const std::string& damaged : {std::string(), whole + "\n", flipped}) {
        folder_.write(mesh, damaged);
        refused({"parts.shard-1-of-2: the file sample_0000.ply is not as the shard wrote it",
                 "run the shard again with --force"});
    }
    folder_.write(mesh, whole);

    const std::string manifest = folder_.read("parts.shard-2-of-2/shard.json");
    auto earlier = nlohmann::ordered_json::parse(manifest); // settings are compared in order
    auto names = nlohmann::ordered_json::array();
    for (const auto& file : earlier["files"])
        names.push_back(file["name"]);
    earlier["files"] = names;
    earlier.erase("beside");
    folder_.write("parts.shard-2-of-2/shard.json", earlier.dump());
    refused({"parts.shard-2-of-2: was made by an earlier version", "again with --force"});
    // Of numbers beyond 32 bits the rest would do.
    for (const char* key : {"shard", "shards"}) {
        auto larger = nlohmann::ordered_json::parse(manifest);
        larger[key] = 4294967298;
        folder_.write("parts.shard-2-of-2/shard.json", larger.dump());
        refused({"parts.shard-2-of-2: shard.json is not one that this program has written"});
    }
    folder_.write("parts.shard-2-of-2/shard.json", manifest);

    folder_.write("parts.shard-1-of-2/notes.txt", "mine");
    folder_.write("parts.shard-2-of-2/more/fit.json", "{}");
    refused({"parts: not written by the shards", "parts.shard-1-of-2/notes.txt, ",
             "parts.shard-2-of-2/more/fit.json", "move it elsewhere"});
    std::filesystem::remove(folder_ / "parts.shard-1-of-2/notes.txt");
    std::filesystem::remove_all(folder_ / "parts.shard-2-of-2/more");
    folder_.write("parts.shard-2-of-2/.shape-1-0.tmp", "of a run that was killed");
    EXPECT_EQ(run({"merge", "parts"})["meshes"], 5);
    EXPECT_FALSE(folder_.has("parts.shard-1-of-2"));
    EXPECT_FALSE(folder_.has("parts.shard-2-of-2"));
}

TEST_F(Scale, MergeWritesIntoADirectoryThatExistsIfItIsForced)
{
    (void)run({"stats", "c.h5", "-o", "m.h5", "--modes", "3"});
    const Arguments generate{"generate", "m.h5", "--sample", "4"};
    (void)run(generate + Arguments{"-o", "whole"});
    for (const char* part : {"1/2", "2/2"})
        (void)run(generate + Arguments{"-o", "parts", "--shard", part});
    folder_.write("parts/sample_0001.ply", "old");
    folder_.write("parts/sample_0099.ply", "older");
    folder_.write("parts/notes.txt", "mine");
    const auto before = folder_.content();
    const Outcome refused = outcome({"merge", "parts"});
    EXPECT_EQ(refused.exit_code, 5);
    EXPECT_NE(refused.err.find("parts: exists already; --force writes into it"), std::string::npos)
        << refused.err;
    EXPECT_EQ(folder_.content(), before);
    const Outcome forced = outcome({"merge", "parts/", "--force"});
    EXPECT_EQ(forced.exit_code, 0) << forced.err;
    EXPECT_NE(forced.err.find("holds 1 other mesh, such as sample_0099.ply"), std::string::npos)
        << forced.err;
    for (const std::string& file : files_in(folder_ / "whole"))
        EXPECT_EQ(folder_.read("parts/" + file), folder_.read("whole/" + file)) << file;
    EXPECT_EQ(folder_.read("parts/notes.txt"), "mine");
    EXPECT_EQ(files_in(folder_ / "parts").size(), files_in(folder_ / "whole").size() + 2);
    EXPECT_FALSE(folder_.has("parts.shard-1-of-2"));

    for (const char* part : {"1/2", "2/2"})
        (void)run(generate + Arguments{"-o", "file", "--shard", part});
    folder_.write("file", "mine");
    EXPECT_EQ(outcome({"merge", "file", "--force"}).exit_code, 5);
    EXPECT_EQ(folder_.read("file"), "mine");
    std::filesystem::remove(folder_ / "file");
    std::filesystem::create_directories(folder_ / "file/sample_0002.ply");
    const Outcome blocked = outcome({"merge", "file", "--force"});
    EXPECT_EQ(blocked.exit_code, 5);
    EXPECT_NE(blocked.err.find("file/sample_0002.ply: exists and is not a regular file"),
              std::string::npos)
        << blocked.err;
    EXPECT_TRUE(folder_.has("file.shard-2-of-2/sample_0001.ply"));
}

TEST_F(Scale, BlendsAndFitsComeInShardsToo)
{
    write_bumpy_spheres(folder_);
    const Arguments blends{"interpolate", "a.ply",     "b.ply",     "--weights", "0.25,0.75",
                           "--weights",   "0.75,0.25", "--weights", "0.5,0.5"};
    (void)run(blends + Arguments{"-o", "whole"});
    for (const char* part : {"1/2", "2/2"})
        (void)run(blends + Arguments{"-o", "parts", "--shard", part});
    (void)run({"merge", "parts"});
    for (const std::string& file : files_in(folder_ / "whole"))
        EXPECT_EQ(folder_.read("parts/" + file), folder_.read("whole/" + file)) << file;
    const Outcome path =
        outcome({"interpolate", "a.ply", "b.ply", "-o", "p", "--frames", "4", "--shard", "1/2"});
    EXPECT_EQ(path.exit_code, 2);
    EXPECT_NE(path.err.find("not a path"), std::string::npos) << path.err;

    const Arguments fit{"fit", "a.ply", "a.ply", "b.ply", "--keep-failed"};
    (void)run(fit + Arguments{"-o", "fits"});
    for (const char* part : {"1/2", "2/2"})
        (void)run(fit + Arguments{"-o", "some", "--shard", part});
    const std::string report = folder_.read("some.shard-2-of-2/fit.json");
    folder_.write("some.shard-2-of-2/fit.json", report + " ");
    const Outcome altered = outcome({"merge", "some"});
    EXPECT_EQ(altered.exit_code, 3);
    EXPECT_NE(altered.err.find("the file fit.json is not as the shard wrote it"), std::string::npos)
        << altered.err;
    folder_.write("some.shard-2-of-2/fit.json", report);
    (void)run({"merge", "some"});
    EXPECT_FALSE(folder_.has("some.shard-1-of-2"));
    (void)run(fit + Arguments{"-o", "some", "--resume"}); // draws, and fits nothing again
    for (const char* file : {"a.ply", "b.ply"})
        EXPECT_EQ(folder_.read(std::string("some/") + file),
                  folder_.read(std::string("fits/") + file));
    EXPECT_TRUE(folder_.has("some/fit.svg"));
}

TEST_F(Scale, ProcessesOfAProgramWithoutThemAreRefused)
{
    const Outcome twice = run_shape(folder_.path(), {"stats", "c.h5", "-o", "m.h5"},
                                    {.environment = {"OMPI_COMM_WORLD_SIZE=2"}});
    if (twice.err.find("built without MPI") == std::string::npos)
        GTEST_SKIP() << "the program was built with MPI";
    EXPECT_EQ(twice.exit_code, 2);
    EXPECT_FALSE(folder_.has("m.h5"));
}

} // namespace
} // namespace shape::test
