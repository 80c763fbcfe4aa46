// SPDX-License-Identifier: MIT

#include "libshape/model/group_means.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "tests/support/collections.h"

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

TEST(GroupShapes, RefusesWhatBreaksARule)
{
    const Collection collection = test::bumpy_spheres(5, 4);
    EXPECT_THROW((void)group_shapes(collection, one_group(4)), InvalidInput);
    EXPECT_THROW((void)group_shapes(collection, {{"a", "b"}, {0, 0, 0, 0, 0}}), InvalidInput);
    const GroupedShapes shapes = group_shapes(collection, two_groups());
    EXPECT_THROW((void)mean_shape(shapes, 2), InvalidInput);
    EXPECT_THROW((void)mean_shape(shapes, -1), InvalidInput);
}

} // namespace
} // namespace shape
