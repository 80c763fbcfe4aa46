// SPDX-License-Identifier: MIT

#pragma once

#include <cmath>

#include "libshape/mesh/collection.h"
#include "tests/support/meshes.h"

namespace shape::test {

/// A square plate with a dent, and the same with the dent popped to the other side: their lengths are the
/// same, and half-way no angle is wanted, for which the lengths are too long. So E has two minima alike.
[[nodiscard]] inline Collection dents(int cells)
{
    const TestMesh patch = open_patch(cells, 1);
    Points up = patch.points;
    const Eigen::RowVector3d low = up.colwise().minCoeff();
    const Eigen::RowVector3d size = up.colwise().maxCoeff() - low;
    for (int v = 0; v < up.rows(); ++v) {
        const double x = (up(v, 0) - low[0]) / size[0] - 0.5;
        const double y = (up(v, 1) - low[1]) / size[1] - 0.5;
        const double r = 3.0 * std::hypot(x, y);
        up(v, 2) = r < 1.0 ? 0.12 * size[0] * std::pow(1.0 - r * r, 2) : 0.0;
    }
    Points down = up;
    down.col(2) *= -1.0;
    return {patch.topology, {"up", "down"}, {up, down}, {}};
}

} // namespace shape::test
