// SPDX-License-Identifier: MIT

#include "libshape/statistics/column_effects.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/student_t.h"

namespace shape {
using namespace internal;
namespace {

void check(const char* name, const RowMatrix& sample)
{
    if (sample.rows() < 2)
        throw InvalidInput(
            join(name, " has ", sample.rows(), " observations, an effect needs two or more"));
    if (!sample.allFinite())
        throw InvalidInput(join(name, " has a value that is not finite"));
}

void check(const RowMatrix& first, const RowMatrix& second)
{
    check("first", first);
    check("second", second);
    if (first.cols() != second.cols())
        throw InvalidInput(join("first has ", first.cols(), " variables, second ", second.cols()));
}

/// Sum of squared deviations from the mean of each column.
Eigen::VectorXd scatter(const RowMatrix& sample, const Eigen::RowVectorXd& mean)
{
    return (sample.rowwise() - mean).colwise().squaredNorm();
}

/// The effect and p of each variable from its mean difference, the standard deviation that this is
/// divided by, and the t and its degrees of freedom that test(variable) gives.
template <class Test>
ColumnEffects effects(const RowMatrix& first, const RowMatrix& second, const Eigen::VectorXd& means,
                      const Eigen::VectorXd& deviations, const Test& test)
{
    const Eigen::Index count = means.size();
    ColumnEffects result{Eigen::VectorXd::Zero(count), Eigen::VectorXd::Ones(count), {}};
    for (Eigen::Index e = 0; e < count; ++e) {
        // Deviations and means below this are what rounding leaves of equal values (1e-16 each).
        const double limit = 1e-12 * std::max(first.col(e).cwiseAbs().maxCoeff(),
                                              second.col(e).cwiseAbs().maxCoeff());
        if (deviations[e] > limit) {
            const auto [t, degrees_of_freedom] = test(e);
            result.effects[e] = means[e] / deviations[e];
            result.probabilities[e] = two_sided_t_probability(t, degrees_of_freedom);
        } else if (std::abs(means[e]) > limit) {
            throw InvalidInput(join("variable ", e, " differs by ", means[e],
                                    " without any spread; its effect size has no value"));
        }
    }
    result.false_discovery_rates = benjamini_hochberg(result.probabilities);
    return result;
}

} // namespace

ColumnEffects paired_effects(const RowMatrix& first, const RowMatrix& second)
{
    check(first, second);
    if (first.rows() != second.rows())
        throw InvalidInput(join("first has ", first.rows(), " observations, second ", second.rows(),
                                "; pairs need as many"));
    const auto count = static_cast<double>(first.rows());
    const RowMatrix differences = second - first;
    const Eigen::RowVectorXd means = differences.colwise().mean();
    const Eigen::VectorXd deviations = (scatter(differences, means) / (count - 1.0)).cwiseSqrt();
    return effects(first, second, means, deviations, [&](Eigen::Index e) {
        return std::pair(means[e] / deviations[e] * std::sqrt(count), count - 1.0);
    });
}

ColumnEffects independent_effects(const RowMatrix& first, const RowMatrix& second)
{
    check(first, second);
    const auto n = static_cast<double>(first.rows());
    const auto m = static_cast<double>(second.rows());
    const Eigen::RowVectorXd first_means = first.colwise().mean();
    const Eigen::RowVectorXd second_means = second.colwise().mean();
    const Eigen::VectorXd means = second_means - first_means;
    const Eigen::VectorXd first_scatter = scatter(first, first_means);
    const Eigen::VectorXd second_scatter = scatter(second, second_means);
    const Eigen::VectorXd pooled = ((first_scatter + second_scatter) / (n + m - 2.0)).cwiseSqrt();
    return effects(first, second, means, pooled, [&](Eigen::Index e) {
        // Squared standard errors of both means.
        const double a = first_scatter[e] / (n - 1.0) / n;
        const double b = second_scatter[e] / (m - 1.0) / m;
        return std::pair(means[e] / std::sqrt(a + b),
                         (a + b) * (a + b) / (a * a / (n - 1.0) + b * b / (m - 1.0)));
    });
}

Eigen::VectorXd benjamini_hochberg(const Eigen::VectorXd& probabilities)
{
    const Eigen::Index count = probabilities.size();
    for (Eigen::Index i = 0; i < count; ++i)
        if (!(probabilities[i] >= 0.0 && probabilities[i] <= 1.0))
            throw InvalidInput(
                join("probabilities[", i, "] is ", probabilities[i], ", must be in [0, 1]"));
    std::vector<Eigen::Index> order(to_size(count));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
        return probabilities[a] < probabilities[b];
    });
    Eigen::VectorXd rates(count);
    double least = 1.0;
    for (Eigen::Index rank = count; rank > 0; --rank) {
        const Eigen::Index i = order[to_size(rank - 1)];
        least = std::min(least,
                         probabilities[i] * static_cast<double>(count) / static_cast<double>(rank));
        rates[i] = least;
    }
    return rates;
}

} // namespace shape
