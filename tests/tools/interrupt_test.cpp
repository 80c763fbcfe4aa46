// SPDX-License-Identifier: MIT

#include "tools/program/interrupt.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/program.h"

// Work that takes minutes if it is let: run_shape() ends it after one, with another code.

namespace shape::test {
namespace {

using Arguments = std::vector<std::string>;

class Interrupts : public testing::TestWithParam<Arguments>
{
};

TEST_P(Interrupts, EndTheWorkWhateverItIsAt)
{
    const Folder folder;
    ASSERT_EQ(run_shape(folder.path(), {"synth", "faces", "--count", "20", "--vertices", "300",
                                        "-o", "faces", "--quiet"})
                  .exit_code,
              0);
    Arguments arguments = GetParam();
    arguments.insert(arguments.end(), {"--json", "--quiet"});
    using namespace std::chrono_literals;
    const Outcome outcome = run_shape(folder.path(), arguments, {.interrupt_after = 500ms});
    EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
    const auto error = nlohmann::json::parse(outcome.out).at("error");
    EXPECT_EQ(error.at("kind"), "interrupted");
    EXPECT_EQ(error.at("message"), "interrupted; nothing half-done was kept");
    EXPECT_EQ(files_in(folder.path()), Arguments{"faces"});
}

INSTANTIATE_TEST_SUITE_P(
    Commands, Interrupts,
    testing::Values(Arguments{"groups", "faces", "--labels", "faces/labels.csv", "--by",
                              "expression", "--permutations", "10000000", "-o", "groups.csv"},
                    Arguments{"stats", "faces", "--bootstrap", "1000000", "-o", "model.h5"},
                    Arguments{"synth", "heads", "--count", "10000", "--vertices", "20000", "-o",
                              "heads"}),
    [](const auto& command) { return command.param.front(); });

} // namespace
} // namespace shape::test
