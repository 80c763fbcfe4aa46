// SPDX-License-Identifier: MIT

#pragma once

#include <algorithm>
#include <cstddef>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector3.h"

namespace shape::internal {

/// Loops over faces or edges work by blocks, one array a coordinate, which the compiler vectorises
/// (vectorised.h) and the first cache holds.
inline constexpr int block_size = 128;
using Row = double[block_size];

/// The vectors of a block, a row for each coordinate.
struct alignas(64) VectorRows
{
    Row x, y, z;

    void set(int i, const Vector3<double>& to)
    {
        x[i] = to.x;
        y[i] = to.y;
        z[i] = to.z;
    }
    [[gnu::always_inline]] Vector3<double> operator[](int i) const { return {x[i], y[i], z[i]}; }
};

/// Calls work(first, count) for consecutive blocks of [0, total), count <= block_size.
template <class Work>
void for_blocks(int total, const Work& work)
{
    constexpr std::size_t grain = 8 * block_size;
    parallel_for(to_size(total), grain, [&](std::size_t begin, std::size_t end) {
        for (int i = static_cast<int>(begin); i < static_cast<int>(end); i += block_size)
            work(i, std::min(block_size, static_cast<int>(end) - i));
    });
}

} // namespace shape::internal
