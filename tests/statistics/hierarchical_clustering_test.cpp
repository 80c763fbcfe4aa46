// SPDX-License-Identifier: MIT

#include "libshape/statistics/hierarchical_clustering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/distance_matrix.h"
#include "tests/support/matrices.h"

namespace shape {
using namespace internal;
namespace {

using Cluster = std::vector<int>;

/// Average linkage by its definition: the mean over all pairs of original distances.
std::vector<std::pair<double, std::set<int>>> by_definition(const Eigen::MatrixXd& distances)
{
    std::vector<Cluster> clusters;
    for (int i = 0; i < distances.rows(); ++i)
        clusters.push_back({i});
    const auto average = [&](const Cluster& a, const Cluster& b) {
        double sum = 0.0;
        for (const int i : a)
            for (const int j : b)
                sum += distances(i, j);
        return sum / static_cast<double>(a.size() * b.size());
    };
    std::vector<std::pair<double, std::set<int>>> merges;
    while (clusters.size() > 1) {
        std::size_t first = 0;
        std::size_t second = 1;
        for (std::size_t a = 0; a < clusters.size(); ++a)
            for (std::size_t b = a + 1; b < clusters.size(); ++b)
                if (average(clusters[a], clusters[b]) < average(clusters[first], clusters[second]))
                    first = a, second = b;
        const double height = average(clusters[first], clusters[second]);
        clusters[first].insert(clusters[first].end(), clusters[second].begin(),
                               clusters[second].end());
        merges.emplace_back(height, std::set(clusters[first].begin(), clusters[first].end()));
        clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(second));
    }
    return merges;
}

/// The observations of every cluster, first the single ones.
std::vector<std::set<int>> members(const Clustering& clustering)
{
    std::vector<std::set<int>> all;
    for (int i = 0; i < static_cast<int>(clustering.order.size()); ++i)
        all.push_back({i});
    for (const Merge& merge : clustering.merges) {
        std::set<int> both = all.at(to_size(merge.first));
        const std::set<int>& second = all.at(to_size(merge.second));
        both.insert(second.begin(), second.end());
        all.push_back(both);
    }
    return all;
}

TEST(AverageLinkage, OfPointsOnALine)
{
    // 0 and 1 merge at 1, 5 and 7 at 2; then 3 joins the first at 2.5; all at the mean of 2 by 3.
    const Eigen::MatrixXd distances =
        distance_matrix((RowMatrix(5, 1) << 5, 0, 7, 1, 3).finished());
    const Clustering clustering = cluster_by_average_linkage(distances);
    ASSERT_EQ(clustering.merges.size(), 4U);
    const auto expect = [&](std::size_t k, int first, int second, double height, int count) {
        EXPECT_EQ(clustering.merges[k].first, first);
        EXPECT_EQ(clustering.merges[k].second, second);
        EXPECT_DOUBLE_EQ(clustering.merges[k].height, height);
        EXPECT_EQ(clustering.merges[k].count, count);
    };
    expect(0, 1, 3, 1.0, 2);
    expect(1, 0, 2, 2.0, 2);
    expect(2, 5, 4, 2.5, 3);
    expect(3, 6, 7, (5 + 4 + 2 + 7 + 6 + 4) / 6.0, 5);
    EXPECT_EQ(clustering.order, (std::vector<int>{0, 2, 1, 3, 4}));
    const std::vector<double> heights = joining_heights(clustering);
    const std::vector<double> expected{0.0, 2.0, 28.0 / 6.0, 1.0, 2.5};
    ASSERT_EQ(heights.size(), expected.size());
    for (std::size_t i = 0; i < heights.size(); ++i)
        EXPECT_DOUBLE_EQ(heights[i], expected[i]);
}

TEST(AverageLinkage, IsThatOfItsDefinition)
{
    for (unsigned seed = 1; seed <= 20; ++seed) {
        const Eigen::MatrixXd distances = distance_matrix(test::random_matrix(25, 3, seed));
        const Clustering clustering = cluster_by_average_linkage(distances);
        const auto expected = by_definition(distances);
        const std::vector<std::set<int>> clusters = members(clustering);
        ASSERT_EQ(clustering.merges.size(), expected.size());
        for (std::size_t k = 0; k < expected.size(); ++k) {
            EXPECT_NEAR(clustering.merges[k].height, expected[k].first, 1e-13);
            EXPECT_EQ(clusters[25 + k], expected[k].second);
            EXPECT_EQ(to_size(clustering.merges[k].count), expected[k].second.size());
        }
    }
}

TEST(AverageLinkage, PutsEveryClusterInOneRunOfTheOrder)
{
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const Clustering clustering =
            cluster_by_average_linkage(distance_matrix(test::random_matrix(40, 2, seed)));
        std::vector<int> sorted = clustering.order;
        std::sort(sorted.begin(), sorted.end());
        for (int i = 0; i < 40; ++i)
            EXPECT_EQ(sorted[to_size(i)], i);
        for (const std::set<int>& cluster : members(clustering)) {
            const auto first = std::find_if(clustering.order.begin(), clustering.order.end(),
                                            [&](int i) { return cluster.contains(i); });
            EXPECT_TRUE(std::all_of(first, first + static_cast<std::ptrdiff_t>(cluster.size()),
                                    [&](int i) { return cluster.contains(i); }));
        }
    }
}

TEST(AverageLinkage, JoinsNeighboursWhereTheirLowestCommonClusterIs)
{
    const Clustering clustering =
        cluster_by_average_linkage(distance_matrix(test::random_matrix(30, 2, 5)));
    const std::vector<std::set<int>> clusters = members(clustering);
    const std::vector<double> heights = joining_heights(clustering);
    for (std::size_t position = 1; position < 30; ++position) {
        std::size_t k = 0;
        while (!clusters[30 + k].contains(clustering.order[position]) ||
               !clusters[30 + k].contains(clustering.order[position - 1]))
            ++k;
        EXPECT_EQ(heights[position], clustering.merges[k].height);
    }
}

TEST(AverageLinkage, ResolvesTiesByTheLowerIndices)
{
    const Eigen::MatrixXd equal = Eigen::MatrixXd::Ones(4, 4) - Eigen::MatrixXd::Identity(4, 4);
    const Clustering clustering = cluster_by_average_linkage(equal);
    EXPECT_EQ(clustering.order, (std::vector<int>{0, 1, 2, 3}));
    EXPECT_EQ(clustering.merges[0].first, 0);
    EXPECT_EQ(clustering.merges[0].second, 1);
    for (const Merge& merge : clustering.merges)
        EXPECT_EQ(merge.height, 1.0);
}

TEST(AverageLinkage, OfOneThingIsThatThing)
{
    const Clustering clustering = cluster_by_average_linkage(Eigen::MatrixXd::Zero(1, 1));
    EXPECT_TRUE(clustering.merges.empty());
    EXPECT_EQ(clustering.order, std::vector<int>{0});
    EXPECT_EQ(joining_heights(clustering), std::vector<double>{0.0});
}

TEST(AverageLinkage, RefusesWhatIsNotAMatrixOfDistances)
{
    EXPECT_THROW((void)cluster_by_average_linkage(-Eigen::MatrixXd::Ones(2, 2)), InvalidInput);
    EXPECT_THROW((void)cluster_by_average_linkage(Eigen::MatrixXd::Zero(2, 3)), InvalidInput);
}

} // namespace
} // namespace shape
