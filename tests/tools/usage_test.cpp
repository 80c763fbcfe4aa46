// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include "tests/tools/program.h"

namespace shape::test {
namespace {

const Arguments commands{
    "collect",     "check",     "info",     "stats",   "project", "generate",   "distance",
    "quality",     "groups",    "classify", "regress", "remove",  "difference", "interpolate",
    "reconstruct", "conformal", "merge",    "draw",    "explore", "report",     "synth"};

/// A wrong command line and what its error must name.
struct WrongUsage
{
    std::string name;
    std::string said;
    Arguments arguments;
};

void PrintTo(const WrongUsage& wrong, std::ostream* out)
{
    *out << wrong.name;
}

std::vector<WrongUsage> wrong_usages()
{
    const Arguments stats{"stats", "a.ply", "b.ply", "-o", "out.h5"};
    const Arguments blend{"interpolate", "a.ply", "b.ply", "-o", "new"};
    const Arguments distance{"distance", "a.ply", "b.ply", "-o", "d.csv"};
    const Arguments quality{"quality", "a.ply", "b.ply", "-o", "q.csv"};
    const Arguments generate{"generate", "model.h5", "-o", "new"};
    const Arguments mean = generate + Arguments{"--mean"};
    const Arguments difference{"difference", "a.ply", "-o", "out.h5", "--pair-by", "k"};
    return {
        {"NoCommand", "command", {}},
        {"UnknownCommand", "frobnicate", {"frobnicate"}},
        {"UnknownOption", "--frobnicate", stats + Arguments{"--frobnicate"}},
        {"NoOutput", "--output", {"stats", "a.ply", "b.ply"}},
        {"NoMeshes", "MESHES", {"stats", "-o", "out.h5"}},
        {"NoThreads", "--threads", stats + Arguments{"--threads", "0"}},
        {"TooManyThreads", "--threads", stats + Arguments{"--threads", "100000"}},
        {"SeedThatIsNoInteger", "--seed", stats + Arguments{"--seed", "1.5"}},
        {"NegativeSeed", "--seed", stats + Arguments{"--seed", "-1"}},
        {"NoModes", "--modes", stats + Arguments{"--modes", "0"}},
        {"HexadecimalModes", "--modes", stats + Arguments{"--modes", "0x2"}},
        {"NanVariance", "--variance", stats + Arguments{"--variance", "nan"}},
        {"InfiniteVariance", "--variance", stats + Arguments{"--variance", "inf"}},
        {"HexadecimalVariance", "--variance", stats + Arguments{"--variance", "0x1"}},
        {"NegativeVariance", "--variance", stats + Arguments{"--variance", "-0.5"}},
        {"ModesAndVariance", "--modes", stats + Arguments{"--modes", "1", "--variance", "0.5"}},
        {"DistancesAsASpreadsheet", ".csv", {"distance", "a.ply", "b.ply", "-o", "d.xlsx"}},
        {"ScoresAsASpreadsheet", ".csv", {"project", "model.h5", "a.ply", "-o", "s.xlsx"}},
        {"QualityAsASpreadsheet", ".csv", {"quality", "a.ply", "b.ply", "-o", "q.xlsx"}},
        {"UnknownScale", "--scale", stats + Arguments{"--scale", "double"}},
        {"UnknownSpace", "--space", stats + Arguments{"--space", "kendall"}},
        {"UnknownCoordinates", "--coordinates", stats + Arguments{"--coordinates", "cubic"}},
        {"NegativeDihedralWeight", "--with-dihedrals", stats + Arguments{"--with-dihedrals", "-1"}},
        {"LogarithmsOfPositions", "--coordinates",
         stats + Arguments{"--space", "procrustes", "--coordinates", "log"}},
        {"AreaWeightsOfPositions", "--area-weighted",
         stats + Arguments{"--space", "procrustes", "--area-weighted"}},
        {"DihedralsWithPositions", "--with-dihedrals",
         stats + Arguments{"--space", "procrustes", "--with-dihedrals", "1"}},
        {"NegativePositionWeight", "--with-positions", stats + Arguments{"--with-positions", "-1"}},
        {"PositionsTwice", "--with-positions",
         stats + Arguments{"--space", "procrustes", "--with-positions", "1"}},
        {"ModelOfAnotherEnding", ".h5", {"stats", "a.ply", "b.ply", "-o", "model.csv"}},
        {"EmptyOutput", ".h5", {"stats", "a.ply", "b.ply", "-o", ""}},
        {"EmptyInput", "MESHES: a path is empty", {"stats", "", "-o", "out.h5"}},
        {"EmptyModel", "MODEL: a path is empty", {"project", "", "a.ply", "-o", "s.csv"}},
        {"CovariateTwice",
         "--on size is given twice",
         {"regress", "a.ply", "b.ply", "--on", "size", "--on", "size", "-o", "r.csv"}},
        {"PlotOfAnotherEnding",
         "--plot",
         {"project", "model.h5", "a.ply", "-o", "s.csv", "--plot", "s.pdf"}},
        {"UnknownMetric", "--metric", distance + Arguments{"--metric", "geodesic"}},
        {"MetricAndSpace", "--space",
         distance + Arguments{"--metric", "edge", "--space", "procrustes"}},
        {"MetricAndScale", "--scale", distance + Arguments{"--metric", "edge", "--scale", "none"}},
        {"MetricOfPositionsWithEdgeWeights", "--area-weighted",
         distance + Arguments{"--metric", "procrustes", "--area-weighted"}},
        {"DistancesWithoutOutput", "-o is required", {"distance", "a.ply", "b.ply"}},
        {"PlaneDrawnIntoAnotherEnding", "--plot", distance + Arguments{"--plot", "mds.pdf"}},
        {"MapDrawnIntoAnotherEnding", "--heat-map", distance + Arguments{"--heat-map", "m.csv"}},
        {"TwoTablesInOneFile", "--mds", distance + Arguments{"--mds", "./d.csv"}},
        {"TwoDrawingsInOneFile", "--heat-map",
         distance + Arguments{"--plot", "m.svg", "--heat-map", "m.svg"}},
        {"ModesThatDescend", "--modes", quality + Arguments{"--modes", "2,1"}},
        {"ModesOfFractions", "--modes", quality + Arguments{"--modes", "1,1.5"}},
        {"NoModesToMeasure", "--modes", quality + Arguments{"--modes", "0,1"}},
        {"FoldsAndLabel", "--folds", quality + Arguments{"--folds", "2", "--leave-out", "subject"}},
        {"OneFold", "--folds", quality + Arguments{"--folds", "1"}},
        {"NoTests", "--tests", quality + Arguments{"--tests", "0"}},
        {"NoSamples", "--samples", quality + Arguments{"--samples", "0"}},
        {"QualityOfAnotherEnding", "--plot", quality + Arguments{"--plot", "q.pdf"}},
        {"NoBlend", "--weights", blend},
        {"WeightsAndFrames", "--frames", blend + Arguments{"--weights", "0,1", "--frames", "3"}},
        {"WeightsThatAreNoNumbers", "--weights", blend + Arguments{"--weights", "0.5;0.5"}},
        {"NanWeights", "--weights", blend + Arguments{"--weights", "nan,1"}},
        {"OneFrame", "--frames", blend + Arguments{"--frames", "1"}},
        {"UnknownPath", "--path", blend + Arguments{"--frames", "3", "--path", "curve"}},
        {"UnknownSpline", "--spline",
         blend + Arguments{"--frames", "3", "--path", "spline", "--spline", "bezier"}},
        {"SplineOfALine", "--spline", blend + Arguments{"--frames", "3", "--spline", "b-spline"}},
        {"WeightsOfASpline", "--weights",
         blend + Arguments{"--weights", "0,1", "--path", "spline"}},
        {"PlaceOnALine", "--at", blend + Arguments{"--at", "0,0"}},
        {"PlaceThatIsNoPair", "--at", blend + Arguments{"--path", "polygon", "--at", "1"}},
        {"PlaceThatIsNoNumber", "--at", blend + Arguments{"--path", "polygon", "--at", "1,x"}},
        {"GridOfAPolygon", "--grid", blend + Arguments{"--path", "polygon", "--grid", "3,3"}},
        {"GridOfOneRow", "--grid", blend + Arguments{"--path", "bilinear", "--grid", "3,1"}},
        {"GridWithoutRows", "--grid", blend + Arguments{"--path", "bilinear", "--grid", "3"}},
        {"TrackOnALine", "--track", blend + Arguments{"--frames", "3", "--track", "0,0:1,1"}},
        {"TrackOfTriples", "--track",
         blend + Arguments{"--frames", "3", "--path", "polygon", "--track", "0,0,0:1,1,1"}},
        {"RangeOfAPatch", "--range",
         blend + Arguments{"--frames", "3", "--path", "bilinear", "--range", "0:1"}},
        {"RangeOfOneEnd", "--range", blend + Arguments{"--frames", "3", "--range", "1"}},
        {"RangeWithoutFrames", "--range", blend + Arguments{"--weights", "0,1", "--range", "0:1"}},
        {"PolygonOfALine", "--polygon",
         blend + Arguments{"--frames", "3", "--polygon", "0,0:1,0:0,1"}},
        {"ForceRangeAlone", "--extrapolate", blend + Arguments{"--frames", "3", "--force-range"}},
        {"FactorsWithoutTags", "--scale-factors",
         blend + Arguments{"--frames", "3", "--scale-factors", "1,2"}},
        {"TagsWithoutFactors", "--scale-factors",
         blend + Arguments{"--frames", "3", "--scale-vertices", "a.ply"}},
        {"FactorsThatAreNoNumbers", "--scale-factors",
         blend + Arguments{"--frames", "3", "--scale-vertices", "a.ply", "--scale-factors", "1;2"}},
        {"OneFrameBetweenKeyframes", "--keyframes",
         blend + Arguments{"--frames", "9", "--keyframes", "1"}},
        {"KeyframesOfWeights", "--keyframes",
         blend + Arguments{"--weights", "0,1", "--keyframes", "2"}},
        {"BetweenWithoutKeyframes", "--keyframes",
         blend + Arguments{"--frames", "9", "--between", "linear"}},
        {"UnknownBetween", "--between",
         blend + Arguments{"--frames", "9", "--keyframes", "2", "--between", "magic"}},
        {"UnknownInit", "--init", mean + Arguments{"--init", "random"}},
        {"SeveralMeshesIntoOneFile",
         "x.ply",
         {"interpolate", "a.ply", "b.ply", "--frames", "3", "-o", "x.ply"}},
        {"MeshesAndLabelsIntoOneAnimation", "x.glb", {"synth", "torus", "-o", "x.glb"}},
        {"RateWithoutAnimation", "--fps", blend + Arguments{"--frames", "3", "--fps", "5"}},
        {"RateOfASingleMesh",
         "--fps",
         {"generate", "model.h5", "--mean", "-o", "x.glb", "--fps", "5"}},
        {"ToleranceWithoutAnimation",
         "--glb-tolerance",
         {"interpolate", "a.ply", "b.ply", "--frames", "2", "-o", "x/", "--glb-tolerance", "1"}},
        {"NoRate",
         "--fps",
         {"interpolate", "a.ply", "b.ply", "--frames", "2", "-o", "x.glb", "--fps", "0"}},
        {"NoTolerance",
         "--glb-tolerance",
         {"interpolate", "a.ply", "b.ply", "--frames", "2", "-o", "x.glb", "--glb-tolerance", "0"}},
        {"ResidualsOfAnAnimation",
         "_residuals.ply",
         {"interpolate", "a.ply", "b.ply", "--frames", "2", "-o", "x.glb", "--residuals"}},
        {"ResidualsOfTheSphere",
         "--residuals",
         {"conformal", "a.ply", "-o", "x.ply", "--residuals"}},
        {"ResidualsWithoutMesh", "--residuals",
         difference + Arguments{"--from", "k=1", "--to", "k=2", "--residuals"}},
        {"UnknownFormat", "x.fbx", {"generate", "model.h5", "--mean", "-o", "x.fbx"}},
        {"FormatAgainstTheEnding",
         "--format",
         {"generate", "model.h5", "--mean", "-o", "x.ply", "--format", "obj"}},
        {"UnknownMethod", "--method", mean + Arguments{"--method", "magic"}},
        {"QualityOfAnotherMethod",
         "--quality is an option of --method dihedral, not of --method closure",
         mean + Arguments{"--method", "closure", "--quality", "preview"}},
        {"SmoothnessOfAnotherMethod",
         "--smoothness is an option of --method dihedral, not of --method multiscale",
         mean + Arguments{"--method", "multiscale", "--smoothness", "0.1"}},
        {"InitOfAnotherMethod",
         "--init is an option of --method multiscale, not of --method dihedral",
         mean + Arguments{"--init", "identity"}},
        {"QualityOfNoMethodOfASequence",
         "--quality is an option of --method dihedral, not of --method closure",
         blend + Arguments{"--frames", "9", "--keyframes", "2", "--between", "multiscale",
                           "--method", "closure", "--quality", "fine"}},
        {"ContactOfMovedVertices", "--avoid-contact does not go with --between spline",
         blend + Arguments{"--frames", "9", "--keyframes", "2", "--between", "spline",
                           "--avoid-contact"}},
        {"NoSmoothness", "--smoothness", mean + Arguments{"--smoothness", "0"}},
        {"NanSmoothness", "--smoothness", mean + Arguments{"--smoothness", "nan"}},
        {"NegativeSize", "--size", mean + Arguments{"--size", "-3"}},
        {"NoPoint", "--mean", generate},
        {"MeanAndSample", "--sample", mean + Arguments{"--sample", "2"}},
        {"ModeWithoutSigma", "--sigma", generate + Arguments{"--mode", "1"}},
        {"SigmaWithoutMode", "--mode", mean + Arguments{"--sigma", "1"}},
        {"SigmaOfTwoParts", "--sigma", generate + Arguments{"--mode", "1", "--sigma", "1:2"}},
        {"SigmaOfEqualEnds", "'1:1:3' has the value 1 more than once",
         generate + Arguments{"--mode", "1", "--sigma", "1:1:3"}},
        {"SigmaOfOneStep", "--sigma", generate + Arguments{"--mode", "1", "--sigma", "1:2:1"}},
        {"HugeSigma", "--sigma", generate + Arguments{"--mode", "1", "--sigma", "0:1e300:3"}},
        {"NanSigma", "--sigma", generate + Arguments{"--mode", "1", "--sigma", "nan"}},
        {"FromWithoutValue", "--from",
         difference + Arguments{"--from", "mood", "--to", "mood=glad"}},
        {"ApplyWithoutMesh", "--mesh",
         difference + Arguments{"--from", "k=1", "--to", "k=2", "--apply"}},
        {"ReportOfAnotherEnding", ".html", {"report", "model.h5", "-o", "page.pdf"}},
        {"PageOfNoMode", "--modes", {"explore", "model.h5", "-o", "page.html", "--modes", "0"}},
        {"PageOfNoSmoothness",
         "--smoothness",
         {"explore", "model.h5", "-o", "page.html", "--smoothness", "0"}},
        {"SynthWithoutName", "NAME", {"synth", "-o", "new"}},
    };
}

class WrongUsageTest : public testing::TestWithParam<WrongUsage>
{
};

TEST_P(WrongUsageTest, EndsWithCodeTwoAndOneLine)
{
    const Folder folder;
    write_bumpy_spheres(folder);
    ASSERT_EQ(run_shape(folder.path(), {"stats", "a.ply", "b.ply", "-o", "model.h5"}).exit_code, 0);
    const std::map<std::string, std::string> before = folder.content();

    const Outcome outcome = run_shape(folder.path(), GetParam().arguments);

    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(line_count(outcome.err), 1) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("shape: error: ")) << outcome.err;
    EXPECT_NE(outcome.err.find(GetParam().said), std::string::npos) << outcome.err;
    EXPECT_TRUE(folder.content() == before) << "a file was made or changed";
}

std::string case_name(const testing::TestParamInfo<WrongUsage>& wrong)
{
    return wrong.param.name;
}

INSTANTIATE_TEST_SUITE_P(Usage, WrongUsageTest, testing::ValuesIn(wrong_usages()), case_name);

TEST(Help, ListsEveryCommand)
{
    const Folder folder;
    const Outcome outcome = run_shape(folder.path(), {"--help"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_EQ(outcome.err, "");
    for (const std::string& command : commands)
        EXPECT_NE(outcome.out.find("\n  " + command + " "), std::string::npos) << command;
}

TEST(Help, OfEveryCommandHasItsOptionsAndAnExample)
{
    const Folder folder;
    for (const std::string& command : commands) {
        const Outcome outcome = run_shape(folder.path(), {command, "--help"});
        EXPECT_EQ(outcome.exit_code, 0) << command;
        EXPECT_EQ(outcome.err, "") << command;
        for (const std::string& word : {std::string("--json"), std::string("--threads"),
                                        std::string("Example"), "shape " + command + " "})
            EXPECT_NE(outcome.out.find(word), std::string::npos) << command << " lacks " << word;
    }
}

TEST(Help, FitsATerminal)
{
    const Folder folder;
    const auto expect_narrow = [&](const Arguments& arguments) {
        std::istringstream help(run_shape(folder.path(), arguments).out);
        for (std::string line; std::getline(help, line);)
            EXPECT_LE(line.size(), 120U) << arguments.front() << ": " << line;
    };
    expect_narrow({"--help"});
    for (const std::string& command : commands)
        expect_narrow({command, "--help"});
}

TEST(Version, IsPrintedOnStdout)
{
    const Folder folder;
    const Outcome outcome = run_shape(folder.path(), {"--version"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_TRUE(outcome.out.starts_with("shape ")) << outcome.out;
}

TEST(Usage, ADirectoryMayHaveTheNameOfACommand)
{
    const Folder folder;
    write_bumpy_spheres(folder);
    std::filesystem::create_directory(folder / "stats");
    for (const char* name : {"a.ply", "b.ply"})
        std::filesystem::rename(folder / name, folder / "stats" / name);
    const Outcome outcome = run_shape(folder.path(), {"stats", "stats", "-o", "model.h5"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST(Words, NearMissesAreAnsweredByWhatWasMeant)
{
    const Folder folder;
    const auto err = [&](const Arguments& arguments) {
        const Outcome outcome = run_shape(folder.path(), arguments);
        EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
        return outcome.err;
    };
    EXPECT_NE(err({"--verson"}).find("did you mean '--version'?"), std::string::npos);
    EXPECT_NE(err({"colect"}).find("did you mean 'collect'?"), std::string::npos);
    EXPECT_NE(err({"help", "genrate"}).find("did you mean 'generate'?"), std::string::npos);
    EXPECT_NE(
        err({"stats", "x.h5", "--scael", "unit", "-o", "y.h5"}).find("did you mean '--scale'?"),
        std::string::npos);
    // What was meant is missing then; that is not news.
    EXPECT_NE(err({"stats", "x.h5", "--outptu", "y.h5"}).find("did you mean '--output'?"),
              std::string::npos);
    EXPECT_NE(err({"stats", "x.h5", "--zzzzzzzzz", "-o", "y.h5"}).find("no option '--zzzzzzzzz'"),
              std::string::npos);
    EXPECT_NE(err({"generate", "x.h5", "--mean", "--method", "dihedrl", "-o", "y.ply"})
                  .find("did you mean 'dihedral'?"),
              std::string::npos);
    EXPECT_EQ(err({"quite-another-word"}).find("did you mean"), std::string::npos);
}

TEST(Words, VersionAndHelpComeInEverySpelling)
{
    const Folder folder;
    const auto out = [&](const Arguments& arguments) {
        const Outcome outcome = run_shape(folder.path(), arguments);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome.out;
    };
    EXPECT_EQ(out({"-V"}), out({"--version"}));
    EXPECT_EQ(out({"help"}), out({"--help"}));
    EXPECT_EQ(out({"help", "stats"}), out({"stats", "--help"}));
}

} // namespace
} // namespace shape::test
