// SPDX-License-Identifier: MIT

#include "libshape/model/unlike_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "libshape/base/format.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/collections.h"
#include "tests/support/meshes.h"
#include "tests/support/seams.h"

namespace shape {
using namespace internal;
namespace {

RowMatrix marks_of(const Collection& known, const Collection& meshes)
{
    const ShapeModel model = fit_model(known);
    return unlike_meshes(known_meshes(model), meshes, project(model, meshes).sizes);
}

/// A sphere in these sizes.
Collection scaled_spheres(const std::vector<double>& scales)
{
    const test::TestMesh mesh = test::bumpy_sphere(1, 0.3, 1);
    Collection spheres{mesh.topology, {}, {}, {}};
    for (const double scale : scales) {
        spheres.names.push_back(std::to_string(spheres.names.size()));
        spheres.points.emplace_back(scale * mesh.points);
    }
    return spheres;
}

/// Open ones, whose handedness their dihedral angles tell.
Collection patches(unsigned count)
{
    Collection known{test::open_patch(8, 1).topology, {}, {}, {}};
    for (unsigned seed = 1; seed <= count; ++seed) {
        known.names.push_back(std::to_string(seed));
        known.points.push_back(test::open_patch(8, seed).points);
    }
    return known;
}

TEST(UnlikeMeshes, AreMirrorImagesAndThoseOfAnotherUnit)
{
    const Collection known = test::bumpy_spheres(6, 1);
    Collection meshes = test::moved(known, 2);
    EXPECT_EQ(marks_of(known, meshes), RowMatrix::Zero(6, 2));
    meshes.points[1].col(0) *= -1.0;
    meshes.points[2] *= 1000.0;
    meshes.points[3] *= 0.001;
    const ShapeModel model = fit_model(known);
    const Eigen::VectorXd ratios = project(model, meshes).sizes / known_meshes(model).usual_size;
    RowMatrix expected = RowMatrix::Zero(6, 2);
    expected(1, 0) = 1.0;
    expected(2, 1) = ratios[2];
    expected(3, 1) = ratios[3];
    EXPECT_EQ(marks_of(known, meshes), expected);
    EXPECT_NEAR(std::log10(ratios[2]), 3.0, 0.7);
}

TEST(UnlikeMeshes, SheetsMayAsWellBendTheOtherWay)
{
    Collection known = patches(6);
    for (Points& points : known.points)
        points.col(2) *= 0.1;
    Collection meshes = test::moved(known, 2);
    EXPECT_EQ(marks_of(known, meshes), RowMatrix::Zero(6, 2));
    for (Points& points : meshes.points)
        points.col(0) *= -1.0;
    EXPECT_EQ(marks_of(known, meshes).col(0), Eigen::VectorXd::Constant(6, 2.0));
}

TEST(UnlikeMeshes, FarOnesHaveExchangedVerticesAndNotAnotherKindOfShape)
{
    // A sphere whose bumps grow; meshes four times as far along that line as any of the model's are of no kind.
    const test::TestMesh plain = test::icosphere(2);
    const auto family = [&](const std::vector<double>& amounts) {
        Collection meshes{plain.topology, {}, {}, {}};
        for (const double amount : amounts) {
            meshes.names.push_back(std::to_string(meshes.names.size()));
            const auto seed = static_cast<unsigned>(meshes.names.size());
            meshes.points.push_back(
                plain.points + amount * (test::bumpy_sphere(2, 0.1, 99).points - plain.points) +
                0.02 * (test::bumpy_sphere(2, 0.1, seed).points - plain.points));
        }
        return meshes;
    };
    const Collection known = family({-1.0, -0.5, 0.0, 0.5, 1.0});
    Collection meshes = family({-1.0, 0.2, 3.0, 6.0, 0.0});
    meshes.points[4].row(3).swap(meshes.points[4].row(120));
    for (const int modes : {0, 1}) { // what the modes leave counts as well
        const ShapeModel model = fit_model(known, {.modes = modes});
        const Eigen::VectorXd times = far_meshes(model, project(model, meshes));
        EXPECT_EQ(times.head(3), Eigen::Vector3d::Zero());
        EXPECT_NEAR(times[3], 6.5, 1.0);
        EXPECT_GT(times[4], 4.0);
        EXPECT_EQ(far_meshes(model, project(model, known)), Eigen::VectorXd::Zero(5));
    }
    const ShapeModel few = fit_model(subset(known, {0, 1, 2, 3}));
    EXPECT_EQ(far_meshes(few, project(few, meshes)), Eigen::VectorXd::Zero(5));
}

TEST(UnlikeMeshes, AreFoundAmongOpenOnesToo)
{
    const Collection known = patches(4);
    Collection meshes = test::moved(known, 5);
    EXPECT_EQ(marks_of(known, meshes), RowMatrix::Zero(4, 2));
    for (Points& points : meshes.points) // all of them: there is no majority to tell by
        points.col(1) *= -1.0;
    // Such sheets may bend the other way as well.
    EXPECT_EQ(marks_of(known, meshes).col(0), Eigen::VectorXd::Constant(4, 2.0));
}

TEST(UnlikeMeshes, AreComparedWithTheMeanOfOpenOnes)
{
    Collection known = patches(6);
    known.points.front().col(2) *= 0.01; // nearly flat: it tells little
    const KnownMeshes all = known_meshes(fit_model(known));
    EXPECT_EQ(all.reference_points, known.points.front());
    const Collection one{known.topology, {"m"}, {test::mirror_image(known.points[3])}, {}};
    const Eigen::VectorXd size = Eigen::VectorXd::Constant(1, all.usual_size);
    EXPECT_EQ(unlike_meshes(all, one, size)(0, 0), 2.0);
    KnownMeshes first = all;
    first.reference_points.col(2).setZero();
    EXPECT_EQ(unlike_meshes(first, one, size)(0, 0), 2.0);
    first.dihedral_angles.resize(0); // a flat sheet says nothing
    EXPECT_EQ(unlike_meshes(first, one, size)(0, 0), 0.0);
}

TEST(UnlikeMeshes, MembranesMayDomeTheOtherWay)
{
    // Domes of a strain of 2 rad, which do not lie flat.
    const test::TestMesh sheet = test::open_patch(14, 1);
    Collection known{sheet.topology, {}, {}, {}};
    const auto dome = [&](double height) {
        Points points = sheet.points;
        for (auto point : points.rowwise())
            point[2] = height * std::exp(-3.0 * point.head<2>().squaredNorm());
        return points;
    };
    for (const double height : {0.6, -0.4, 0.5, 0.2, -0.1, 0.3}) {
        known.names.push_back(join("m", known.size()));
        known.points.push_back(dome(height));
    }
    const Collection one{known.topology, {"m"}, {dome(-0.5)}, {}};
    EXPECT_EQ(marks_of(known, one)(0, 0), 2.0);
    const KnownMeshes first = known_meshes(known); // without mean angles
    const Eigen::VectorXd size = Eigen::VectorXd::Constant(1, first.usual_size);
    EXPECT_EQ(unlike_meshes(first, one, size)(0, 0), 2.0);
}

TEST(UnlikeMeshes, SizesAreOddByFarOrByTheSpreadOfFiveAndMore)
{
    const auto check_factor = [](const std::vector<double>& scales, double factor) {
        const Collection spheres = scaled_spheres(scales);
        const double unit = edge_lengths(spheres.topology, spheres.points[0]).sum() / scales[0];
        const KnownMeshes known = known_meshes(spheres);
        const auto [least, largest] = std::minmax_element(scales.begin(), scales.end());
        EXPECT_NEAR(known.largest_size, factor * *largest * unit, 1e-9 * known.largest_size);
        EXPECT_NEAR(known.least_size, *least * unit / factor, 1e-9 * known.least_size);
        EXPECT_EQ(odd_size(known, 1.001 * known.largest_size),
                  1.001 * known.largest_size / known.usual_size);
        EXPECT_EQ(odd_size(known, 0.999 * known.least_size),
                  0.999 * known.least_size / known.usual_size);
        EXPECT_EQ(odd_size(known, 0.999 * known.largest_size), 0.0);
        EXPECT_EQ(odd_size(known, 1.001 * known.least_size), 0.0);
    };
    check_factor({1.0}, 5.0);
    check_factor({1.0, 1.01, 0.99, 1.0}, 5.0); // of four the spread is not known
    check_factor({1.0, 1.01, 0.99, 1.02, 0.98}, 2.0);
    check_factor({1.0, 1.1, 1.0 / 1.1, 1.2, 1.0 / 1.2}, std::pow(1.1, 14.826));
    check_factor({1.0, 2.0, 0.5, 3.0, 0.3}, 5.0);
}

TEST(UnlikeMeshes, OfADifferenceAreFarFromBothItsGroups)
{
    Collection spheres = scaled_spheres({1.0, 1.0, 3.0, 3.0});
    for (std::size_t i = 0; i < 4; ++i) // no two alike
        spheres.points[i].row(0) *= 1.0 + 0.01 * static_cast<double>(i);
    spheres.labels = {{"group", {"from", "from", "to", "to"}}};
    const DifferenceVector difference = mean_difference(
        spheres,
        {.from_label = "group", .from_value = "from", .to_label = "group", .to_value = "to"});
    const KnownMeshes known = known_meshes(difference);
    EXPECT_EQ(known.largest_size, 5.0 * difference.to_size);
    EXPECT_EQ(known.least_size, difference.from_size / 5.0);
    EXPECT_EQ(known.usual_size, 0.5 * (difference.from_size + difference.to_size));
    EXPECT_EQ(known.reference_points, difference.reference_points);
    EXPECT_EQ(known.dihedral_angles, difference.mean_dihedral_angles);
}

} // namespace
} // namespace shape
