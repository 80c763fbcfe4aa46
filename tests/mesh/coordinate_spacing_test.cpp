// SPDX-License-Identifier: MIT

#include "libshape/mesh/coordinate_spacing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

/// A sphere around a place as scanners have it: the largest coordinate is between 512 and 1000.
Points sphere()
{
    return (8.0 * test::bumpy_sphere(2, 0.1, 1).points).rowwise() +
           Eigen::RowVector3d(150.0, -220.0, 900.0);
}

Points printed(Points points, const char* format)
{
    for (double& x : points.reshaped()) {
        char text[64];
        std::snprintf(text, sizeof text, format, x);
        x = std::strtod(text, nullptr);
    }
    return points;
}

TEST(CoordinateSpacing, IsThatOfTheFormatThatHoldsAll)
{
    EXPECT_EQ(coordinate_spacing(sphere()), std::ldexp(1.0, -43));
    EXPECT_EQ(coordinate_spacing(sphere().cast<float>().cast<double>()), std::ldexp(1.0, -14));
    EXPECT_NEAR(coordinate_spacing(printed(sphere(), "%.4f")), 1e-4, 1e-12);
    EXPECT_NEAR(coordinate_spacing(printed(sphere(), "%.6g")), 1e-3, 1e-12);
    EXPECT_NEAR(coordinate_spacing(printed(sphere(), "%.6e")), 1e-4, 1e-12);
    EXPECT_NEAR(coordinate_spacing(1e-9 * printed(sphere(), "%.6g")), 1e-12, 1e-20);
    // Text of seven digits that became single precision is no coarser than that.
    EXPECT_NEAR(coordinate_spacing(printed(sphere(), "%.5g").cast<float>().cast<double>()), 1e-2,
                1e-10);
    EXPECT_EQ(coordinate_spacing(printed(sphere(), "%.7g").cast<float>().cast<double>()),
              std::ldexp(1.0, -14));
}

TEST(CoordinateSpacing, OneFineNumberTellsAndWhatIsRoundingDoesNot)
{
    Points points = printed(sphere(), "%.4f");
    points(40, 1) = 1.2345678901234e-13;
    EXPECT_NEAR(coordinate_spacing(points), 1e-4, 1e-12);
    points(40, 1) = 1.0 / 3.0;
    EXPECT_EQ(coordinate_spacing(points), std::ldexp(1.0, -43));
}

TEST(CoordinateSpacing, SmallIntegersHaveFourDigitsAndNothingHasNone)
{
    EXPECT_NEAR(coordinate_spacing(test::tetrahedron().points), 1e-3, 1e-15);
    EXPECT_EQ(coordinate_spacing(Points::Zero(3, 3)), 0.0);
    EXPECT_EQ(coordinate_spacing(Points(0, 3)), 0.0);
}

/// Edges of about 0.3.
test::TestMesh ball()
{
    return test::bumpy_sphere(2, 0.1, 1);
}

Points rounded_to(Points points, double step)
{
    for (double& x : points.reshaped())
        x = std::round(x / step) * step;
    return points;
}

TEST(CoarseCoordinates, AreThoseOfSinglePrecisionFarFromTheOrigin)
{
    const test::TestMesh mesh = ball();
    const auto at = [&](double place) {
        const Points far = mesh.points.rowwise() + Eigen::RowVector3d(place, 1.1 * place, 30.0);
        return coarse_coordinates(mesh.topology.faces(), far.cast<float>().cast<double>());
    };
    EXPECT_FALSE(at(0.0));
    EXPECT_FALSE(at(1e4)); // steps of 0.001
    const auto found = at(8e5);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->step, 0.0625);
    EXPECT_NEAR(found->share, 0.2, 0.05);
    EXPECT_TRUE(found->is_single);
    EXPECT_TRUE(found->is_far);
    EXPECT_TRUE(describe(*found).starts_with("multiples of 0.0625, ")) << describe(*found);
    EXPECT_NE(describe(*found).find("single precision has no finer numbers"), std::string::npos);
    EXPECT_NE(describe(*found).find("relative to a local origin"), std::string::npos);
    // Double precision has its end, too.
    const Points far = mesh.points.array() + 1e14;
    ASSERT_TRUE(coarse_coordinates(mesh.topology.faces(), far));
    EXPECT_FALSE(coarse_coordinates(mesh.topology.faces(), far)->is_single);
    EXPECT_TRUE(coarse_coordinates(mesh.topology.faces(), far)->is_far);
}

TEST(CoarseCoordinates, AreThoseOfTooFewDigits)
{
    const test::TestMesh mesh = ball();
    const Faces& faces = mesh.topology.faces();
    EXPECT_FALSE(coarse_coordinates(faces, mesh.points));
    EXPECT_FALSE(coarse_coordinates(faces, printed(mesh.points, "%.3f")));
    for (const double size : {1.0, 1e-50, 1e40})
        for (const char* format : {"%.1f", "%.2f"}) {
            const auto found = coarse_coordinates(faces, size * printed(mesh.points, format));
            if (size == 1.0) {
                ASSERT_TRUE(found) << format;
                EXPECT_NEAR(found->step, format[2] == '1' ? 0.1 : 0.01, 1e-9);
                EXPECT_FALSE(found->is_far);
                EXPECT_NE(describe(*found).find("digits were cut off"), std::string::npos);
            }
        }
    EXPECT_TRUE(
        coarse_coordinates(faces, printed(mesh.points, "%.2f").cast<float>().cast<double>()));
    EXPECT_TRUE(coarse_coordinates(faces, printed(100.0 * mesh.points, "%.0f")));
    EXPECT_TRUE(coarse_coordinates(faces, rounded_to(mesh.points, 0.05)));
    EXPECT_TRUE(coarse_coordinates(faces, rounded_to(mesh.points, 0.0625)));
    // One axis is enough.
    Points points = mesh.points;
    points.col(1) = printed(mesh.points, "%.2f").col(1);
    EXPECT_TRUE(coarse_coordinates(faces, points));
    points.col(1) = rounded_to(mesh.points, 0.17).col(1); // two steps an edge
    EXPECT_TRUE(coarse_coordinates(faces, points));
}

TEST(CoarseCoordinates, AreNotThoseOfRastersAndOfFewVertices)
{
    EXPECT_FALSE(
        coarse_coordinates(test::tetrahedron().topology.faces(), test::tetrahedron().points));
    // A raster of heights, in steps of 30, 1.2 and 0.9765625.
    const test::TestMesh patch = test::open_patch(12, 1);
    for (const double step : {30.0, 1.2, 0.9765625, 1.0 / 3.0})
        for (const double origin : {0.0, 4e5}) {
            Points raster = patch.points;
            for (int v = 0; v < raster.rows(); ++v)
                raster.row(v) << origin + step * (v % 13), 2.0 * origin + step * (v / 13),
                    step * patch.points(v, 2);
            EXPECT_FALSE(coarse_coordinates(patch.topology.faces(), raster)) << step;
            if (step < 1.0)
                continue;
            // Heights that were rounded are rounded.
            Points rough = raster;
            rough.col(2) = rounded_to(raster, step / 12.0).col(2);
            EXPECT_TRUE(coarse_coordinates(patch.topology.faces(), rough)) << step;
        }
    // Slices are exact along one axis; numbers that have no finer steps are not, however coarse.
    Points slices = patch.points;
    for (int v = 0; v < slices.rows(); ++v)
        slices(v, 1) = 0.3 * (v / 13);
    EXPECT_FALSE(coarse_coordinates(patch.topology.faces(), slices));
    const test::TestMesh fine = test::icosphere(3);
    Points far = fine.points;
    far.col(0).array() += 3.2e6; // edges of 0.15, steps of 0.25
    far = far.cast<float>().cast<double>().eval();
    const auto along_x = coarse_coordinates(fine.topology.faces(), far);
    ASSERT_TRUE(along_x);
    EXPECT_EQ(along_x->step, 0.25);
    EXPECT_TRUE(along_x->is_far);
    // The surface of voxels, of half-integers in units of 0.6.
    Points voxels = patch.points;
    for (int v = 0; v < voxels.rows(); ++v)
        voxels.row(v) << 0.6 * (v % 13), 0.6 * (v / 13), 0.3 * ((v * v) % 3);
    EXPECT_FALSE(coarse_coordinates(patch.topology.faces(), voxels));
    EXPECT_TRUE(coarse_coordinates(patch.topology.faces(), voxels, false));
}

} // namespace
} // namespace shape
