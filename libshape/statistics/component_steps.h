// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/linalg/symmetric_eigen.h"
#include "libshape/statistics/principal_components.h"

// The steps of a principal component analysis that are the same whether all data are in memory or come
// by in passes.

namespace shape::internal {

inline constexpr double smallest_variance_ratio =
    1e-12; ///< Modes of less, relative to the first one, are rounding.

/// Eigenpairs of the Gram matrix for the modes that are asked for and are more than rounding.
[[nodiscard]] Eigenpairs leading_eigenpairs(const Eigen::MatrixXd& gram,
                                            const PrincipalComponentsOptions& options);

/// x = weights^T x in place, in fixed strips of columns: the modes may be as large as the data.
void mix_rows(const RowMatrix& weights, RowMatrix& x);

/// Makes the rows of modes = weights^T x, which are nearly so, orthonormal to rounding. With
/// modes modes^T = L L^T, applying L^-1 is the Gram-Schmidt process in the order of the rows.
void orthonormalise(RowMatrix& modes, RowMatrix& weights);

/// The rotation J that makes the columns of scores J orthogonal (one-sided Jacobi). The Gram matrix
/// knows a mode only up to rounding of the largest variance; the scores know it better.
[[nodiscard]] RowMatrix decorrelating_rotation(Eigen::MatrixXd scores);

/// Makes the entry of largest magnitude of every mode positive.
void fix_signs(RowMatrix& modes, RowMatrix& weights);

/// Variances of the scores. Modes of equal variance may have changed places by rounding: they are
/// put in descending order.
void measure_variances(PrincipalComponents& components);

} // namespace shape::internal
