// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"

namespace shape {

/// How two samples differ, variable by variable: E entries each.
struct ColumnEffects
{
    Eigen::VectorXd effects;       ///< Cohen's d [1]: > 0 where the second sample is larger.
    Eigen::VectorXd probabilities; ///< p of the two-sided t test.
    Eigen::VectorXd false_discovery_rates; ///< q: benjamini_hochberg(p).
};

/// Of N pairs: with the differences d_i = second_i - first_i, their mean m and standard deviation s
/// (divisor N - 1), the effect is m / s (Cohen's d_z) and t = m / (s / sqrt(N)) has N - 1 degrees of
/// freedom.
///
/// A variable without spread, s <= 1e-12 max |value|, has effect 0 and p = 1 if |m| is within the
/// same limit.
/// @param first, second  N by E, finite; row i of both is pair i.
/// @throws InvalidInput if the sizes differ, N < 2, a value is not finite, or a variable without
///     spread has another mean: its effect has no value.
[[nodiscard]] ColumnEffects paired_effects(const RowMatrix& first, const RowMatrix& second);

/// Of independent samples of N and M observations: the effect is the difference of the means divided
/// by the pooled standard deviation (Cohen 1988), p that of Welch's test, which does not take the
/// variances for equal (Welch 1947). Variables without spread as above.
/// @param first  N by E, finite.
/// @param second  M by E, finite.
/// @throws InvalidInput as paired_effects().
[[nodiscard]] ColumnEffects independent_effects(const RowMatrix& first, const RowMatrix& second);

/// The least false discovery rate at which each of m tests is significant: with the p in ascending
/// order, q_(i) = min over j >= i of p_(j) m / j (Benjamini and Hochberg 1995).
/// @throws InvalidInput if a p is outside [0, 1].
[[nodiscard]] Eigen::VectorXd benjamini_hochberg(const Eigen::VectorXd& probabilities);

} // namespace shape
