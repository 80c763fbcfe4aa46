// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"

namespace shape::internal {

/// Parts of row-major matrices.
using Block = Eigen::Ref<RowMatrix, 0, Eigen::OuterStride<>>;
using ConstBlock = Eigen::Ref<const RowMatrix, 0, Eigen::OuterStride<>>;

// Products of dense blocks, in the calling thread; c overlaps neither a nor b. The same sizes give the same bits,
// however many threads call; others where the processor cannot multiply and add at once.

/// Up to so many rows add_product_with_rows() takes each entry as a sum of its own.
inline constexpr Eigen::Index few_rows = 24;

/// c += a b, by BLAS: m by n, m by k, k by n.
void add_product(const ConstBlock& a, const ConstBlock& b, Block c);

/// c += a b^T: m by n, m by k, n by k. By BLAS, whose bits depend on m and n, unless both are at most few_rows.
void add_product_with_rows(const ConstBlock& a, const ConstBlock& b, Block c);

/// c += a^T b: m by n, k by m, k by n. One of the k rows after another, so that bits do not depend on how rows and
/// columns are cut into pieces.
void add_product_of_columns(const ConstBlock& a, const ConstBlock& b, Block c);

} // namespace shape::internal
