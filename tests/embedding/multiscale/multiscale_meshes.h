// SPDX-License-Identifier: MIT

#pragma once

#include <vector>

#include "tests/support/meshes.h"

namespace shape::test {

/// Sample meshes, and larger ones that are split into several subtrees.
[[nodiscard]] inline std::vector<TestMesh> multiscale_meshes()
{
    std::vector<TestMesh> all = sample_meshes();
    all.push_back(bumpy_sphere(4, 0.3, 5));
    all.push_back(torus(30, 50));
    all.push_back(open_cylinder(30, 60));
    return all;
}

} // namespace shape::test
