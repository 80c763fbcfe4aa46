// SPDX-License-Identifier: MIT

#include "libshape/mesh/vertex_normals.h"

#include <Eigen/Geometry>

namespace shape::internal {

using Eigen::Vector3d;

Points vertex_normals(const Points& points, const Faces& faces)
{
    Points normals = Points::Zero(points.rows(), 3);
    for (const auto& face : faces.rowwise()) {
        const Vector3d a = points.row(face[0]), b = points.row(face[1]), c = points.row(face[2]);
        const Vector3d normal = (b - a).cross(c - a);
        for (const int v : face)
            normals.row(v) += normal.transpose();
    }
    for (auto normal : normals.rowwise())
        normal.stableNormalize();
    return normals;
}

double outwardness(const Points& points, const Faces& faces)
{
    const Vector3d centroid = points.colwise().mean();
    double flux = 0.0, all = 0.0;
    for (const auto& face : faces.rowwise()) {
        const Vector3d a = points.row(face[0]), b = points.row(face[1]), c = points.row(face[2]);
        const Vector3d normal = (b - a).cross(c - a);
        const Vector3d arm = (a + b + c) / 3.0 - centroid;
        flux += arm.dot(normal);
        all += arm.norm() * normal.norm();
    }
    return all > 0.0 ? flux / all : 0.0;
}

} // namespace shape::internal
