// SPDX-License-Identifier: MIT

#include "libshape/statistics/covariate_blocks.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/block_slopes.h"

namespace shape {
using namespace internal;

using Eigen::Index;
using Eigen::MatrixXd;

BlockDesign block_design(const MatrixXd& covariates, const Grouping& blocks)
{
    if (blocks.size() != covariates.rows())
        throw InvalidInput(join("blocks are of ", blocks.size(), " observations, covariates of ",
                                covariates.rows()));
    const std::vector<std::vector<int>> lists = members(blocks);
    if (lists.size() < 2)
        return BlockDesign::Crossed;
    Index nested = -1;
    Index crossed = -1;
    for (Index c = 0; c < covariates.cols(); ++c) {
        const bool is_nested = std::all_of(lists.begin(), lists.end(), [&](const auto& block) {
            return std::all_of(block.begin(), block.end(), [&](int i) {
                return covariates(i, c) == covariates(block.front(), c);
            });
        });
        (is_nested ? nested : crossed) = c;
    }
    if (nested >= 0 && crossed >= 0)
        throw InvalidInput(join("covariate ", nested, " is the same within every block, covariate ",
                                crossed, " is not; regress on one of them at a time"));
    return nested >= 0 ? BlockDesign::Nested : BlockDesign::Crossed;
}

Grouping covariate_rows(const MatrixXd& covariates, const Grouping& blocks)
{
    if (block_design(covariates, blocks) == BlockDesign::Nested)
        return blocks;
    if (blocks.group_count() < 2)
        return groups_of_one(blocks.size());
    Grouping rows;
    std::map<std::pair<int, std::vector<double>>, int> numbers;
    for (Index i = 0; i < covariates.rows(); ++i) {
        std::vector<double> own(covariates.row(i).begin(), covariates.row(i).end());
        const auto [place, is_new] =
            numbers.try_emplace({blocks.group_of[to_size(i)], std::move(own)}, rows.group_count());
        if (is_new)
            rows.names.push_back(std::to_string(place->second));
        rows.group_of.push_back(place->second);
    }
    return rows;
}

MatrixXd mean_weights(const Grouping& blocks)
{
    const std::vector<std::vector<int>> lists = members(blocks);
    MatrixXd weights = MatrixXd::Zero(blocks.size(), blocks.group_count());
    for (std::size_t b = 0; b < lists.size(); ++b)
        weights(lists[b], static_cast<Index>(b))
            .setConstant(1.0 / static_cast<double>(lists[b].size()));
    return weights;
}

ExchangeableRows exchangeable_rows(const MatrixXd& products, const MatrixXd& covariates,
                                   const Grouping& blocks)
{
    const BlockDesign design = block_design(covariates, blocks);
    const Grouping rows = covariate_rows(covariates, blocks);
    if (design == BlockDesign::Crossed && rows.group_count() == blocks.size())
        return {design, products, covariates, blocks};
    const Eigen::SparseMatrix<double> weights = mean_weights(rows).sparseView();
    std::vector<int> firsts;
    for (const std::vector<int>& row : members(rows))
        firsts.push_back(row.front());
    return {design, weights.transpose() * products * weights, weights.transpose() * covariates,
            design == BlockDesign::Nested ? one_group(weights.cols()) : subset(blocks, firsts)};
}

bool compares_slopes(const ExchangeableRows& rows)
{
    const std::vector<std::vector<int>> blocks = members(rows.blocks);
    const auto has_more_than = [&](std::size_t count) {
        return std::count_if(blocks.begin(), blocks.end(),
                             [&](const std::vector<int>& block) { return block.size() > count; });
    };
    return rows.design == BlockDesign::Crossed && has_more_than(1) > 1 && has_more_than(2) > 0;
}

LinearModelTest test_covariates(const ExchangeableRows& rows, const MatrixXd& tested,
                                const MatrixXd& nuisance, const PermutationOptions& options)
{
    return compares_slopes(rows)
               ? test_slopes(rows.products, tested, nuisance, rows.blocks, options)
               : test_linear_model(rows.products, tested, nuisance, rows.blocks, options);
}

} // namespace shape
