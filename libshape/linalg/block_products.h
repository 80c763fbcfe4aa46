// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"

namespace shape::internal {

/// Up to which two blocks are multiplied row by row, each entry a sum of its own; larger ones by BLAS, of which the
/// bits depend on the sizes.
inline constexpr Eigen::Index few_rows = 24;

/// Parts of row-major matrices.
using Block = Eigen::Ref<RowMatrix, 0, Eigen::OuterStride<>>;
using ConstBlock = Eigen::Ref<const RowMatrix, 0, Eigen::OuterStride<>>;

// Products of dense blocks by BLAS, in the calling thread. The same sizes give the same bits, however
// many threads call.

void add_product(const ConstBlock& a, const ConstBlock& b, Block c);            ///< c += a b.
void add_product_with_rows(const ConstBlock& a, const ConstBlock& b, Block c);  ///< c += a b^T.
void add_product_of_columns(const ConstBlock& a, const ConstBlock& b, Block c); ///< c += a^T b, one row after another.

} // namespace shape::internal
