// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/linalg/dense.h"

namespace shape::internal {

/// base + sum over k of weights[k] rows.row(k), in this order for every entry: the same bits on every
/// processor, which Eigen's product does not promise. What embeds a point far from any mesh takes up to
/// percents of its error from the last bit of its target.
/// @param weights  At most as many as there are rows.
[[nodiscard]] Eigen::VectorXd with_rows_added(Eigen::VectorXd base, const RowMatrix& rows,
                                              const Eigen::VectorXd& weights);

} // namespace shape::internal
