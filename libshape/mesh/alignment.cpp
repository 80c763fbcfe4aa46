// SPDX-License-Identifier: MIT

#include "libshape/mesh/alignment.h"

#include <Eigen/LU>
#include <Eigen/SVD>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m)
{
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0.0)
        u.col(2) *= -1.0;
    return u * svd.matrixV().transpose();
}

RigidMotion best_rigid_motion(const Points& moving, const Points& fixed)
{
    if (moving.rows() != fixed.rows() || moving.rows() == 0)
        throw InvalidInput(join("alignment of ", moving.rows(), " points with ", fixed.rows(),
                                ": the counts must be equal and not 0"));
    const Eigen::RowVector3d moving_centre = moving.colwise().mean();
    const Eigen::RowVector3d fixed_centre = fixed.colwise().mean();
    const Eigen::Matrix3d covariance =
        (fixed.rowwise() - fixed_centre).transpose() * (moving.rowwise() - moving_centre);
    RigidMotion motion;
    motion.rotation = nearest_rotation(covariance);
    motion.translation = fixed_centre.transpose() - motion.rotation * moving_centre.transpose();
    return motion;
}

} // namespace shape
