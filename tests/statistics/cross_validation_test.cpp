// SPDX-License-Identifier: MIT

#include "libshape/statistics/cross_validation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/statistics/discriminant_analysis.h"
#include "libshape/statistics/inner_products.h"
#include "libshape/statistics/principal_components.h"
#include "libshape/statistics/projection.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// 20 subjects in three states; 40 coordinates of decreasing spread. States move the first ones.
struct Sample
{
    RowMatrix data;
    Grouping states;
    Grouping subjects;
};

Sample sample(unsigned seed, double effect)
{
    const MatrixXd people = test::random_matrix(20, 40, seed);
    const MatrixXd noise = test::random_matrix(60, 40, seed + 1);
    const MatrixXd moves = test::random_matrix(3, 40, seed + 2);
    RowMatrix data(60, 40);
    std::vector<std::string> states;
    std::vector<std::string> subjects;
    for (Index i = 0; i < 60; ++i) {
        data.row(i) = people.row(i / 3) + 0.7 * noise.row(i) + effect * moves.row(i % 3);
        states.push_back(i % 3 == 0 ? "calm" : i % 3 == 1 ? "glad" : "grim");
        subjects.push_back(std::to_string(i / 3));
    }
    for (Index k = 0; k < 40; ++k)
        data.col(k) *= std::pow(0.9, k);
    return {data, group_by(states), group_by(subjects)};
}

/// Fits components and discriminants to the other folds, one fold after the other.
std::vector<int> predicted_directly(const Sample& s, const Grouping& folds, int modes)
{
    std::vector<int> predicted(s.states.group_of.size());
    for (const std::vector<int>& fold : members(folds)) {
        std::vector<int> kept;
        for (int i = 0; i < s.data.rows(); ++i)
            if (std::find(fold.begin(), fold.end(), i) == fold.end())
                kept.push_back(i);
        const PrincipalComponents components =
            principal_components(s.data(kept, Eigen::all), {.modes = modes});
        Grouping groups{s.states.names, {}};
        for (const int i : kept)
            groups.group_of.push_back(s.states.group_of[to_size(i)]);
        const DiscriminantAnalysis analysis = discriminant_analysis(components.scores, groups);
        const std::vector<int> groups_of_fold = classify(
            analysis,
            project_onto_subspace(s.data(fold, Eigen::all), components.mean, components.modes)
                .scores);
        for (std::size_t k = 0; k < fold.size(); ++k)
            predicted[to_size(fold[k])] = groups_of_fold[k];
    }
    return predicted;
}

TEST(CrossValidate, DoesWhatFittingEveryFoldAnewDoes)
{
    for (const unsigned seed : {1u, 10u, 20u})
        for (const int modes : {1, 3, 12}) {
            const Sample s = sample(seed, 0.6);
            const MatrixXd products = inner_products(s.data);
            for (const Grouping& folds : {s.subjects, groups_of_one(60)})
                EXPECT_EQ(cross_validate(products, s.states, folds, modes).predicted,
                          predicted_directly(s, folds, modes));
        }
}

TEST(CrossValidate, TakesFoldsOfHalfTheObservations)
{
    const Sample s = sample(30, 0.6);
    std::vector<std::string> halves;
    for (int i = 0; i < 60; ++i)
        halves.push_back(i < 30 ? "first" : "second");
    EXPECT_EQ(cross_validate(inner_products(s.data), s.states, group_by(halves), 4).predicted,
              predicted_directly(s, group_by(halves), 4));
}

TEST(CrossValidate, CountsWhatItPredicts)
{
    const Sample s = sample(40, 3.0);
    const CrossValidation result = cross_validate(inner_products(s.data), s.states, s.subjects, 10);
    EXPECT_EQ(result.confusion.sum(), 60);
    EXPECT_EQ(result.confusion.rowwise().sum(), Eigen::Vector3i(20, 20, 20));
    int right = 0;
    for (std::size_t i = 0; i < 60; ++i)
        right += result.predicted[i] == s.states.group_of[i];
    EXPECT_EQ(result.confusion.trace(), right);
    EXPECT_DOUBLE_EQ(result.accuracy, right / 60.0);
    EXPECT_GT(result.accuracy, 0.9);
}

TEST(CrossValidate, FindsNothingWhereNothingIs)
{
    // A third is chance; 40 % is two standard errors of 300 predictions above it.
    int right = 0;
    for (unsigned seed = 50; seed < 55; ++seed) {
        const Sample s = sample(10 * seed, 0.0);
        right += cross_validate(inner_products(s.data), s.states, s.subjects, 15).confusion.trace();
    }
    EXPECT_LT(right, 0.40 * 300);
    EXPECT_GT(right, 0.26 * 300);
}

TEST(CrossValidate, KnowsNothingOfTheFoldItPredicts)
{
    // Neither the labels nor the other members of a fold change a prediction.
    const Sample s = sample(60, 0.6);
    const std::vector<int> before =
        cross_validate(inner_products(s.data), s.states, s.subjects, 5).predicted;
    Sample changed = s;
    for (const std::size_t i : {0u, 1u, 2u})
        changed.states.group_of[i] = 2 - changed.states.group_of[i];
    changed.data.row(2) *= 30.0;
    const std::vector<int> after =
        cross_validate(inner_products(changed.data), changed.states, s.subjects, 5).predicted;
    EXPECT_EQ(before[0], after[0]);
    EXPECT_EQ(before[1], after[1]);
}

/// Five points, twelve times each, in two groups that have all of them.
Sample few_points()
{
    const MatrixXd points = test::random_matrix(5, 8, 90);
    RowMatrix data(60, 8);
    std::vector<std::string> groups;
    for (Index i = 0; i < 60; ++i) {
        data.row(i) = points.row(i % 5);
        groups.push_back(i < 30 ? "a" : "b");
    }
    return {data, group_by(groups), groups_of_one(60)};
}

TEST(CrossValidate, TakesFewerModesWhereTheObservationsHaveNotSoMany)
{
    const Sample full = sample(85, 0.6);
    const MatrixXd many = inner_products(full.data);
    EXPECT_EQ(cross_validate_up_to(many, full.states, full.subjects, 8).predicted,
              cross_validate(many, full.states, full.subjects, 8).predicted);
    EXPECT_EQ(cross_validate_up_to(many, full.states, full.subjects, 8).modes, 8);

    const Sample low = few_points();
    const MatrixXd products = inner_products(low.data);
    const CrossValidation found = cross_validate_up_to(products, low.states, low.subjects, 20);
    EXPECT_EQ(found.modes, 4);
    EXPECT_EQ(found.predicted, cross_validate(products, low.states, low.subjects, 4).predicted);
    EXPECT_EQ(found.predicted, predicted_directly(low, low.subjects, 4));

    // Where each point is of one group alone, one direction less varies within the groups.
    Sample pure = low;
    for (std::size_t i = 0; i < 60; ++i)
        pure.states.group_of[i] = i % 5 < 2 ? 0 : 1;
    const CrossValidation apart = cross_validate_up_to(products, pure.states, pure.subjects, 20);
    EXPECT_EQ(apart.modes, 3);
    EXPECT_EQ(apart.predicted, predicted_directly(pure, pure.subjects, 3));
    EXPECT_THROW((void)cross_validate(products, pure.states, pure.subjects, 4), NumericalError);
    for (std::size_t i = 0; i < 60; ++i) // two points, a group each: nothing varies within them
        pure.data.row(static_cast<Index>(i)) = low.data.row(pure.states.group_of[i]);
    EXPECT_THROW(
        (void)cross_validate_up_to(inner_products(pure.data), pure.states, pure.subjects, 20),
        NumericalError);
}

TEST(CrossValidate, LearnsNoComponentThatAFoldTakesAwayWithIt)
{
    Sample s = few_points(); // one observation alone leaves the span of the others
    s.data.row(7) += 0.1 * test::random_matrix(1, 8, 91).row(0);
    const MatrixXd products = inner_products(s.data);
    EXPECT_EQ(cross_validate_up_to(products, s.states, s.subjects, 20).modes, 4);
    const std::string message = test::message_of<InvalidInput>(
        [&] { (void)cross_validate(products, s.states, s.subjects, 5); });
    EXPECT_EQ(message,
              "cross-validation: modes is 5, but without fold '7' there are 59 observations of 4 "
              "components in 2 groups; it must be at most 4");
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)cross_validate(MatrixXd::Zero(60, 60), s.states, s.subjects, 1);
              }).find("all observations are equal"),
              std::string::npos);
}

TEST(CrossValidate, HasTheSameBitsForAnyThreadCount)
{
    const Sample s = sample(70, 0.3);
    const auto predicted = [&](int threads) {
        const test::ThreadScope scope(threads);
        return cross_validate(inner_products(s.data), s.states, s.subjects, 8).predicted;
    };
    EXPECT_EQ(predicted(1), predicted(3));
}

TEST(CrossValidateFaces, AgreesWithNumpy)
{
    if (!test::has_ict_faces())
        GTEST_SKIP() << "no ict_faces600";
    // Printed by tests/oracles/face_groups.py, which decomposes every fold anew.
    const Collection faces = test::ict_faces();
    const MatrixXd products =
        centred_inner_products(shape_vectors(faces, Scale::Unit).edge_lengths);
    const Grouping groups = group_by(find_label(faces.labels, "expression").values);
    ASSERT_EQ(groups.names, (std::vector<std::string>{"angry", "happy", "neutral"}));
    const Grouping subjects = group_by(find_label(faces.labels, "subject").values);
    const Eigen::Matrix3i expected{{189, 0, 11}, {0, 198, 2}, {7, 0, 193}};
    EXPECT_EQ(cross_validate(products, groups, subjects, 5).confusion, expected);
}

TEST(CrossValidate, SaysWhatIsWrong)
{
    const Sample s = sample(80, 0.3);
    const MatrixXd products = inner_products(s.data);
    const auto message = [&](const Grouping& groups, const Grouping& folds, int modes) {
        return test::message_of<InvalidInput>(
            [&] { (void)cross_validate(products, groups, folds, modes); });
    };
    EXPECT_EQ(message(s.states, s.states, 3),
              "cross-validation: without fold 'calm' nothing is left of group 'calm' to learn "
              "from; it needs observations in two folds, or "
              "leave them out");
    EXPECT_EQ(message(s.states, s.subjects, 55),
              "cross-validation: modes is 55, but without fold '0' there are 57 observations of 40 "
              "components in 3 groups; it must be at most 40");
    EXPECT_NE(message(one_group(60), s.subjects, 3).find("1 group,"), std::string::npos);
    EXPECT_NE(message(s.states, one_group(60), 3).find("1 fold,"), std::string::npos);
    EXPECT_NE(message(s.states, s.subjects, 0).find("0 modes"), std::string::npos);
    EXPECT_NE(message(s.states, one_group(59), 3).find("must agree"), std::string::npos);
}

} // namespace
} // namespace shape
