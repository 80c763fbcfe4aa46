// SPDX-License-Identifier: MIT

#include <cstdlib>

#include "libshape/base/format.h"
#include "libshape/io/table_file.h"
#include "tests/tools/program_test.h"

namespace shape::test {
using namespace internal;
namespace {

/// `-` as standard input and output.
class Streams : public ProgramTest
{
protected:
    Streams()
    {
        write_bumpy_spheres(folder_);
        (void)run({"collect", "a.ply", "b.ply", "c.ply", "--labels", "labels.csv", "-o", "f.h5"});
        (void)run({"stats", "f.h5", "-o", "model.h5"});
    }
    [[nodiscard]] Outcome shape(const Arguments& arguments, const std::string& input = {}) const
    {
        return run_shape(folder_.path(), arguments, {.input_file = input});
    }
};

TEST_F(Streams, TablesMeshesAndPicturesGoToStandardOutput)
{
    (void)run({"project", "model.h5", "f.h5", "-o", "scores.csv"});
    EXPECT_EQ(shape({"project", "model.h5", "f.h5", "-o", "-"}).out, folder_.read("scores.csv"));
    EXPECT_EQ(shape({"project", "model.h5", "f.h5", "--output=-"}).out, folder_.read("scores.csv"));
    (void)run({"generate", "model.h5", "--mean", "-o", "mean.ply"});
    (void)run({"generate", "model.h5", "--mean", "-o", "mean.off"});
    EXPECT_EQ(shape({"generate", "model.h5", "--mean", "-o", "-"}).out, folder_.read("mean.ply"));
    EXPECT_EQ(shape({"generate", "model.h5", "--mean", "-o", "-", "--format", "off"}).out,
              folder_.read("mean.off"));
    (void)run({"distance", "f.h5", "--mds", "mds.csv", "--cluster", "tree.csv"});
    EXPECT_EQ(shape({"distance", "f.h5", "--mds", "-"}).out, folder_.read("mds.csv"));
    EXPECT_EQ(shape({"distance", "f.h5", "--cluster", "-"}).out, folder_.read("tree.csv"));
    EXPECT_TRUE(shape({"draw", "a.ply", "-o", "-"}).out.find("<svg") != std::string::npos);
    EXPECT_FALSE(folder_.has("-"));
}

TEST_F(Streams, MeshesTablesAndCollectionsComeFromStandardInput)
{
    for (const char* file : {"a.ply", "f.h5"}) {
        const Outcome outcome = shape({"check", "-"}, file);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    }
    (void)run({"generate", "model.h5", "--mean", "-o", "mean.off"});
    (void)run({"generate", "model.h5", "--mean", "-o", "mean.obj"});
    for (const char* file : {"mean.off", "mean.obj"})
        EXPECT_EQ(shape({"check", "-"}, file).exit_code, 0);
    (void)run({"generate", "model.h5", "--mean", "-o", "mean.stl"});
    std::string binary = folder_.read("mean.stl");
    binary.replace(0, 80, std::string(80, '\0')); // a head may say anything, or nothing
    folder_.write("bare.stl", binary);
    folder_.write("cut.stl", binary.substr(0, binary.size() - 7));
    for (const char* file : {"mean.stl", "bare.stl"}) {
        const Outcome outcome = shape({"check", "-"}, file);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    }
    const Outcome cut = shape({"check", "-"}, "cut.stl");
    EXPECT_NE((cut.out + cut.err).find("is this an STL file?"), std::string::npos) << cut.err;
    const Outcome labelled =
        shape({"collect", "a.ply", "b.ply", "c.ply", "--labels", "-", "-o", "g.h5"}, "labels.csv");
    EXPECT_EQ(labelled.exit_code, 0) << labelled.err;
    EXPECT_EQ(folder_.read("g.h5"), folder_.read("f.h5"));
    // Both ends of a pipe.
    const Outcome both =
        shape({"interpolate", "-", "b.ply", "--weights", "1,0", "-o", "-"}, "a.ply");
    EXPECT_TRUE(both.out.starts_with("ply\n")) << both.err;
}

TEST_F(Streams, AFailedRunPrintsNothingAndNamesTheStream)
{
    folder_.write("bad.obj", "v 0 0 zero\n");
    const Outcome outcome =
        shape({"interpolate", "-", "b.ply", "--weights", "1,0", "-o", "-"}, "bad.obj");
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find("error: -: line 1"), std::string::npos) << outcome.err;
}

TEST_F(Streams, MessagesNameTheStreamAndNoFileOfOurs)
{
    for (const Arguments& arguments :
         {Arguments{"stats", "f.h5", "-o", "-"}, Arguments{"distance", "f.h5", "-o", "-"}}) {
        const Outcome outcome = shape(arguments);
        EXPECT_EQ(outcome.exit_code, 0);
        EXPECT_TRUE(outcome.err.starts_with("-: ")) << outcome.err;
        EXPECT_EQ(outcome.err.find("/shape-"), std::string::npos) << outcome.err;
    }
    folder_.write("bad.obj", "v 0 0 zero\n");
    for (const char* file : {"a.ply", "bad.obj"})
        for (const Arguments& arguments :
             {Arguments{"check", "-", "--json"}, Arguments{"check", "-"},
              Arguments{"check", "-", "--verbose"}}) {
            const Outcome checked = shape(arguments, file);
            EXPECT_EQ(checked.out.find("/shape-"), std::string::npos) << checked.out;
        }
}

TEST_F(Streams, OneStreamServesOnePurpose)
{
    for (const Arguments& arguments :
         {Arguments{"project", "model.h5", "f.h5", "-o", "-", "--json"},
          Arguments{"project", "model.h5", "f.h5", "-o", "-", "--plot", "-"},
          Arguments{"check", "f.h5", "--fix", "-"}, Arguments{"check", "-", "-"}}) {
        const Outcome outcome = shape(arguments, "a.ply");
        EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
        if (arguments.back() == "--json")
            EXPECT_NE(outcome.out.find("\"usage\""), std::string::npos) << outcome.out;
        else
            EXPECT_EQ(outcome.out, "");
        EXPECT_EQ(line_count(outcome.err), 1) << outcome.err;
    }
}

} // namespace
} // namespace shape::test
