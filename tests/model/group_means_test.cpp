// SPDX-License-Identifier: MIT

#include "libshape/model/group_means.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "libshape/base/error.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"

namespace shape {
namespace {

const Grouping& two_groups()
{
    static const Grouping grouping = group_by({"a", "b", "a", "a", "b"});
    return grouping;
}

TEST(GroupShapes, AveragesLengthsAnglesAndSizesOfTheMembers)
{
    const Collection collection = test::bumpy_spheres(5, 1);
    const ShapeVectors v = shape_vectors(collection, Scale::Unit);
    const GroupedShapes shapes = group_shapes(collection, two_groups());
    EXPECT_NEAR(shapes.mean_sizes[1], 0.5 * (v.sizes[1] + v.sizes[4]), 1e-13);
    const auto mean = std::get<ShapePoint>(mean_shape(shapes, 1));
    const Eigen::RowVectorXd lengths =
        0.5 * shapes.mean_sizes[1] * (v.edge_lengths.row(1) + v.edge_lengths.row(4));
    EXPECT_LE((mean.edge_lengths.transpose() - lengths).norm(), 1e-14 * lengths.norm());
    EXPECT_LE((mean.dihedral_angles.transpose() -
               0.5 * (v.dihedral_angles.row(1) + v.dihedral_angles.row(4)))
                  .norm(),
              1e-13);
    EXPECT_NEAR(mean.edge_lengths.sum(), shapes.mean_sizes[1], 1e-12);
}

TEST(GroupShapes, HasTheDistancesOfTheMeshesInItsProducts)
{
    const Collection collection = test::bumpy_spheres(5, 2);
    const ShapeVectors v = shape_vectors(collection, Scale::Unit);
    const GroupedShapes shapes = group_shapes(collection, two_groups());
    const Eigen::MatrixXd& g = shapes.products;
    EXPECT_NEAR(std::sqrt(g(0, 0) + g(3, 3) - 2.0 * g(0, 3)),
                (v.edge_lengths.row(0) - v.edge_lengths.row(3)).norm(), 1e-14);
}

TEST(GroupShapes, HasMeshesAsMeansInProcrustesSpace)
{
    const Collection collection = test::bumpy_spheres(5, 3);
    const GroupedShapes shapes =
        group_shapes(collection, two_groups(), {.kind = SpaceKind::Procrustes});
    EXPECT_EQ(std::get<Points>(mean_shape(shapes, 0)).rows(), collection.topology.vertex_count());
}

TEST(GroupShapes, AveragesBlocksFirst)
{
    // Three scans of one member of a, and one of another.
    const Collection collection = test::bumpy_spheres(6, 5);
    const ShapeVectors v = shape_vectors(collection, Scale::Unit);
    const Grouping sexes = group_by({"a", "b", "a", "a", "b", "a"});
    const Grouping people = group_by({"1", "2", "1", "1", "3", "4"});
    const GroupedShapes shapes = group_shapes(collection, sexes, {}, people);
    Eigen::VectorXd weights(6);
    weights << 1.0 / 6.0, 0.0, 1.0 / 6.0, 1.0 / 6.0, 0.0, 0.5;
    EXPECT_NEAR(shapes.mean_sizes[0], weights.dot(v.sizes), 1e-13);
    EXPECT_LE((shapes.means.row(0) - weights.transpose() * v.edge_lengths).norm(), 1e-15);
    const auto mean = std::get<ShapePoint>(mean_shape(shapes, 0));
    EXPECT_LE((mean.dihedral_angles.transpose() - weights.transpose() * v.dihedral_angles).norm(),
              1e-13);
    const GroupedShapes plain = group_shapes(collection, sexes);
    EXPECT_EQ(plain.means, group_shapes(collection, sexes, {}, groups_of_one(6)).means);
    EXPECT_GT((plain.means - shapes.means).norm(), 1e-4);
}

TEST(GroupShapes, AreAdjustedForCovariates)
{
    // Sizes of the groups are the same once they are adjusted for size.
    const Collection collection = test::bumpy_spheres(9, 6);
    const Grouping groups = group_by({"a", "a", "b", "a", "b", "b", "a", "b", "b"});
    const GroupedShapes shapes =
        group_shapes(collection, groups, {}, groups_of_one(9),
                     [](const Eigen::VectorXd& sizes) -> Eigen::MatrixXd { return sizes; });
    const double mean_size = shapes.sizes.mean();
    EXPECT_NEAR(shapes.covariate_means[0], mean_size, 1e-12 * mean_size);
    for (const int group : {0, 1})
        EXPECT_NEAR(shapes.mean_sizes[group], mean_size, 1e-11 * mean_size);
    const RowMatrix data = shape_vectors(collection, Scale::Unit).edge_lengths;
    Eigen::MatrixXd columns(9, 3);
    columns << indicators(groups), shapes.sizes.array() - mean_size;
    const Eigen::MatrixXd fitted =
        columns.completeOrthogonalDecomposition().solve(Eigen::MatrixXd(data));
    EXPECT_LE((shapes.means - fitted.topRows(2)).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_NEAR(std::get<ShapePoint>(mean_shape(shapes, 0)).edge_lengths.sum(), mean_size,
                1e-11 * mean_size);
    // A covariate that is another one in each group leaves no slope to adjust by.
    const GroupedShapes open = group_shapes(
        collection, groups, {}, groups_of_one(9),
        [&](const Eigen::VectorXd&) { return Eigen::MatrixXd(indicators(groups).leftCols(1)); });
    EXPECT_EQ(open.products, shapes.products);
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)mean_shape(open, 1);
              }).find("cannot be adjusted for a covariate that does not vary"),
              std::string::npos);
}

TEST(GroupShapes, RefusesWhatBreaksARule)
{
    const Collection collection = test::bumpy_spheres(5, 4);
    EXPECT_THROW((void)group_shapes(collection, one_group(4)), InvalidInput);
    EXPECT_THROW((void)group_shapes(collection, two_groups(), {}, one_group(4)), InvalidInput);
    EXPECT_THROW((void)group_shapes(collection, {{"a", "b"}, {0, 0, 0, 0, 0}}), InvalidInput);
    const GroupedShapes shapes = group_shapes(collection, two_groups());
    EXPECT_THROW((void)mean_shape(shapes, 2), InvalidInput);
    EXPECT_THROW((void)mean_shape(shapes, -1), InvalidInput);
}

} // namespace
} // namespace shape
