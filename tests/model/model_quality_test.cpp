// SPDX-License-Identifier: MIT

#include "libshape/model/model_quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/procrustes.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/model/shape_model.h"
#include "tests/support/collections.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_ranks.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

const SpaceOptions edge{.kind = SpaceKind::Edge};
const SpaceOptions procrustes{.kind = SpaceKind::Procrustes};

/// A sphere with one bump of different heights and random pose: shapes on a curve.
Collection one_parameter(int count)
{
    const test::TestMesh sphere = test::icosphere(2);
    Collection collection{sphere.topology, {}, {}, {}};
    for (int i = 0; i < count; ++i) {
        const double height = 0.5 * i / (count - 1);
        const Eigen::VectorXd radius =
            1.0 + height * (6.0 * (sphere.points.col(2).array() - 1.0)).exp();
        collection.names.push_back("bump" + std::to_string(i));
        collection.points.push_back(
            test::moved(Points(radius.asDiagonal() * sphere.points), static_cast<unsigned>(i)));
    }
    return collection;
}

TEST(ModelQuality, OfALineOfPositionsIsPerfectWithOneMode)
{
    // Positions are linear in the height: one mode says all, up to the turns of the alignment,
    // which symmetry excludes here.
    const Collection collection = one_parameter(8);
    const SpaceOptions plain{.kind = SpaceKind::Procrustes, .scale = Scale::None};
    const ModelQuality quality = measure_quality(
        collection, groups_of_one(8), {.space = plain, .modes = {1}, .tests = 8, .samples = 5});
    EXPECT_NEAR(quality.compactness[0], 1.0, 1e-9);
    EXPECT_LE(quality.generalisation_vertex.mean[0], 1e-6);
    EXPECT_LE(quality.generalisation_edge.mean[0], 1e-6);
    EXPECT_GT(quality.specificity_vertex.mean[0], 1e-4);
    EXPECT_EQ(quality.tests, 8);
    EXPECT_EQ(quality.decoded, 13);
}

TEST(ModelQuality, IsWhatOneFindsByHand)
{
    const Collection collection = test::bumpy_spheres(5, 3);
    const SpaceOptions plain{.kind = SpaceKind::Procrustes, .scale = Scale::None};
    const ModelQuality quality = measure_quality(
        collection, groups_of_one(5), {.space = plain, .modes = {1, 3}, .tests = 5, .samples = 1});
    for (const int k : {0, 1}) {
        const int modes = quality.modes[to_size(k)];
        Eigen::VectorXd vertex(5);
        Eigen::VectorXd lengths(5);
        for (std::size_t i = 0; i < 5; ++i) {
            std::vector<std::size_t> others{0, 1, 2, 3, 4};
            others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
            const ShapeModel model =
                fit_model(subset(collection, others), {.modes = modes, .space = plain});
            const Projection scores = project(model, subset(collection, {i}));
            const Points mesh =
                std::get<Points>(model_point(model, scores.scores.row(0).transpose(), 1.0));
            const Points truth =
                collection.points[i].rowwise() - collection.points[i].colwise().mean();
            const Points centred = mesh.rowwise() - mesh.colwise().mean();
            vertex[static_cast<Eigen::Index>(i)] =
                (aligned_with(truth, centred, Scale::None) - truth).norm() / std::sqrt(42.0);
            const Eigen::VectorXd wanted = edge_lengths(collection.topology, truth);
            lengths[static_cast<Eigen::Index>(i)] =
                std::sqrt((edge_lengths(collection.topology, mesh) - wanted).squaredNorm() /
                          120.0) /
                wanted.mean();
        }
        EXPECT_NEAR(quality.generalisation_vertex.mean[k], vertex.mean(), 1e-9);
        EXPECT_NEAR(quality.generalisation_edge.mean[k], lengths.mean(), 1e-9);
        EXPECT_NEAR(quality.generalisation_vertex.deviation[k],
                    std::sqrt((vertex.array() - vertex.mean()).square().sum() / 4.0), 1e-9);
    }
    // The model of all meshes: shares of variance.
    const ShapeModel model = fit_model(collection, {.space = plain});
    EXPECT_NEAR(quality.compactness[1], model.variances.head(3).sum() / model.total_variance,
                1e-12);
}

TEST(ModelQuality, MoreModesReconstructBetterAndSampleFartherOff)
{
    const Collection collection = test::bumpy_spheres(12, 4);
    for (const SpaceOptions& space : {edge, procrustes}) {
        const ModelQuality quality =
            measure_quality(collection, groups_of_one(12),
                            {.space = space, .modes = {1, 10}, .tests = 12, .samples = 10});
        EXPECT_LT(quality.generalisation_edge.mean[1], quality.generalisation_edge.mean[0]);
        EXPECT_LT(quality.generalisation_vertex.mean[1], quality.generalisation_vertex.mean[0]);
        EXPECT_LT(quality.compactness[0], quality.compactness[1]);
        EXPECT_GT(quality.specificity_edge.mean[0], 0.0);
    }
}

TEST(ModelQuality, OfUnitScaleKnowsNeitherSizeNorPose)
{
    const Collection collection = test::bumpy_spheres(6, 5);
    Collection others = test::moved(collection, 30);
    for (std::size_t i = 0; i < others.size(); ++i)
        others.points[i] *= centroid_size(collection.points[0]) / centroid_size(others.points[i]);
    for (const SpaceOptions& space : {edge, procrustes}) {
        const QualityOptions options{.space = space, .modes = {2}, .tests = 6, .samples = 4};
        const ModelQuality here = measure_quality(collection, groups_of_one(6), options);
        const ModelQuality there = measure_quality(others, groups_of_one(6), options);
        EXPECT_NEAR(here.generalisation_edge.mean[0], there.generalisation_edge.mean[0],
                    1e-4 * here.generalisation_edge.mean[0]);
        EXPECT_NEAR(here.compactness[0], there.compactness[0], 1e-9);
    }
}

TEST(ModelQuality, HasTheSameBitsForAnyThreadCountAndFollowsTheSeed)
{
    const Collection collection = test::bumpy_spheres(8, 6);
    const auto made = [&](int threads, std::uint64_t seed) {
        const test::ThreadScope scope(threads);
        return measure_quality(collection, random_folds(8, 4, 1),
                               {.modes = {1, 4}, .tests = 5, .samples = 6, .seed = seed});
    };
    const ModelQuality one = made(1, 7);
    const ModelQuality many = made(4, 7);
    EXPECT_EQ(one.generalisation_vertex.mean, many.generalisation_vertex.mean);
    EXPECT_EQ(one.specificity_edge.mean, many.specificity_edge.mean);
    EXPECT_EQ(one.infeasible, many.infeasible);
    EXPECT_NE(one.specificity_edge.mean, made(1, 8).specificity_edge.mean);
}

TEST(ModelQuality, InPassesIsThatInMemory)
{
    const Collection collection = test::bumpy_spheres(24, 2);
    const Grouping folds = random_folds(24, 4, 1);
    const QualityOptions options{.space = edge, .modes = {1, 3}, .tests = 5, .samples = 4};
    const ModelQuality expected = measure_quality(collection, folds, options);
    const ModelQuality found = measure_quality(stream_of(collection), folds, options, {});
    EXPECT_EQ(found.tests, expected.tests);
    EXPECT_EQ(found.decoded, expected.decoded);
    EXPECT_EQ(found.infeasible, expected.infeasible);
    EXPECT_LE((found.compactness - expected.compactness).cwiseAbs().maxCoeff(), 1e-12);
    for (const auto curve :
         {&ModelQuality::generalisation_vertex, &ModelQuality::generalisation_edge,
          &ModelQuality::specificity_vertex, &ModelQuality::specificity_edge})
        for (const auto column : {&QualityCurve::mean, &QualityCurve::deviation}) {
            const Eigen::VectorXd& a = found.*curve.*column;
            const Eigen::VectorXd& b = expected.*curve.*column;
            EXPECT_LE((a - b).cwiseAbs().maxCoeff(), 1e-7 * b.cwiseAbs().maxCoeff());
        }
    EXPECT_THROW((void)measure_quality(stream_of(collection), random_folds(23, 4, 1), options, {}),
                 InvalidInput);
    EXPECT_THROW((void)measure_quality(stream_of(collection), folds, options, {.tolerance = 2.0}),
                 InvalidInput);
}

TEST(ModelQuality, HasTheSameBitsForOneTwoAndFourProcesses)
{
    const Collection collection = test::bumpy_spheres(14, 2);
    const Grouping folds = random_folds(14, 4, 1);
    const QualityOptions options{.space = edge, .modes = {1, 3}, .tests = 5, .samples = 3};
    const auto made = [&](int count) {
        std::vector<ModelQuality> found(to_size(count));
        test::run_as_ranks(count, [&](const Ranks& ranks) {
            StreamOptions stream;
            stream.ranks = ranks;
            found[to_size(ranks.number)] =
                measure_quality(stream_of(collection), folds, options, stream);
        });
        return found;
    };
    const ModelQuality alone = made(1).front();
    EXPECT_EQ(alone.decoded, (5 + 3) * 2);
    for (const int count : {2, 4})
        for (const ModelQuality& found : made(count)) {
            EXPECT_EQ(found.compactness, alone.compactness);
            EXPECT_EQ(found.decoded, alone.decoded);
            EXPECT_EQ(found.infeasible, alone.infeasible);
            for (const auto curve :
                 {&ModelQuality::generalisation_vertex, &ModelQuality::generalisation_edge,
                  &ModelQuality::specificity_vertex, &ModelQuality::specificity_edge}) {
                EXPECT_EQ((found.*curve).mean, (alone.*curve).mean);
                EXPECT_EQ((found.*curve).deviation, (alone.*curve).deviation);
            }
        }
}

TEST(ModelQuality, TakesTheUsualNumbersOfModesAsFarAsEveryModelHasThem)
{
    const Collection collection = test::bumpy_spheres(5, 7);
    const QualityOptions usual{.space = edge, .tests = 5, .samples = 2};
    EXPECT_EQ(measure_quality(collection, groups_of_one(5), usual).modes,
              (std::vector<int>{1, 2, 3}));
    // Of two meshes there are two each, and one of a third: without that the others have one mode.
    Collection copies = collection;
    for (std::size_t i = 2; i < 4; ++i)
        copies.points[i] = collection.points[i - 2];
    const ModelQuality low = measure_quality(copies, groups_of_one(5), usual);
    EXPECT_EQ(low.modes, std::vector<int>{1});
    EXPECT_EQ(low.compactness.size(), 1);
    QualityOptions more = usual;
    more.modes = {1, 2};
    EXPECT_THROW((void)measure_quality(copies, groups_of_one(5), more), InvalidInput);
}

TEST(ModelQuality, RefusesWhatBreaksARule)
{
    const Collection collection = test::bumpy_spheres(5, 7);
    const auto measure = [&](const Grouping& folds, const QualityOptions& options) {
        (void)measure_quality(collection, folds, options);
    };
    const Grouping each = groups_of_one(5);
    EXPECT_THROW(measure(groups_of_one(4), {.modes = {1}}), InvalidInput);
    EXPECT_THROW(measure(one_group(5), {.modes = {1}}), InvalidInput);
    EXPECT_THROW(measure(each, {.modes = {0, 1}}), InvalidInput);
    EXPECT_THROW(measure(each, {.modes = {1, 1}}), InvalidInput);
    EXPECT_THROW(measure(each, {.modes = {4}}), InvalidInput); // four others have three modes
    EXPECT_THROW(measure(each, {.modes = {1}, .tests = 0}), InvalidInput);
    EXPECT_THROW(measure(each, {.modes = {1}, .samples = 0}), InvalidInput);
}

TEST(RandomFolds, AreOfEqualSize)
{
    for (const int count : {2, 3, 7, 10}) {
        const Grouping folds = random_folds(23, count, 5);
        EXPECT_EQ(folds.group_count(), count);
        std::vector<int> sizes(to_size(count), 0);
        for (const int fold : folds.group_of)
            ++sizes[to_size(fold)];
        const auto [least, most] = std::minmax_element(sizes.begin(), sizes.end());
        EXPECT_LE(*most - *least, 1);
    }
    EXPECT_EQ(random_folds(23, 5, 9).group_of, random_folds(23, 5, 9).group_of);
    EXPECT_NE(random_folds(23, 5, 9).group_of, random_folds(23, 5, 10).group_of);
    EXPECT_EQ(random_folds(4, 4, 1).group_of, groups_of_one(4).group_of);
    EXPECT_THROW((void)random_folds(4, 5, 1), InvalidInput);
    EXPECT_THROW((void)random_folds(4, 1, 1), InvalidInput);
}

TEST(UsualModeCounts, EndWithTheMost)
{
    EXPECT_EQ(usual_mode_counts(1), std::vector<int>{1});
    EXPECT_EQ(usual_mode_counts(7), (std::vector<int>{1, 2, 5, 7}));
    EXPECT_EQ(usual_mode_counts(50), (std::vector<int>{1, 2, 5, 10, 20, 50}));
    EXPECT_EQ(usual_mode_counts(539), (std::vector<int>{1, 2, 5, 10, 20, 50}));
}

} // namespace
} // namespace shape
