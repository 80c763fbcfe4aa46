// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape::internal {

/// Runs body(first, count) for strips of [0, total), rows or columns of a matrix, `width` wide but for the last. They
/// are the chunks of parallel_for(): what it says of bits goes for them.
template <class Body>
void for_strips(Eigen::Index total, Eigen::Index width, const Body& body)
{
    parallel_for(to_size(total), to_size(width), [&](std::size_t begin, std::size_t end) {
        body(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin));
    });
}

} // namespace shape::internal
