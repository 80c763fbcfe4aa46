// SPDX-License-Identifier: MIT

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "tests/support/data.h"
#include "tests/tools/program.h"

namespace shape::test {
using namespace internal;
namespace {

namespace fs = std::filesystem;

/// One line that begins as errors do, and names something.
void expect_refusal(const Outcome& outcome, int exit_code, const std::string& named)
{
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_EQ(line_count(outcome.err), 1) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("shape: error: ")) << outcome.err;
    EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome.err;
}

TEST(HostileInput, Hdf5FilesThatCrashTheirLibraryAreRefusedInOneLine)
{
    const fs::path directory = data_dir() / "hostile";
    if (!fs::exists(directory))
        GTEST_SKIP() << "no data";
    const Folder folder;
    int files = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(directory))
        if (entry.path().extension() == ".h5") {
            ++files;
            const std::string file = entry.path().string();
            expect_refusal(run_shape(folder.path(), {"info", file}), 3, file);
            expect_refusal(run_shape(folder.path(), {"collect", file, "-o", "x.h5"}), 3, file);
        }
    EXPECT_GT(files, 0);
    EXPECT_TRUE(folder.names().empty());
}

TEST(HostileInput, Hdf5FilesWithListsOfWhatIsNotThereAreRefusedInOneLine)
{
    const Folder folder;
    for (const std::string name :
         {"model/attributes_not_listed", "difference/attributes_not_listed",
          "model/fewer_links_than_stated"}) {
        const std::string file = join(SHAPE_FUZZ_INPUTS, "/", name);
        ASSERT_TRUE(fs::exists(file)) << file;
        expect_refusal(run_shape(folder.path(), {"info", file}), 3, file);
    }
}

/// Three meshes, and what starts a run of three frames.
class HostileRun : public testing::Test
{
protected:
    HostileRun() { write_bumpy_spheres(folder_); }

    [[nodiscard]] Outcome blend(const Arguments& more, const Launch& launch = {}) const
    {
        return run_shape(folder_.path(),
                         Arguments{"interpolate", "a.ply", "b.ply", "-o", "new"} + more, launch);
    }

    Folder folder_;
};

TEST_F(HostileRun, RefusesListsThatAreNestedTooDeep)
{
    for (const int depth : {65, 500'000}) {
        const auto levels = to_size(depth);
        folder_.write("path.json",
                      "{\"at\": " + std::string(levels, '[') + std::string(levels, ']') + "}");
        expect_refusal(blend({"--path-file", "path.json"}), 3, "64");
    }
}

TEST_F(HostileRun, RefusesAManifestOfOtherTypes)
{
    const auto levels = std::string(500'000, '[');
    for (const std::string& manifest :
         {std::string(R"({"program": 7, "--seed": 1})"), std::string(R"({"program": [[1]]})"),
          std::string("[1]"), std::string("7"), "{\"program\": " + levels, std::string("\xff")}) {
        folder_.write("new.unfinished/manifest.json", manifest);
        expect_refusal(blend({"--frames", "3", "--resume", "--quiet"}), 3, "new.unfinished");
    }
}

TEST_F(HostileRun, MakesAnewWhatWasChangedInAFinishedMesh)
{
    ASSERT_EQ(blend({"--frames", "300"}, {.interrupt_at_file = "new.unfinished/3.mesh"}).exit_code,
              130);
    const std::string mesh = folder_.read("new.unfinished/1.mesh");
    const auto digit = mesh.find("\"edge_rms\":") + 11;
    ASSERT_NE(mesh.find("\"edge_rms\":"), std::string::npos);
    std::string changed = mesh;
    changed[digit] = changed[digit] == '1' ? '2' : '1';
    folder_.write("new.unfinished/1.mesh", changed);
    folder_.write("new.unfinished/2.mesh", "{\"hash\": 7, \"figures\": 7, \"reason\": []}\nx");
    const Outcome resumed = blend({"--frames", "300", "--resume", "--json"});
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    const Outcome afresh = run_shape(folder_.path(), {"interpolate", "a.ply", "b.ply", "-o",
                                                      "fresh", "--frames", "300", "--quiet"});
    ASSERT_EQ(afresh.exit_code, 0) << afresh.err;
    for (const std::string frame : {"frame_0001.ply", "frame_0002.ply"})
        EXPECT_EQ(folder_.read("new/" + frame), folder_.read("fresh/" + frame));
}

TEST_F(HostileRun, LeavesADirectoryToTheRunThatHasIt)
{
    fs::create_directory(folder_ / "new.unfinished");
    const int other = open((folder_ / "new.unfinished").c_str(), O_RDONLY | O_DIRECTORY);
    ASSERT_EQ(flock(other, LOCK_EX), 0);
    expect_refusal(blend({"--frames", "3", "--resume", "--quiet"}), 5, "another run");
    close(other); // as the end of a process does, however it ends
    EXPECT_EQ(blend({"--frames", "3", "--resume"}).exit_code, 0);
    EXPECT_FALSE(folder_.has("new.unfinished"));
}

TEST_F(HostileRun, RefusesPipesBeforeAnyWork)
{
    ASSERT_EQ(mkfifo((folder_ / "labels").c_str(), 0600), 0);
    const Outcome outcome = run_shape(
        folder_.path(), {"collect", "a.ply", "missing.ply", "--labels", "labels", "-o", "x.h5"});
    expect_refusal(outcome, 5, "labels: is not a regular file");
}

TEST_F(HostileRun, NamesFilesThatAreNotTextInText)
{
    fs::copy(folder_ / "a.ply", folder_ / "caf\xe9.ply");
    ASSERT_EQ(run_shape(folder_.path(), {"distance", "b.ply", "c.ply", "caf\xe9.ply", "-o", "d.csv",
                                         "--plot", "d.svg"})
                  .exit_code,
              0);
    EXPECT_NE(folder_.read("d.csv").find("caf%E9"), std::string::npos);
    EXPECT_NE(folder_.read("d.svg").find("caf%E9"), std::string::npos);
    EXPECT_EQ(folder_.read("d.svg").find('\xe9'), std::string::npos);
}

TEST_F(HostileRun, PlotsEqualMeshesWithoutNan)
{
    fs::copy(folder_ / "a.ply", folder_ / "equal.ply");
    ASSERT_EQ(run_shape(folder_.path(),
                        {"distance", "a.ply", "equal.ply", "-o", "d.csv", "--plot", "d.svg"})
                  .exit_code,
              0);
    EXPECT_EQ(folder_.read("d.svg").find("nan"), std::string::npos);
}

TEST_F(HostileRun, RefusesLengthsWhosePowersOverflow)
{
    const std::string tetrahedron =
        "v 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    folder_.write("t.obj", tetrahedron);
    for (const std::string length : {"1e300", "1e160", "1e61", "1e-160"}) {
        std::string table = "v0,v1,length\n";
        for (const char* edge : {"0,1", "0,2", "0,3", "1,2", "1,3", "2,3"})
            table += join(edge, ",", length, "\n");
        folder_.write("l.csv", table);
        for (const std::string method : {"dihedral", "closure", "multiscale"})
            expect_refusal(
                run_shape(folder_.path(), {"reconstruct", "--reference", "t.obj", "--lengths",
                                           "l.csv", "--method", method, "-o", "x.ply"}),
                3, "longest edge");
    }
}

#if !defined(__SANITIZE_ADDRESS__) // which maps terabytes
TEST_F(HostileRun, EndsWithAResultOrALineWhereMemoryIsShort)
{
    for (const std::size_t mebibytes : {100U, 150U, 220U, 300U, 400U, 600U})
        for (const std::string method : {"dihedral", "closure", "multiscale"}) {
            const Outcome outcome =
                blend({"--frames", "3", "--method", method, "--force", "--quiet"},
                      {.address_space = mebibytes << 20U});
            if (outcome.exit_code != 0)
                expect_refusal(outcome, 6, "");
        }
}

TEST_F(HostileRun, NeverBlamesAFileWhereMemoryIsShort)
{
    ASSERT_EQ(
        run_shape(folder_.path(), {"collect", "a.ply", "b.ply", "c.ply", "-o", "s.h5"}).exit_code,
        0);
    for (std::size_t mebibytes = 30; mebibytes <= 110; mebibytes += 2) {
        // Before main() libgfortran, which OpenBLAS brings in, calls itself without end where its first
        // allocation fails: then --version, which asks for nothing, crashes too.
        constexpr int crashed = 128 + SIGSEGV;
        if (run_shape(folder_.path(), {"--version"}, {.address_space = mebibytes << 20U})
                .exit_code == crashed)
            continue;
        for (const Arguments& arguments :
             {Arguments{"info", "s.h5", "--quiet"},
              Arguments{"stats", "s.h5", "-o", "x.h5", "--force", "--quiet"}}) {
            const Outcome outcome =
                run_shape(folder_.path(), arguments, {.address_space = mebibytes << 20U});
            SCOPED_TRACE(testing::PrintToString(arguments) + " " + std::to_string(mebibytes));
            // 127: the system cannot load the libraries, and says so.
            if (outcome.exit_code != 0 && outcome.exit_code != 127)
                expect_refusal(outcome, 6, "");
        }
    }
}
#endif

} // namespace
} // namespace shape::test
