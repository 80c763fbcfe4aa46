// SPDX-License-Identifier: MIT

#pragma once

#include "tests/support/collections.h"
#include "tests/support/meshes.h"

namespace shape::test {

/// Flattened spheres, half of them turned inside out: angles near pi on both sides of it.
[[nodiscard]] inline Collection folded_spheres(int count)
{
    Collection collection = bumpy_spheres(count, 4);
    for (int i = 0; i < count; ++i) {
        Points& points = collection.points[static_cast<std::size_t>(i)];
        points = bumpy_sphere(1, 0.1, static_cast<unsigned>(i)).points;
        points.col(2) *= i % 2 == 0 ? 0.02 : -0.02;
    }
    return collection;
}

} // namespace shape::test
