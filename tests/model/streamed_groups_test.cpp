// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_groups.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "tests/support/collections.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

using Eigen::Index;

/// Groups and blocks of 24 meshes: every mesh by itself; subjects in two states; repeated scans, of some more than of
/// others; subjects in three states, of whom two lack some; groups of one and of two; one subject in two states among
/// others in one.
struct Design
{
    const char* name;
    Grouping groups;
    Grouping blocks;
    bool takes_no_slope = false; ///< One more column leaves no degree of freedom.
};

std::vector<Design> designs()
{
    std::vector<std::string> thirds, states, subjects, sexes, halves;
    for (int i = 0; i < 24; ++i) {
        thirds.emplace_back(i % 5 == 0 ? "a" : i % 3 == 0 ? "b" : "c");
        halves.emplace_back(i < 11 ? "a" : "b");
        states.emplace_back(i % 2 == 0 ? "rest" : "smile");
        subjects.push_back(internal::join("s", i % 12 / 2));
        sexes.emplace_back(i % 12 / 2 % 2 == 0 ? "f" : "m");
    }
    std::vector<std::string> few, slip;
    for (int i = 0; i < 24; ++i) {
        few.emplace_back(i == 3 ? "one" : i == 5 || i == 9 ? "pair" : i % 2 == 0 ? "a" : "b");
        slip.emplace_back(i == 17 || (i != 8 && i / 3 % 2 == 0) ? "a" : "b");
    }
    std::vector<std::string> people, of_people, triples, three_states;
    const std::vector<int> scans{5, 1, 2, 3, 1, 2, 1, 5, 1, 3};
    for (std::size_t person = 0; person < scans.size(); ++person)
        for (int k = 0; k < scans[person]; ++k) {
            people.push_back(internal::join("p", person));
            of_people.emplace_back(person % 2 == 0 ? "f" : "m");
        }
    for (int i = 0; i < 24; ++i) {
        triples.push_back(internal::join("t", i / 3));
        three_states.push_back(std::to_string(i == 8 ? 1 : i >= 21 ? 0 : i % 3));
    }
    return {{"single", group_by(thirds), groups_of_one(24)},
            {"two", group_by(halves), groups_of_one(24)},
            {"crossed", group_by(states), group_by(subjects)},
            {"nested", group_by(sexes), group_by(subjects)},
            {"scans", group_by(of_people), group_by(people)},
            {"incomplete", group_by(three_states), group_by(triples)},
            {"few", group_by(few), groups_of_one(24)},
            {"slip", group_by(slip), group_by(triples), true}};
}

void expect_near(const LinearModelTest& a, const LinearModelTest& b)
{
    EXPECT_EQ(std::isnan(a.f), std::isnan(b.f));
    EXPECT_EQ(a.permutations, b.permutations);
    if (std::isnan(b.f)) // not tested
        return;
    EXPECT_NEAR(a.sum_of_squares, b.sum_of_squares, 1e-10 * b.total_sum_of_squares);
    EXPECT_NEAR(a.residual_sum_of_squares, b.residual_sum_of_squares,
                1e-10 * b.total_sum_of_squares);
    EXPECT_NEAR(a.total_sum_of_squares, b.total_sum_of_squares, 1e-10 * b.total_sum_of_squares);
    EXPECT_EQ(a.degrees_of_freedom, b.degrees_of_freedom);
    EXPECT_EQ(a.residual_degrees_of_freedom, b.residual_degrees_of_freedom);
    EXPECT_EQ(a.p_value, b.p_value);
}

void expect_near(const StreamedGroups& a, const GroupComparison& comparison,
                 const GroupSpread& spread, const LinearModelTest& spread_test)
{
    EXPECT_EQ(a.comparison.design, comparison.design);
    EXPECT_EQ(a.comparison.left_out, comparison.left_out);
    EXPECT_EQ(a.spread.counts, spread.counts);
    expect_near(a.comparison.overall, comparison.overall);
    expect_near(a.spread_test, spread_test);
    ASSERT_EQ(a.comparison.pairs.size(), comparison.pairs.size());
    for (std::size_t k = 0; k < comparison.pairs.size(); ++k) {
        const PairComparison& pair = comparison.pairs[k];
        EXPECT_NEAR(a.comparison.pairs[k].distance, pair.distance, 1e-9 * pair.distance);
        expect_near(a.comparison.pairs[k].test, pair.test);
        if (pair.test.permutations > 0) {
            EXPECT_EQ(a.comparison.pairs[k].adjusted_p, pair.adjusted_p);
        }
    }
    const auto expect_same = [](double x, double y, double rounding = 0.0) {
        EXPECT_TRUE(std::abs(x - y) <= 1e-9 * std::abs(y) + rounding ||
                    (std::isnan(x) && std::isnan(y)))
            << x << " " << y;
    };
    for (std::size_t g = 0; g < spread.variances.size(); ++g) {
        // A replicate whose residuals are 0 has those of rounding.
        const double rounding = std::isnan(spread.variances[g]) ? 0.0 : 1e-12 * spread.variances[g];
        expect_same(a.spread.variances[g], spread.variances[g]);
        expect_same(a.spread.variance_intervals[g].low, spread.variance_intervals[g].low, rounding);
        expect_same(a.spread.variance_intervals[g].high, spread.variance_intervals[g].high,
                    rounding);
        for (std::size_t h = 0; h < g; ++h)
            expect_same(a.spread.distance_radii(static_cast<Index>(g), static_cast<Index>(h)),
                        spread.distance_radii(static_cast<Index>(g), static_cast<Index>(h)));
    }
}

TEST(StreamedGroups, AreWhatTheCollectionInMemoryGives)
{
    const Collection collection = test::bumpy_spheres(24, 2);
    for (const Design& design : designs())
        for (const bool adjusts : {false, true})
            for (const bool by_inner_products : {false, true}) {
                SCOPED_TRACE(internal::join(design.name, " ", adjusts, " ", by_inner_products));
                if (adjusts && design.takes_no_slope)
                    continue;
                StreamedGroupsOptions options;
                if (adjusts)
                    options.covariates = [](const Eigen::VectorXd& sizes) { return sizes; };
                const GroupedShapes shapes =
                    group_shapes(collection, design.groups, {}, design.blocks, options.covariates);
                const Eigen::MatrixXd covariates =
                    adjusts ? Eigen::MatrixXd(shapes.sizes) : Eigen::MatrixXd(24, 0);
                options.permutations.permutations = 49;
                options.bootstrap.replicates = 40;
                options.with_companions = true;
                options.by_inner_products = by_inner_products;
                const StreamedGroups found =
                    compare_groups(stream_of(collection), design.groups, design.blocks, options);
                EXPECT_EQ(found.by_inner_products, by_inner_products);
                expect_near(found,
                            compare_groups(shapes.products, design.groups, design.blocks,
                                           covariates, options.permutations),
                            group_spread(shapes.products, design.groups, design.blocks, covariates,
                                         options.bootstrap),
                            test_spread(shapes.products, design.groups, design.blocks, covariates,
                                        options.permutations));
                EXPECT_EQ(found.shapes.covariate_means, shapes.covariate_means);
                EXPECT_LE((found.shapes.means - shapes.means).cwiseAbs().maxCoeff(), 1e-14);
                EXPECT_LE(
                    (found.shapes.dihedral_angles - shapes.dihedral_angles).cwiseAbs().maxCoeff(),
                    1e-13);
                EXPECT_EQ(found.shapes.sizes, shapes.sizes);
                EXPECT_LE((found.shapes.mean_sizes - shapes.mean_sizes).cwiseAbs().maxCoeff(),
                          1e-12 * shapes.sizes.maxCoeff());
                EXPECT_EQ(found.reference_points, collection.points.front());
            }
}

TEST(StreamedGroups, HaveTheSameBitsForAnyMemoryAndThreadCount)
{
    const Collection collection = test::bumpy_spheres(24, 2);
    const Design design = designs().front();
    const auto found = [&](std::uint64_t memory, int threads) {
        const test::ThreadScope scope(threads);
        StreamedGroupsOptions options;
        options.permutations.permutations = 99;
        options.bootstrap.replicates = 20;
        options.by_inner_products = false;
        options.memory = memory;
        return compare_groups(stream_of(collection), design.groups, design.blocks, options);
    };
    const StreamedGroups much = found(1 << 30, 3);
    const StreamedGroups little = found(200000, 1);
    EXPECT_GT(little.passes, much.passes);
    EXPECT_EQ(much.comparison.overall.sum_of_squares, little.comparison.overall.sum_of_squares);
    EXPECT_EQ(much.comparison.overall.residual_sum_of_squares,
              little.comparison.overall.residual_sum_of_squares);
    EXPECT_EQ(much.spread.distances, little.spread.distances);
    EXPECT_EQ(much.spread.variances, little.spread.variances);
    EXPECT_EQ(much.spread_test.f, little.spread_test.f);
}

TEST(StreamedGroups, TakeTheWayThatCostsLess)
{
    const Collection collection = test::bumpy_spheres(24, 1);
    StreamedGroupsOptions options;
    options.bootstrap.replicates = 1;
    const auto takes_inner_products = [&](int permutations) {
        options.permutations.permutations = permutations;
        return compare_groups(stream_of(collection), designs()[1].groups, groups_of_one(24),
                              options)
            .by_inner_products;
    };
    EXPECT_FALSE(takes_inner_products(5));
    EXPECT_TRUE(takes_inner_products(99));
}

TEST(StreamedGroups, RefuseWhatBreaksARule)
{
    const Collection collection = test::bumpy_spheres(4, 1);
    const MeshStream meshes = stream_of(collection);
    const Grouping halves = group_by({"a", "a", "b", "b"});
    EXPECT_THROW((void)compare_groups(meshes, one_group(4), groups_of_one(4), {}), InvalidInput);
    EXPECT_THROW((void)compare_groups(meshes, one_group(3), groups_of_one(4), {}), InvalidInput);
    EXPECT_THROW((void)compare_groups(meshes, halves, groups_of_one(3), {}), InvalidInput);
    EXPECT_THROW((void)compare_groups(meshes, halves, groups_of_one(4),
                                      {.space = {.kind = SpaceKind::Procrustes}}),
                 InvalidInput);
    EXPECT_THROW((void)compare_groups(meshes, halves, groups_of_one(4), {.memory = 1000}),
                 LimitExceeded);
}

} // namespace
} // namespace shape
