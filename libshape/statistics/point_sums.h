// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "libshape/linalg/block_products.h"
#include "libshape/statistics/grouping.h"

// Tests, bootstraps and spreads ask nothing of N points but the inner products of weighted sums of them. Put
// as questions, they are answered by the N by N matrix of inner products or, where that is too large, by passes
// over the points (streamed_sums.h): either way the statistics are the same code.

namespace shape::internal {

/// Columns of weights that the members of a family have in common.
struct SumColumns
{
    Eigen::Index width = 1;
    std::vector<int> support; ///< Points that have weights, ascending.
};

/// As many sets of sums as there are permutations or replicates; each has all the columns.
struct SumFamily
{
    /// Writes weights of a member: those of columns[set] for the points of its support from number
    /// `first` on, a row each.
    using Fill =
        std::function<void(Eigen::Index member, std::size_t set, std::size_t first, Block weights)>;

    Eigen::Index members = 0;
    std::vector<SumColumns> columns;
    /// Makes members [begin, end) ready to be filled in; may be called from several threads.
    std::function<Fill(Eigen::Index begin, Eigen::Index end)> prepare;
    std::uint64_t bytes_per_member = 0; ///< Of what prepare() makes.

    [[nodiscard]] Eigen::Index width() const; ///< Of all columns together.
};

/// One sum for each part of the points.
struct PartSums
{
    std::vector<int> points;  ///< Ascending.
    std::vector<int> part_of; ///< Of each of them, in [0, parts).
    Eigen::VectorXd weights;  ///< Of each of them.
    Eigen::Index parts = 0;
    /// Parts by K: how much of each of the references is taken from a sum; without columns nothing is.
    Eigen::MatrixXd taken = {};
};

struct SumQuestions
{
    std::vector<SumFamily> families;
    std::vector<PartSums> parts;
    std::optional<Grouping> groups; ///< From whose means the distances of their members are wanted.
    /// N by K: weights of the points in sums that parts are measured from; without columns there are none.
    Eigen::MatrixXd references = {};
};

struct SumAnswers
{
    Eigen::VectorXd squares; ///< N: of the points.
    /// For each family, and each of its members, the inner products of its sums.
    std::vector<std::vector<Eigen::MatrixXd>> families;
    std::vector<Eigen::VectorXd> parts;  ///< For each, the squares of its sums.
    Eigen::VectorXd squares_about_means; ///< N: of the distances from the mean of the own group.
};

/// From the N by N inner products of the points.
/// Cost: N^2 multiplications for each column of each member.
[[nodiscard]] SumAnswers answer(const Eigen::MatrixXd& products, const SumQuestions& questions);

} // namespace shape::internal
