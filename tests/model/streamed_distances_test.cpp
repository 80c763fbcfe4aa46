// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_distances.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "libshape/model/shape_distances.h"
#include "tests/support/collections.h"
#include "tests/support/thread_ranks.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

using Eigen::Index;

/// All rows, and in how many parts they came.
Eigen::MatrixXd matrix_of(const Collection& collection, const StreamedDistancesOptions& options,
                          int* parts = nullptr)
{
    const auto count = static_cast<Index>(collection.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Constant(count, count, -1.0);
    (void)for_each_distance_row(stream_of(collection), options,
                                [&](Index first, const RowMatrix& distances) {
                                    matrix.middleRows(first, distances.rows()) = distances;
                                    if (parts != nullptr)
                                        ++*parts;
                                });
    return matrix;
}

/// The last three meshes are the first, nearly the first and the second.
Collection spheres_and_copies()
{
    Collection collection = test::bumpy_spheres(300, 1);
    collection.points[297] = collection.points[0];
    collection.points[298] = collection.points[0] * (1.0 + 1e-7);
    collection.points[298].col(0) *= 1.0 + 1e-9;
    collection.points[299] = collection.points[1];
    return collection;
}

TEST(StreamedDistances, AreThoseOfTheCollectionInMemory)
{
    const Collection collection = spheres_and_copies();
    for (const SpaceOptions& space : {SpaceOptions{}, SpaceOptions{.scale = Scale::None},
                                      SpaceOptions{.dihedral_weight = 0.2}}) {
        const Eigen::MatrixXd expected = shape_distances(collection, space).matrix;
        const Eigen::MatrixXd found = matrix_of(collection, {.space = space});
        EXPECT_LE(((found - expected).array().abs() - 1e-10 * expected.array()).maxCoeff(), 1e-16);
        EXPECT_EQ(found, found.transpose());
        EXPECT_EQ(found.diagonal(), Eigen::VectorXd::Zero(300));
        EXPECT_EQ(found(297, 0), 0.0);
        EXPECT_EQ(found(299, 1), 0.0);
    }
}

TEST(StreamedDistances, HaveTheSameBitsForAnyMemoryAndThreadCount)
{
    const Collection collection = spheres_and_copies();
    int few = 0;
    const Eigen::MatrixXd expected = matrix_of(collection, {}, &few);
    EXPECT_EQ(few, 1);
    int many = 0;
    const test::ThreadScope scope(1);
    EXPECT_EQ(matrix_of(collection, {.memory = 2 * 128 * 8 * 420}, &many), expected);
    EXPECT_EQ(many, 3);
}

TEST(StreamedDistances, AreThoseOfOneProcessForSeveral)
{
    const Collection collection = spheres_and_copies();
    const Eigen::MatrixXd expected = matrix_of(collection, {});
    for (const int count : {2, 4})
        test::run_as_ranks(count, [&](const Ranks& ranks) {
            EXPECT_EQ(matrix_of(collection, {.ranks = ranks}), expected);
        });
}

TEST(StreamedDistances, RefuseWhatBreaksARule)
{
    const Collection collection = test::bumpy_spheres(4, 1);
    EXPECT_THROW((void)matrix_of(subset(collection, {0}), {}), InvalidInput);
    EXPECT_THROW((void)matrix_of(collection, {.space = {.kind = SpaceKind::Procrustes}}),
                 InvalidInput);
    EXPECT_THROW((void)matrix_of(collection, {.memory = 1000}), LimitExceeded);
    EXPECT_THROW((void)classical_scaling(stream_of(collection), 0, {}), InvalidInput);
    EXPECT_THROW((void)classical_scaling(stream_of(collection), 5, {}), InvalidInput);
    Ranks ranks;
    ranks.count = 2; // of one partial sum
    EXPECT_THROW((void)matrix_of(collection, {.ranks = ranks}), InvalidInput);
}

TEST(StreamedDistances, AreScaledToThePlaneAsTheirMatrixIs)
{
    const Collection collection = test::bumpy_spheres(30, 2);
    const ClassicalScaling expected = classical_scaling(shape_distances(collection, {}).matrix, 2);
    const ClassicalScaling found = classical_scaling(stream_of(collection), 2, {});
    EXPECT_LE((found.points - expected.points).cwiseAbs().maxCoeff(),
              1e-8 * expected.points.maxCoeff());
    EXPECT_LE((found.eigenvalues - expected.eigenvalues).cwiseAbs().maxCoeff(),
              1e-9 * expected.eigenvalues[0]);
    EXPECT_NEAR(found.total, expected.total, 1e-9 * expected.total);
}

} // namespace
} // namespace shape
