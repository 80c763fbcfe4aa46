// SPDX-License-Identifier: MIT

#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "libshape/io/mesh_file.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/tools/program.h"

namespace shape::test {

using Json = nlohmann::json;

/// The JSON on the stdout of a run that must have succeeded.
[[nodiscard]] inline Json json_of(const Outcome& outcome)
{
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.exit_code == 0 ? Json::parse(outcome.out) : Json();
}

/// A folder of its own, in which the program runs.
class ProgramTest : public testing::Test
{
protected:
    /// Runs what must succeed and returns the JSON on stdout.
    [[nodiscard]] Json run(const Arguments& arguments) const
    {
        return json_of(run_shape(folder_.path(), arguments + Arguments{"--json"}));
    }
    [[nodiscard]] Points points(const std::string& file) const
    {
        return read_mesh(folder_ / file).points;
    }
    [[nodiscard]] Eigen::VectorXd lengths(const std::string& file) const
    {
        const NamedMesh mesh = read_mesh(folder_ / file);
        return edge_lengths(Topology(mesh.faces, static_cast<int>(mesh.points.rows())),
                            mesh.points);
    }

    const Folder folder_{};
};

/// A folder with three meshes, in which nothing is said on stderr.
class SilentProgramTest : public ProgramTest
{
protected:
    SilentProgramTest() { write_bumpy_spheres(folder_); }

    [[nodiscard]] Json run(const Arguments& arguments) const
    {
        const Outcome outcome = run_shape(folder_.path(), arguments + Arguments{"--json"});
        EXPECT_EQ(outcome.err, "");
        return json_of(outcome);
    }
};

/// Largest difference relative to the mean of b.
[[nodiscard]] inline double difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b)
{
    return (a - b).cwiseAbs().maxCoeff() / b.mean();
}

} // namespace shape::test
