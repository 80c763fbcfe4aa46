// SPDX-License-Identifier: MIT

#include "libshape/model/effect_weights.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/statistics/covariate_blocks.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// The weights do not depend on the observations, so these are zeros.
Regression regress_nothing(const MatrixXd& covariates)
{
    return regress(RowMatrix::Zero(covariates.rows(), 1), covariates);
}

} // namespace

MatrixXd with_blocks(const MatrixXd& covariates, const Grouping& blocks)
{
    const Index further = blocks.group_count() - 1;
    MatrixXd columns(covariates.rows(), covariates.cols() + further);
    columns << covariates, indicators(blocks).rightCols(further);
    return columns;
}

MatrixXd columns_of_rows(const MatrixXd& covariates, const Grouping& blocks, const Grouping& rows,
                         BlockDesign design)
{
    if (design == BlockDesign::Nested)
        return covariates;
    std::vector<int> firsts;
    for (const std::vector<int>& row : members(rows))
        firsts.push_back(row.front());
    return with_blocks(covariates, subset(blocks, firsts));
}

Regression head(Regression regression, Index count)
{
    regression.covariate_means.conservativeResize(count);
    regression.slopes.conservativeResize(count, Eigen::NoChange);
    regression.weights = regression.weights.leftCols(count).eval();
    return regression;
}

EffectWeights effect_weights(const MatrixXd& covariates, const Grouping& blocks)
{
    if (blocks.size() != covariates.rows())
        throw InvalidInput(
            join("covariates are of ", covariates.rows(), " meshes, blocks of ", blocks.size()));
    EffectWeights result;
    result.design = block_design(covariates, blocks);
    const Grouping rows = covariate_rows(covariates, blocks);
    const bool are_means = result.design == BlockDesign::Nested || rows.group_count() < rows.size();
    result.means = are_means ? mean_weights(rows) : MatrixXd(covariates.rows(), 0);
    const MatrixXd columns = are_means ? columns_of_rows(result.means.transpose() * covariates,
                                                         blocks, rows, result.design)
                                       : with_blocks(covariates, blocks);
    result.regression = regress_nothing(columns);
    result.weights = result.regression.weights;
    result.centred = columns.rowwise() - result.regression.covariate_means.transpose();
    if (are_means) {
        result.regression = head(std::move(result.regression), covariates.cols());
        result.regression.weights = result.means * result.regression.weights;
        result.shares = result.means.rowwise().mean();
    } else {
        result.regression = head(std::move(result.regression), covariates.cols());
        result.shares = Eigen::VectorXd::Constant(covariates.rows(),
                                                  1.0 / static_cast<double>(covariates.rows()));
    }
    return result;
}

double explained_share(const MatrixXd& products, const EffectWeights& weights)
{
    MatrixXd own = products;
    if (weights.means.cols() > 0)
        own = weights.means.transpose() * products * weights.means;
    const double total = own.trace() - own.sum() / static_cast<double>(own.rows());
    const MatrixXd slopes = weights.weights.transpose() * own * weights.weights;
    const double explained =
        (weights.centred.transpose() * weights.centred).cwiseProduct(slopes).sum();
    return total > 0.0 ? std::clamp(explained / total, 0.0, 1.0) : 0.0;
}

} // namespace shape::internal
