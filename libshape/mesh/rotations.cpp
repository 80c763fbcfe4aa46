// SPDX-License-Identifier: MIT

#include "libshape/mesh/rotations.h"

#include <cmath>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape::internal {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Vector3d rotation_vector(const Quaterniond& rotation)
{
    const double sine = rotation.vec().norm(); // of half the angle
    if (sine == 0.0)
        return Vector3d::Zero();
    const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
    return sign * 2.0 * std::atan2(sine, std::abs(rotation.w())) / sine * rotation.vec();
}

Quaterniond rotation_by(const Vector3d& vector)
{
    const double angle = vector.norm();
    if (angle == 0.0)
        return Quaterniond::Identity();
    const Vector3d imaginary = std::sin(0.5 * angle) / angle * vector;
    return {std::cos(0.5 * angle), imaginary.x(), imaginary.y(), imaginary.z()};
}

Rotations face_frames(const Topology& topology, const Points& points)
{
    Rotations frames(to_size(topology.face_count()));
    parallel_for(frames.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            const auto row = topology.faces().row(static_cast<Eigen::Index>(f));
            const auto side = [&](int corner) -> Vector3d {
                return (points.row(row[corner]) - points.row(row[0])).normalized();
            };
            const Vector3d normal = side(1).cross(side(2)).normalized();
            Eigen::Matrix3d frame;
            frame << side(1), normal.cross(side(1)), normal;
            frames[f] = frame;
        }
    });
    return frames;
}

} // namespace shape::internal
