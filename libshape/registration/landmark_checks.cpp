// SPDX-License-Identifier: MIT

#include "libshape/registration/landmark_checks.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/percent.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

using Eigen::Index;

/// About their mean, root of the sum of squares 1.
Eigen::MatrixXd normed(const Points& points)
{
    const Eigen::MatrixXd centred = points.rowwise() - points.colwise().mean();
    return centred / centred.norm();
}

/// What the best rotation of normed points a leaves of others, b: |a R - b|, where tr(R^T a^T b) is largest (Umeyama
/// 1991).
/// @param product  a^T b.
/// @param turn  1; -1: the best rotation and reflection.
double misfit(const Eigen::Matrix3d& product, double turn)
{
    const Eigen::Vector3d values = Eigen::JacobiSVD<Eigen::Matrix3d>(product).singularValues();
    const double last = product.determinant() * turn < 0.0 ? -values[2] : values[2];
    return std::sqrt(std::max(0.0, 2.0 - 2.0 * (values[0] + values[1] + last)));
}

} // namespace

void check_not_far(const std::vector<std::string>& names, const Points& landmarks,
                   const Points& surface, const std::string& whose)
{
    constexpr double far = 20.0; // diagonals; set by hand
    const double diagonal = bounding_box_diagonal(surface);
    const Eigen::RowVector3d centre =
        0.5 * (surface.colwise().minCoeff() + surface.colwise().maxCoeff());
    std::string text;
    Index count = 0;
    for (Index i = 0; i < landmarks.rows(); ++i)
        if (const double away = (landmarks.row(i) - centre).norm() / diagonal; away > far)
            text += join(count++ == 0 ? "" : ", ", "'", names[to_size(i)], "' lies ",
                         std::round(away), " diagonals away");
    if (count > 0 && count < landmarks.rows())
        throw InvalidInput(join("landmarks of ", whose, ": ", text,
                                "; is that a code for a missing one? Leave its coordinates empty"));
}

std::optional<std::string> mistaken_landmarks(const std::vector<std::string>& names,
                                              const Points& on_template, const Points& on_scan)
{
    constexpr double least_misfit = 0.05, explained = 1.0 / 3.0; // see the header
    const Index count = on_scan.rows();
    for (Index i = 0; i < count; ++i)
        for (Index j = i + 1; j < count; ++j) {
            const bool are_one_there = on_template.row(i) == on_template.row(j);
            if (are_one_there != (on_scan.row(i) == on_scan.row(j)))
                return join("landmarks '", names[to_size(i)], "' and '", names[to_size(j)],
                            "' lie on one point of the ", are_one_there ? "template" : "scan",
                            ", but not of the ", are_one_there ? "scan" : "template");
        }
    if (count < 4)
        return std::nullopt;
    const Eigen::MatrixXd from = normed(on_template), to = normed(on_scan);
    const Eigen::Matrix3d product = from.transpose() * to;
    const double as_given = misfit(product, 1.0);
    if (!(as_given >= least_misfit))
        return std::nullopt;
    double least = explained * as_given;
    std::optional<std::string> said;
    const auto than_as_given = [&] {
        return join(percent(least), " of their spread from those of the template, as they are by ",
                    percent(as_given));
    };
    if (const double left = misfit(product, -1.0); left <= least) {
        least = left;
        said = join("the landmarks of the scan look like a mirror image: mirrored they differ by ",
                    than_as_given(),
                    "; mirror the scan and its landmarks (one coordinate times -1), or exchange "
                    "left and right in their names if those are wrong");
    }
    for (Index i = 0; i < count; ++i)
        for (Index j = i + 1; j < count; ++j) {
            const Eigen::Matrix3d exchanged =
                product - (from.row(i) - from.row(j)).transpose() * (to.row(i) - to.row(j));
            if (const double left = misfit(exchanged, 1.0); left < least) {
                least = left;
                said = join("landmarks '", names[to_size(i)], "' and '", names[to_size(j)],
                            "' look exchanged: with their names exchanged the landmarks differ by ",
                            than_as_given());
            }
        }
    return said;
}

} // namespace shape::internal
