// SPDX-License-Identifier: MIT

#include "libshape/statistics/covariate_blocks.h"

#include <algorithm>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

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
    if (design == BlockDesign::Crossed)
        return {design, products, covariates, blocks};
    const MatrixXd weights = mean_weights(blocks);
    return {design, weights.transpose() * products * weights, weights.transpose() * covariates,
            one_group(weights.cols())};
}

} // namespace shape
