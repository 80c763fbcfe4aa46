// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

namespace shape {

/// Vertex positions, #V by 3 [length]; row v is vertex v.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Triangles, #F by 3 vertex indices, counter-clockwise seen from outside.
using Faces = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Undirected edges, #E by 2 vertex indices, the lower index first.
using Edges = Eigen::Matrix<int, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// Length of the diagonal of the axis-aligned bounding box [length]; 0 for no points.
[[nodiscard]] inline double bounding_box_diagonal(const Points& points)
{
    if (points.rows() == 0)
        return 0.0;
    return (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
}

} // namespace shape
