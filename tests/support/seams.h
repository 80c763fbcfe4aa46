// SPDX-License-Identifier: MIT

#pragma once

#include <cmath>

#include "libshape/base/to_size.h"
#include "tests/support/meshes.h"

namespace shape::test {

/// A closed mesh around the origin cut open along half of its equator (or all of it, into two patches): the faces above
/// take a vertex of their own, appended, for every vertex of the rim with y > 0. What exporters do along a seam.
struct CutMesh
{
    Faces faces;
    std::vector<int> vertices; ///< Entry i: the vertex of the whole mesh that vertex i copies.

    [[nodiscard]] Points points(const Points& whole) const { return whole(vertices, Eigen::all); }
    [[nodiscard]] int doubled(const Points& whole) const
    {
        return static_cast<int>(vertices.size()) - static_cast<int>(whole.rows());
    }
};

[[nodiscard]] inline CutMesh cut_along_the_equator(const TestMesh& mesh, bool into_patches = false)
{
    const Faces& faces = mesh.topology.faces();
    const auto is_above = [&](Eigen::Index f) {
        return mesh.points(faces(f, 0), 2) + mesh.points(faces(f, 1), 2) +
                   mesh.points(faces(f, 2), 2) >
               0.0;
    };
    std::vector<int> sides(internal::to_size(mesh.points.rows()), 0);
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        for (const int v : faces.row(f))
            sides[internal::to_size(v)] |= is_above(f) ? 1 : 2;
    CutMesh cut{faces, {}};
    std::vector<int> copy(sides.size(), -1);
    for (int v = 0; v < mesh.points.rows(); ++v)
        cut.vertices.push_back(v);
    for (int v = 0; v < mesh.points.rows(); ++v)
        if (sides[internal::to_size(v)] == 3 && (into_patches || mesh.points(v, 1) > 1e-9)) {
            copy[internal::to_size(v)] = static_cast<int>(cut.vertices.size());
            cut.vertices.push_back(v);
        }
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        for (int c = 0; c < 3; ++c)
            if (const int own = copy[internal::to_size(faces(f, c))]; is_above(f) && own >= 0)
                cut.faces(f, c) = own;
    return cut;
}

/// As scanners have it, in single precision far from the origin, the last vertices one number further in every
/// coordinate: what exporters leave where patches meet.
[[nodiscard]] inline Points in_scanner_coordinates(const Points& points, int last)
{
    Points moved = points.rowwise() + Eigen::RowVector3d(150.0, -220.0, 900.0);
    moved = moved.cast<float>().cast<double>();
    for (double& x : moved.bottomRows(last).reshaped())
        x = std::nextafter(static_cast<float>(x), 1e9F);
    return moved;
}

/// The mesh in a mirror: x changes its sign, the faces stay.
[[nodiscard]] inline Points mirror_image(Points points)
{
    points.col(0) = -points.col(0);
    return points;
}

[[nodiscard]] inline Faces reversed_faces(Faces faces)
{
    faces.col(1).swap(faces.col(2));
    return faces;
}

} // namespace shape::test
