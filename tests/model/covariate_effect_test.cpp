// SPDX-License-Identifier: MIT

#include "libshape/model/covariate_effect.h"

#include <gtest/gtest.h>

#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "tests/support/collections.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int count = 7;

CovariateEffect effect_on(const Collection& collection, const MatrixXd& covariates,
                          const SpaceOptions& options = {},
                          const Grouping& blocks = one_group(count))
{
    return covariate_effect(collection, make_space(collection, options), covariates, blocks);
}

const MatrixXd ages{{1.0}, {2.0}, {4.0}, {5.0}, {7.0}, {8.0}, {15.0}};

/// The regression of shape vectors by the textbook formula for one covariate.
VectorXd slope_of(const RowMatrix& rows, const VectorXd& covariate)
{
    const VectorXd centred = covariate.array() - covariate.mean();
    return rows.transpose() * centred / centred.squaredNorm();
}

TEST(CovariateEffect, RegressesLengthsAndAnglesAlike)
{
    const Collection collection = test::bumpy_spheres(count, 1);
    const ShapeVectors v = shape_vectors(collection, Scale::Unit);
    const CovariateEffect effect = effect_on(collection, ages);
    const VectorXd lengths = slope_of(v.edge_lengths, ages.col(0));
    const VectorXd angles = slope_of(v.dihedral_angles, ages.col(0));
    EXPECT_LE((effect.regression.slopes.row(0).transpose() - lengths).norm(),
              1e-13 * lengths.norm());
    EXPECT_LE((effect.slope_dihedral_angles.row(0).transpose() - angles).norm(),
              1e-13 * angles.norm());
    const auto young =
        std::get<ShapePoint>(expected_shape(effect, VectorXd::Constant(1, 3.0), 10.0));
    const VectorXd expected = 10.0 * (v.edge_lengths.colwise().mean().transpose() - 3.0 * lengths);
    EXPECT_LE((young.edge_lengths - expected).norm(), 1e-13 * expected.norm());
    EXPECT_NEAR(young.edge_lengths.sum(), 10.0, 1e-12);
    EXPECT_LE(
        (young.dihedral_angles - (v.dihedral_angles.colwise().mean().transpose() - 3.0 * angles))
            .norm(),
        1e-12);
}

TEST(CovariateEffect, IsGoneOnceEveryMeshIsMovedToTheMean)
{
    const Collection collection = test::bumpy_spheres(count, 2);
    for (const SpaceOptions& options :
         {SpaceOptions{}, SpaceOptions{.scale = Scale::None},
          SpaceOptions{.coordinates = LengthCoordinates::Log, .dihedral_weight = 0.1}}) {
        const CovariateEffect effect = effect_on(collection, ages, options);
        RowMatrix lengths(count, collection.topology.edge_count());
        for (int i = 0; i < count; ++i) {
            const auto moved = std::get<ShapePoint>(
                move_along_slopes(effect, subset(collection, {to_size(i)}), ages.row(i),
                                  effect.regression.covariate_means));
            lengths.row(i) = moved.edge_lengths.transpose();
            if (options.scale == Scale::Unit)
                lengths.row(i) /= lengths.row(i).sum();
        }
        if (options.coordinates == LengthCoordinates::Plain)
            EXPECT_LE(slope_of(lengths, ages.col(0)).norm(),
                      1e-12 * effect.regression.slopes.norm());
        else
            EXPECT_LE(slope_of(lengths.array().log(), ages.col(0)).norm(),
                      0.2 * effect.regression.slopes.norm()); // sums are brought back to 1
    }
}

TEST(CovariateEffect, LeavesAMeshAloneThatStaysWhereItIs)
{
    const Collection collection = test::bumpy_spheres(count, 3);
    const ShapeVectors v = shape_vectors(collection, Scale::None);
    const CovariateEffect effect = effect_on(collection, ages);
    const auto same = std::get<ShapePoint>(
        move_along_slopes(effect, subset(collection, {4}), ages.row(4), ages.row(4)));
    EXPECT_LE((same.edge_lengths.transpose() - v.edge_lengths.row(4)).norm(), 1e-12);
    EXPECT_NEAR(same.edge_lengths.sum(), v.sizes[4], 1e-11);
}

TEST(CovariateEffect, WithinBlocksIsThatOfTheirDeviations)
{
    const Collection collection = test::bumpy_spheres(count, 4);
    const Grouping blocks = group_by({"x", "x", "x", "y", "y", "y", "y"});
    RowMatrix rows = shape_vectors(collection, Scale::Unit).edge_lengths;
    VectorXd covariate = ages.col(0);
    for (const auto& [first, size] : {std::pair{0, 3}, std::pair{3, 4}}) {
        covariate.segment(first, size).array() -= covariate.segment(first, size).mean();
        const Eigen::RowVectorXd mean = rows.middleRows(first, size).colwise().mean();
        rows.middleRows(first, size).rowwise() -= mean;
    }
    const CovariateEffect effect = effect_on(collection, ages, {}, blocks);
    ASSERT_EQ(effect.regression.slopes.rows(), 1);
    const VectorXd expected = slope_of(rows, covariate);
    EXPECT_LE((effect.regression.slopes.row(0).transpose() - expected).norm(),
              1e-12 * expected.norm());
}

TEST(CovariateEffect, WithinBlocksTakesTheMeanOfWhatHasOneValue)
{
    const Collection collection = test::bumpy_spheres(count, 6);
    const Grouping blocks = group_by({"x", "x", "x", "y", "y", "y", "y"});
    const MatrixXd age = (VectorXd(7) << 1, 1, 3, 2, 4, 4, 4).finished();
    const RowMatrix all = shape_vectors(collection, Scale::Unit).edge_lengths;
    const RowMatrix x = all.row(2) - 0.5 * (all.row(0) + all.row(1)); // in two years each
    const RowMatrix y = all.bottomRows(3).colwise().mean() - all.row(3);
    const CovariateEffect effect = effect_on(collection, age, {}, blocks);
    EXPECT_LE((effect.regression.slopes - 0.25 * (x + y)).norm(), 1e-12 * x.norm());
    EXPECT_NEAR(effect.regression.covariate_means[0], 2.5, 1e-15);
    const VectorXd weights{{-1.0 / 8, -1.0 / 8, 0.25, -0.25, 1.0 / 12, 1.0 / 12, 1.0 / 12}};
    EXPECT_LE((effect.regression.weights - weights).norm(), 1e-12);
}

TEST(CovariateEffect, RefusesWhatBreaksARule)
{
    const Collection collection = test::bumpy_spheres(count, 5);
    EXPECT_THROW((void)effect_on(collection, ages.topRows(5)), InvalidInput);
    EXPECT_THROW((void)effect_on(collection, MatrixXd::Ones(count, 1)), InvalidInput);
    EXPECT_THROW((void)effect_on(collection, ages, {}, one_group(4)), InvalidInput);
    const CovariateEffect effect = effect_on(collection, ages);
    const VectorXd one = VectorXd::Ones(1);
    const VectorXd nan = VectorXd::Constant(1, std::numeric_limits<double>::quiet_NaN());
    EXPECT_THROW((void)expected_shape(effect, VectorXd::Ones(2), 1.0), InvalidInput);
    EXPECT_THROW((void)expected_shape(effect, nan, 1.0), InvalidInput);
    EXPECT_THROW((void)expected_shape(effect, one, 0.0), InvalidInput);
    const Collection mesh = subset(collection, {0});
    EXPECT_NO_THROW((void)move_along_slopes(effect, mesh, one, one));
    EXPECT_THROW((void)move_along_slopes(effect, mesh, VectorXd::Ones(2), one), InvalidInput);
    EXPECT_THROW((void)move_along_slopes(effect, mesh, one, nan), InvalidInput);
    EXPECT_THROW((void)move_along_slopes(effect, collection, one, one), InvalidInput);
}

} // namespace
} // namespace shape
