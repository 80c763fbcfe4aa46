// SPDX-License-Identifier: MIT

#include "libshape/embedding/multiscale/patch_registration.h"

#include <Eigen/Cholesky>
#include <array>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/rotation_fit.h"

namespace shape::internal {
namespace {

using Moments = Eigen::Matrix4d; // sum of p q^T over common vertices: second, first, zeroth moments
using Block = Eigen::Matrix3d;

/// Q of register_patches() and the moments it is made of.
struct Problem
{
    std::array<Moments, max_patches*(max_patches - 1) / 2> moments;
    std::array<Block, max_patches * max_patches> blocks; ///< Block (k, l) at k * max_patches + l.
    /// Column l of entry k: what a rotation of patch k adds to the translations' equation l.
    std::array<Eigen::Matrix<double, 3, max_patches>, max_patches> shifts;

    [[nodiscard]] Block& block(int k, int l) { return blocks[to_size(k * max_patches + l)]; }
    [[nodiscard]] const Block& block(int k, int l) const
    {
        return blocks[to_size(k * max_patches + l)];
    }
};

Moments gather_moments(const PaddedPoint* first, const PaddedPoint* second,
                       const CommonVertex* common, int count)
{
    Moments moments = Moments::Zero();
    for (int i = 0; i < count; ++i)
        moments.noalias() += first[common[i].first] * second[common[i].second].transpose();
    return moments;
}

void build(Problem& problem, std::span<const PaddedPoint* const> patches,
           std::span<const PatchOverlap> overlaps, const CommonVertex* common,
           const double* inverse)
{
    const int n = static_cast<int>(patches.size());
    const auto at = [](int k) { return to_size(k); };
    for (int k = 0; k < n; ++k) {
        problem.shifts[at(k)].leftCols(n).setZero();
        for (int l = 0; l < n; ++l)
            problem.block(k, l).setZero();
    }
    for (std::size_t i = 0; i < overlaps.size(); ++i) {
        const auto& [k, l, begin, count] = overlaps[i];
        const Moments m = gather_moments(patches[at(k)], patches[at(l)], common + begin, count);
        problem.moments[i] = m;
        problem.block(k, l) = m.topLeftCorner<3, 3>();
        const Eigen::Vector3d sum_k = m.topRightCorner<3, 1>();
        const Eigen::Vector3d sum_l = m.bottomLeftCorner<1, 3>().transpose();
        problem.shifts[at(k)].col(k) += sum_k;
        problem.shifts[at(k)].col(l) -= sum_k;
        problem.shifts[at(l)].col(l) += sum_l;
        problem.shifts[at(l)].col(k) -= sum_l;
    }
    // The eliminated translations add B_k L^-1 B_l^T.
    const Eigen::Map<const Eigen::MatrixXd> g(inverse, n - 1, n - 1);
    for (int k = 0; k < n; ++k) {
        Eigen::Matrix<double, 3, max_patches> moved;
        for (int j = 0; j < n - 1; ++j) {
            Eigen::Vector3d sum = Eigen::Vector3d::Zero();
            for (int i = 0; i < n - 1; ++i)
                sum += g(i, j) * problem.shifts[at(k)].col(i + 1);
            moved.col(j) = sum;
        }
        for (int l = k + 1; l < n; ++l) {
            Block& block = problem.block(k, l);
            for (int j = 0; j < n - 1; ++j)
                block += moved.col(j) * problem.shifts[at(l)].col(j + 1).transpose();
            problem.block(l, k) = block.transpose();
        }
    }
}

/// Fits every patch to those before it: pairwise covariances about the overlaps' centroids.
void start_incrementally(const Problem& problem, std::span<const PatchOverlap> overlaps,
                         std::span<Eigen::Matrix3d> rotations)
{
    for (int k = 1; k < static_cast<int>(rotations.size()); ++k) {
        Eigen::Matrix3d fit = Eigen::Matrix3d::Zero();
        int most = 0;
        for (std::size_t i = 0; i < overlaps.size(); ++i) {
            if (overlaps[i].second != k)
                continue;
            const Moments& m = problem.moments[i];
            const Eigen::Matrix3d& placed = rotations[to_size(overlaps[i].first)];
            const Eigen::Matrix3d covariance =
                m.topLeftCorner<3, 3>() -
                m.topRightCorner<3, 1>() * m.bottomLeftCorner<1, 3>() / m(3, 3);
            fit.noalias() += placed * covariance;
            if (overlaps[i].count > most) {
                most = overlaps[i].count;
                rotations[to_size(k)] = placed;
            }
        }
        rotations[to_size(k)] = nearest_rotation_from(fit, rotations[to_size(k)]);
    }
}

} // namespace

Eigen::MatrixXd translation_inverse(int patch_count, std::span<const PatchOverlap> overlaps)
{
    Eigen::MatrixXd laplacian = Eigen::MatrixXd::Zero(patch_count, patch_count);
    for (const PatchOverlap& overlap : overlaps) {
        laplacian(overlap.first, overlap.second) -= overlap.count;
        laplacian(overlap.second, overlap.first) -= overlap.count;
        laplacian(overlap.first, overlap.first) += overlap.count;
        laplacian(overlap.second, overlap.second) += overlap.count;
    }
    const Eigen::Index rest = patch_count - 1;
    const Eigen::LDLT<Eigen::MatrixXd> factor(laplacian.bottomRightCorner(rest, rest));
    // Where links are missing a pivot is 0 but for rounding (1e-16); of patches that are linked, at most 16,
    // none is as small as this unless their overlaps differ by more than a million times.
    if (!(factor.vectorD().minCoeff() > 1e-9 * factor.vectorD().maxCoeff()))
        throw InvalidInput(
            join("registration: the overlaps do not link all ", patch_count, " patches"));
    return factor.solve(Eigen::MatrixXd::Identity(rest, rest));
}

} // namespace shape::internal

namespace shape {

void check(const RegistrationOptions& options)
{
    internal::require_at_least(0, options.passes, "RegistrationOptions.passes");
}

} // namespace shape

namespace shape::internal {

void register_patches(std::span<const PaddedPoint* const> patches,
                      std::span<const PatchOverlap> overlaps, const CommonVertex* common,
                      const double* inverse, const RegistrationOptions& options,
                      std::span<Eigen::Matrix3d> rotations)
{
    check(options);
    Problem problem;
    build(problem, patches, overlaps, common, inverse);
    for (Eigen::Matrix3d& rotation : rotations)
        rotation.setIdentity();
    if (options.start == RegistrationStart::Incremental)
        start_incrementally(problem, overlaps, rotations);
    const int n = static_cast<int>(patches.size());
    for (int pass = 0; pass < options.passes; ++pass)
        for (int k = 1; k < n; ++k) {
            Eigen::Matrix3d fit = Eigen::Matrix3d::Zero();
            for (int l = 0; l < n; ++l)
                if (l != k)
                    fit.noalias() += rotations[to_size(l)] * problem.block(l, k);
            rotations[to_size(k)] = nearest_rotation_from(fit, rotations[to_size(k)]);
        }
}

} // namespace shape::internal
