// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/linalg/dense.h"
#include "libshape/statistics/grouping.h"

namespace shape {

/// Canonical variates: the axes along which G groups of points of K coordinates lie furthest apart
/// compared to their spread (Fisher 1936, Rao 1948).
struct DiscriminantAnalysis
{
    Eigen::VectorXd mean;   ///< K; of all points.
    RowMatrix axes;         ///< C by K, C = min(K, G - 1); covariance within groups 1 along them.
    Eigen::VectorXd ratios; ///< C, descending: variance between groups / variance within, >= 0.
    RowMatrix group_means;  ///< G by C, in canonical variates.
    Eigen::VectorXd log_priors; ///< G; shares of the points.
};

/// Canonical variates of groups: axes along which variance between groups is largest against that within them.
/// @param points  N by K, finite.
/// @param groups  At least 2; their covariances are pooled with divisor N - G.
/// @throws InvalidInput if a rule is broken, or N < K + G.
/// @throws NumericalError if the pooled covariance is singular: a coordinate varies within the groups by at most 1e-12 of what
///     it varies in all, or forms an angle of at most 1e-7 [rad] with those before it.
/// The sign of an axis makes its entry of largest magnitude positive (the first of equals).
[[nodiscard]] DiscriminantAnalysis discriminant_analysis(const RowMatrix& points,
                                                         const Grouping& groups);

/// Coordinates along the axes, N by C.
/// @throws InvalidInput if points does not have K columns.
[[nodiscard]] RowMatrix canonical_variates(const DiscriminantAnalysis& analysis,
                                           const RowMatrix& points);

/// The most probable group of each point if the groups are normal with one covariance: the least
/// |z - mean_g|^2 / 2 - log(prior_g) in canonical variates z, the first of equals.
/// @throws InvalidInput as canonical_variates().
[[nodiscard]] std::vector<int> classify(const DiscriminantAnalysis& analysis,
                                        const RowMatrix& points);

} // namespace shape
