// SPDX-License-Identifier: MIT

#include "tools/program/interrupt.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "libshape/io/mesh_file.h"
#include "tests/support/meshes.h"
#include "tests/tools/program.h"

namespace shape::test {
namespace {

/// Six subjects scanned twice, of two kinds; a warning that rows repeat comes just before they are drawn.
class Interrupts : public testing::Test
{
protected:
    Interrupts()
    {
        std::string kinds = "mesh,kind\n";
        std::string subjects = "mesh,subject\n";
        std::filesystem::create_directory(folder_ / "scans");
        for (unsigned i = 0; i < 6; ++i) {
            const TestMesh mesh = bumpy_sphere(1, 0.2, i + 1);
            const std::string subject = "s" + std::to_string(i);
            for (const auto& [scan, size] : {std::pair{"_a", 1.0}, std::pair{"_b", 1.01}}) {
                write_mesh(folder_ / ("scans/" + subject + scan + ".ply"), size * mesh.points,
                           mesh.topology.faces(), MeshFormat::Ply);
                kinds += subject + scan + (i % 2 == 0 ? ",even\n" : ",odd\n");
                subjects += subject + scan + "," + subject + "\n";
            }
        }
        folder_.write("kinds.csv", kinds);
        folder_.write("subjects.csv", subjects);
    }

    /// @param arguments  Of work that goes on for long if it is let, and ends with another code.
    void expect_end(const Arguments& arguments, const Launch& launch) const
    {
        const Outcome outcome = run_shape(folder_.path(), arguments + Arguments{"--json"}, launch);
        ASSERT_EQ(outcome.exit_code, 130) << outcome.err;
        const auto error = nlohmann::json::parse(outcome.out).at("error");
        EXPECT_EQ(error.at("kind"), "interrupted");
        EXPECT_EQ(error.at("message"), "interrupted; nothing half-done was kept");
        EXPECT_EQ(files_in(folder_.path()), (Arguments{"kinds.csv", "scans", "subjects.csv"}));
    }

    const Folder folder_{};
};

TEST_F(Interrupts, EndPermutations)
{
    expect_end({"groups", "scans", "--labels", "kinds.csv", "--by", "kind", "--permutations",
                "10000000", "-o", "groups.csv"},
               {.interrupt_at_message = true});
}

TEST_F(Interrupts, EndABootstrap)
{
    expect_end(
        {"stats", "scans", "--labels", "subjects.csv", "--bootstrap", "1000000", "-o", "model.h5"},
        {.interrupt_at_message = true});
}

TEST_F(Interrupts, EndWhatIsMadeUp)
{
    expect_end({"synth", "heads", "--count", "10000", "--vertices", "20000", "-o", "heads"},
               {.interrupt_when_caught = true});
}

TEST_F(Interrupts, EndScansThatAreMadeUpAndTakeTheirNewFoldersAway)
{
    expect_end({"synth", "scans", "--count", "2", "--vertices", "200000", "-o", "raw/first"},
               {.interrupt_at_change = true});
    const Folder there; // before the run
    const Outcome outcome =
        run_shape(there.path(), {"synth", "scans", "--count", "40", "-o", there.path().string()},
                  {.interrupt_at_change = true});
    EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
    ASSERT_TRUE(std::filesystem::exists(there.path()));
    EXPECT_EQ(files_in(there.path()), Arguments{});
}

} // namespace
} // namespace shape::test
