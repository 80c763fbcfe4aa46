// SPDX-License-Identifier: MIT

#include "libshape/statistics/group_comparison.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/statistics/inner_products.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"
#include "tests/support/matrices.h"
#include "tests/support/uniformity.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Labels = std::vector<std::string>;

GroupComparison compare(const RowMatrix& data, const Labels& groups, const Grouping& blocks,
                        const PermutationOptions& options = {.permutations = 99})
{
    return compare_groups(inner_products(data), group_by(groups), blocks, MatrixXd(data.rows(), 0),
                          options);
}

TEST(CompareGroups, HasAPairForAnyTwoGroups)
{
    RowMatrix data = test::random_matrix(9, 4, 1);
    data.bottomRows(3).array() += 5.0;
    const GroupComparison result =
        compare(data, {"a", "a", "a", "b", "b", "b", "c", "c", "c"}, groups_of_one(9));
    ASSERT_EQ(result.pairs.size(), 3u);
    EXPECT_EQ(result.pairs[1].first, 0);
    EXPECT_EQ(result.pairs[1].second, 2);
    const Eigen::RowVectorXd a = data.topRows(3).colwise().mean();
    const Eigen::RowVectorXd c = data.bottomRows(3).colwise().mean();
    EXPECT_NEAR(result.pairs[1].distance, (a - c).norm(), 1e-13);
    EXPECT_NEAR(result.pairs[1].test.sum_of_squares, 1.5 * (a - c).squaredNorm(), 1e-11);
    EXPECT_EQ(result.pairs[1].test.residual_degrees_of_freedom, 4);
    EXPECT_EQ(result.overall.degrees_of_freedom, 2);
}

TEST(CompareGroups, ComparesPairsOfSubjectsWithinThem)
{
    // Subjects differ far more than their two states do.
    const RowMatrix subjects = 100.0 * test::random_matrix(12, 3, 2);
    RowMatrix data = 0.1 * test::random_matrix(24, 3, 3);
    Labels states;
    Labels names;
    for (Index i = 0; i < 24; ++i) {
        data.row(i) += subjects.row(i / 2);
        data(i, 0) += i % 2 == 0 ? 0.0 : 0.5;
        states.push_back(i % 2 == 0 ? "rest" : "smile");
        names.push_back(std::to_string(i / 2));
    }
    const GroupComparison paired = compare(data, states, group_by(names));
    EXPECT_EQ(paired.design, BlockDesign::Crossed);
    EXPECT_EQ(paired.overall.p_value, 0.01);
    EXPECT_EQ(paired.overall.residual_degrees_of_freedom, 11);
    const GroupComparison unpaired = compare(data, states, groups_of_one(24));
    EXPECT_EQ(unpaired.design, BlockDesign::Nested);
    EXPECT_GT(unpaired.overall.p_value, 0.5);
}

TEST(CompareGroups, ComparesTheMeansOfNestedBlocks)
{
    const RowMatrix data = test::random_matrix(12, 3, 4);
    const Labels groups{"a", "a", "a", "b", "b", "a", "a", "b", "b", "b", "b", "a"};
    const Labels blocks{"1", "1", "2", "3", "3", "4", "4", "5", "5", "5", "6", "2"};
    const GroupComparison nested = compare(data, groups, group_by(blocks));
    RowMatrix means(6, 3);
    means << data.topRows(2).colwise().mean(), 0.5 * (data.row(2) + data.row(11)),
        data.middleRows(3, 2).colwise().mean(), data.middleRows(5, 2).colwise().mean(),
        data.middleRows(7, 3).colwise().mean(), data.row(10);
    const GroupComparison direct = compare(means, {"a", "a", "b", "a", "b", "b"}, groups_of_one(6));
    EXPECT_EQ(nested.design, BlockDesign::Nested);
    EXPECT_NEAR(nested.overall.f, direct.overall.f, 1e-11);
    EXPECT_EQ(nested.overall.p_value, direct.overall.p_value);
    EXPECT_EQ(nested.overall.residual_degrees_of_freedom, 4);
    EXPECT_NEAR(nested.pairs[0].distance, direct.pairs[0].distance, 1e-13);
    EXPECT_EQ(nested.left_out, 0);
}

TEST(CompareGroups, LeavesBlocksOfOneGroupOutOfACrossedDesign)
{
    const RowMatrix data = test::random_matrix(8, 3, 5);
    const Labels groups{"a", "b", "a", "b", "a", "b", "a", "a"};
    const Labels blocks{"1", "1", "2", "2", "3", "3", "4", "4"};
    const GroupComparison all = compare(data, groups, group_by(blocks));
    const GroupComparison pairs = compare(data.topRows(6), {"a", "b", "a", "b", "a", "b"},
                                          group_by({"1", "1", "2", "2", "3", "3"}));
    EXPECT_NEAR(all.overall.f, pairs.overall.f, 1e-11);
    EXPECT_EQ(all.overall.p_value, pairs.overall.p_value);
    EXPECT_NEAR(all.pairs[0].distance, pairs.pairs[0].distance, 1e-13);
    EXPECT_EQ(all.left_out, 2);
    EXPECT_EQ(pairs.left_out, 0);
}

TEST(CompareGroups, MeasuresTheDifferenceWithinBlocksHoweverOftenEachWasMeasured)
{
    // The same difference in all, up to whom subjects are; most scans before are of the first.
    const Labels groups{"a", "a", "a", "a", "b", "a", "b", "b", "b", "a", "b"};
    const Labels blocks{"1", "1", "1", "1", "1", "2", "2", "2", "2", "3", "3"};
    const RowMatrix subjects = 10.0 * test::random_matrix(3, 4, 15);
    const RowMatrix scans = test::random_matrix(11, 4, 16);
    RowMatrix data(11, 4);
    for (std::size_t i = 0; i < 11; ++i) {
        const auto row = static_cast<Index>(i);
        data.row(row) = scans.row(row) + subjects.row(std::stoi(blocks[i]) - 1);
    }
    const Eigen::RowVectorXd difference =
        ((data.row(4) - data.topRows(4).colwise().mean()) +
         (data.middleRows(6, 3).colwise().mean() - data.row(5)) + (data.row(10) - data.row(9))) /
        3.0;
    EXPECT_NEAR(compare(data, groups, group_by(blocks)).pairs[0].distance, difference.norm(),
                1e-12);
}

/// Subjects of two states, some scans of each; each subject changes in a way of its own, which is nothing on average.
struct Scans
{
    RowMatrix data;
    Labels states;
    Labels subjects;
};

Scans repeated_scans(int subjects, int scans, Random& random)
{
    Scans result{RowMatrix(2 * subjects * scans, 3), {}, {}};
    Index row = 0;
    for (int s = 0; s < subjects; ++s)
        for (const char* state : {"a", "b"}) {
            Eigen::RowVector3d own;
            for (double& x : own)
                x = 3.0 * s + random.normal();
            for (int k = 0; k < scans; ++k, ++row) {
                for (Index e = 0; e < 3; ++e)
                    result.data(row, e) = own[e] + 0.3 * random.normal();
                result.states.emplace_back(state);
                result.subjects.push_back(std::to_string(s));
            }
        }
    return result;
}

TEST(CompareGroups, CountRepeatedScansOfAStateOnce)
{
    Random random(21);
    const Scans scans = repeated_scans(6, 3, random);
    const GroupComparison repeated = compare(scans.data, scans.states, group_by(scans.subjects));
    RowMatrix means(12, 3);
    Labels states;
    Labels subjects;
    for (Index i = 0; i < 12; ++i) {
        means.row(i) = scans.data.middleRows(3 * i, 3).colwise().mean();
        states.push_back(scans.states[to_size(3 * i)]);
        subjects.push_back(scans.subjects[to_size(3 * i)]);
    }
    const GroupComparison once = compare(means, states, group_by(subjects));
    EXPECT_NEAR(repeated.overall.f, once.overall.f, 1e-9);
    EXPECT_NEAR(repeated.overall.r_squared, once.overall.r_squared, 1e-12);
    EXPECT_EQ(repeated.overall.p_value, once.overall.p_value);
    EXPECT_EQ(repeated.overall.residual_degrees_of_freedom, 5);
    EXPECT_NEAR(repeated.overall.smallest_p, 2.0 / 64.0, 1e-12);
    EXPECT_NEAR(repeated.pairs[0].distance, once.pairs[0].distance, 1e-12);
    // Pairs of three groups, some of them of unequal numbers, likewise.
    Labels three = scans.states;
    for (std::size_t i = 0; i < three.size(); i += 3)
        three[i] = std::string(1, 'c');
    const GroupComparison pairs = compare(scans.data, three, group_by(scans.subjects));
    for (const PairComparison& pair : pairs.pairs)
        EXPECT_EQ(pair.test.residual_degrees_of_freedom, 5);
}

TEST(CompareGroups, KeepTheLevelWhereSubjectsChangeDifferently)
{
    Random random(22);
    int found = 0;
    for (unsigned round = 0; round < 200; ++round) {
        const Scans scans = repeated_scans(8, 5, random);
        found += compare(scans.data, scans.states, group_by(scans.subjects),
                         {.permutations = 199, .seed = round})
                             .overall.p_value <= 0.05
                     ? 1
                     : 0;
    }
    EXPECT_LE(found, 20); // of 200 at 5 %: more with probability 0.001
}

TEST(CompareGroups, TakesCovariatesIntoAccount)
{
    // The groups differ by their covariate alone.
    const Index count = 40;
    RowMatrix data = 0.1 * test::random_matrix(count, 3, 6);
    MatrixXd covariate = test::random_matrix(count, 1, 7);
    Labels groups;
    for (Index i = 0; i < count; ++i) {
        covariate(i, 0) += i % 2 == 0 ? 0.0 : 2.0;
        data(i, 1) += covariate(i, 0);
        groups.push_back(i % 2 == 0 ? "young" : "old");
    }
    EXPECT_EQ(compare(data, groups, groups_of_one(count)).overall.p_value, 0.01);
    const GroupComparison adjusted =
        compare_groups(inner_products(data), group_by(groups), groups_of_one(count), covariate,
                       {.permutations = 99});
    EXPECT_GT(adjusted.overall.p_value, 0.05);
    EXPECT_EQ(adjusted.overall.residual_degrees_of_freedom, count - 3);
    MatrixXd columns(count, 3);
    columns << indicators(group_by(groups)), covariate;
    const MatrixXd fitted = columns.completeOrthogonalDecomposition().solve(MatrixXd(data));
    EXPECT_NEAR(adjusted.pairs[0].distance, (fitted.row(0) - fitted.row(1)).norm(), 1e-12);
    EXPECT_LT(adjusted.pairs[0].distance,
              0.1 * compare(data, groups, groups_of_one(count)).pairs[0].distance);
    // Ages of people say nothing within them, and so nothing of others.
    const Labels states{"a", "b", "a", "b", "a", "b", "a", "b", "c", "c", "c", "c"};
    const Labels people{"1", "1", "2", "2", "3", "3", "4", "4", "5", "6", "7", "8"};
    const VectorXd ages = (VectorXd(12) << 1, 1, 2, 2, 5, 5, 3, 3, 6, 4, 9, 7).finished();
    const GroupComparison open = compare_groups(inner_products(data.topRows(12)), group_by(states),
                                                group_by(people), ages, {.permutations = 9});
    EXPECT_GT(open.pairs[0].distance, 0.0);
    EXPECT_TRUE(std::isnan(open.pairs[1].distance));
    EXPECT_EQ(open.pairs[1].test.residual_degrees_of_freedom, 5);
}

TEST(CompareGroups, LeavesAPairWithoutDegreesOfFreedomUntested)
{
    const GroupComparison result =
        compare(test::random_matrix(4, 2, 8), {"a", "b", "c", "c"}, groups_of_one(4));
    EXPECT_EQ(result.pairs[0].test.permutations, 0);
    for (const double figure :
         {result.pairs[0].adjusted_p, result.pairs[0].test.p_value, result.pairs[0].test.f,
          result.pairs[0].test.r_squared, result.pairs[0].test.sum_of_squares,
          result.pairs[0].test.residual_sum_of_squares, result.pairs[0].test.smallest_p})
        EXPECT_TRUE(std::isnan(figure)) << figure;
    EXPECT_GT(result.pairs[0].distance, 0.0);
    EXPECT_EQ(result.pairs[1].test.permutations, 99);
    // Two tests were made, and two are counted.
    const double a = result.pairs[1].test.p_value, b = result.pairs[2].test.p_value;
    EXPECT_NEAR(std::min(result.pairs[1].adjusted_p, result.pairs[2].adjusted_p),
                std::min(1.0, 2.0 * std::min(a, b)), 1e-15);
}

TEST(CompareGroups, SaysWhatIsWrong)
{
    const RowMatrix data = test::random_matrix(4, 2, 9);
    const auto message = [&](const Labels& groups, const Grouping& blocks) {
        return test::message_of<InvalidInput>([&] { (void)compare(data, groups, blocks); });
    };
    EXPECT_EQ(message({"a", "a", "a", "a"}, groups_of_one(4)),
              "groups: all 4 observations are in one group; at least two are needed");
    EXPECT_EQ(message({"a", "b", "c", "d"}, groups_of_one(4)),
              "groups: 4 observations in 4 groups; there must be more observations than groups");
    EXPECT_EQ(message({"a", "a", "b", "b"}, group_by({"1", "1", "2", "2"})),
              "groups: 2 blocks in 2 groups; there must be more blocks than groups");
    EXPECT_EQ(message({"a", "a", "b", "a"}, group_by({"1", "1", "2", "2"})),
              "groups: 1 block has members of several groups ('2'), 2 means in all, as each counts "
              "once in a group; to compare 2 groups within it takes 3 at the least. If that is a "
              "slip, correct it; else compare without blocks");
    EXPECT_NE(message({"a", "b"}, groups_of_one(4)).find("all must agree"), std::string::npos);
    RowMatrix equal = data;
    equal.row(1) = equal.row(0);
    equal.row(2) = equal.row(0);
    const std::string pair = test::message_of<InvalidInput>([&] {
        (void)compare(equal, {"a", "b", "a", "c"}, groups_of_one(4));
    });
    EXPECT_NE(pair.find("groups 'a' and 'b': linear model: the observations do not vary"),
              std::string::npos)
        << pair;
}

TEST(HolmAdjusted, MultipliesFromTheSmallestUp)
{
    const Eigen::VectorXd p_values = Eigen::Vector4d(0.01, 0.04, 0.03, 0.9);
    const Eigen::VectorXd adjusted = holm_adjusted(p_values);
    EXPECT_LE((adjusted - Eigen::Vector4d(0.04, 0.09, 0.09, 0.9)).cwiseAbs().maxCoeff(), 1e-15);
    EXPECT_EQ(holm_adjusted(Eigen::Vector2d(0.7, 0.8)), Eigen::Vector2d(1.0, 1.0));
}

TEST(HolmAdjusted, CountsNoTestThatWasNotMade)
{
    const double none = std::numeric_limits<double>::quiet_NaN();
    const Eigen::VectorXd adjusted =
        holm_adjusted(Eigen::VectorXd{{none, 0.01, 0.04, none, 0.03, 0.9, none}});
    const Eigen::VectorXd alone = holm_adjusted(Eigen::Vector4d(0.01, 0.04, 0.03, 0.9));
    EXPECT_TRUE(std::isnan(adjusted[0]) && std::isnan(adjusted[3]) && std::isnan(adjusted[6]));
    EXPECT_EQ(Eigen::Vector4d(adjusted[1], adjusted[2], adjusted[4], adjusted[5]), alone);
    EXPECT_EQ(holm_adjusted(Eigen::VectorXd()).size(), 0);
}

/// Real faces: expressions differ, shuffled ones do not.
class CompareFaces : public testing::Test
{
protected:
    void SetUp() override
    {
        if (!test::has_ict_faces())
            GTEST_SKIP() << "no ict_faces600";
    }
};

TEST_F(CompareFaces, AgreesWithNumpy)
{
    // Printed by tests/oracles/face_groups.py.
    const Collection faces = test::ict_faces();
    const MatrixXd products =
        centred_inner_products(shape_vectors(faces, Scale::Unit).edge_lengths);
    const Grouping expressions = group_by(find_label(faces.labels, "expression").values);
    const Grouping subjects = group_by(find_label(faces.labels, "subject").values);
    const PermutationOptions few{.permutations = 9};
    const GroupComparison paired =
        compare_groups(products, expressions, subjects, MatrixXd(600, 0), few);
    EXPECT_NEAR(paired.overall.f, 1924.444470663147, 1e-6);
    const GroupComparison unpaired =
        compare_groups(products, expressions, groups_of_one(600), MatrixXd(600, 0), few);
    EXPECT_NEAR(unpaired.overall.f, 157.501017605726, 1e-7);
    EXPECT_NEAR(unpaired.overall.r_squared, 0.34539619765038937, 1e-10);
}

TEST_F(CompareFaces, FindsExpressionsButNotShuffledOnes)
{
    const Collection faces = test::ict_faces();
    const Labels& expression = find_label(faces.labels, "expression").values;
    const Labels& subject = find_label(faces.labels, "subject").values;
    const ShapeVectors vectors = shape_vectors(faces, Scale::Unit);
    // Happy and neutral faces of the first 30 subjects.
    std::vector<int> chosen;
    for (int i = 0; chosen.size() < 60; ++i)
        if (expression[to_size(i)] != "angry")
            chosen.push_back(i);
    const MatrixXd products = centred_inner_products(vectors.edge_lengths(chosen, Eigen::all));
    const Grouping groups = subset(group_by(expression), chosen);
    const Grouping subjects = subset(group_by(subject), chosen);
    const MatrixXd none(60, 0);
    for (const Grouping& blocks : {subjects, groups_of_one(60)})
        EXPECT_EQ(compare_groups(products, groups, blocks, none).overall.p_value, 0.001);

    Random random(1);
    std::vector<double> p_values;
    for (unsigned repetition = 0; repetition < 200; ++repetition) {
        Grouping shuffled = groups;
        for (std::size_t i = 60; i > 1; --i)
            std::swap(shuffled.group_of[i - 1], shuffled.group_of[random.index(i)]);
        p_values.push_back(compare_groups(products, shuffled, groups_of_one(60), none,
                                          {.permutations = 199, .seed = repetition})
                               .overall.p_value);
    }
    EXPECT_LT(test::kolmogorov_smirnov(p_values), 1.63);
}

} // namespace
} // namespace shape
