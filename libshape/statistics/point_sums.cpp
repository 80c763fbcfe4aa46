// SPDX-License-Identifier: MIT

#include "libshape/statistics/point_sums.h"

#include <algorithm>
#include <numeric>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::size_t grain = 16; ///< Members that share one product of matrices, which is quicker.

/// The weights of members [begin, end), N rows, side by side.
MatrixXd weights_of(const SumFamily& family, Index points, Index begin, Index end)
{
    const Index width = family.width();
    MatrixXd weights = MatrixXd::Zero(points, width * (end - begin));
    const SumFamily::Fill fill = family.prepare(begin, end);
    Index left = 0;
    for (std::size_t set = 0; set < family.columns.size(); ++set) {
        const SumColumns& columns = family.columns[set];
        RowMatrix part(static_cast<Index>(columns.support.size()), columns.width);
        for (Index member = begin; member < end; ++member) {
            fill(member, set, 0, part);
            weights.middleCols((member - begin) * width + left, columns.width)(columns.support,
                                                                               Eigen::all) = part;
        }
        left += columns.width;
    }
    return weights;
}

std::vector<MatrixXd> products_of_sums(const MatrixXd& products, const SumFamily& family)
{
    std::vector<MatrixXd> result(to_size(family.members));
    const Index width = family.width();
    parallel_for(result.size(), grain, [&](std::size_t begin, std::size_t end) {
        const MatrixXd weights =
            weights_of(family, products.rows(), static_cast<Index>(begin), static_cast<Index>(end));
        const MatrixXd images = products * weights;
        for (std::size_t member = begin; member < end; ++member) {
            const Index left = static_cast<Index>(member - begin) * width;
            result[member] =
                weights.middleCols(left, width).transpose() * images.middleCols(left, width);
        }
    });
    return result;
}

/// Inner products of points and references, N by K, and of references.
struct ReferenceProducts
{
    MatrixXd with_points;
    MatrixXd own;

    ReferenceProducts(const MatrixXd& products, const MatrixXd& weights)
    {
        if (weights.cols() == 0)
            return;
        with_points = products * weights;
        own = weights.transpose() * with_points;
    }
};

Eigen::VectorXd squares_of_parts(const MatrixXd& products, const PartSums& parts,
                                 const ReferenceProducts& references)
{
    std::vector<std::vector<int>> members(to_size(parts.parts)); // numbers of points
    for (std::size_t i = 0; i < parts.points.size(); ++i)
        members[to_size(parts.part_of[i])].push_back(static_cast<int>(i));
    Eigen::VectorXd squares(parts.parts);
    parallel_for(members.size(), 1, [&](std::size_t part, std::size_t) {
        double sum = 0.0;
        for (const int i : members[part]) {
            double row = 0.0;
            for (const int j : members[part])
                row +=
                    parts.weights[j] * products(parts.points[to_size(j)], parts.points[to_size(i)]);
            sum += parts.weights[i] * row;
        }
        const auto number = static_cast<Index>(part);
        if (parts.taken.cols() > 0) {
            const Eigen::RowVectorXd taken = parts.taken.row(number);
            for (const int i : members[part])
                sum -= 2.0 * parts.weights[i] *
                       references.with_points.row(parts.points[to_size(i)]).dot(taken);
            sum = std::max(sum + (taken * references.own).dot(taken), 0.0);
        }
        squares[number] = sum;
    });
    return squares;
}

/// Squared distances of points from the mean of their group; 0 of a single one.
Eigen::VectorXd squares_about_means(const MatrixXd& products, const Grouping& groups)
{
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(products.rows());
    for (const std::vector<int>& group : members(groups)) {
        const auto count = static_cast<double>(group.size());
        if (group.size() < 2)
            continue; // a single point is its mean
        const MatrixXd own = products(group, group);
        squares(group) = (own.diagonal() - 2.0 / count * own.rowwise().sum() +
                          Eigen::VectorXd::Constant(own.rows(), own.sum() / (count * count)))
                             .cwiseMax(0.0);
    }
    return squares;
}

} // namespace

Index SumFamily::width() const
{
    return std::accumulate(columns.begin(), columns.end(), Index{0},
                           [](Index sum, const SumColumns& c) { return sum + c.width; });
}

SumAnswers answer(const MatrixXd& products, const SumQuestions& questions)
{
    SumAnswers answers;
    answers.squares = products.diagonal();
    for (const SumFamily& family : questions.families)
        answers.families.push_back(products_of_sums(products, family));
    const ReferenceProducts references(products, questions.references);
    for (const PartSums& parts : questions.parts)
        answers.parts.push_back(squares_of_parts(products, parts, references));
    if (questions.groups)
        answers.squares_about_means = squares_about_means(products, *questions.groups);
    return answers;
}

} // namespace shape::internal
