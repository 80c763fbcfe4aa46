// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <vector>

#include "libshape/linalg/dense.h"

namespace shape {

/// What work that goes over its data several times needs to go on after a pass: numbers and arrays in
/// the order in which they were put in. It goes on to the same bits.
struct PassState
{
    std::vector<std::int64_t> numbers;
    std::vector<RowMatrix> arrays;
};

} // namespace shape
