// SPDX-License-Identifier: MIT

#include "libshape/mesh/stretched_meshes.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "libshape/base/order_statistics.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/alignment.h"

namespace shape::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Set on faces, vertebrae, arms, hands and bodies: of 300 draws of 5 to 24 faces none is said to be stretched, and of those
// with one face times 1.5 and more along an axis all. One of the vertebrae is 1.4 times as long as the others by nature.
const double least_stretch = std::log(1.5);
constexpr double apart = 1.5, apart_along_axis = 1.3;
constexpr double posed = 0.25;
constexpr double single = 0.8; // 0.75 where the middle value is as far from both others
const double along_axis = std::cos(10.0 / 180.0 * 3.14159265358979);
constexpr std::size_t references = 5, least_count = 5;

Points centred(const Points& points)
{
    return points.rowwise() - centroid(points);
}

/// How a mesh is stretched against another.
struct Stretch
{
    double all = 0.0; ///< log(s_1 / s_3).
    double one = 0.0; ///< Logarithm of the factor along the one axis against both others.
    Vector3d axis = Vector3d::Zero();
};

Stretch stretch(const Points& mesh, const Points& reference, const Matrix3d& inverse_square)
{
    const Matrix3d affine = mesh.transpose() * reference * inverse_square;
    // Its eigenvalues are the squares of the singular values, ascending.
    const Eigen::SelfAdjointEigenSolver<Matrix3d> square(affine * affine.transpose());
    const Vector3d& s = square.eigenvalues();
    if (!(s[0] > 1e-12 * s[2])) // flat: no axis across it
        return {};
    const bool is_longer = s[2] * s[0] > s[1] * s[1];
    return {0.5 * std::log(s[2] / s[0]),
            0.5 * (is_longer ? std::log(s[2] / std::sqrt(s[1] * s[0]))
                             : std::log(s[0] / std::sqrt(s[2] * s[1]))),
            square.eigenvectors().col(is_longer ? 2 : 0)};
}

std::vector<Stretch> stretches_against(const std::vector<Points>& meshes, std::size_t reference)
{
    const Points fixed = centred(meshes[reference]);
    const Matrix3d square = fixed.transpose() * fixed;
    const Eigen::LDLT<Matrix3d> factor(square);
    std::vector<Stretch> all(meshes.size());
    // A plane reference has no affine images out of it.
    if (factor.info() != Eigen::Success ||
        !(factor.vectorD().minCoeff() > 1e-10 * factor.vectorD().maxCoeff()))
        return all;
    const Matrix3d inverse = factor.solve(Matrix3d::Identity());
    parallel_for(meshes.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (i != reference)
                all[i] = stretch(centred(meshes[i]), fixed, inverse);
    });
    return all;
}

double median_of(const std::vector<Stretch>& stretches)
{
    std::vector<double> values;
    for (const Stretch& s : stretches)
        values.push_back(s.all);
    return median(std::move(values));
}

/// The coordinate axis along which all of them are stretched, or -1.
int common_axis(const std::vector<Stretch>& stretches, const std::vector<std::size_t>& those)
{
    for (int axis = 0; axis < 3; ++axis)
        if (std::ranges::all_of(those, [&](std::size_t i) {
                return std::abs(stretches[i].axis[axis]) >= along_axis;
            }))
            return axis;
    return -1;
}

} // namespace

StretchedMeshes stretched_meshes(const std::vector<Points>& meshes)
{
    const std::size_t count = meshes.size();
    if (count < least_count)
        return {};
    std::vector<Stretch> stretches;
    for (std::size_t k = 0; k < references; ++k) {
        std::vector<Stretch> found = stretches_against(meshes, k * (count - 1) / (references - 1));
        if (stretches.empty() || median_of(found) < median_of(stretches))
            stretches = std::move(found);
    }
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return stretches[i].all; });
    for (std::size_t first = count / 2 + 1; first < count; ++first) {
        std::vector<std::size_t> those(order.begin() + std::ptrdiff_t(first), order.end());
        const double least = stretches[order[first]].all;
        const double before = stretches[order[first - 1]].all;
        if (least <= least_stretch || stretches[order[first / 2]].all >= posed)
            continue;
        const int axis = common_axis(stretches, those);
        if (least <= (axis >= 0 ? apart_along_axis : apart) * before)
            continue;
        const double sign = stretches[those.front()].one;
        double sum = 0.0;
        bool is_one_way = true;
        for (const std::size_t i : those) {
            const Stretch& s = stretches[i];
            is_one_way = is_one_way && s.one * sign > 0.0 && std::abs(s.one) >= single * s.all;
            sum += s.one;
        }
        if (!is_one_way)
            continue;
        std::ranges::sort(those);
        return {std::move(those), std::exp(sum / static_cast<double>(count - first)), axis};
    }
    return {};
}

} // namespace shape::internal
