// SPDX-License-Identifier: MIT

#include "libshape/embedding/multiscale/patch_registration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;
namespace {

Eigen::Matrix3d random_rotation(Random& random)
{
    return Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
        .normalized()
        .toRotationMatrix();
}

/// Windows of a point cloud, each in a pose of its own; neighbours overlap.
struct Patches
{
    std::vector<std::vector<PaddedPoint>> points;
    std::vector<Eigen::Matrix3d> poses; ///< Rotation of the cloud that made the patch.
    std::vector<PatchOverlap> overlaps;
    std::vector<CommonVertex> common;

    [[nodiscard]] int size() const { return static_cast<int>(points.size()); }

    [[nodiscard]] std::vector<Eigen::Matrix3d> registered(const RegistrationOptions& options) const
    {
        std::vector<const PaddedPoint*> pointers;
        for (const auto& patch : points)
            pointers.push_back(patch.data());
        std::vector<Eigen::Matrix3d> rotations(points.size());
        const Eigen::MatrixXd inverse = translation_inverse(size(), overlaps);
        register_patches(pointers, overlaps, common.data(), inverse.data(), options, rotations);
        return rotations;
    }

    /// The cost with the best translations, by dense least squares.
    [[nodiscard]] double cost(const std::vector<Eigen::Matrix3d>& rotations) const
    {
        const auto rows = 3 * static_cast<Eigen::Index>(common.size());
        Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(rows, 3 * size());
        Eigen::VectorXd gaps(rows);
        for (const PatchOverlap& overlap : overlaps)
            for (int i = 0; i < overlap.count; ++i) {
                const std::size_t at = overlap.begin + to_size(i);
                const auto k = to_size(overlap.first);
                const auto l = to_size(overlap.second);
                const auto row = 3 * static_cast<Eigen::Index>(at);
                const auto point = [&](std::size_t p, int v) -> Eigen::Vector3d {
                    return rotations[p] * points[p][to_size(v)].head<3>();
                };
                matrix.block<3, 3>(row, 3 * overlap.first).setIdentity();
                matrix.block<3, 3>(row, 3 * overlap.second) = -Eigen::Matrix3d::Identity();
                gaps.segment<3>(row) = point(k, common[at].first) - point(l, common[at].second);
            }
        const Eigen::VectorXd shifts = matrix.completeOrthogonalDecomposition().solve(-gaps);
        return (matrix * shifts + gaps).squaredNorm();
    }
};

/// @param flatness  Factor of the cloud's third coordinate: 0 for coplanar data.
Patches make_patches(int count, double noise, double flatness, std::uint64_t seed)
{
    Random random(seed);
    const int width = 8;
    const int step = 4;
    std::vector<Eigen::Vector3d> cloud;
    for (int i = 0; i < step * count + width; ++i)
        cloud.emplace_back(0.3 * i + random.normal(), random.normal(), flatness * random.normal());
    Patches patches;
    for (int k = 0; k < count; ++k) {
        patches.poses.push_back(k == 0 ? Eigen::Matrix3d::Identity() : random_rotation(random));
        const Eigen::Vector3d shift(random.normal(), random.normal(), random.normal());
        auto& points = patches.points.emplace_back();
        for (int i = 0; i < width; ++i) {
            const Eigen::Vector3d error(random.normal(), random.normal(), random.normal());
            const Eigen::Vector3d p = cloud[to_size(step * k + i)] + noise * error;
            points.emplace_back((patches.poses.back() * p + shift).homogeneous());
        }
        if (k > 0) {
            patches.overlaps.push_back({k - 1, k, patches.common.size(), width - step});
            for (int i = 0; i < width - step; ++i)
                patches.common.push_back({i + step, i});
        }
    }
    return patches;
}

TEST(Registration, RecoversKnownRotations)
{
    for (const int count : {2, 3, 6, 12})
        for (const double flatness : {1.0, 0.0}) {
            SCOPED_TRACE(count);
            const Patches patches = make_patches(count, 0.0, flatness, 7);
            const auto rotations = patches.registered({});
            for (std::size_t k = 0; k < rotations.size(); ++k)
                EXPECT_LT((rotations[k] * patches.poses[k] - Eigen::Matrix3d::Identity()).norm(),
                          1e-11)
                    << "patch " << k;
            EXPECT_LT(patches.cost(rotations), 1e-20);
        }
}

TEST(Registration, EndsWhereNoTurnOfAPatchLowersTheCost)
{
    for (const RegistrationStart start :
         {RegistrationStart::Incremental, RegistrationStart::Identity}) {
        const Patches patches = make_patches(5, 0.2, 1.0, 11);
        auto rotations = patches.registered({start, 500});
        const double cost = patches.cost(rotations);
        EXPECT_GT(cost, 1e-2); // the noise leaves a gap
        for (std::size_t k = 0; k < rotations.size(); ++k) {
            const Eigen::Matrix3d best = rotations[k];
            for (int axis = 0; axis < 3; ++axis)
                for (const double angle : {-1e-3, 1e-3}) {
                    rotations[k] = Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)) * best;
                    EXPECT_GT(patches.cost(rotations), cost);
                }
            rotations[k] = best;
        }
    }
}

TEST(Registration, EveryPassLowersTheCost)
{
    const Patches patches = make_patches(6, 0.3, 1.0, 13);
    double last = patches.cost(patches.registered({RegistrationStart::Identity, 0}));
    for (int passes = 1; passes < 6; ++passes) {
        const double cost = patches.cost(patches.registered({RegistrationStart::Identity, passes}));
        EXPECT_LT(cost, last);
        last = cost;
    }
}

TEST(Registration, KeepsTheFirstPatchAndNeverReflects)
{
    // Mirrored copies: without the correction of determinants reflections would fit best.
    Patches patches = make_patches(4, 0.0, 1.0, 17);
    for (PaddedPoint& point : patches.points[2])
        point[0] = -point[0];
    for (const RegistrationStart start :
         {RegistrationStart::Incremental, RegistrationStart::Identity}) {
        const auto rotations = patches.registered({start, 4});
        EXPECT_EQ(rotations[0], Eigen::Matrix3d::Identity());
        for (const Eigen::Matrix3d& rotation : rotations)
            EXPECT_NEAR(rotation.determinant(), 1.0, 1e-13);
    }
}

TEST(Registration, RefusesPatchesThatAreNotLinked)
{
    const std::vector<PatchOverlap> overlaps{{0, 1, 0, 3}, {2, 3, 3, 3}};
    EXPECT_THROW((void)translation_inverse(4, overlaps), InvalidInput);
    EXPECT_THROW((void)translation_inverse(3, std::span(overlaps).first(1)), InvalidInput);
}

} // namespace
} // namespace shape
