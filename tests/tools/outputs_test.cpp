// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/tools/program.h"

namespace shape::test {
namespace {

using Arguments = std::vector<std::string>;

class Outputs : public testing::Test
{
protected:
    Outputs() { write_bumpy_spheres(folder_); }

    [[nodiscard]] Outcome run(const Arguments& arguments, const Launch& launch = {}) const
    {
        return run_shape(folder_.path(), arguments, launch);
    }

    const Folder folder_;
};

TEST_F(Outputs, ForceReplacesAFile)
{
    folder_.write("model.h5", "old");
    EXPECT_EQ(run({"stats", "a.ply", "b.ply", "-o", "model.h5"}).exit_code, 5);
    EXPECT_EQ(folder_.read("model.h5"), "old");
    EXPECT_EQ(run({"stats", "a.ply", "b.ply", "-o", "model.h5", "--force"}).exit_code, 0);
    EXPECT_NE(folder_.read("model.h5"), "old");
}

TEST_F(Outputs, WriteProtectedFilesAreNotReplacedEvenByForce)
{
    namespace fs = std::filesystem;
    ASSERT_EQ(run({"stats", "a.ply", "b.ply", "-o", "m.h5"}).exit_code, 0);
    ASSERT_EQ(run({"collect", "a.ply", "-o", "set.h5"}).exit_code, 0);
    for (const char* part : {"1/2", "2/2"})
        ASSERT_EQ(
            run({"generate", "m.h5", "--sample", "2", "-o", "parts", "--shard", part}).exit_code,
            0);
    for (const char* file :
         {"model.h5", "new/frame_0001.ply", "table/scores.csv", "parts/sample_0001.ply",
          "fitted/fit.csv", "fitted/fit.svg", "again/fit.csv"})
        folder_.write(file, "old");
    struct Case
    {
        std::string file;
        Arguments arguments;
    };
    const std::vector<Case> cases = {
        {"model.h5", {"stats", "a.ply", "b.ply", "-o", "model.h5"}},
        {"set.h5", {"collect", "b.ply", "--append", "-o", "set.h5"}},
        {"new/frame_0001.ply", {"interpolate", "a.ply", "b.ply", "--frames", "2", "-o", "new"}},
        {"table/scores.csv", {"export", "m.h5", "--to", "csv", "-o", "table"}},
        {"parts/sample_0001.ply", {"merge", "parts"}},
        {"fitted/fit.csv", {"fit", "a.ply", "b.ply", "-o", "fitted"}},
        {"fitted/fit.svg", {"fit", "a.ply", "b.ply", "-o", "fitted"}},
        {"again/fit.csv", {"fit", "a.ply", "b.ply", "-o", "again", "--resume"}},
    };
    for (const auto& [file, arguments] : cases) {
        // Its group may write: that of the owner counts.
        fs::permissions(folder_ / file, fs::perms::owner_read | fs::perms::group_write);
        const std::map<std::string, std::string> before = folder_.content();
        const Outcome outcome = run(arguments + Arguments{"--force"});
        EXPECT_EQ(outcome.exit_code, 5) << file;
        EXPECT_EQ(line_count(outcome.err), 1) << outcome.err;
        EXPECT_NE(outcome.err.find(file + ": exists and is write-protected"), std::string::npos)
            << outcome.err;
        EXPECT_TRUE(folder_.content() == before) << file;
        fs::permissions(folder_ / file, fs::perms::owner_all);
    }
    EXPECT_EQ(run(cases[0].arguments + Arguments{"--force"}).exit_code, 0);
    EXPECT_EQ(run(cases[4].arguments + Arguments{"--force"}).exit_code, 0);
}

TEST_F(Outputs, ATableOfFitsIsNotReplacedWithoutForce)
{
    folder_.write("fitted/fit.csv", "old");
    const Outcome outcome = run({"fit", "a.ply", "b.ply", "-o", "fitted"});
    EXPECT_EQ(outcome.exit_code, 5);
    EXPECT_NE(outcome.err.find("fitted/fit.csv: exists; --force"), std::string::npos)
        << outcome.err;
    EXPECT_EQ(folder_.read("fitted/fit.csv"), "old");
}

TEST_F(Outputs, MayHaveEndingsInCapitals)
{
    EXPECT_EQ(run({"stats", "a.ply", "b.ply", "c.ply", "-o", "M.H5"}).exit_code, 0);
    EXPECT_EQ(
        run({"project", "M.H5", "a.ply", "b.ply", "-o", "S.CSV", "--plot", "S.SVG"}).exit_code, 0);
    EXPECT_EQ(run({"export", "M.H5", "--to", "statismo", "-o", "X.H5"}).exit_code, 0);
    EXPECT_EQ(run({"draw", "a.ply", "-o", "D.SVG"}).exit_code, 0);
    EXPECT_TRUE(folder_.read("D.SVG").starts_with("<"));
    EXPECT_EQ(run({"draw", "a.ply", "-o", "D.PNG"}).exit_code, 0);
    EXPECT_TRUE(folder_.read("D.PNG").starts_with("\x89PNG"));
    for (const char* page : {"P.HTML", "P.htm"}) // with or without the page in this build
        EXPECT_NE(run({"explore", "M.H5", "-o", page}).exit_code, 2) << page;
}

TEST_F(Outputs, AFileThatAppearsWhileTheRunWorksIsReplacedWithForceAlone)
{
    folder_.write("bin/rsvg-convert", // stands for another run, which is quicker
                  "#!/bin/sh\ncat > /dev/null\nprintf theirs > p.png\nprintf '\\211PNG'\n");
    std::filesystem::permissions(folder_ / "bin/rsvg-convert", std::filesystem::perms::owner_all);
    const Launch launch{.environment = {"PATH=" + (folder_ / "bin").string() + ":/usr/bin:/bin"}};
    const Arguments distance{"distance", "a.ply", "b.ply",  "c.ply",
                             "-o",       "d.csv", "--plot", "p.png"};
    const Outcome outcome = run(distance, launch);
    EXPECT_EQ(outcome.exit_code, 5);
    EXPECT_NE(outcome.err.find("p.png: since this run began"), std::string::npos) << outcome.err;
    EXPECT_EQ(folder_.read("p.png"), "theirs");
    std::filesystem::remove(folder_ / "p.png");
    EXPECT_EQ(run(distance + Arguments{"--force"}, launch).exit_code, 0);
    EXPECT_EQ(folder_.read("p.png"), "\211PNG");
}

TEST_F(Outputs, OfTwoRunsThatWriteOneOutputOneEndsWell)
{
    ASSERT_EQ(run({"stats", "a.ply", "b.ply", "c.ply", "-o", "m.h5"}).exit_code, 0);
    for (const Arguments& command :
         {Arguments{"collect", "a.ply", "b.ply", "c.ply", "-o", "out.h5"},
          Arguments{"generate", "m.h5", "--sample", "3", "-o", "meshes"},
          Arguments{"export", "m.h5", "--to", "csv", "-o", "tables"}}) {
        Outcome other;
        std::thread second([&] { other = run(command); });
        const Outcome outcome = run(command);
        second.join();
        const std::string& lost = outcome.exit_code == 0 ? other.err : outcome.err;
        EXPECT_EQ(outcome.exit_code + other.exit_code, 5) << outcome.err << other.err;
        EXPECT_NE(lost.find("shape: error: "), std::string::npos) << lost;
        EXPECT_TRUE(folder_.has(command.back()));
        for (const auto& [name, content] : folder_.content())
            EXPECT_EQ(name.find(".unfinished"), std::string::npos) << name;
    }
}

TEST_F(Outputs, ForceReplacesOnlyItsOwnFilesOfADirectory)
{
    folder_.write("new/frame_0000.ply", "old");
    folder_.write("new/mine.txt", "mine");
    const Arguments blend{"interpolate", "a.ply", "b.ply", "--frames", "2", "-o", "new", "--force"};
    EXPECT_EQ(run(blend).exit_code, 0);
    EXPECT_NE(folder_.read("new/frame_0000.ply"), "old");
    EXPECT_EQ(folder_.read("new/mine.txt"), "mine");
    EXPECT_EQ(files_in(folder_ / "new"),
              (Arguments{"frame_0000.ply", "frame_0001.ply", "mine.txt"}));
}

TEST_F(Outputs, MeshesOfALongerRunThatStayAreSaid)
{
    const auto blend = [&](const char* frames) {
        return run({"interpolate", "a.ply", "b.ply", "--frames", frames, "-o", "new", "--force"});
    };
    EXPECT_EQ(blend("4").err.find("other mesh"), std::string::npos);
    EXPECT_EQ(blend("4").err.find("other mesh"), std::string::npos);
    const std::string said = blend("2").err;
    EXPECT_NE(said.find("new: holds 2 other meshes, such as frame_0002.ply"), std::string::npos)
        << said;
}

TEST_F(Outputs, ASingleMeshAmongOthersIsSaid)
{
    (void)run({"stats", "a.ply", "b.ply", "-o", "model.h5"});
    folder_.write("set/a.ply", folder_.read("a.ply"));
    const std::string said = run({"generate", "model.h5", "--mean", "-o", "set"}).err;
    EXPECT_NE(said.find("set: holds 1 other mesh, such as a.ply"), std::string::npos) << said;
    EXPECT_EQ(run({"generate", "model.h5", "--mean", "-o", "set/m2.ply"}).err.find("holds"),
              std::string::npos);
}

TEST_F(Outputs, ADirectoryThatExistsTakesNewFiles)
{
    folder_.write("new/mine.txt", "mine");
    EXPECT_EQ(run({"interpolate", "a.ply", "b.ply", "--frames", "2", "-o", "new/"}).exit_code, 0);
    EXPECT_EQ(files_in(folder_ / "new"),
              (Arguments{"frame_0000.ply", "frame_0001.ply", "mine.txt"}));
}

TEST_F(Outputs, ADirectoryMayHaveAnEndingIfItEndsInASlash)
{
    EXPECT_EQ(run({"interpolate", "a.ply", "b.ply", "--frames", "2", "-o", "v1.5/"}).exit_code, 0);
    EXPECT_EQ(files_in(folder_ / "v1.5"), (Arguments{"frame_0000.ply", "frame_0001.ply"}));
}

TEST_F(Outputs, APathWithAnotherEndingIsToldThatADirectoryMayEndInASlash)
{
    ASSERT_EQ(run({"stats", "a.ply", "b.ply", "-o", "m.h5"}).exit_code, 0);
    for (const Arguments& arguments :
         {Arguments{"generate", "m.h5", "--sample", "2", "-o", "set_25.4"},
          Arguments{"generate", "m.h5", "--sample", "2", "-o", "set.ply"},
          Arguments{"interpolate", "a.ply", "b.ply", "--frames", "2", "-o", "set_25.4"},
          Arguments{"synth", "torus", "-o", "set_25.4"},
          Arguments{"export", "m.h5", "--to", "csv", "-o", "set.h5"},
          Arguments{"fit", "a.ply", "b.ply", "-o", "set_25.4"}}) {
        const Outcome refused = run(arguments);
        EXPECT_EQ(refused.exit_code, 2) << refused.err;
        EXPECT_NE(refused.err.find("; a directory may end in a slash"), std::string::npos)
            << arguments.front() << ": " << refused.err;
    }
    EXPECT_EQ(
        run({"fit", "a.ply", "b.ply", "--no-search", "--keep-failed", "-o", "set_25.4/"}).exit_code,
        0);
}

TEST_F(Outputs, MessagesGoToStderrAndDataToStdout)
{
    const Outcome stats = run({"stats", "a.ply", "b.ply", "-o", "model.h5"});
    EXPECT_EQ(stats.out, "");
    EXPECT_NE(stats.err.find("model.h5"), std::string::npos);
    const Outcome quiet = run({"stats", "a.ply", "b.ply", "-o", "quiet.h5", "--quiet"});
    EXPECT_EQ(quiet.out + quiet.err, "");
    const Outcome info = run({"info", "model.h5"});
    EXPECT_NE(info.out.find("kind: model"), std::string::npos);
    EXPECT_EQ(info.err, "");
}

TEST_F(Outputs, QuietKeepsErrors)
{
    EXPECT_EQ(line_count(run({"info", "no.h5", "--quiet"}).err), 1);
}

TEST_F(Outputs, NoThreadCountChangesAByte)
{
    for (const std::string threads : {"1", "2"}) {
        const Arguments common{"--threads", threads, "--quiet"};
        const auto with = [&](Arguments arguments) {
            arguments.insert(arguments.end(), common.begin(), common.end());
            EXPECT_EQ(run(arguments).exit_code, 0) << arguments.front();
        };
        with({"synth", "arm", "--vertices", "3000", "-o", "arm" + threads});
        with({"stats", "arm" + threads, "-o", "model" + threads + ".h5"});
        with({"generate", "model" + threads + ".h5", "--sample", "2", "-o", "new" + threads});
    }
    EXPECT_EQ(folder_.read("model1.h5"), folder_.read("model2.h5"));
    EXPECT_EQ(folder_.read("new1/sample_0001.ply"), folder_.read("new2/sample_0001.ply"));
}

TEST_F(Outputs, AnInterruptLeavesNothingBehind)
{
    ASSERT_EQ(run({"stats", "a.ply", "b.ply", "-o", "model.h5"}).exit_code, 0);
    const std::map<std::string, std::string> before = folder_.content();
    const Outcome outcome = run({"generate", "model.h5", "--sample", "1000000", "-o", "new"},
                                {.interrupt_at_change = true});
    EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
    EXPECT_EQ(line_count(outcome.err), 1) << outcome.err;
    EXPECT_TRUE(folder_.content() == before);
}

TEST_F(Outputs, AReaderThatWentAwayIsNotAnError)
{
    const Outcome outcome = run({"synth", "--list"}, {.close_stdout = true});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_EQ(outcome.err, "");
}

TEST_F(Outputs, ALocaleWithDecimalCommasChangesNothing)
{
    const Arguments stats{"stats", "a.ply", "b.ply", "--json", "-o"};
    Arguments plain = stats;
    plain.emplace_back("plain.h5");
    Arguments comma = stats;
    comma.emplace_back("comma.h5");
    ASSERT_EQ(run(plain).exit_code, 0);
    ASSERT_EQ(run(comma, {.environment = {"LC_ALL=de_DE.UTF-8"}}).exit_code, 0);
    EXPECT_EQ(folder_.read("plain.h5"), folder_.read("comma.h5"));
}

} // namespace
} // namespace shape::test
