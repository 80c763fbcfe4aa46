// SPDX-License-Identifier: MIT

#include "libshape/registration/scan.h"

#include <gtest/gtest.h>

#include <limits>

#include "libshape/base/error.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace shape::test {
namespace {

TEST(CleanScan, KeepsASoundMeshAsItIs)
{
    const TestMesh mesh = icosphere(1);
    const Scan scan = clean_scan(mesh.points, mesh.topology.faces());
    EXPECT_EQ(scan.points, mesh.points);
    EXPECT_EQ(scan.faces, mesh.topology.faces());
    EXPECT_TRUE(scan.ignored.empty());
}

TEST(CleanScan, LeavesOutWhatIsNotASurfaceAndSaysSo)
{
    Points points(7, 3);
    points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 5, 5, 5, 0, 0, 0;
    points(6, 0) = std::numeric_limits<double>::quiet_NaN();
    Faces faces(5, 3);
    faces << 0, 1, 2, 3, 4, 2, 2, 0, 1, 0, 1, 3, 0, 1, 6; // 3 is at 1; the third is the first again
    const Scan scan = clean_scan(points, faces);
    EXPECT_EQ(scan.points.rows(), 4);
    Faces kept(2, 3);
    kept << 0, 1, 2, 1, 3, 2;
    EXPECT_EQ(scan.faces, kept);
    const std::vector<std::string> said{"1 vertex with a coordinate that is not finite",
                                        "1 face without area", "1 face that occur twice",
                                        "1 vertex without a face",
                                        "1 vertex at the place of another one (merged)"};
    EXPECT_EQ(scan.ignored, said);
}

TEST(CleanScan, RefusesWhatHasNoSurface)
{
    EXPECT_NE(message_of<InvalidInput>([] {
                  (void)clean_scan(Points(3, 3), Faces(0, 3));
              }).find("has no face"),
              std::string::npos);
    Faces outside(1, 3);
    outside << 0, 1, 9;
    EXPECT_NE(message_of<InvalidInput>([&] {
                  (void)clean_scan(Points::Zero(3, 3), outside);
              }).find("face 0 names a vertex"),
              std::string::npos);
    Faces flat(1, 3);
    flat << 0, 1, 2;
    EXPECT_NE(message_of<InvalidInput>([&] {
                  (void)clean_scan(Points::Zero(3, 3), flat);
              }).find("no face with an area"),
              std::string::npos);
}

} // namespace
} // namespace shape::test
