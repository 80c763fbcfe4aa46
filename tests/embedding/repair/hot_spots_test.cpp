// SPDX-License-Identifier: MIT

#include "libshape/embedding/repair/hot_spots.h"

#include <gtest/gtest.h>

#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/vertex_regions.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

/// A bumpy sphere with some vertices moved out along their rays.
struct Stretched
{
    test::TestMesh mesh = test::bumpy_sphere(4, 0.2, 3); // 2,562 vertices
    LengthDihedralEnergy energy{
        mesh.topology,
        {edge_lengths(mesh.topology, mesh.points), dihedral_angles(mesh.topology, mesh.points)},
        5e-3};
    [[nodiscard]] Eigen::VectorXd without(const std::vector<int>& vertices, double factor) const
    {
        Points points = mesh.points;
        for (const int v : vertices)
            points.row(v) *= factor;
        return points.reshaped<Eigen::RowMajor>();
    }
};

TEST(HotSpots, LieWhereTheStrainIs)
{
    const Stretched sphere;
    const std::vector<int> moved = {1000, 2000, 2500};
    const auto count = static_cast<double>(moved.size());
    const auto spots = hot_spots(sphere.energy, sphere.without(moved, 1.1),
                                 {.seeds = (count + 0.5) / std::sqrt(2562.0), .rings = 2});
    EXPECT_EQ(spots, regions_around(sphere.mesh.topology, moved, 2));
}

TEST(HotSpots, AreAtMostAsManyAsARootOfTheVertices)
{
    const Stretched sphere;
    std::vector<int> moved(200);
    for (std::size_t i = 0; i < moved.size(); ++i)
        moved[i] = 12 * static_cast<int>(i);
    std::size_t seeds = 0;
    for (const auto& region : hot_spots(sphere.energy, sphere.without(moved, 0.9),
                                        {.seeds = 2.0, .contrast = 1.0, .rings = 0}))
        seeds += region.size();
    EXPECT_EQ(seeds, 101U); // floor(2 sqrt 2562)
}

TEST(HotSpots, AreNoneWhereStrainIsSpreadEvenly)
{
    const Stretched sphere;
    const Eigen::VectorXd larger = 1.05 * sphere.without({}, 1.0);
    EXPECT_TRUE(hot_spots(sphere.energy, larger).empty());
    EXPECT_TRUE(hot_spots(sphere.energy, sphere.without({}, 1.0)).empty()); // nor without any
}

TEST(HotSpots, AreTheSameForOneAndTwoThreads)
{
    const Stretched sphere;
    const Eigen::VectorXd points = sphere.without({11, 12, 1300}, 1.05);
    const auto run = [&](int threads) {
        const test::ThreadScope scope(threads);
        return hot_spots(sphere.energy, points);
    };
    EXPECT_EQ(run(1), run(2));
}

} // namespace
} // namespace shape
