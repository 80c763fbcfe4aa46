// SPDX-License-Identifier: MIT

#include "libshape/io/vertex_scalars.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/io/mesh_file.h"
#include "tests/support/files.h"
#include "tests/support/matrices.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

using test::TemporaryDirectory;
using test::TestMesh;

const std::string triangle =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property uchar heat\nproperty float z\nproperty list uchar int near\n"
    "element face 1\nproperty list uchar int vertex_indices\nproperty int heat\nend_header\n"
    "0 0 7 0 1 5\n1 0 8 0 0\n0 1 9 0 2 1 1\n3 0 1 2 4\n";

class VertexScalars : public testing::Test
{
protected:
    [[nodiscard]] std::string writing(const std::vector<VertexScalar>& scalars) const
    {
        return test::message_of<InvalidInput>([&] {
            write_vertex_scalars(directory_ / "x.ply", mesh_.points, mesh_.topology.faces(),
                                 scalars);
        });
    }
    [[nodiscard]] std::string reading(const char* file, const char* name) const
    {
        return test::message_of<InvalidInput>(
            [&] { (void)read_vertex_scalar(directory_ / file, name); });
    }

    const TemporaryDirectory directory_;
    const TestMesh mesh_ = test::open_patch(4, 1);
};

TEST_F(VertexScalars, ComeBackBitByBitAndLeaveTheMeshAsItIs)
{
    const Eigen::VectorXd first = test::random_matrix(mesh_.points.rows(), 1, 1);
    const Eigen::VectorXd second = 1e-300 * test::random_matrix(mesh_.points.rows(), 1, 2);
    write_vertex_scalars(directory_ / "x.ply", mesh_.points, mesh_.topology.faces(),
                         {{"edge_error", first}, {"Q2", second}});
    EXPECT_EQ(read_vertex_scalar(directory_ / "x.ply", "edge_error"), first);
    EXPECT_EQ(read_vertex_scalar(directory_ / "x.ply", "Q2"), second);
    const NamedMesh read = read_mesh(directory_ / "x.ply");
    EXPECT_EQ(read.points, mesh_.points);
    EXPECT_EQ(read.faces, mesh_.topology.faces());
}

TEST_F(VertexScalars, AreNoneInAnOrdinaryFile)
{
    for (const char* name : {"with.ply", "without.ply"})
        write_mesh(directory_ / name, mesh_.points, mesh_.topology.faces(), MeshFormat::Ply);
    write_vertex_scalars(directory_ / "with.ply", mesh_.points, mesh_.topology.faces(), {});
    EXPECT_EQ(test::read_bytes(directory_ / "with.ply"),
              test::read_bytes(directory_ / "without.ply"));
}

TEST_F(VertexScalars, OfOtherProgramsAreReadWhateverTheirTypeAndPlace)
{
    test::write_bytes(directory_ / "t.ply", triangle);
    EXPECT_EQ(read_vertex_scalar(directory_ / "t.ply", "heat"), Eigen::Vector3d(7, 8, 9));
    EXPECT_EQ(read_vertex_scalar(directory_ / "t.ply", "x"), Eigen::Vector3d(0, 1, 0));
    EXPECT_EQ(read_vertex_scalar(directory_ / "t.ply", "y"), Eigen::Vector3d(0, 0, 1));
}

TEST_F(VertexScalars, MayHaveGapsWhereThatIsAskedFor)
{
    std::string text = triangle;
    text.replace(text.find("uchar heat"), 10, "float heat");
    for (const char* gap : {"nan", "-nan(ind)", "NaN", "inf", "-1.#IND", "1e999"}) {
        std::string with_gap = text;
        with_gap.replace(with_gap.find("1 0 8"), 5, std::string("1 0 ") + gap); // x, y, heat
        test::write_bytes(directory_ / "t.ply", with_gap);
        const Eigen::VectorXd heat = read_vertex_scalar_with_gaps(directory_ / "t.ply", "heat");
        ASSERT_EQ(heat.size(), 3);
        EXPECT_TRUE(std::isnan(heat[1])) << gap;
        EXPECT_EQ(heat[2], 9.0);
        EXPECT_NE(reading("t.ply", "heat").find("must be a finite number"), std::string::npos);
    }
    text.replace(text.find("1 0 8"), 5, "1 0 x");
    test::write_bytes(directory_ / "t.ply", text);
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)read_vertex_scalar_with_gaps(directory_ / "t.ply", "heat");
              }).find("vertex 1 is 'x'"),
              std::string::npos);
}

TEST_F(VertexScalars, OfFacesAreSharedByTheTrianglesOfAPolygon)
{
    test::write_bytes(directory_ / "t.ply", triangle);
    EXPECT_EQ(read_face_scalar(directory_ / "t.ply", "heat"), Eigen::VectorXd::Constant(1, 4.0));
    test::write_bytes(directory_ / "q.ply",
                      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                      "property float y\nproperty float z\nelement face 2\nproperty short part\n"
                      "property list uchar int vertex_indices\nend_header\n"
                      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n-7 4 0 1 2 3\n5 3 0 2 1\n");
    EXPECT_EQ(read_face_scalar(directory_ / "q.ply", "part"), Eigen::Vector3d(-7, -7, 5));
    for (const char* name : {"x", "vertex_indices", "heat"})
        EXPECT_NE(test::message_of<InvalidInput>([&] {
                      (void)read_face_scalar(directory_ / "q.ply", name);
                  }).find("face elements have no property"),
                  std::string::npos)
            << name;
}

TEST_F(VertexScalars, RefuseWhatNoFileCanHold)
{
    const Eigen::VectorXd good = Eigen::VectorXd::Zero(mesh_.points.rows());
    for (const char* name : {"", "x", "y", "z", "1st", "two words", "a-b", "naïve", "a\nb"})
        EXPECT_NE(writing({{name, good}}).find("name"), std::string::npos) << name;
    EXPECT_NE(writing({{"a", good}, {"a", good}}).find("once"), std::string::npos);
    EXPECT_NE(writing({{"a", good.head(3)}}).find("has 3 values"), std::string::npos);
    Eigen::VectorXd bad = good;
    bad[5] = std::numeric_limits<double>::infinity();
    EXPECT_NE(writing({{"a", bad}}).find("value 5"), std::string::npos);
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  write_vertex_scalars(directory_ / "x.ply", mesh_.points,
                                       mesh_.topology.faces().array() + 1, {});
              }).find("faces: row"),
              std::string::npos);
    EXPECT_TRUE(directory_.names().empty());
    EXPECT_THROW(
        write_vertex_scalars(directory_ / "no" / "x.ply", mesh_.points, mesh_.topology.faces(), {}),
        FileError);
}

TEST_F(VertexScalars, ThatAreNotThereAreNotRead)
{
    test::write_bytes(directory_ / "t.ply", triangle);
    for (const char* name : {"cold", "near", "", "vertex_indices"})
        EXPECT_NE(reading("t.ply", name).find("; they have x, y, heat and z"), std::string::npos)
            << name;
    EXPECT_NE(reading("t.obj", "heat").find("PLY files alone"), std::string::npos);
    EXPECT_THROW((void)read_vertex_scalar(directory_ / "no.ply", "heat"), FileError);
    write_vertex_scalars(directory_ / "nan.ply", mesh_.points, mesh_.topology.faces(),
                         {{"heat", Eigen::VectorXd::Zero(mesh_.points.rows())}});
    std::string bytes = test::read_bytes(directory_ / "nan.ply");
    const std::size_t heat_of_second = bytes.find("end_header\n") + 11 + 40 + 24; // quality too
    bytes.replace(heat_of_second, 8, std::string("\0\0\0\0\0\0\xf8\x7f", 8));
    test::write_bytes(directory_ / "nan.ply", bytes);
    EXPECT_NE(reading("nan.ply", "heat").find("vertex 1 is not finite"), std::string::npos);
    EXPECT_TRUE(std::isnan(read_vertex_scalar_with_gaps(directory_ / "nan.ply", "heat")[1]));
    std::string text = triangle;
    text.replace(text.find("1 0 8"), 5, "1 0 nan"); // x, y, heat
    text.replace(text.find("uchar heat"), 10, "float heat");
    test::write_bytes(directory_ / "text.ply", text);
    EXPECT_NE(reading("text.ply", "heat").find("property 'heat' of vertex 1 is 'nan'"),
              std::string::npos);
    EXPECT_NO_THROW((void)read_mesh(directory_ / "nan.ply"));
}

} // namespace
} // namespace shape
