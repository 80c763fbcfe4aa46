// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_effect.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "tests/support/collections.h"
#include "tests/support/folded.h"

namespace shape {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Two covariates of 24 meshes: one that is the same within triples, and one that is not.
MatrixXd covariates_of(const Eigen::VectorXd& sizes, Index which)
{
    MatrixXd columns(sizes.size(), 2);
    for (Index i = 0; i < sizes.size(); ++i)
        columns.row(i) << static_cast<double>(i / 3 * 5 % 7), sizes[i];
    return which < 0 ? columns : MatrixXd(columns.col(which));
}

Grouping triples(Index count)
{
    Grouping blocks;
    for (Index i = 0; i < count; ++i) {
        if (i % 3 == 0)
            blocks.names.push_back("block" + std::to_string(i / 3));
        blocks.group_of.push_back(static_cast<int>(i / 3));
    }
    return blocks;
}

/// Blocks in which the first covariate has values of several meshes.
Grouping pairs_and_fours(Index count)
{
    Grouping blocks = triples(count);
    for (int& block : blocks.group_of)
        block /= 2;
    blocks.names.resize(blocks.names.size() / 2);
    return blocks;
}

void expect_near(const auto& a, const auto& b, const char* what)
{
    ASSERT_EQ(a.rows(), b.rows()) << what;
    ASSERT_EQ(a.cols(), b.cols()) << what;
    if (b.size() > 0) {
        EXPECT_LE((a - b).cwiseAbs().maxCoeff(), 1e-9 * b.cwiseAbs().maxCoeff()) << what;
    }
}

TEST(StreamedEffect, IsThatOfTheCollectionInMemory)
{
    const Collection collection = test::folded_spheres(24);
    struct Design
    {
        Index which;
        Grouping blocks;
        BlockDesign expected;
    };
    for (const Design& design :
         {Design{-1, one_group(24), BlockDesign::Crossed},
          Design{0, triples(24), BlockDesign::Nested}, Design{1, triples(24), BlockDesign::Crossed},
          Design{0, pairs_and_fours(24), BlockDesign::Crossed}})
        for (const SpaceOptions& space : {SpaceOptions{}, SpaceOptions{.dihedral_weight = 0.3}}) {
            StreamedEffectOptions options;
            options.space = space;
            options.covariates = [&](const Eigen::VectorXd& sizes) {
                return covariates_of(sizes, design.which);
            };
            const StreamedEffect found =
                covariate_effect(stream_of(collection), design.blocks, options);
            const ShapeSpace made = make_space(collection, space);
            const MatrixXd covariates = covariates_of(sizes(made, collection), design.which);
            const CovariateEffect expected =
                covariate_effect(collection, made, covariates, design.blocks);
            EXPECT_TRUE(found.covariates == covariates);
            EXPECT_EQ(found.effect.design, design.expected);
            EXPECT_EQ(expected.design, design.expected);
            const Regression& a = found.effect.regression;
            const Regression& b = expected.regression;
            expect_near(a.mean, b.mean, "mean");
            expect_near(a.slopes, b.slopes, "slopes");
            expect_near(a.weights, b.weights, "weights");
            expect_near(a.covariate_means, b.covariate_means, "means of covariates");
            EXPECT_NEAR(a.r_squared, b.r_squared, 1e-10);
            expect_near(found.slope_norms, b.slopes.rowwise().norm(), "norms");
            expect_near(found.effect.scores, expected.scores, "scores");
            expect_near(found.effect.products, expected.products, "products");
            expect_near(found.effect.mean_dihedral_angles, expected.mean_dihedral_angles, "angles");
            expect_near(found.effect.slope_dihedral_angles, expected.slope_dihedral_angles,
                        "slopes of angles");
            options.with_shapes = false;
            const StreamedEffect figures =
                covariate_effect(stream_of(collection), design.blocks, options);
            EXPECT_EQ(figures.passes, 1);
            EXPECT_TRUE(figures.effect.scores == found.effect.scores);
        }
}

TEST(StreamedEffect, RefusesWhatTheOneInMemoryDoes)
{
    const Collection collection = test::bumpy_spheres(24, 1);
    StreamedEffectOptions options;
    EXPECT_THROW((void)covariate_effect(stream_of(collection), one_group(24), options),
                 InvalidInput); // no covariates
    options.covariates = [](const Eigen::VectorXd& sizes) { return covariates_of(sizes, -1); };
    EXPECT_THROW((void)covariate_effect(stream_of(collection), triples(24), options), InvalidInput);
    EXPECT_THROW((void)covariate_effect(stream_of(collection), one_group(23), options),
                 InvalidInput);
    options.covariates = [](const Eigen::VectorXd& sizes) {
        return MatrixXd(MatrixXd::Ones(sizes.size(), 1));
    };
    EXPECT_THROW((void)covariate_effect(stream_of(collection), one_group(24), options),
                 InvalidInput);
}

} // namespace
} // namespace shape
