// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "tests/support/meshes.h"

namespace shape::test {

/// Triangulated convex hull of seeded uniform random points on the unit sphere; O(count^2).
[[nodiscard]] TestMesh random_inscribed(int count, unsigned seed);

/// The mesh with every point multiplied by the semi-axes.
[[nodiscard]] TestMesh stretched(TestMesh mesh, const Eigen::Vector3d& axes);

/// The mesh with its vertices moved by a seeded normal offset of about `amount` mean edge lengths.
[[nodiscard]] TestMesh jittered(TestMesh mesh, double amount, unsigned seed);

/// The mesh with a vertex inserted in a share of its faces, next to the middle of one side: flat
/// triangles with two angles of that many degrees.
[[nodiscard]] TestMesh with_slivers(const TestMesh& mesh, double share, double degrees,
                                    unsigned seed);

/// Sphere of meridians and parallels: needles at the poles when meridians are many.
[[nodiscard]] TestMesh globe(int meridians, int parallels);

/// Sphere with `count` tentacles of the given length [radius]: strongly varying factors.
[[nodiscard]] TestMesh tentacled(int levels, int count, double length, unsigned seed);

} // namespace shape::test
