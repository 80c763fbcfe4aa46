// SPDX-License-Identifier: MIT

#include "libshape/model/outlying_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>

#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/io/mesh_file.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/data.h"
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

TEST(OutlyingMeshes, AreTwoWithTheSameSlip)
{
    Random random(6);
    for (int round = 0; round < 20; ++round) {
        Collection collection = spheres(5 + random.index(6));
        const auto vertex = [&] {
            return static_cast<Eigen::Index>(
                random.index(static_cast<std::uint64_t>(collection.topology.vertex_count())));
        };
        const Eigen::Index a = vertex();
        const Eigen::Index b = vertex();
        if (a == b)
            continue;
        for (const std::size_t mesh : {1U, 3U})
            collection.points[mesh].row(a).swap(collection.points[mesh].row(b));
        EXPECT_EQ(outliers(collection), (std::vector<std::size_t>{1, 3})) << round;
        for (const OutlyingMesh& found : find_outlying_meshes(collection)) {
            const std::string other = found.mesh == 1 ? "m3" : "m1";
            EXPECT_TRUE(found.message.starts_with(join("m", found.mesh,
                                                       " is far from all other meshes but ", other,
                                                       ": vertex ", found.vertex, " lies ")))
                << found.message;
        }
    }
}

TEST(OutlyingMeshes, AreThoseWithExchangedLandmarks)
{
    // What lies around two places is taken to the other one, as a registration by exchanged landmarks does.
    Collection collection = spheres(8, 4);
    Points& points = collection.points[5];
    const Points before = points;
    const Eigen::RowVector3d first = before.row(0);
    Eigen::Index near = 0; // about seven edges away
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index v = 0; v < before.rows(); ++v)
        if (const double off = std::abs((before.row(v) - first).norm() - 0.5); off < least) {
            least = off;
            near = v;
        }
    const Eigen::RowVector3d way = before.row(near) - first;
    for (Eigen::Index v = 0; v < points.rows(); ++v)
        for (const double side : {1.0, -1.0}) {
            const Eigen::RowVector3d from = side > 0.0 ? first : before.row(near).eval();
            const double far = (before.row(v) - from).squaredNorm() / way.squaredNorm();
            points.row(v) += side * std::exp(-2.0 * far) * way;
        }
    const std::vector<OutlyingMesh> found = find_outlying_meshes(collection);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].mesh, 5U);
    EXPECT_GT(found[0].region_shift, 0.8);
}

/// Every so many-th PLY file of a folder, by name.
Collection read_every(std::size_t step, const std::filesystem::path& folder)
{
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".ply")
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<NamedMesh> meshes;
    for (std::size_t i = 0; i < files.size(); i += step)
        meshes.push_back(read_mesh(files[i]));
    return collect(std::move(meshes));
}

TEST(OutlyingMeshes, AreNoPosesOfAnArticulatedThing)
{
    Random random(8);
    for (const char* name : {"mh_body_poses", "mh_arm", "mh_hand"}) {
        const std::filesystem::path folder = test::data_dir() / name;
        if (!std::filesystem::exists(folder))
            GTEST_SKIP() << folder << " is missing";
        const Collection all = read_every(1, folder);
        EXPECT_TRUE(outliers(all).empty()) << name; // squat by its knees, with angles alone
        int warned = 0;
        constexpr int rounds = 8; // half of those of bodies had one
        for (int round = 0; round < rounds; ++round) {
            std::vector<std::size_t> some(all.size());
            std::iota(some.begin(), some.end(), 0);
            for (std::size_t i = some.size(); i > 1; --i)
                std::swap(some[i - 1], some[random.index(i)]);
            some.resize(5 + static_cast<std::size_t>(round) % (all.size() - 5));
            std::sort(some.begin(), some.end());
            warned += outliers(subset(all, some)).empty() ? 0 : 1;
        }
        EXPECT_LE(warned, 1) << name;
    }
}

TEST(OutlyingMeshes, AreThoseWithOneVertexMovedByTwoEdgesInAnyDirection)
{
    const std::filesystem::path folder = test::data_dir() / "ict_faces600";
    if (!std::filesystem::exists(folder))
        GTEST_SKIP() << folder << " is missing";
    const Collection all = read_every(5, folder);
    int found = 0;
    int sound = 0;
    constexpr int trials = 50;
    for (int trial = 0; trial < trials; ++trial) {
        Random random(static_cast<std::uint64_t>(trial));
        std::vector<std::size_t> some(all.size());
        std::iota(some.begin(), some.end(), 0);
        for (std::size_t i = some.size(); i > 1; --i)
            std::swap(some[i - 1], some[random.index(i)]);
        some.resize(20);
        Collection collection = subset(all, some);
        const std::size_t mesh = random.index(collection.size());
        const auto vertex = static_cast<Eigen::Index>(
            random.index(static_cast<std::uint64_t>(collection.topology.vertex_count())));
        const Eigen::RowVector3d direction(random.normal(), random.normal(), random.normal());
        Points& points = collection.points[mesh];
        points.row(vertex) +=
            2.0 * edge_lengths(collection.topology, points).mean() * direction.normalized();
        for (const std::size_t outlier : outliers(collection))
            (outlier == mesh ? found : sound) += 1;
    }
    EXPECT_GE(found, trials - 1); // along the normal, edges are longer and nothing else
    EXPECT_LE(sound, 3);
}

/// A sheet whose vertices are drawn anew in every mesh, `jitter` of an edge; the squares are cut along either diagonal.
Collection jittered_sheets(double jitter, std::uint64_t seed)
{
    constexpr int n = 30;
    Random random(seed);
    Faces faces(2 * n * n, 3);
    Points flat((n + 1) * (n + 1), 3);
    const auto vertex = [](int i, int j) { return i * (n + 1) + j; };
    Eigen::Index f = 0;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) {
            flat.row(vertex(i, j)) << i, j, 0.0;
            if (i == n || j == n)
                continue;
            const int a = vertex(i, j), b = vertex(i, j + 1);
            const int c = vertex(i + 1, j + 1), d = vertex(i + 1, j);
            const bool is_turned = random.uniform() < 0.5;
            faces.row(f++) << a, b, (is_turned ? d : c);
            faces.row(f++) << (is_turned ? b : a), c, d;
        }
    Collection sheets{Topology(faces, static_cast<int>(flat.rows())), {}, {}, {}};
    for (int k = 0; k < 10; ++k) {
        sheets.names.push_back(join("m", k));
        sheets.points.push_back(flat);
        for (double& x : sheets.points.back().reshaped())
            x += jitter * random.normal();
    }
    return sheets;
}

TEST(OutlyingMeshes, AreSeldomAmongJitteredSheetsWhateverTheirDiagonals)
{
    for (const double jitter : {0.1, 0.2}) {
        int named = 0;
        for (std::uint64_t seed = 0; seed < 40; ++seed)
            named += outliers(jittered_sheets(jitter, seed)).empty() ? 0 : 1;
        EXPECT_LE(named, 2) << jitter;
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

/// Meshes that differ in a few directions alone.
Collection family(std::size_t count, int directions, bool is_lognormal, Random& random)
{
    const test::TestMesh first = test::bumpy_sphere(1, 0.2, 0);
    Collection collection{first.topology, {}, {}, {}};
    for (std::size_t i = 0; i < count; ++i) {
        collection.names.push_back(join("m", i));
        Points points = first.points;
        for (int d = 0; d < directions; ++d) {
            const double normal = random.normal();
            const double score = is_lognormal ? std::exp(0.5 * normal) : normal;
            points += 0.05 * score *
                      (test::bumpy_sphere(1, 0.5, static_cast<unsigned>(7 + d)).points -
                       test::icosphere(1).points);
        }
        collection.points.push_back(points);
    }
    return collection;
}

TEST(OutlyingMeshes, AreSeldomInSoundFamiliesOfFewDirections)
{
    Random random(3);
    for (const bool is_lognormal : {false, true}) {
        int warned = 0;
        int all = 0;
        for (const int directions : {1, 2, 3})
            for (const std::size_t count : {5U, 8U, 15U, 30U})
                for (int round = 0; round < 25; ++round, ++all)
                    warned +=
                        outliers(family(count, directions, is_lognormal, random)).empty() ? 0 : 1;
        EXPECT_LE(warned, is_lognormal ? 9 : 3)
            << "of " << all; // 57 and 106 by the neighbours alone
    }
}

TEST(OutlyingMeshes, AreThoseThatDifferInADirectionInWhichNoOtherDoes)
{
    Random random(5);
    for (int round = 0; round < 5; ++round) {
        Collection collection = family(30, 1, false, random);
        EXPECT_TRUE(outliers(collection).empty());
        collection.points[4] +=
            0.2 * (test::bumpy_sphere(1, 0.5, 50).points - test::icosphere(1).points);
        EXPECT_EQ(outliers(collection), std::vector<std::size_t>{4});
    }
}

TEST(OutlyingMeshes, AreFoundInFamiliesOfFewDirections)
{
    Random random(4);
    for (const int directions : {1, 2, 3})
        for (const std::size_t count : {5U, 8U, 15U, 30U})
            for (int round = 0; round < 5; ++round) {
                Collection exchanged = family(count, directions, false, random);
                exchanged.points[3].row(1).swap(exchanged.points[3].row(30));
                EXPECT_TRUE(std::ranges::count(outliers(exchanged), 3U)) << directions << count;
                Collection other = family(count, directions, false, random);
                other.points[2] = test::bumpy_sphere(1, 0.9, 99).points;
                other.points[2].col(0) *= 2.0;
                EXPECT_TRUE(std::ranges::count(outliers(other), 2U)) << directions << count;
            }
}

} // namespace
} // namespace shape
