// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/embedder.h"
#include "libshape/io/mesh_file.h"
#include "libshape/mesh/collection.h"
#include "libshape/mesh/dihedral_angles.h"
#include "tests/support/data.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

/// Half-way blends of two real meshes far apart.
struct Pair
{
    const char* name;
    const char* folder;
    const char* first;
    const char* second;
};

class RealPairsSlow : public testing::TestWithParam<Pair>
{
protected:
    void SetUp() override
    {
        const std::filesystem::path folder = test::data_dir() / GetParam().folder;
        if (!std::filesystem::exists(folder))
            GTEST_SKIP() << "no " << folder;
        meshes_ = collect({read_mesh(folder / (std::string(GetParam().first) + ".ply")),
                           read_mesh(folder / (std::string(GetParam().second) + ".ply"))});
    }

    /// The blend of the meshes in a unit that many times smaller.
    [[nodiscard]] Points half_way(EmbeddingQuality quality, double scale = 1.0) const
    {
        Collection meshes = *meshes_;
        for (Points& points : meshes.points)
            points *= scale;
        const ShapePoint target =
            blend(shape_vectors(meshes, Scale::None), Eigen::Vector2d::Constant(0.5));
        return Embedder(meshes.topology, meshes.points, {.quality = quality}).embed(target).points;
    }

    /// Per face, whether it lies folded onto a neighbour or has next to no area.
    [[nodiscard]] std::vector<bool> bad_faces(const Points& points) const
    {
        constexpr double fold = 150.0 * std::numbers::pi / 180.0;
        const Topology& topology = meshes_->topology;
        const Eigen::VectorXd angles = dihedral_angles(topology, points);
        std::vector<bool> bad;
        for (int f = 0; f < topology.face_count(); ++f) {
            const auto corner = [&](int c) -> Eigen::Vector3d {
                return points.row(topology.faces()(f, c));
            };
            const Eigen::Vector3d u = corner(1) - corner(0);
            const Eigen::Vector3d v = corner(2) - corner(0);
            const double longest =
                std::max({u.squaredNorm(), v.squaredNorm(), (u - v).squaredNorm()});
            double sharpest = 0.0;
            for (int c = 0; c < 3; ++c)
                sharpest = std::max(sharpest, std::abs(angles[topology.face_edges()(f, c)]));
            bad.push_back(sharpest > fold || u.cross(v).norm() < 1e-3 * longest);
        }
        return bad;
    }

    std::optional<Collection> meshes_;
};

constexpr EmbeddingQuality qualities[] = {EmbeddingQuality::Fine, EmbeddingQuality::Preview};

TEST_P(RealPairsSlow, HaveTheSameBitsForAnyThreadCountAndInEveryRun)
{
    for (const EmbeddingQuality quality : qualities) {
        const Points points = half_way(quality);
        for (const int threads : {1, 2, 3}) {
            const test::ThreadScope scope(threads);
            EXPECT_TRUE(half_way(quality) == points) << threads;
        }
    }
}

TEST_P(RealPairsSlow, DoNotDependOnTheUnitOfLength)
{
    constexpr double scale = 1024.0; // a power of two: rounding scales too
    for (const EmbeddingQuality quality : qualities)
        EXPECT_TRUE(half_way(quality, scale) / scale == half_way(quality));
}

TEST_P(RealPairsSlow, HaveNoFoldedOrDegenerateFaceThatWasNotSoInAnInput)
{
    const std::vector<bool> a = bad_faces(meshes_->points[0]);
    const std::vector<bool> b = bad_faces(meshes_->points[1]);
    const std::vector<bool> found = bad_faces(half_way(EmbeddingQuality::Fine));
    for (std::size_t f = 0; f < found.size(); ++f)
        EXPECT_LE(found[f], a[f] || b[f]) << "face " << f;
}

INSTANTIATE_TEST_SUITE_P(
    , RealPairsSlow,
    testing::Values(Pair{"Arm", "mh_arm", "elbow_000", "elbow_1000"},
                    Pair{"Hand", "mh_hand", "fist_0", "fist_5"},
                    Pair{"Body", "mh_body_poses", "rest", "lunge"},
                    Pair{"Walk", "mh_body_poses", "walk_00", "walk_06"},
                    Pair{"Face", "ict_faces_full", "s000_neutral", "s000_happy"}),
    [](const testing::TestParamInfo<Pair>& pair) { return std::string(pair.param.name); });

} // namespace
} // namespace shape
