// SPDX-License-Identifier: MIT

#include "libshape/mesh/alignment.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/rotation_fit.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::RowVector3d;

/// Sum of term(first, count) over ranges of rows, in order.
template <class Value, class Term>
Value sum_over_rows(Index rows, const Term& term)
{
    constexpr std::size_t grain = 8192;
    const auto count = to_size(rows);
    std::vector<Value> parts((count + grain - 1) / grain);
    parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
        parts[begin / grain] = term(static_cast<Index>(begin), static_cast<Index>(end - begin));
    });
    Value sum = Value::Zero();
    for (const Value& part : parts)
        sum += part;
    return sum;
}

} // namespace

Matrix3d nearest_rotation(const Matrix3d& m)
{
    const double size = m.norm();
    if (!(size > 0.0))
        return Matrix3d::Identity();
    // Its quaternion is the eigenvector of the largest eigenvalue of k (Horn 1987), which Newton's
    // method finds in the characteristic polynomial from above.
    const Matrix3d s = m / size;
    const double trace = s.trace();
    Matrix4d k;
    k(0, 0) = trace;
    k.bottomRightCorner<3, 3>() = s + s.transpose() - trace * Matrix3d::Identity();
    k.topRightCorner<1, 3>() << s(2, 1) - s(1, 2), s(0, 2) - s(2, 0), s(1, 0) - s(0, 1);
    k.bottomLeftCorner<3, 1>() = k.topRightCorner<1, 3>().transpose();
    const double linear = -8.0 * s.determinant();
    const double constant = k.determinant();
    // Newton's method doubles the digits: after a step of 1e-8 there are 16. A double root halves the
    // error a step, and 30 of them leave 1e-9.
    constexpr int max_steps = 30;
    constexpr double last_step = 1e-8;
    double eigenvalue = std::sqrt(3.0);
    for (int i = 0; i < max_steps; ++i) {
        const double square = eigenvalue * eigenvalue;
        const double step = ((square - 2.0) * square + linear * eigenvalue + constant) /
                            (4.0 * (square - 1.0) * eigenvalue + linear);
        if (!(step > last_step))
            break;
        eigenvalue -= step;
    }
    const Matrix4d inverse = ((eigenvalue + last_step) * Matrix4d::Identity() - k).inverse();
    Index largest = 0;
    inverse.diagonal().cwiseAbs().maxCoeff(&largest);
    const Eigen::Vector4d q = inverse.col(largest).normalized();
    if (!q.allFinite())
        return nearest_rotation_from(m, Matrix3d::Identity());
    return nearest_rotation_from(m, Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix());
}

RowVector3d centroid(const Points& points)
{
    return sum_over_rows<RowVector3d>(points.rows(),
                                      [&](Index first, Index count) {
                                          return points.middleRows(first, count).colwise().sum();
                                      }) /
           static_cast<double>(points.rows());
}

RigidMotion best_rigid_motion(const Points& moving, const Points& fixed)
{
    if (moving.rows() != fixed.rows() || moving.rows() == 0)
        throw InvalidInput(join("alignment of ", moving.rows(), " points with ", fixed.rows(),
                                ": the counts must be equal and not 0"));
    const RowVector3d moving_centre = centroid(moving);
    const RowVector3d fixed_centre = centroid(fixed);
    const Matrix3d covariance =
        sum_over_rows<Matrix3d>(moving.rows(), [&](Index first, Index count) {
            Matrix3d sum = Matrix3d::Zero();
            for (Index v = first; v < first + count; ++v)
                sum.noalias() +=
                    (fixed.row(v) - fixed_centre).transpose() * (moving.row(v) - moving_centre);
            return sum;
        });
    RigidMotion motion;
    motion.rotation = nearest_rotation(covariance);
    motion.translation = fixed_centre.transpose() - motion.rotation * moving_centre.transpose();
    return motion;
}

Points RigidMotion::operator()(const Points& points) const
{
    Points moved(points.rows(), 3);
    parallel_for(to_size(points.rows()), 8192, [&](std::size_t begin, std::size_t end) {
        for (auto v = static_cast<Index>(begin); v < static_cast<Index>(end); ++v)
            moved.row(v) = (rotation * points.row(v).transpose() + translation).transpose();
    });
    return moved;
}

} // namespace shape
