// SPDX-License-Identifier: MIT

#include "libshape/mesh/rotation_fit.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace shape::internal {
namespace {

/// Improves `rotation` until it is exact; false where Newton's method does not lead there.
bool climb(const Eigen::Matrix3d& m, Eigen::Matrix3d& rotation)
{
    constexpr int max_steps = 8;
    constexpr double max_step = 0.5; // |tan(angle / 2)|^2: beyond 70 degrees another branch is near
    constexpr double last_step = 1e-10; // the next step would be its cube
    constexpr double flat_limit =
        1e-12; // determinant over cubed trace: a line, any turn about it fits

    for (int step = 0; step < max_steps; ++step) {
        const Eigen::Matrix3d s = rotation.transpose() * m;
        // With the unit quaternion (1, v) / |(1, v)|, trace(dR(v)^T s) is a Rayleigh quotient; its
        // stationary v solves (lambda + trace(s) - s - s^T) v = z, where lambda is trace(s) up to
        // |v|^2.
        const double z0 = s(2, 1) - s(1, 2);
        const double z1 = s(0, 2) - s(2, 0);
        const double z2 = s(1, 0) - s(0, 1);
        const double a00 = 2.0 * (s(1, 1) + s(2, 2));
        const double a11 = 2.0 * (s(0, 0) + s(2, 2));
        const double a22 = 2.0 * (s(0, 0) + s(1, 1));
        const double a01 = -(s(0, 1) + s(1, 0));
        const double a02 = -(s(0, 2) + s(2, 0));
        const double a12 = -(s(1, 2) + s(2, 1));
        const double c00 = a11 * a22 - a12 * a12;
        const double c01 = a02 * a12 - a01 * a22;
        const double c02 = a01 * a12 - a02 * a11;
        const double determinant = a00 * c00 + a01 * c01 + a02 * c02;
        const double trace = a00 + a11 + a22;
        if (!(a11 > 0.0 && c00 > 0.0 && determinant > flat_limit * trace * trace * trace))
            return false;
        const double c11 = a00 * a22 - a02 * a02;
        const double c12 = a01 * a02 - a00 * a12;
        const double c22 = a00 * a11 - a01 * a01;
        const double inverse = 1.0 / determinant;
        const double x = (c00 * z0 + c01 * z1 + c02 * z2) * inverse;
        const double y = (c01 * z0 + c11 * z1 + c12 * z2) * inverse;
        const double w = (c02 * z0 + c12 * z1 + c22 * z2) * inverse;
        const double squared = x * x + y * y + w * w;
        if (!(squared < max_step))
            return false;
        const double f = 2.0 / (1.0 + squared);
        Eigen::Matrix3d turn;
        turn << 1.0 - f * (y * y + w * w), f * (x * y - w), f * (x * w + y), //
            f * (x * y + w), 1.0 - f * (x * x + w * w), f * (y * w - x),     //
            f * (x * w - y), f * (y * w + x), 1.0 - f * (x * x + y * y);
        rotation = rotation * turn;
        if (squared < last_step)
            return true;
    }
    return false;
}

Eigen::Matrix3d by_singular_values(const Eigen::Matrix3d& m)
{
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0.0)
        u.col(2) *= -1.0;
    return u * svd.matrixV().transpose();
}

} // namespace

Eigen::Matrix3d nearest_rotation_from(const Eigen::Matrix3d& m, const Eigen::Matrix3d& guess)
{
    Eigen::Matrix3d rotation = guess;
    if (climb(m, rotation))
        return rotation;
    const double size = m.norm();
    if (size == 0.0)
        return guess;
    // A little of the guess decides where m leaves a choice; elsewhere, climbing removes it.
    rotation = by_singular_values(m + 1e-12 * size * guess);
    climb(m, rotation);
    return rotation;
}

} // namespace shape::internal
