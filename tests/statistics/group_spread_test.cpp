// SPDX-License-Identifier: MIT

#include "libshape/statistics/group_spread.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/inner_products.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

/// Two groups of 30 points in five coordinates, the second moved by `move` in each.
RowMatrix two_groups(unsigned seed, double move)
{
    RowMatrix data = test::random_matrix(60, 5, seed);
    data.bottomRows(30).array() += move;
    return data;
}

Grouping halves()
{
    std::vector<std::string> labels;
    for (int i = 0; i < 60; ++i)
        labels.push_back(i < 30 ? "a" : "b");
    return group_by(labels);
}

GroupSpread spread_of(const RowMatrix& data, const Grouping& groups, const Grouping& blocks,
                      const BootstrapOptions& options)
{
    return group_spread(inner_products(data), groups, blocks, Eigen::MatrixXd(data.rows(), 0),
                        options);
}

LinearModelTest spread_test_of(const RowMatrix& data, const Grouping& groups,
                               const Grouping& blocks, const PermutationOptions& options)
{
    return test_spread(inner_products(data), groups, blocks, Eigen::MatrixXd(data.rows(), 0),
                       options);
}

TEST(GroupSpread, MeasuresVariancesAndDistancesOfMeans)
{
    const RowMatrix data = two_groups(1, 2.0);
    const GroupSpread result = spread_of(data, halves(), groups_of_one(60), {.replicates = 50});
    const Eigen::RowVectorXd a = data.topRows(30).colwise().mean();
    const Eigen::RowVectorXd b = data.bottomRows(30).colwise().mean();
    EXPECT_NEAR(result.variances[0], (data.topRows(30).rowwise() - a).squaredNorm() / 29.0, 1e-12);
    EXPECT_NEAR(result.distances(0, 1), (a - b).norm(), 1e-12);
    EXPECT_EQ(result.distances(1, 0), result.distances(0, 1));
    EXPECT_EQ(result.distance_radii(1, 0), result.distance_radii(0, 1));
    EXPECT_NEAR(result.distances(0, 0), 0.0, 1e-7);
    EXPECT_LT(result.variance_intervals[0].low, result.variances[0]);
    EXPECT_GT(result.variance_intervals[0].high, result.variances[0]);
}

TEST(GroupSpread, HoldsTheTrueDifferenceAsOftenAsItSays)
{
    int held = 0;
    constexpr int repetitions = 200;
    for (unsigned repetition = 0; repetition < repetitions; ++repetition) {
        const RowMatrix data = two_groups(100 + repetition, 1.0);
        const GroupSpread result =
            spread_of(data, halves(), groups_of_one(60), {.replicates = 200, .seed = repetition});
        const Eigen::RowVectorXd difference =
            data.bottomRows(30).colwise().mean() - data.topRows(30).colwise().mean();
        held += (difference.array() - 1.0).matrix().norm() <= result.distance_radii(0, 1);
    }
    // 95 % nominally, a little less for groups of 30; the standard error is 1.5 %.
    EXPECT_GE(held, 0.89 * repetitions);
    EXPECT_LE(held, 0.99 * repetitions);
}

TEST(GroupSpread, DrawsPairsTogether)
{
    // The two states of a subject differ by the same vector: nothing is uncertain of it.
    RowMatrix data = test::random_matrix(60, 5, 2);
    std::vector<std::string> subjects;
    for (Index i = 0; i < 60; ++i)
        subjects.push_back(std::to_string(i % 30));
    data.bottomRows(30) = data.topRows(30).array() + 1.0;
    const GroupSpread paired = spread_of(data, halves(), group_by(subjects), {.replicates = 50});
    EXPECT_LE(paired.distance_radii(0, 1), 1e-6);
    const GroupSpread unpaired = spread_of(data, halves(), groups_of_one(60), {.replicates = 50});
    EXPECT_GT(unpaired.distance_radii(0, 1), 0.3);
}

TEST(GroupSpread, LeavesOutReplicatesWithoutAGroup)
{
    // Group c is in one of three subjects.
    const RowMatrix data = test::random_matrix(7, 3, 3);
    const GroupSpread result =
        spread_of(data, group_by({"a", "b", "a", "b", "a", "b", "c"}),
                  group_by({"1", "1", "2", "2", "3", "3", "3"}), {.replicates = 100});
    EXPECT_TRUE(std::isfinite(result.distance_radii(0, 1)));
    EXPECT_TRUE(std::isnan(result.distance_radii(0, 2)));
    EXPECT_TRUE(std::isnan(result.variances[2]));
    int refused = 0;
    for (unsigned seed = 0; seed < 20; ++seed)
        try {
            (void)spread_of(data, group_by({"a", "b", "a", "b", "a", "b", "c"}),
                            group_by({"1", "1", "2", "2", "3", "3", "3"}),
                            {.replicates = 1, .seed = seed});
        } catch (const InvalidInput& error) {
            ++refused;
            EXPECT_NE(std::string(error.what()).find("draw more of them"), std::string::npos);
        }
    EXPECT_GT(refused, 0);
    EXPECT_LT(refused, 20);
}

TEST(GroupSpread, OfTooFewReplicatesHasNoIntervals)
{
    const RowMatrix data = two_groups(5, 0.5);
    for (const auto& [replicates, is_known] : {std::pair(1, false), {38, false}, {39, true}}) {
        const GroupSpread found =
            spread_of(data, halves(), groups_of_one(60), {.replicates = replicates});
        EXPECT_EQ(std::isfinite(found.distance_radii(0, 1)), is_known) << replicates;
        EXPECT_EQ(std::isfinite(found.variance_intervals[0].low), is_known) << replicates;
        EXPECT_GT(found.variances[0], 0.0);
        EXPECT_GT(found.distances(0, 1), 0.0);
    }
}

TEST(GroupSpread, OfTooFewIsNotDetermined)
{
    const RowMatrix data = test::random_matrix(12, 3, 61);
    const GroupSpread found =
        spread_of(data, group_by({"1", "2", "2", "3", "3", "3", "6", "6", "6", "6", "6", "6"}),
                  groups_of_one(12), {.replicates = 50});
    EXPECT_TRUE(std::isnan(found.variances[0])); // not 0: of one nothing is known
    EXPECT_NEAR(found.variances[1], 0.5 * (data.row(1) - data.row(2)).squaredNorm(), 1e-12);
    for (Index g = 0; g < 4; ++g) {
        const Interval interval = found.variance_intervals[to_size(g)];
        EXPECT_EQ(std::isfinite(interval.low), g >= 2) << g;
        EXPECT_EQ(std::isfinite(interval.high), g >= 2) << g;
        for (Index h = 0; h < g; ++h) {
            EXPECT_GT(found.distances(g, h), 0.0);
            EXPECT_EQ(std::isfinite(found.distance_radii(g, h)), h >= 2) << g << " " << h;
            EXPECT_EQ(std::isfinite(found.distance_radii(h, g)), h >= 2) << g << " " << h;
        }
    }
}

TEST(GroupSpread, OfTooFewBlocksIsNotDetermined)
{
    // Blocks of the groups that are named: three of a and b, three of b and c, two of c and d, one of a and e,
    // three of e and d.
    std::vector<std::string> groups, blocks;
    int block = 0;
    const auto add = [&](int count, const std::string& first, const std::string& second) {
        for (int k = 0; k < count; ++k, ++block)
            for (const std::string& group : {first, second}) {
                groups.push_back(group);
                blocks.push_back(std::to_string(block));
            }
    };
    add(3, "a", "b");
    add(3, "b", "c");
    add(2, "c", "d");
    add(1, "a", "e");
    add(3, "e", "d");
    const GroupSpread found =
        spread_of(test::random_matrix(static_cast<Index>(groups.size()), 3, 62), group_by(groups),
                  group_by(blocks), {.replicates = 200});
    // In the order of their first rows: a, b, c, d, e. Those of {a, b, c} are linked by three, and d with e.
    for (Index g = 0; g < 5; ++g)
        for (Index h = 0; h < g; ++h)
            EXPECT_EQ(std::isfinite(found.distance_radii(g, h)), g < 3 || h >= 3) << g << " " << h;
    // One block of both among blocks of one group, which count no more.
    const GroupSpread slip =
        spread_of(test::random_matrix(7, 3, 63), group_by({"a", "a", "b", "b", "a", "b", "b"}),
                  group_by({"1", "1", "2", "2", "3", "3", "3"}), {.replicates = 50});
    EXPECT_GT(slip.distances(0, 1), 0.0);
    EXPECT_TRUE(std::isnan(slip.distance_radii(0, 1)));
    EXPECT_TRUE(std::isnan(slip.variances[0]));
    EXPECT_TRUE(std::isnan(slip.variance_intervals[1].high));
}

TEST(GroupSpread, HasNoVarianceWhereTheSlopesLeaveNothing)
{
    // The slope is that of the two members of a, which lie on it.
    const GroupSpread found =
        group_spread(inner_products(test::random_matrix(3, 2, 64)), group_by({"a", "a", "b"}),
                     groups_of_one(3), Eigen::Vector3d(1.0, 2.0, 4.0), {.replicates = 50});
    EXPECT_TRUE(std::isnan(found.variances[0]));
    EXPECT_TRUE(std::isnan(found.variances[1]));
}

/// Points, what counts once of them, and the groups and blocks of both.
struct Repeated
{
    RowMatrix data;
    std::vector<std::string> groups, blocks;
    RowMatrix rows;
    std::vector<std::string> row_groups, row_blocks;
};

/// Twelve people of two sexes, scanned one to four times.
Repeated nested_scans()
{
    Repeated made;
    const RowMatrix scans = test::random_matrix(30, 4, 11);
    made.rows.resize(12, 4);
    Index first = 0;
    for (int person = 0; person < 12; ++person) {
        const Index count = 1 + person % 4;
        made.row_groups.emplace_back(person % 3 == 0 ? "f" : "m");
        made.row_blocks.push_back(std::to_string(person));
        for (Index k = 0; k < count; ++k) {
            made.groups.push_back(made.row_groups.back());
            made.blocks.push_back(made.row_blocks.back());
        }
        made.rows.row(person) = scans.middleRows(first, count).colwise().mean();
        first += count;
    }
    made.data = scans.topRows(first);
    return made;
}

/// Eight people before and after, some scans of them taken twice; three others before alone.
Repeated crossed_scans()
{
    Repeated made;
    const RowMatrix people = 10.0 * test::random_matrix(11, 4, 12);
    const RowMatrix scans = test::random_matrix(40, 4, 13);
    made.data.resize(40, 4);
    made.rows.resize(16, 4);
    Index first = 0, row = 0;
    for (int person = 0; person < 11; ++person)
        for (const char* when : {"pre", "post"}) {
            if (person >= 8 && when == std::string("post"))
                continue;
            const Index count = 1 + (person + (when == std::string("pre") ? 0 : 1)) % 3 / 2;
            for (Index k = 0; k < count; ++k) {
                made.data.row(first + k) = scans.row(first + k) + people.row(person);
                made.groups.emplace_back(when);
                made.blocks.push_back(std::to_string(person));
            }
            if (person < 8) {
                made.rows.row(row++) = made.data.middleRows(first, count).colwise().mean();
                made.row_groups.emplace_back(when);
                made.row_blocks.push_back(std::to_string(person));
            }
            first += count;
        }
    made.data.conservativeResize(first, Eigen::NoChange);
    return made;
}

void expect_near(const GroupSpread& a, const GroupSpread& b)
{
    EXPECT_EQ(a.counts, b.counts);
    EXPECT_LE((a.distances - b.distances).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LE((a.distance_radii - b.distance_radii).cwiseAbs().maxCoeff(), 1e-10);
    for (std::size_t g = 0; g < b.variances.size(); ++g) {
        EXPECT_NEAR(a.variances[g], b.variances[g], 1e-10);
        EXPECT_NEAR(a.variance_intervals[g].low, b.variance_intervals[g].low, 1e-10);
        EXPECT_NEAR(a.variance_intervals[g].high, b.variance_intervals[g].high, 1e-10);
    }
}

TEST(GroupSpread, IsThatOfWhatCountsOnce)
{
    for (const Repeated& made : {nested_scans(), crossed_scans()}) {
        const Grouping groups = group_by(made.groups), blocks = group_by(made.blocks);
        const Grouping rows = group_by(made.row_groups), row_blocks = group_by(made.row_blocks);
        const GroupSpread found = spread_of(made.data, groups, blocks, {.replicates = 60});
        expect_near(found, spread_of(made.rows, rows, row_blocks, {.replicates = 60}));
        const Eigen::MatrixXd inside = indicators(rows);
        const RowMatrix means =
            inside.colwise().sum().cwiseInverse().asDiagonal() * inside.transpose() * made.rows;
        EXPECT_NEAR(found.distances(0, 1), (means.row(0) - means.row(1)).norm(), 1e-11);
        const LinearModelTest spread =
            spread_test_of(made.data, groups, blocks, {.permutations = 49});
        const LinearModelTest of_rows =
            spread_test_of(made.rows, rows, row_blocks, {.permutations = 49});
        EXPECT_NEAR(spread.f, of_rows.f, 1e-9 * of_rows.f);
        EXPECT_EQ(spread.p_value, of_rows.p_value);
    }
    // Within people: their means differ by the mean difference, however often each was scanned.
    const Repeated made = crossed_scans();
    RowMatrix difference = RowMatrix::Zero(1, 4);
    for (Index person = 0; person < 8; ++person)
        difference += (made.rows.row(2 * person + 1) - made.rows.row(2 * person)) / 8.0;
    EXPECT_NEAR(
        spread_of(made.data, group_by(made.groups), group_by(made.blocks), {.replicates = 1})
            .distances(0, 1),
        difference.norm(), 1e-11);
}

/// Coefficients of a fit to rows that count some times each.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& data,
                              const Eigen::VectorXd& times)
{
    const Eigen::VectorXd roots = times.cwiseSqrt();
    return (roots.asDiagonal() * columns)
        .completeOrthogonalDecomposition()
        .solve(roots.asDiagonal() * data);
}

TEST(GroupSpread, IsAdjustedForCovariates)
{
    RowMatrix data = two_groups(21, 0.5);
    Eigen::MatrixXd covariates = test::random_matrix(60, 2, 22);
    covariates.col(0).tail(30).array() += 1.5;
    data += 3.0 * covariates * test::random_matrix(2, 5, 23);
    const BootstrapOptions options{.replicates = 80, .seed = 3};
    const GroupSpread found =
        group_spread(inner_products(data), halves(), groups_of_one(60), covariates, options);

    Eigen::MatrixXd columns(60, 4);
    columns << indicators(halves()), covariates;
    const Eigen::MatrixXd all = least_squares(columns, data, Eigen::VectorXd::Ones(60));
    const Eigen::RowVectorXd difference = all.row(0) - all.row(1);
    EXPECT_NEAR(found.distances(0, 1), difference.norm(), 1e-11);
    const Eigen::MatrixXd left = data - columns * all;
    const Eigen::MatrixXd hat = columns * columns.completeOrthogonalDecomposition().pseudoInverse();
    for (const Index start : {0, 30}) {
        const double freedom = 30.0 - hat.diagonal().segment(start, 30).sum();
        EXPECT_NEAR(found.variances[start > 0 ? 1 : 0],
                    left.middleRows(start, 30).squaredNorm() / freedom, 1e-11);
        EXPECT_LT(freedom, 29.0);
    }
    // Replicates, found anew from the observations that were drawn.
    const RowMatrix replicates = bootstrap(
        {groups_of_one(60), halves()},
        [&](const Eigen::VectorXd& times) -> Eigen::VectorXd {
            const Eigen::MatrixXd drawn = least_squares(columns, data, times);
            Eigen::Vector2d result;
            result[0] = (drawn.row(0) - drawn.row(1) - difference).norm();
            const Eigen::RowVectorXd mean =
                times.head(30).transpose() * left.topRows(30) / times.head(30).sum();
            result[1] =
                times.head(30).dot((left.topRows(30).rowwise() - mean).rowwise().squaredNorm()) /
                29.0 * 29.0 / (30.0 - hat.diagonal().head(30).sum());
            return result;
        },
        options);
    EXPECT_NEAR(found.distance_radii(0, 1), quantile(replicates.col(0), 0.95), 1e-10);
    const Interval interval = percentile_interval(replicates.col(1), 0.95);
    EXPECT_NEAR(found.variance_intervals[0].low, interval.low, 1e-10);
    EXPECT_NEAR(found.variance_intervals[0].high, interval.high, 1e-10);
}

TEST(GroupSpread, OfBlocksThatLackAGroupIsOfLeastSquares)
{
    // Nine people in three states, of which two lack one; each state moves all by the same vector.
    const RowMatrix people = 10.0 * test::random_matrix(9, 4, 31);
    const RowMatrix states = test::random_matrix(3, 4, 32);
    std::vector<std::string> groups, blocks;
    RowMatrix data(25, 4);
    Index row = 0;
    for (Index person = 0; person < 9; ++person)
        for (Index state = 0; state < 3; ++state)
            if (!(person == 1 && state == 0) && !(person == 4 && state == 2)) {
                data.row(row++) = people.row(person) + states.row(state);
                groups.push_back(std::to_string(state));
                blocks.push_back(std::to_string(person));
            }
    const Eigen::MatrixXd age = test::random_matrix(25, 1, 33);
    for (const bool adjusts : {false, true}) {
        const RowMatrix seen =
            adjusts ? RowMatrix(data + age * test::random_matrix(1, 4, 34)) : data;
        const GroupSpread found =
            group_spread(inner_products(seen), group_by(groups), group_by(blocks),
                         adjusts ? age : Eigen::MatrixXd(25, 0), {.replicates = 50});
        for (Index g = 0; g < 3; ++g)
            for (Index h = 0; h < g; ++h)
                EXPECT_NEAR(found.distances(g, h), (states.row(g) - states.row(h)).norm(), 1e-10);
        EXPECT_LE(found.distance_radii.maxCoeff(), 1e-5); // whoever is drawn
        EXPECT_EQ(found.counts, (std::vector<int>{8, 9, 8}));
    }
    // The variance of a state is that of the people in it.
    std::vector<int> first;
    for (int i = 0; i < 25; ++i)
        if (groups[to_size(i)] == "0")
            first.push_back(i);
    const RowMatrix own = data(first, Eigen::all);
    EXPECT_NEAR(spread_of(data, group_by(groups), group_by(blocks), {.replicates = 1}).variances[0],
                (own.rowwise() - own.colwise().mean()).squaredNorm() / 7.0, 1e-9);
}

TEST(GroupSpread, HasNoVarianceByTheSlopeOfOneBlock)
{
    const RowMatrix data = test::random_matrix(12, 3, 77);
    std::vector<std::string> states;
    std::vector<std::string> people;
    Eigen::MatrixXd age(12, 1);
    for (int i = 0; i < 12; ++i) {
        states.emplace_back(i % 2 == 0 ? "a" : "b");
        people.push_back(std::to_string(i / 2));
        age(i, 0) = 20 + 3 * (i / 2) + (i == 5 ? 1 : 0); // a slip
    }
    const Eigen::MatrixXd products = inner_products(data);
    const GroupSpread spread =
        group_spread(products, group_by(states), group_by(people), age, {.replicates = 99});
    for (const double figure : {spread.variances[0], spread.variance_intervals[1].high})
        EXPECT_TRUE(std::isnan(figure)) << figure;
    EXPECT_EQ(test_spread(products, group_by(states), group_by(people), age, {}).permutations, 0);
}

TEST(GroupSpread, HasNoDistanceThatTheCovariatesLeaveOpen)
{
    Eigen::VectorXd habitat(60);
    std::vector<std::string> groups;
    for (int i = 0; i < 60; ++i) {
        groups.push_back(i % 3 == 0 ? "a" : i % 3 == 1 ? "b" : "c");
        habitat[i] = i % 3 == 0 ? 1.0 : 2.0;
    }
    const GroupSpread found = group_spread(inner_products(two_groups(41, 0.0)), group_by(groups),
                                           groups_of_one(60), habitat, {.replicates = 40});
    EXPECT_TRUE(std::isnan(found.distances(0, 1)));
    EXPECT_TRUE(std::isnan(found.distance_radii(1, 0)));
    EXPECT_GT(found.distances(1, 2), 0.0); // which have the same habitat
    EXPECT_GT(found.distance_radii(1, 2), 0.0);
    EXPECT_GT(found.variances[0], 0.0);
}

TEST(GroupSpread, HasTheSameBitsForAnyThreadCount)
{
    const Eigen::MatrixXd products = inner_products(two_groups(4, 1.0));
    const Eigen::MatrixXd none(60, 0);
    const auto radii = [&](int threads) {
        const test::ThreadScope scope(threads);
        return group_spread(products, halves(), groups_of_one(60), none, {.replicates = 40})
            .distance_radii;
    };
    EXPECT_EQ(radii(1), radii(3));
}

TEST(GroupSpread, RefusesWhatBreaksARule)
{
    const Eigen::MatrixXd products = inner_products(two_groups(5, 1.0));
    const Eigen::MatrixXd none(60, 0);
    EXPECT_THROW((void)group_spread(products.topRows(9), halves(), groups_of_one(60), none),
                 InvalidInput);
    EXPECT_THROW((void)group_spread(products, one_group(9), groups_of_one(60), none), InvalidInput);
    EXPECT_THROW((void)group_spread(products, halves(), groups_of_one(9), none), InvalidInput);
    EXPECT_THROW(
        (void)group_spread(products, halves(), groups_of_one(60), none, {.confidence = 1.0}),
        InvalidInput);
    EXPECT_THROW((void)group_spread(products, halves(), groups_of_one(60), Eigen::MatrixXd(9, 1)),
                 InvalidInput);
    EXPECT_THROW(
        (void)test_spread(products, halves(), groups_of_one(60), none, {.permutations = -1}),
        InvalidInput);
    EXPECT_THROW((void)test_spread(products, halves(), groups_of_one(9), none), InvalidInput);
}

TEST(SpreadTest, IsTheAnalysisOfVarianceOfDistancesFromTheMean)
{
    RowMatrix data = two_groups(4, 2.0);
    data.bottomRows(30) *= 1.7;
    const LinearModelTest test =
        spread_test_of(data, halves(), groups_of_one(60), {.permutations = 199});
    Eigen::VectorXd distances(60);
    for (const Index start : {0, 30}) {
        const RowMatrix group = data.middleRows(start, 30);
        distances.segment(start, 30) =
            std::sqrt(30.0 / 29.0) * (group.rowwise() - group.colwise().mean()).rowwise().norm();
    }
    const double a = distances.head(30).mean();
    const double b = distances.tail(30).mean();
    const double within = (distances.head(30).array() - a).square().sum() +
                          (distances.tail(30).array() - b).square().sum();
    EXPECT_NEAR(test.f, 15.0 * (a - b) * (a - b) / (within / 58.0), 1e-8 * test.f);
    EXPECT_EQ(test.p_value, 1.0 / 200.0);
}

TEST(SpreadTest, IsOfResidualsWhereCovariatesAreTakenIntoAccount)
{
    // Members of the second group spread because their ages do.
    RowMatrix data = 0.1 * two_groups(51, 0.0);
    Eigen::MatrixXd age = test::random_matrix(60, 1, 52);
    age.col(0).tail(30) *= 4.0;
    data += age * Eigen::RowVectorXd::Ones(5);
    EXPECT_EQ(spread_test_of(data, halves(), groups_of_one(60), {.permutations = 99}).p_value,
              0.01);
    const LinearModelTest test =
        test_spread(inner_products(data), halves(), groups_of_one(60), age, {.permutations = 99});
    EXPECT_GT(test.p_value, 0.05);
    Eigen::MatrixXd columns(60, 3);
    columns << indicators(halves()), age;
    const Eigen::MatrixXd hat = columns * columns.completeOrthogonalDecomposition().pseudoInverse();
    const Eigen::VectorXd distances =
        (data - hat * data)
            .rowwise()
            .norm()
            .cwiseQuotient((1.0 - hat.diagonal().array()).sqrt().matrix());
    const double a = distances.head(30).mean();
    const double b = distances.tail(30).mean();
    const double within = (distances.head(30).array() - a).square().sum() +
                          (distances.tail(30).array() - b).square().sum();
    EXPECT_NEAR(test.f, 15.0 * (a - b) * (a - b) / (within / 58.0), 1e-7 * test.f);
}

TEST(SpreadTest, LeavesOutGroupsWhoseMembersAreEquallyFarFromTheirMean)
{
    // Of pairs alone nothing is left; beside halves of 28 points, a pair and single ones change nothing.
    const RowMatrix data = two_groups(6, 1.0);
    std::vector<std::string> pairs, some;
    for (int i = 0; i < 60; ++i) {
        pairs.push_back(std::to_string(i / 2));
        some.push_back(i < 28 ? "a" : i < 56 ? "b" : i < 58 ? "pair" : std::to_string(i));
    }
    const PermutationOptions options{.permutations = 99};
    const LinearModelTest nothing =
        spread_test_of(data, group_by(pairs), groups_of_one(60), options);
    EXPECT_EQ(nothing.permutations, 0);
    EXPECT_TRUE(std::isnan(nothing.p_value));
    EXPECT_TRUE(std::isnan(nothing.f));
    EXPECT_EQ(nothing.degrees_of_freedom, 0);
    const LinearModelTest found = spread_test_of(data, group_by(some), groups_of_one(60), options);
    some.resize(56);
    const LinearModelTest alone =
        spread_test_of(data.topRows(56), group_by(some), groups_of_one(56), options);
    EXPECT_NEAR(found.f, alone.f, 1e-9 * alone.f);
    EXPECT_EQ(found.p_value, alone.p_value);
    EXPECT_EQ(found.residual_degrees_of_freedom, 54);
}

TEST(SpreadTest, LeavesOutResidualsThatCannotBeOtherThanZero)
{
    // A covariate that is 1 in one point alone takes that point away.
    const RowMatrix data = two_groups(65, 0.0);
    const Eigen::MatrixXd one = Eigen::VectorXd::Unit(60, 59);
    const PermutationOptions options{.permutations = 99};
    const LinearModelTest found =
        test_spread(inner_products(data), halves(), groups_of_one(60), one, options);
    std::vector<std::string> labels(59, "a");
    std::fill(labels.begin() + 30, labels.end(), std::string("b"));
    const LinearModelTest without =
        spread_test_of(data.topRows(59), group_by(labels), groups_of_one(59), options);
    EXPECT_EQ(found.residual_degrees_of_freedom, 57);
    EXPECT_NEAR(found.f, without.f, 1e-7 * (1.0 + without.f));
}

TEST(SpreadTest, IsEmptyWhereBothStatesOfASubjectAreEquallyFarFromTheirMeans)
{
    RowMatrix data = test::random_matrix(60, 5, 2);
    data.bottomRows(30) = data.topRows(30).array() + 1.0;
    std::vector<std::string> subjects;
    for (int i = 0; i < 60; ++i)
        subjects.push_back(std::to_string(i % 30));
    const LinearModelTest test =
        spread_test_of(data, halves(), group_by(subjects), {.permutations = 9});
    EXPECT_EQ(test.permutations, 0);
    EXPECT_EQ(test.residual_degrees_of_freedom, 0);
}

TEST(SpreadTest, FindsNothingWhereOnlyTheMeansDiffer)
{
    int found = 0;
    for (unsigned seed = 0; seed < 100; ++seed)
        found += spread_test_of(two_groups(300 + seed, 3.0), halves(), groups_of_one(60),
                                {.permutations = 99, .seed = seed})
                     .p_value <= 0.05;
    EXPECT_LE(found, 12); // 5 expected, standard error 2.2
    // Means of blocks count once: three scans of each of twenty subjects.
    std::vector<std::string> subjects;
    for (int i = 0; i < 60; ++i)
        subjects.push_back(std::to_string(i / 3));
    EXPECT_EQ(spread_test_of(two_groups(5, 1.0), halves(), group_by(subjects), {.permutations = 9})
                  .residual_degrees_of_freedom,
              18);
}

} // namespace
} // namespace shape
