// SPDX-License-Identifier: MIT

#include "libshape/io/landmark_file.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "tests/support/files.h"

namespace shape::test {
namespace {

using Eigen::Vector3d;

class LandmarkFiles : public testing::Test
{
protected:
    [[nodiscard]] LandmarkFile read_all(const std::string& name, const std::string& text) const
    {
        write_bytes(folder_ / name, text);
        return read_landmarks(folder_ / name);
    }
    [[nodiscard]] std::vector<Landmark> read(const std::string& name, const std::string& text) const
    {
        return read_all(name, text).landmarks;
    }
    TemporaryDirectory folder_;
};

TEST_F(LandmarkFiles, ReadsTables)
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

TEST_F(LandmarkFiles, TellsTheCoordinateSystemsOfSlicerApart)
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

TEST_F(LandmarkFiles, KeepsThoseWithoutCoordinatesApart)
{
    // As R, pandas and spreadsheets write what was not to be seen.
    const LandmarkFile table = read_all("a.csv",
                                        "scan,name,vertex,x,y,z\ns1,nose,,1,2,3\n"
                                        "s1,chin,,NA,NA,NA\ns1,ear,,nan,NaN,\ns1,eye,17,,,\n");
    ASSERT_EQ(table.landmarks.size(), 1U);
    ASSERT_EQ(table.missing.size(), 3U);
    EXPECT_EQ(table.missing[0].name, "chin");
    EXPECT_EQ(table.missing[1].scan, "s1");
    EXPECT_EQ(table.missing[2].vertex, 17);
    EXPECT_EQ(read_all("b.csv", "name,x,y,z\nnose,NA,NA,NA\n").missing.size(), 1U);
    EXPECT_NE(message_of<InvalidInput>([&] {
                  (void)read("c.csv", "name,x,y,z\nnose,1,inf,3\n");
              }).find("c.csv, row 1, y: 'inf' is not a finite number"),
              std::string::npos);
    EXPECT_NE(
        message_of<InvalidInput>([&] {
            (void)read("c.csv", "name,x,y,z,vertex\nnose,1,2,3,\"1,5\"\n");
        }).find("c.csv, row 1, vertex: '1,5' is not a finite number (decimal point, no comma)"),
        std::string::npos);
    EXPECT_NE(message_of<InvalidInput>([&] {
                  (void)read("c.csv", "name,x,y,z\nnose,1,2,3\nchin,NA,2,3\n");
              }).find("row 2: 1 of the three coordinates is missing; give all of them"),
              std::string::npos);

    const LandmarkFile points = read_all(
        "a.fcsv",
        "# CoordinateSystem = LPS\n1,1,2,3,0,0,0,1,1,1,0,\"left, nose\",\"says \"\"hm\"\"\",,2,0\n"
        "2,0,0,0,0,0,0,1,1,1,0,chin,,,0,0\n3,4,5,6,0,0,0,1,1,1,0,ear,,,1,0\n"
        "4,0,0,0,0,0,0,1,1,1,0,eye,,,3,0\n5,nan,nan,nan,0,0,0,1,1,1,0,brow,,\n");
    ASSERT_EQ(points.landmarks.size(), 1U);
    EXPECT_EQ(points.landmarks[0].name, "left, nose");
    ASSERT_EQ(points.missing.size(), 4U);
    EXPECT_EQ(points.missing[3].name, "brow");

    std::string controls = R"({"label": "nose", "position": [1, 2, 3]})";
    for (const char* status : {"undefined", "missing", "preview"})
        controls += std::string(R"(, {"label": "chin", "position": "", "positionStatus": ")") +
                    status + "\"}";
    controls += R"(, {"label": "ear", "position": [null, null, null]}, {"label": "eye"})";
    const LandmarkFile markups =
        read_all("a.mrk.json", R"({"markups": [{"controlPoints": [)" + controls + "]}]}");
    EXPECT_EQ(markups.landmarks.size(), 1U);
    EXPECT_EQ(markups.missing.size(), 5U);
}

TEST_F(LandmarkFiles, StripsOuterBlanks)
{
    const auto marks =
        read("a.csv", "scan , name,x,y,z\n s1.ply , nose,1, 2,3 \n,,,,\n s2,\xC2\xA0nose ,4,5,6\n");
    ASSERT_EQ(marks.size(), 2U);
    for (const Landmark& mark : marks)
        EXPECT_EQ(mark.name, "nose");
    EXPECT_EQ(marks[0].scan, "s1");
    EXPECT_EQ(marks[0].position, Vector3d(1, 2, 3));
    EXPECT_EQ(marks[1].scan, "s2");
    EXPECT_EQ(read("a.fcsv", "1, 1, 2, 3,0,0,0,1,1,1,0, nose ,,\n \n")[0].name, "nose");
    EXPECT_EQ(
        read("a.mrk.json",
             R"({"markups": [{"controlPoints": [{"label": " nose ", "position": [1, 2, 3]}]}]})")[0]
            .name,
        "nose");
}

TEST_F(LandmarkFiles, RefusesWhatItCannotRead)
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
    const std::string deep(500'000, '[');
    EXPECT_NE(message("a.mrk.json", "{\"markups\": " + deep).find("lists lie more than"),
              std::string::npos);
    EXPECT_THROW((void)read("a.txt", "nose"), InvalidInput);
    EXPECT_THROW((void)read_landmarks(folder_ / "missing.csv"), FileError);
}

} // namespace
} // namespace shape::test
