// SPDX-License-Identifier: MIT

#include "libshape/model/outlying_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"
#include "tests/support/seams.h"

namespace shape {
using namespace internal;
namespace {

Collection spheres(std::size_t count, int levels = 3)
{
    const test::TestMesh first = test::bumpy_sphere(levels, 0.1, 0);
    Collection collection{first.topology, {}, {}, {}};
    for (std::size_t i = 0; i < count; ++i) {
        collection.names.push_back(join("m", i));
        collection.points.push_back(
            test::moved(test::bumpy_sphere(levels, 0.1, static_cast<unsigned>(i)).points, 3));
    }
    return collection;
}

std::vector<std::size_t> outliers(const Collection& collection)
{
    std::vector<std::size_t> meshes;
    for (const OutlyingMesh& found : find_outlying_meshes(collection))
        meshes.push_back(found.mesh);
    return meshes;
}

TEST(OutlyingMeshes, AreNoneAmongMeshesOfOneKindWhateverTheirSizes)
{
    Collection collection = spheres(12);
    EXPECT_TRUE(outliers(collection).empty());
    for (std::size_t i = 0; i < collection.size(); ++i)
        collection.points[i] *= static_cast<double>(i + 1);
    EXPECT_TRUE(outliers(collection).empty());
}

TEST(OutlyingMeshes, AreThoseWithExchangedVertices)
{
    Random random(5);
    for (int round = 0; round < 20; ++round) {
        Collection collection = spheres(10);
        const std::size_t mesh = random.index(10);
        const auto vertex = [&] {
            return static_cast<Eigen::Index>(
                random.index(static_cast<std::uint64_t>(collection.topology.vertex_count())));
        };
        const Eigen::Index a = vertex();
        // Neighbours as well as vertices far apart.
        const Eigen::Index b =
            round % 2 == 0 ? vertex() : collection.topology.spokes(static_cast<int>(a))[0].vertex;
        if (a == b)
            continue;
        collection.points[mesh].row(a).swap(collection.points[mesh].row(b));
        const std::vector<OutlyingMesh> found = find_outlying_meshes(collection);
        ASSERT_EQ(found.size(), 1U) << round;
        EXPECT_EQ(found[0].mesh, mesh);
        EXPECT_TRUE(found[0].message.starts_with(collection.names[mesh] + " is far from all"))
            << found[0].message;
        const auto spokes = collection.topology.spokes(found[0].vertex);
        EXPECT_TRUE(found[0].vertex == a || found[0].vertex == b ||
                    std::any_of(spokes.begin(), spokes.end(), [&](const Topology::Spoke& spoke) {
                        return spoke.vertex == a || spoke.vertex == b;
                    }));
    }
}

TEST(OutlyingMeshes, AreThoseOfAnotherShape)
{
    Collection collection = spheres(10);
    collection.points[7].col(0) *= 3.0;
    EXPECT_EQ(outliers(collection), std::vector<std::size_t>{7});
    // Two that are near one another are a group.
    collection.points[8] = collection.points[7];
    collection.points[8].col(1) *= 1.01;
    EXPECT_TRUE(outliers(collection).empty());
}

/// To the nearest of all others.
double nearest_distance(const Collection& collection, std::size_t mesh)
{
    const auto shape_of = [&](std::size_t i) -> Eigen::VectorXd {
        const Eigen::VectorXd lengths = edge_lengths(collection.topology, collection.points[i]);
        return lengths / lengths.sum();
    };
    const Eigen::VectorXd shape = shape_of(mesh);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < collection.size(); ++i)
        if (i != mesh)
            nearest = std::min(nearest, (shape_of(i) - shape).norm());
    return nearest;
}

TEST(OutlyingMeshes, AreFoundAmongMoreThanAreAllCompared)
{
    // Of 2,100 meshes every second or third one is compared with all: 0, 2, 4, 6, 8, 10, ...
    Collection collection = spheres(2100, 0);
    for (const std::size_t mesh : {3U, 5U}) // near one another, far from all that are compared
        collection.points[mesh] = collection.points[0];
    collection.points[3].col(0) *= 3.0;
    collection.points[5].col(0) *= 3.01;
    collection.points[9].col(1) *= 3.0;
    collection.points[10].col(2) *= 3.0;
    const std::vector<OutlyingMesh> found = find_outlying_meshes(collection);
    ASSERT_EQ(found.size(), 2U);
    for (const std::size_t i : {0U, 1U}) {
        EXPECT_EQ(found[i].mesh, 9 + i);
        EXPECT_NEAR(found[i].distance, nearest_distance(collection, 9 + i), 1e-9);
    }
}

TEST(OutlyingMeshes, NeedFiveMeshes)
{
    Collection collection = spheres(4);
    collection.points[1].col(0) *= 9.0;
    EXPECT_TRUE(outliers(collection).empty());
}

TEST(OutlyingMeshes, CopiesAndMirrorImagesMakeNoOutliersOfTheRest)
{
    Collection collection = spheres(6);
    for (std::size_t i = 0; i < 5; ++i) { // the sixth has no copy
        collection.names.push_back("copy" + std::to_string(i));
        collection.points.push_back(test::mirror_image(collection.points[i]));
    }
    for (const OutlyingMesh& found : find_outlying_meshes(collection))
        ADD_FAILURE() << found.message;
}

} // namespace
} // namespace shape
