// SPDX-License-Identifier: MIT

#include "libshape/io/landmark_file.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "tests/support/files.h"

namespace shape::test {
namespace {

using Eigen::Vector3d;

class LandmarkFile : public testing::Test
{
protected:
    [[nodiscard]] std::vector<Landmark> read(const std::string& name, const std::string& text) const
    {
        write_bytes(folder_ / name, text);
        return read_landmarks(folder_ / name);
    }
    TemporaryDirectory folder_;
};

TEST_F(LandmarkFile, ReadsTables)
{
    const auto marks = read("a.csv", "scan,name,x,y,z\ns1,nose,1,2,3\ns2,nose,4,5,6\n");
    ASSERT_EQ(marks.size(), 2U);
    EXPECT_EQ(marks[1].scan, "s2");
    EXPECT_EQ(marks[1].name, "nose");
    EXPECT_EQ(marks[1].vertex, -1);
    EXPECT_EQ(marks[1].position, Vector3d(4, 5, 6));
    EXPECT_EQ(read("e.csv", "scan,name,x,y,z\ntemplate.PLY,nose,1,2,3\n")[0].scan, "template");
    const auto of_vertices = read("b.csv", "name,vertex,x,y,z\nnose,17,1,2,3\n");
    EXPECT_EQ(of_vertices[0].vertex, 17);
    EXPECT_EQ(of_vertices[0].scan, "");
}

TEST_F(LandmarkFile, TellsTheCoordinateSystemsOfSlicerApart)
{
    const std::string row = "1,10,20,30,0,0,0,1,1,1,0,nose,,\n";
    EXPECT_EQ(read("a.fcsv", "# CoordinateSystem = LPS\n" + row)[0].position, Vector3d(10, 20, 30));
    EXPECT_EQ(read("b.fcsv", "# CoordinateSystem = RAS\n" + row)[0].position,
              Vector3d(-10, -20, 30));
    EXPECT_EQ(read("b.fcsv", "# CoordinateSystem = 0\n" + row)[0].name, "nose");
    const auto markup = [](const std::string& system) {
        return R"({"markups": [{"coordinateSystem": ")" + system +
               R"(", "controlPoints": [{"label": "nose", "position": [10, 20, 30]},
               {"label": "ear", "position": [0, 0, 0], "positionStatus": "undefined"}]}]})";
    };
    const auto lps = read("a.mrk.json", markup("LPS"));
    ASSERT_EQ(lps.size(), 1U);
    EXPECT_EQ(lps[0].position, Vector3d(10, 20, 30));
    EXPECT_EQ(read("b.mrk.json", markup("RAS"))[0].position, Vector3d(-10, -20, 30));
    EXPECT_THROW((void)read("c.mrk.json", markup("XYZ")), InvalidInput);
}

TEST_F(LandmarkFile, RefusesWhatItCannotRead)
{
    EXPECT_THROW((void)read("a.csv", "scan,name,x,y\ns1,nose,1,2\n"), InvalidInput);
    EXPECT_THROW((void)read("a.csv", "name,x,y,z\nnose,1,two,3\n"), InvalidInput);
    EXPECT_THROW((void)read("a.csv", "name,vertex,x,y,z\nnose,1.5,1,2,3\n"), InvalidInput);
    EXPECT_THROW((void)read("a.csv", "name,x,y,z\n"), InvalidInput);
    const auto message = [&](const std::string& name, const std::string& text) {
        return message_of<InvalidInput>([&] { (void)read(name, text); });
    };
    const std::string of_two = message("a.csv", "mesh,name,x,y,z\na,nose,1,2,3\nb,nose,1,2,3\n");
    for (const char* said : {"'nose' occurs twice", "no column 'scan'", "(columns: mesh, name, x",
                             "rename 'mesh' to 'scan'"})
        EXPECT_NE(of_two.find(said), std::string::npos) << of_two;
    EXPECT_NE(message("a.csv", "name,x,y,z\nnose,1,2,3\nnose,1,2,3\n").find("give one with"),
              std::string::npos);
    EXPECT_NE(message("a.mrk.json", "{").find("3D Slicer: line 1, column 2: is not JSON (syntax"),
              std::string::npos);
    EXPECT_THROW((void)read("a.fcsv", "1,2,3\n"), InvalidInput);
    EXPECT_THROW((void)read("a.mrk.json", "{"), InvalidInput);
    EXPECT_THROW((void)read("a.mrk.json", "{\"markups\": 3}"), InvalidInput);
    EXPECT_THROW((void)read("a.txt", "nose"), InvalidInput);
    EXPECT_THROW((void)read_landmarks(folder_ / "missing.csv"), FileError);
}

} // namespace
} // namespace shape::test
