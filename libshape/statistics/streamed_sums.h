// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "libshape/linalg/dense.h"
#include "libshape/statistics/point_sums.h"

namespace shape::internal {

/// N points of E coordinates that come by in passes.
struct PointPasses
{
    using Visit = std::function<void(Eigen::Index first, const RowMatrix& rows)>;

    Eigen::Index points = 0;
    Eigen::Index coordinates = 0;
    /// Shows all points once, in their order, in the same tiles each time.
    std::function<void(const Visit& visit)> pass;
    RowMatrix group_means = {}; ///< G by E: of the groups that a question is about, if one is.
    RowMatrix references = {};  ///< K by E: the sums that questions have as references, if they do.
};

/// The same answers as from all inner products, by passes over the points, each as exact: a sum is a sum of
/// points, and no inner product of two points is needed. A pass takes as many sums as the memory holds.
/// Same bits for any memory and thread count.
///
/// @param memory  What the sums may take [byte]; some are kept in any case.
/// Cost: 2 N E multiplications for each column of each member, where it has support.
[[nodiscard]] SumAnswers answer(const PointPasses& points, const SumQuestions& questions,
                                std::uint64_t memory);

/// The same from points in memory: for many of them with few coordinates.
[[nodiscard]] SumAnswers answer_in_memory(const RowMatrix& points, const SumQuestions& questions);

} // namespace shape::internal
