// SPDX-License-Identifier: MIT

#include "libshape/statistics/group_spread.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/statistics/group_comparison.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Distances between points with these inner products.
MatrixXd distances_of(const MatrixXd& products)
{
    const VectorXd squares = products.diagonal();
    MatrixXd result = -products - products.transpose();
    result.colwise() += squares;
    result.rowwise() += squares.transpose();
    return result.cwiseMax(0.0).cwiseSqrt();
}

/// Groups of which every observation counts several times.
class WeightedGroups
{
public:
    WeightedGroups(const MatrixXd& products, const MatrixXd& indicators, const VectorXd& times)
        : counts_(indicators.transpose() * times),
          mean_weights_(times.asDiagonal() * indicators * counts_.cwiseInverse().asDiagonal()),
          squares_(indicators.transpose() * times.cwiseProduct(products.diagonal()))
    {
    }

    [[nodiscard]] bool all_have_members() const { return counts_.minCoeff() > 0.0; }

    /// The weights of column g make the mean of group g.
    [[nodiscard]] const MatrixXd& mean_weights() const { return mean_weights_; }

    [[nodiscard]] VectorXd variances(const MatrixXd& products_of_means) const
    {
        VectorXd result(counts_.size());
        for (Index g = 0; g < result.size(); ++g)
            result[g] = std::max(squares_[g] - counts_[g] * products_of_means(g, g), 0.0) /
                        std::max(counts_[g] - 1.0, 1.0);
        return result;
    }

private:
    VectorXd counts_;
    MatrixXd mean_weights_;
    VectorXd squares_;
};

} // namespace

GroupSpread group_spread(const MatrixXd& products, const Grouping& groups, const Grouping& blocks,
                         const BootstrapOptions& options)
{
    const Index count = products.rows();
    if (products.cols() != count || groups.size() != count || blocks.size() != count)
        throw InvalidInput(join("groups: inner products are ", count, " by ", products.cols(),
                                ", groups ", groups.size(), ", blocks ", blocks.size(),
                                "; all must agree"));
    const MatrixXd indicator = indicators(groups);
    const WeightedGroups measured(products, indicator, VectorXd::Ones(count));
    const MatrixXd& weights = measured.mean_weights();
    const MatrixXd products_of_means = weights.transpose() * products * weights;
    const VectorXd variances = measured.variances(products_of_means);

    const Index group_count = groups.group_count();
    const bool is_nested = block_design(groups, blocks) == BlockDesign::Nested;
    const RowMatrix replicates = bootstrap(
        {blocks, is_nested ? groups : one_group(count)},
        [&](const VectorXd& times) {
            const WeightedGroups drawn(products, indicator, times);
            VectorXd values(group_count + group_count * group_count);
            if (!drawn.all_have_members())
                return values.setConstant(std::numeric_limits<double>::quiet_NaN()).eval();
            const MatrixXd& drawn_weights = drawn.mean_weights();
            const MatrixXd moves = drawn_weights - weights;
            values.head(group_count) =
                drawn.variances(drawn_weights.transpose() * products * drawn_weights);
            values.tail(group_count * group_count) =
                distances_of(moves.transpose() * products * moves).reshaped();
            return values;
        },
        options);

    GroupSpread result;
    result.distances = distances_of(products_of_means);
    result.distance_radii = RowMatrix::Zero(group_count, group_count);
    for (Index g = 0; g < group_count; ++g) {
        result.variances.push_back(variances[g]);
        result.variance_intervals.push_back(
            percentile_interval(replicates.col(g), options.confidence));
        for (Index h = 0; h < g; ++h)
            result.distance_radii(g, h) = result.distance_radii(h, g) =
                quantile(replicates.col(group_count + g + h * group_count), options.confidence);
    }
    return result;
}

LinearModelTest test_spread(const Eigen::MatrixXd& products, const Grouping& groups,
                            const Grouping& blocks, const PermutationOptions& options)
{
    Eigen::VectorXd distances = Eigen::VectorXd::Zero(products.rows());
    for (const std::vector<int>& group : members(groups)) {
        const auto count = static_cast<double>(group.size());
        if (group.size() < 2)
            continue; // a single point is its mean
        const Eigen::MatrixXd own = products(group, group);
        const Eigen::VectorXd squares =
            own.diagonal() - 2.0 / count * own.rowwise().sum() +
            Eigen::VectorXd::Constant(own.rows(), own.sum() / (count * count));
        distances(group) = (count / (count - 1.0) * squares.cwiseMax(0.0)).cwiseSqrt();
    }
    distances.array() -= distances.mean();
    const Eigen::MatrixXd none(products.rows(), 0);
    return compare_groups(distances * distances.transpose(), groups, blocks, none, options).overall;
}

} // namespace shape
