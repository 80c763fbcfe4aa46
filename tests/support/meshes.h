// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::test {

/// A mesh with its triangulation, made for tests.
struct TestMesh
{
    std::string name;
    Topology topology;
    Points points;
};

[[nodiscard]] TestMesh tetrahedron();

/// Unit sphere: an icosahedron split `levels` times, 10 * 4^levels + 2 vertices.
[[nodiscard]] TestMesh icosphere(int levels);

/// The icosphere with smooth seeded bumps of about `amplitude` times its radius.
[[nodiscard]] TestMesh bumpy_sphere(int levels, double amplitude, unsigned seed);

/// Torus of genus 1, `around` by `along` vertices.
[[nodiscard]] TestMesh torus(int around, int along);

/// Open height field over a square, (n + 1)^2 vertices, one boundary loop.
[[nodiscard]] TestMesh open_patch(int n, unsigned seed);

/// The open patch of 49 by 49 vertices with nine of them folded over their neighbours.
struct FoldedPatch
{
    TestMesh mesh;
    Points folded;
};
[[nodiscard]] FoldedPatch folded_patch();

/// Open cylinder, two boundary loops.
[[nodiscard]] TestMesh open_cylinder(int around, int along);

/// One of each kind: closed, open with one and two loops, genus 1.
[[nodiscard]] std::vector<TestMesh> sample_meshes();

/// Edge lengths and dihedral angles of a mesh.
[[nodiscard]] ShapePoint shape_of(const Topology& topology, const Points& points);

/// Positions in another pose: a seeded rotation and translation.
[[nodiscard]] Points moved(const Points& points, unsigned seed);

} // namespace shape::test
