// SPDX-License-Identifier: MIT

#include "libshape/base/format.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/vertex_scalars.h"
#include "tests/tools/program_test.h"

namespace shape::test {
using namespace internal;
namespace {

/// A folder with four meshes, a.ply to d.ply, where every run must succeed.
class Interpolate : public SilentProgramTest
{
protected:
    Interpolate()
    {
        NamedMesh d = read_mesh(folder_ / "c.ply");
        d.points.col(0) *= 1.3;
        write_mesh(folder_ / "d.ply", d.points, d.faces, MeshFormat::Ply);
    }

    [[nodiscard]] Outcome outcome(const Arguments& more, const Launch& launch = {},
                                  const Arguments& meshes = {"a.ply", "b.ply"}) const
    {
        Arguments arguments{"interpolate"};
        arguments.insert(arguments.end(), meshes.begin(), meshes.end());
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run_shape(folder_.path(), arguments, launch);
    }

    /// Runs and returns the JSON on stdout; stderr stays empty.
    [[nodiscard]] Json run(Arguments more, const Arguments& meshes = {"a.ply", "b.ply"}) const
    {
        more.emplace_back("--json");
        const Outcome result = outcome(more, {}, meshes);
        EXPECT_EQ(result.err, "");
        return json_of(result);
    }

    /// Largest difference of lengths relative to the mean.
    [[nodiscard]] double difference(const std::string& file, const std::string& wanted) const
    {
        return (lengths(file) - lengths(wanted)).cwiseAbs().maxCoeff() / lengths(wanted).mean();
    }

    const Arguments four_{"a.ply", "b.ply", "c.ply", "d.ply"};
};

TEST_F(Interpolate, TheFirstFrameLiesWhereTheFirstMeshDoes)
{
    NamedMesh far = read_mesh(folder_ / "a.ply");
    far.points.rowwise() += Eigen::RowVector3d(10.0, -20.0, 30.0);
    write_mesh(folder_ / "a.ply", far.points, far.faces, MeshFormat::Ply);
    for (const std::string method : {"dihedral", "closure", "multiscale"}) {
        (void)run({"--frames", "2", "-o", method, "--method", method});
        EXPECT_LT((points(method + "/frame_0000.ply") - far.points).cwiseAbs().maxCoeff(), 1e-9);
    }
}

TEST_F(Interpolate, ALineThroughManyMeshesMeetsEachOfThem)
{
    const Json figures = run({"--frames", "7", "-o", "new"}, four_);
    EXPECT_LT(difference("new/frame_0002.ply", "b.ply"), 1e-6);
    EXPECT_LT(difference("new/frame_0004.ply", "c.ply"), 1e-6);
    EXPECT_LT(difference("new/frame_0006.ply", "d.ply"), 1e-6);
    EXPECT_NEAR(figures["weights"][1][0].get<double>(), 0.5, 1e-15);
}

TEST_F(Interpolate, APatchMeetsItsCornersInTheirOrder)
{
    const Json figures = run({"--path", "bilinear", "--grid", "3,2", "-o", "new"}, four_);
    EXPECT_EQ(figures["weights"].size(), 6U);
    EXPECT_EQ(figures["weights"][1], Json({0.5, 0.5, 0.0, 0.0}));
    EXPECT_LT(difference("new/frame_0000.ply", "a.ply"), 1e-6);
    EXPECT_LT(difference("new/frame_0002.ply", "b.ply"), 1e-6);
    EXPECT_LT(difference("new/frame_0003.ply", "c.ply"), 1e-6);
    EXPECT_LT(difference("new/frame_0005.ply", "d.ply"), 1e-6);
    EXPECT_EQ(run({"--path", "bilinear", "--at", "0.25,0.5", "-o", "x.ply"}, four_)["weights"],
              Json({{0.375, 0.125, 0.375, 0.125}}));
}

TEST_F(Interpolate, APointInAPolygonHasMeanValueCoordinates)
{
    const Json middle =
        run({"--path", "polygon", "--polygon", "0,0:2,0:2,2:0,2", "--at", "1,1", "-o", "x.ply"},
            four_)["weights"][0];
    for (const Json& weight : middle)
        EXPECT_NEAR(weight.get<double>(), 0.25, 1e-15);
    (void)run({"--path", "polygon", "--frames", "5", "-o", "round"}, four_);
    for (const std::string i : {"0", "1", "2", "3"})
        EXPECT_LT(difference("round/frame_000" + i + ".ply", four_[std::stoul(i)]), 1e-6);
    EXPECT_LT(difference("round/frame_0004.ply", "a.ply"), 1e-6);
}

TEST_F(Interpolate, SplinesMeetWhatTheySay)
{
    (void)run({"--path", "spline", "--frames", "7", "-o", "through"}, four_);
    EXPECT_LT(difference("through/frame_0002.ply", "b.ply"), 1e-6);
    EXPECT_LT(difference("through/frame_0004.ply", "c.ply"), 1e-6);
    const Json near = run({"--path", "spline", "--spline", "b-spline", "--frames", "3", "--range",
                           "0.5:1", "-o", "near"},
                          four_);
    EXPECT_EQ(near["weights"][0], Json({0.125, 0.375, 0.375, 0.125}));
    EXPECT_LT(difference("near/frame_0002.ply", "d.ply"), 1e-6);
}

TEST_F(Interpolate, APathFileSaysWhatTheOptionsSay)
{
    folder_.write("path.json", R"({
        "path": "polygon", "polygon": [[0, 0], [2, 0], [2, 2], [0, 2]],
        "track": [[0.5, 0.5], [1, 1.5]], "frames": 3})");
    const Json file = run({"--path-file", "path.json", "-o", "file"}, four_);
    const Json options = run({"--path", "polygon", "--polygon", "0,0:2,0:2,2:0,2", "--track",
                              "0.5,0.5:1,1.5", "--frames", "3", "-o", "options"},
                             four_);
    EXPECT_EQ(file["weights"], options["weights"]);
    EXPECT_EQ(folder_.read("file/frame_0001.ply"), folder_.read("options/frame_0001.ply"));
    folder_.write("more.json", R"({"path": "bilinear", "grid": [2, 2]})");
    EXPECT_EQ(run({"--path-file", "more.json", "-o", "grid"}, four_)["weights"].size(), 4U);
    folder_.write("weights.json", R"({"weights": [[0.5, 0.5], [0, 1]]})");
    EXPECT_EQ(run({"--path-file", "weights.json", "-o", "weights"})["weights"],
              Json({{0.5, 0.5}, {0.0, 1.0}}));
}

TEST_F(Interpolate, AnOptionAndAKeyThatSayTheSameAreRefused)
{
    folder_.write("path.json", R"({"frames": 3})");
    const Outcome twice = outcome({"--path-file", "path.json", "--frames", "3", "-o", "new"});
    EXPECT_EQ(twice.exit_code, 2);
    EXPECT_NE(twice.err.find("--frames"), std::string::npos) << twice.err;
    folder_.write("path.json", R"({"path": "line"})");
    EXPECT_EQ(outcome({"--path-file", "path.json", "-o", "new"}).exit_code, 2);
}

TEST_F(Interpolate, TheSafeRangeIsSaidAndHonoured)
{
    for (const std::string blend : {"plain", "squared"}) {
        const Arguments common{"--extrapolate", "--lengths", blend, "--frames", "2"};
        const auto at = [&](double t, Arguments more) {
            more.insert(more.end(), common.begin(), common.end());
            more.insert(more.end(), {"--range", join("0:", t)});
            return more;
        };
        const Json range = run(at(1.0, {"-o", blend, "--method", "multiscale"}))["safe_range"];
        const double high = range["high"].get<double>();
        EXPECT_LT(range["low"].get<double>(), 0.0);
        EXPECT_GT(high, 1.0);
        // Multiscale takes no lengths that break a triangle inequality; dihedral would stand in.
        const Json within =
            run(at(1.0 + 0.9999 * (high - 1.0), {"-o", blend + "-in", "--method", "multiscale"}));
        EXPECT_EQ(within["embeddings"][1]["method"], "multiscale");
        EXPECT_NEAR(within["safe_reach"][1].get<double>(), 1.0001, 1e-4);
        EXPECT_TRUE(within["safe_reach"][0].is_null());
        const double beyond = 1.0 + 1.0001 * (high - 1.0);
        const Outcome refused = outcome(at(beyond, {"-o", blend + "-out"}));
        EXPECT_EQ(refused.exit_code, 3);
        EXPECT_NE(refused.err.find(join("face ", range["high_face"].get<int>())), std::string::npos)
            << refused.err;
        const Outcome forced = outcome(at(beyond, {"-o", blend + "-out", "--force-range"}));
        EXPECT_EQ(forced.exit_code, 0) << forced.err;
        EXPECT_NE(forced.err.find("safe range of the line: "), std::string::npos) << forced.err;
        EXPECT_NE(forced.err.find("infeasible"), std::string::npos) << forced.err;
    }
}

TEST_F(Interpolate, TaggedPartsGrowByTheirFactor)
{
    folder_.write("tags.txt",
                  "0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 # half\n"
                  "22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37 38 39 40 41\n");
    for (const std::string method : {"dihedral", "closure", "multiscale"}) {
        (void)run({"--frames", "3", "-o", method, "--scale-vertices", "tags.txt", "--method",
                   method, "--scale-factors", "1,2"});
        EXPECT_LT(difference(method + "/frame_0000.ply", "a.ply"), 1e-6);
        const Eigen::VectorXd wanted = 2.0 * lengths("b.ply");
        EXPECT_LT((lengths(method + "/frame_0002.ply") - wanted).cwiseAbs().maxCoeff(), 1e-6);
    }
    folder_.write("faces.txt", "0 1 2 3\n");
    const Eigen::VectorXd plain = lengths("a.ply");
    (void)run({"--weights", "1,0", "-o", "x.ply", "--scale-faces", "faces.txt", "--scale-factors",
               "1.3,1"});
    const NamedMesh a = read_mesh(folder_ / "a.ply");
    const Topology topology(a.faces, static_cast<int>(a.points.rows()));
    const Eigen::VectorXd grown = lengths("x.ply").cwiseQuotient(plain);
    for (int f = 0; f < 4; ++f)
        for (const int e : topology.face_edges().row(f))
            EXPECT_NEAR(grown[e], 1.3, 0.1);
    EXPECT_NEAR(grown.minCoeff(), 1.0, 0.1);
}

TEST_F(Interpolate, APartMayBeALabelOfAPlyFile)
{
    const NamedMesh a = read_mesh(folder_ / "a.ply");
    Eigen::VectorXd part = Eigen::VectorXd::Zero(a.points.rows());
    part.segment(2, 3).setConstant(7.0);
    part[9] = -1.0;
    write_vertex_scalars(folder_ / "parts.ply", a.points, a.faces, {{"part", part}});
    folder_.write("seven.txt", "2 3 4\n");
    folder_.write("any.txt", "2 3 4 9\n");
    const auto half = [&](const std::string& name, const Arguments& more) {
        Arguments arguments{"--weights", "0.5,0.5", "-o", name, "--scale-factors", "1,1.5"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        (void)run(arguments);
        return folder_.read(name);
    };
    const std::string seven = half("0.ply", {"--scale-vertices", "seven.txt"});
    const std::string any = half("1.ply", {"--scale-vertices", "any.txt"});
    EXPECT_NE(seven, any);
    EXPECT_EQ(half("2.ply", {"--scale-vertices", "parts.ply", "--scale-label", "part=7"}), seven);
    EXPECT_EQ(half("3.ply", {"--scale-vertices", "parts.ply", "--scale-label", "part"}), any);
    EXPECT_NE(half("4.ply", {"--scale-vertices", "seven.txt", "--scale-border", "3"}), seven);

    std::string faces = join(
        "ply\nformat ascii 1.0\nelement vertex ", a.points.rows(),
        "\nproperty float x\nproperty float y\nproperty float z\n", "element face ", a.faces.rows(),
        "\nproperty list uchar int vertex_indices\nproperty int part\n", "end_header\n");
    for (Eigen::Index v = 0; v < a.points.rows(); ++v)
        faces += "0 0 0\n";
    for (Eigen::Index f = 0; f < a.faces.rows(); ++f)
        faces += join("3 ", a.faces(f, 0), " ", a.faces(f, 1), " ", a.faces(f, 2),
                      f < 4 ? " 2\n" : " 1\n");
    folder_.write("faces.ply", faces);
    folder_.write("faces.txt", "0 1 2 3\n");
    EXPECT_EQ(half("5.ply", {"--scale-faces", "faces.ply", "--scale-label", "part=2"}),
              half("6.ply", {"--scale-faces", "faces.txt"}));
}

TEST_F(Interpolate, KeyframesAreThoseOfTheMethodAndTheRestIsFilledIn)
{
    const Arguments common{"--frames", "9", "--method", "closure"};
    const auto with = [&](Arguments more) {
        more.insert(more.begin(), common.begin(), common.end());
        return more;
    };
    (void)run(with({"-o", "all"}));
    for (const std::string between : {"multiscale", "dihedral", "closure", "linear", "spline"}) {
        const Json embeddings =
            run(with({"-o", between, "--keyframes", "3", "--between", between}))["embeddings"];
        ASSERT_EQ(embeddings.size(), 9U);
        for (const std::size_t key : {0U, 3U, 6U, 8U}) {
            const std::string name = embeddings[key]["name"];
            EXPECT_EQ(embeddings[key]["method"], "closure");
            EXPECT_LT(difference(between + "/" + name + ".ply", "all/" + name + ".ply"), 1e-9);
        }
        EXPECT_EQ(embeddings[4]["method"], between);
        EXPECT_LT(embeddings[4]["edge_rms"].get<double>(), 0.05);
    }
}

TEST_F(Interpolate, AvoidingContactLeavesMeshesThatAreFreeAndSaysSo)
{
    const Json plain = run({"--weights", "0.5,0.5", "-o", "plain.ply"})["embeddings"][0];
    EXPECT_FALSE(plain.contains("avoidable_self_intersections"));
    const Json apart =
        run({"--weights", "0.5,0.5", "-o", "apart.ply", "--avoid-contact"})["embeddings"][0];
    EXPECT_EQ(apart["avoidable_self_intersections"], plain["new_self_intersections"]);
    EXPECT_EQ(apart["new_self_intersections"], 0);
    EXPECT_EQ(difference("plain.ply", "apart.ply"), 0.0);
}

TEST_F(Interpolate, TimesOfTheMultiscaleMethodAreSplit)
{
    const Json embedding =
        run({"--weights", "0.5,0.5", "-o", "x.ply", "--method", "multiscale"})["embeddings"][0];
    const Json& seconds = embedding["multiscale_seconds"];
    for (const char* part :
         {"splitting", "factorising", "interpolation", "registration", "blending", "pose"})
        EXPECT_GE(seconds[part].get<double>(), 0.0) << part;
    EXPECT_GT(seconds["splitting"].get<double>(), 0.0);
    EXPECT_FALSE(run({"--weights", "0.5,0.5", "-o", "y.ply"})["embeddings"][0].contains(
        "multiscale_seconds"));
}

TEST_F(Interpolate, TheRegistrationMayStartAsInThePaper)
{
    const auto blend = [&](const std::string& name, Arguments more) {
        more.insert(more.begin(), {"--weights", "0.5,0.5", "-o", name, "--method", "multiscale"});
        (void)run(more);
        return folder_.read(name);
    };
    const std::string standard = blend("standard.ply", {});
    EXPECT_EQ(blend("incremental.ply", {"--init", "incremental"}), standard);
    EXPECT_NE(blend("identity.ply", {"--init", "identity"}), standard);
    EXPECT_NE(blend("seed.ply", {"--seed", "2"}), standard);
}

class Resume : public Interpolate, public testing::WithParamInterface<Arguments>
{
};

TEST_P(Resume, EndsWithTheSameBits)
{
    Arguments common{"--frames", "300"};
    common.insert(common.end(), GetParam().begin(), GetParam().end());
    const auto with = [&](Arguments more) {
        more.insert(more.begin(), common.begin(), common.end());
        return more;
    };
    ASSERT_EQ(outcome(with({"-o", "whole"})).exit_code, 0);
    const Outcome stopped =
        outcome(with({"-o", "new"}), {.interrupt_at_file = "new.unfinished/20.mesh"});
    ASSERT_EQ(stopped.exit_code, 130) << stopped.err;
    EXPECT_NE(stopped.err.find("are kept in new.unfinished"), std::string::npos) << stopped.err;
    EXPECT_EQ(line_count(stopped.err), 1) << stopped.err;
    EXPECT_FALSE(folder_.has("new"));
    EXPECT_EQ(outcome(with({"-o", "new"})).exit_code, 5); // asks what to do
    const Outcome other = outcome(with({"-o", "new", "--resume", "--smoothness", "1"}));
    EXPECT_EQ(other.exit_code, 3);
    EXPECT_NE(other.err.find("differs in --smoothness"), std::string::npos) << other.err;

    folder_.write("new.unfinished/5.mesh", "damaged"); // is made again
    const Outcome resumed = outcome(with({"-o", "new", "--resume", "--threads", "1"}));
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_NE(resumed.err.find(" of 300 meshes are finished already"), std::string::npos);
    EXPECT_EQ(resumed.err.find("\n0 of 300"), std::string::npos) << resumed.err;
    EXPECT_FALSE(folder_.has("new.unfinished"));
    EXPECT_EQ(files_in(folder_ / "new"), files_in(folder_ / "whole"));
    for (const std::string& file : files_in(folder_ / "whole"))
        EXPECT_TRUE(folder_.read("new/" + file) == folder_.read("whole/" + file)) << file;
}

INSTANTIATE_TEST_SUITE_P(Sequences, Resume,
                         testing::Values(Arguments{"--method", "dihedral"},
                                         Arguments{"--keyframes", "20"}));

TEST_F(Interpolate, ARunThatCannotWriteItsOutputKeepsItsMeshes)
{
    const Arguments blend{"--frames", "12", "--glb-tolerance", "1e-9", "-o"};
    ASSERT_EQ(outcome(blend + Arguments{"whole.glb"}).exit_code, 0);
    const Outcome failed = outcome(blend + Arguments{"new.glb"}, {.largest_file = 8000});
    EXPECT_EQ(failed.exit_code, 5);
    EXPECT_EQ(line_count(failed.err), 1) << failed.err;
    EXPECT_NE(failed.err.find("new.glb: File too large; 12 of 12 meshes are kept in "
                              "new.glb.unfinished"),
              std::string::npos)
        << failed.err;
    EXPECT_FALSE(folder_.has("new.glb"));
    EXPECT_EQ(outcome(blend + Arguments{"new.glb", "--resume"}).exit_code, 0);
    EXPECT_TRUE(folder_.read("new.glb") == folder_.read("whole.glb"));
    EXPECT_FALSE(folder_.has("new.glb.unfinished"));

    const Outcome nothing = outcome(blend + Arguments{"none.glb"}, {.largest_file = 300});
    EXPECT_EQ(nothing.exit_code, 5);
    EXPECT_NE(nothing.err.find("File too large"), std::string::npos) << nothing.err;
    EXPECT_EQ(nothing.err.find("kept"), std::string::npos) << nothing.err;
}

TEST_F(Interpolate, ForceDiscardsAnInterruptedRun)
{
    const Arguments blend{"--frames", "300", "-o", "new"};
    ASSERT_EQ(outcome(blend, {.interrupt_at_file = "new.unfinished/3.mesh"}).exit_code, 130);
    Arguments forced{"--frames", "4", "-o", "new", "--force"};
    EXPECT_EQ(outcome(forced).exit_code, 0);
    EXPECT_FALSE(folder_.has("new.unfinished"));
    EXPECT_EQ(files_in(folder_ / "new").size(), 4U);
}

TEST_F(Interpolate, ADirectoryThatExistsKeepsAnInterruptedRunInside)
{
    folder_.write("new/mine.txt", "mine");
    const Arguments blend{"--frames", "300", "-o", "new"};
    ASSERT_EQ(outcome(blend, {.interrupt_at_file = "new/unfinished/3.mesh"}).exit_code, 130);
    Arguments resumed = blend;
    resumed.emplace_back("--resume");
    EXPECT_EQ(outcome(resumed).exit_code, 0);
    EXPECT_FALSE(folder_.has("new/unfinished"));
    EXPECT_EQ(files_in(folder_ / "new").size(), 301U);
}

TEST_F(Interpolate, AMeshMayOccurTwice)
{
    EXPECT_EQ(
        json_of(run_shape(folder_.path(), {"interpolate", "a.ply", "b.ply", "a.ply", "--frames",
                                           "5", "-o", "there_and_back", "--path", "polygon",
                                           "--quality", "preview", "--json"}))["outputs"]
            .size(),
        5U);
    folder_.write("x/m.ply", folder_.read("a.ply"));
    folder_.write("y/m.ply", folder_.read("b.ply"));
    EXPECT_EQ(run_shape(folder_.path(), {"draw", "x", "y", "-o", "both.svg"}).exit_code, 0);
    EXPECT_NE(folder_.read("both.svg").find("m (2)"), std::string::npos);
}

TEST_F(Interpolate, OutputsMayHaveNamesAsLongAsTheFileSystemTakes)
{
    const std::string name(249, 'n');
    const Outcome outcome = run_shape(folder_.path(), {"interpolate", "a.ply", "b.ply", "--frames",
                                                       "3", "-o", name, "--quality", "preview"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(files_in(folder_ / name).size(), 3U);
}

} // namespace
} // namespace shape::test
