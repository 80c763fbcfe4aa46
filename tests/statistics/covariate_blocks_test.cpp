// SPDX-License-Identifier: MIT

#include "libshape/statistics/covariate_blocks.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/statistics/inner_products.h"
#include "tests/support/files.h"

namespace shape {
using namespace internal;
namespace {

const Grouping three_blocks = group_by({"x", "x", "y", "y", "y", "z"});

Eigen::MatrixXd columns(std::initializer_list<double> a, std::initializer_list<double> b = {})
{
    Eigen::MatrixXd result(6, b.size() == 0 ? 1 : 2);
    std::copy(a.begin(), a.end(), result.col(0).begin());
    if (b.size() > 0)
        std::copy(b.begin(), b.end(), result.col(1).begin());
    return result;
}

TEST(CovariateBlocks, AreNestedIfTheCovariatesAreTheSameWithinThem)
{
    EXPECT_EQ(block_design(columns({1, 1, 2, 2, 2, 1}), three_blocks), BlockDesign::Nested);
    EXPECT_EQ(block_design(columns({1, 1, 2, 2, 3, 1}), three_blocks), BlockDesign::Crossed);
    EXPECT_EQ(block_design(columns({1, 2, 2, 2, 2, 1}, {0, 0, 0, 1, 1, 1}), three_blocks),
              BlockDesign::Crossed);
    EXPECT_EQ(block_design(columns({1, 2, 3, 4, 5, 6}), groups_of_one(6)), BlockDesign::Nested);
    EXPECT_EQ(block_design(columns({1, 2, 3, 4, 5, 6}), one_group(6)), BlockDesign::Crossed);
}

TEST(CovariateBlocks, RefuseCovariatesOfBothKinds)
{
    const std::string message = test::message_of<InvalidInput>([] {
        (void)block_design(columns({1, 1, 2, 2, 2, 1}, {0, 1, 0, 1, 0, 1}), three_blocks);
    });
    EXPECT_NE(message.find("covariate 0 is the same within every block, covariate 1 is not"),
              std::string::npos)
        << message;
    EXPECT_THROW((void)block_design(Eigen::MatrixXd(5, 1), three_blocks), InvalidInput);
}

TEST(CovariateBlocks, NestedRowsAreTheMeansOfTheBlocks)
{
    Random random(3);
    RowMatrix data(6, 4);
    for (double& x : data.reshaped())
        x = random.normal();
    const Eigen::MatrixXd age = columns({1, 1, 2, 2, 2, 5});
    const ExchangeableRows rows = exchangeable_rows(inner_products(data), age, three_blocks);
    EXPECT_EQ(rows.design, BlockDesign::Nested);
    RowMatrix means(3, 4);
    means.row(0) = data.topRows(2).colwise().mean();
    means.row(1) = data.middleRows(2, 3).colwise().mean();
    means.row(2) = data.row(5);
    EXPECT_TRUE(rows.products.isApprox(inner_products(means), 1e-12));
    EXPECT_TRUE(rows.covariates.isApprox(Eigen::Vector3d(1, 2, 5), 1e-12));
    EXPECT_EQ(rows.blocks.group_count(), 1);

    const Eigen::MatrixXd dose = columns({1, 2, 3, 4, 5, 6});
    const ExchangeableRows same = exchangeable_rows(inner_products(data), dose, three_blocks);
    EXPECT_EQ(same.products, inner_products(data));
    EXPECT_EQ(same.blocks.group_of, three_blocks.group_of);
}

TEST(CovariateBlocks, CrossedRowsAreTheMeansOfWhatBlocksHaveOfOneValue)
{
    Random random(4);
    RowMatrix data(6, 4);
    for (double& x : data.reshaped())
        x = random.normal();
    const Eigen::MatrixXd age = columns({1, 1, 2, 3, 2, 1});
    EXPECT_EQ(covariate_rows(age, three_blocks).group_of, (std::vector<int>{0, 0, 1, 2, 1, 3}));
    const ExchangeableRows rows = exchangeable_rows(inner_products(data), age, three_blocks);
    RowMatrix means(4, 4);
    means << data.topRows(2).colwise().mean(), 0.5 * (data.row(2) + data.row(4)), data.row(3),
        data.row(5);
    EXPECT_EQ(rows.design, BlockDesign::Crossed);
    EXPECT_TRUE(rows.products.isApprox(inner_products(means), 1e-12));
    EXPECT_TRUE(rows.covariates.isApprox(Eigen::Vector4d(1, 2, 3, 1), 1e-12));
    EXPECT_EQ(rows.blocks.group_of, (std::vector<int>{0, 1, 1, 2}));
    // In one block nothing says what is repeated.
    EXPECT_EQ(covariate_rows(age, one_group(6)).group_count(), 6);
    EXPECT_EQ(covariate_rows(columns({1, 1, 2, 2, 2, 1}), three_blocks).group_of,
              three_blocks.group_of);
}

/// Repeated measurements of people say no more than their means: chance stays chance.
TEST(CovariateBlocks, KeepTheLevelOfTestsOfRepeatedMeasurements)
{
    constexpr int people = 30;
    constexpr int scans = 4;
    Random random(11);
    int nested_rejections = 0;
    int plain_rejections = 0;
    for (int round = 0; round < 60; ++round) {
        RowMatrix data(people * scans, 5);
        Eigen::MatrixXd age(people * scans, 1);
        std::vector<std::string> person;
        for (int p = 0; p < people; ++p) {
            Eigen::RowVectorXd own(5);
            for (double& x : own)
                x = random.normal();
            const double years = random.normal();
            for (int s = 0; s < scans; ++s) {
                for (int k = 0; k < 5; ++k)
                    data(p * scans + s, k) = own[k] + 0.1 * random.normal();
                age(p * scans + s, 0) = years;
                person.push_back(std::to_string(p));
            }
        }
        const Eigen::MatrixXd products = centred_inner_products(data);
        const auto p_value = [&](const ExchangeableRows& rows) {
            return test_linear_model(rows.products, rows.covariates,
                                     Eigen::MatrixXd(rows.covariates.rows(), 0), rows.blocks,
                                     {.permutations = 99})
                .p_value;
        };
        nested_rejections += p_value(exchangeable_rows(products, age, group_by(person))) <= 0.05;
        plain_rejections +=
            p_value(exchangeable_rows(products, age, one_group(people * scans))) <= 0.05;
    }
    EXPECT_LE(nested_rejections, 9); // of 60 at 5 %: more with probability 0.001
    EXPECT_GE(plain_rejections, 20);
}

} // namespace
} // namespace shape
