// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/base/blocks.h"

namespace shape::internal {

/// Rows of an array of points: first[0], first[stride], first[2 stride], ... A column of faces has stride 3.
struct StridedRows
{
    const int* first;
    int stride = 1;
};

/// Sets vectors[i] = points[at[i]], i < count <= block_size; vectors behind them stay.
/// @param points  #P by 3, row by row. Rows are not checked: all are in [0, #P).
void gather(int count, const double* points, StridedRows at, VectorRows& vectors);

/// Sets vectors[i] = points[to[i]] - points[from[i]] likewise.
void gather_differences(int count, const double* points, StridedRows to, StridedRows from,
                        VectorRows& vectors);

} // namespace shape::internal
