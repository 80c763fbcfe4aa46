// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/base/blocks.h"

namespace shape::internal {

/// Indices first[0], first[stride], first[2 stride], ...
struct Indices
{
    const int* first;
    int stride = 1;
};

/// Sets vectors[i] = points[at[i]], i < count <= block_size, of points x y z in memory.
void gather(int count, const double* points, Indices at, VectorRows& vectors);

/// Sets vectors[i] = points[to[i]] - points[from[i]] likewise.
void gather_differences(int count, const double* points, Indices to, Indices from,
                        VectorRows& vectors);

} // namespace shape::internal
