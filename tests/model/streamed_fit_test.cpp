// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/mesh/dihedral_angles.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"
#include "tests/support/folded.h"
#include "tests/support/thread_ranks.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

/// Every array of the models, relative to what it holds at most.
void expect_near(const ShapeModel& a, const ShapeModel& b, double tolerance)
{
    const auto near = [&](const auto& x, const auto& y, const char* what) {
        ASSERT_EQ(x.rows(), y.rows()) << what;
        ASSERT_EQ(x.cols(), y.cols()) << what;
        if (x.size() > 0) {
            EXPECT_LE((x - y).cwiseAbs().maxCoeff(), tolerance * y.cwiseAbs().maxCoeff()) << what;
        }
    };
    near(a.mean, b.mean, "mean");
    near(a.modes, b.modes, "modes");
    near(a.mean_dihedral_angles, b.mean_dihedral_angles, "mean angles");
    near(a.mode_dihedral_angles, b.mode_dihedral_angles, "mode angles");
    near(a.variances, b.variances, "variances");
    near(a.scores, b.scores, "scores");
    near(a.sizes, b.sizes, "sizes");
    EXPECT_NEAR(a.total_variance, b.total_variance, 1e-12 * b.total_variance);
    EXPECT_EQ(a.reference_points, b.reference_points);
    EXPECT_EQ(a.names, b.names);
}

void expect_same_bits(const ShapeModel& a, const ShapeModel& b)
{
    EXPECT_TRUE(a.mean == b.mean);
    EXPECT_TRUE(a.modes == b.modes);
    EXPECT_TRUE(a.mode_dihedral_angles == b.mode_dihedral_angles);
    EXPECT_TRUE(a.mean_dihedral_angles == b.mean_dihedral_angles);
    EXPECT_TRUE(a.variances == b.variances);
    EXPECT_TRUE(a.scores == b.scores);
    EXPECT_TRUE(a.sizes == b.sizes);
}

std::vector<SpaceOptions> spaces()
{
    return {{},
            {.scale = Scale::None},
            {.coordinates = LengthCoordinates::Log, .weighting = EdgeWeighting::Area},
            {.dihedral_weight = 0.3},
            {.position_weight = 3.0}};
}

TEST(StreamedFit, GivesTheModelOfTheCollectionInMemory)
{
    for (const Collection& collection : {test::bumpy_spheres(30, 1), test::folded_spheres(30)})
        for (const SpaceOptions& space : spaces()) {
            const ModelOptions options{.modes = 6, .space = space};
            const ShapeModel expected = fit_model(collection, options);
            const StreamedFit gram =
                fit_model(stream_of(collection), options, {.algorithm = FitAlgorithm::Gram});
            expect_near(gram.model, expected, 1e-10);
            EXPECT_EQ(gram.error, 0.0);
            const StreamedFit krylov =
                fit_model(stream_of(collection), options,
                          {.algorithm = FitAlgorithm::Krylov, .tolerance = 1e-13});
            expect_near(krylov.model, expected, 1e-6);
            EXPECT_LE(krylov.error,
                      std::max(1e-13, 5.0 * std::numeric_limits<double>::epsilon() *
                                          expected.variances[0] / expected.variances[5]));
            for (Index k = 0; k < 6; ++k)
                EXPECT_NEAR(krylov.model.variances[k], expected.variances[k],
                            1e-12 * expected.variances[0]);
        }
}

TEST(StreamedFit, MeasuresScoresWhereTheGramMatrixWouldRoundThem)
{
    Collection collection = test::bumpy_spheres(30, 1);
    const Points base = collection.points.front();
    for (std::size_t i = 0; i < collection.size(); ++i) // size goes before all others
        collection.points[i] =
            (1.0 + static_cast<double>(i % 7)) * (base + 3e-3 * (collection.points[i] - base));
    const ModelOptions options{.modes = 6, .space = {.scale = Scale::None}};
    const ShapeModel expected = fit_model(collection, options);
    ASSERT_LT(expected.variances[5], 1e-4 * expected.variances[0]);
    const test::TemporaryDirectory folder;
    StreamOptions stream{.algorithm = FitAlgorithm::Gram, .scratch = folder.path()};
    const StreamedFit fit = fit_model(stream_of(collection), options, stream);
    EXPECT_EQ(fit.passes, 2); // of meshes: the modes come from the disk
    expect_near(fit.model, expected, 1e-10);
    for (Index k = 0; k < 6; ++k)
        EXPECT_NEAR(fit.model.scores.col(k).squaredNorm(), 29.0 * expected.variances[k],
                    1e-10 * 29.0 * expected.variances[k])
            << k;
    stream.scratch.clear();
    const StreamedFit without_disk = fit_model(stream_of(collection), options, stream);
    EXPECT_EQ(without_disk.passes, 3);
    expect_same_bits(without_disk.model, fit.model);
}

TEST(StreamedFit, KrylovFitsIntoLittleMemory)
{
    // 256 of these meshes, a usual block, take 47 MiB: of less memory they get a quarter.
    const Points points = Points::Random(2562, 3);
    const test::TestMesh sphere = test::icosphere(4);
    ASSERT_EQ(sphere.points.rows(), points.rows());
    Collection collection{sphere.topology, {}, {}, {}};
    for (int i = 0; i < 30; ++i) {
        collection.names.push_back(join("m", i));
        collection.points.emplace_back(sphere.points + 1e-3 * (i % 5) * points +
                                       1e-3 * (i % 7) * points.colwise().reverse());
    }
    const ModelOptions options{.modes = 1};
    const StreamedFit little = fit_model(stream_of(collection), options,
                                         {.memory = 16 << 20, .algorithm = FitAlgorithm::Krylov});
    const StreamedFit much =
        fit_model(stream_of(collection), options, {.algorithm = FitAlgorithm::Krylov});
    EXPECT_NEAR(little.model.variances[0], much.model.variances[0], 1e-6 * much.model.variances[0]);
}

TEST(StreamedFit, TheFoldedMeshesNeedTheBranchRuleIndeed)
{
    const Collection collection = test::folded_spheres(30);
    double sharpest = 0.0;
    for (const Points& points : collection.points)
        sharpest =
            std::max(sharpest, dihedral_angles(collection.topology, points).cwiseAbs().maxCoeff());
    EXPECT_GT(sharpest, 3.0);
    const RowMatrix angles = companion_angles(collection);
    EXPECT_GT(angles.cwiseAbs().maxCoeff(), std::numbers::pi);
}

TEST(StreamedFit, KeepsAllModesOrAShareOfTheVariance)
{
    const Collection collection = test::bumpy_spheres(20, 2);
    expect_near(fit_model(stream_of(collection), {}, {}).model, fit_model(collection), 1e-8);
    const ModelOptions share{.variance = 0.8};
    const ShapeModel expected = fit_model(collection, share);
    for (const FitAlgorithm algorithm : {FitAlgorithm::Gram, FitAlgorithm::Krylov})
        EXPECT_EQ(fit_model(stream_of(collection), share, {.algorithm = algorithm})
                      .model.variances.size(),
                  expected.variances.size());
    EXPECT_THROW((void)fit_model(stream_of(collection), {}, {.algorithm = FitAlgorithm::Krylov}),
                 InvalidInput);
}

TEST(StreamedFit, MeetsTheRulesOfItsOptionsAndOfTheMeshes)
{
    const Collection collection = test::bumpy_spheres(5, 2);
    const MeshStream stream = stream_of(collection);
    EXPECT_THROW((void)fit_model(stream, {.modes = 5}, {}), InvalidInput);
    EXPECT_THROW((void)fit_model(stream, {}, {.tolerance = 0.0}), InvalidInput);
    EXPECT_THROW((void)fit_model(stream, {.space = {.kind = SpaceKind::Procrustes}}, {}),
                 InvalidInput);
    EXPECT_THROW((void)fit_model(subset(stream, {0}), {}, {}), InvalidInput);
    Collection same = subset(collection, {0, 1});
    same.points[1] = same.points[0];
    for (const FitAlgorithm algorithm : {FitAlgorithm::Gram, FitAlgorithm::Krylov})
        EXPECT_THROW((void)fit_model(stream_of(same), {.modes = 1}, {.algorithm = algorithm}),
                     InvalidInput);
    const std::string message = test::message_of<LimitExceeded>(
        [&] { (void)fit_model(stream, {.modes = 4}, {.memory = 1000}); });
    EXPECT_NE(message.find("4 modes need 1 MiB"), std::string::npos) << message;
}

TEST(StreamedFit, ByGramIsRefusedWhereItsMatricesExceedTheMemory)
{
    const Collection collection = test::folded_spheres(200);
    constexpr std::uint64_t matrices = 4 * sizeof(double) * 200 * 200;
    const auto fit_within = [&](std::uint64_t memory) {
        return fit_model(stream_of(collection), {.modes = 1},
                         {.memory = memory, .algorithm = FitAlgorithm::Gram});
    };
    const std::string message =
        test::message_of<LimitExceeded>([&] { (void)fit_within(matrices - 1); });
    EXPECT_NE(message.find("inner products of 200 meshes"), std::string::npos) << message;
    EXPECT_EQ(fit_within(matrices).algorithm, FitAlgorithm::Gram);
}

/// All bits of what a fit finds.
TEST(StreamedFit, HasTheSameBitsForAnyThreadCountAndWhenItIsResumedAfterAnyPass)
{
    const Collection collection = test::folded_spheres(300); // of 128 Krylov makes its start
    for (const FitAlgorithm algorithm : {FitAlgorithm::Gram, FitAlgorithm::Krylov}) {
        const ModelOptions options{.modes = 4};
        std::vector<PassState> states;
        StreamOptions stream{.algorithm = algorithm, .tolerance = 1e-10};
        stream.save = [&](const PassState& state) { states.push_back(state); };
        const StreamedFit whole = fit_model(stream_of(collection), options, stream);
        ASSERT_GT(states.size(), 0U);
        for (const PassState& state : states) {
            const StreamedFit resumed =
                fit_model(stream_of(collection), options,
                          {.algorithm = algorithm, .tolerance = 1e-10, .state = state});
            expect_same_bits(resumed.model, whole.model);
            EXPECT_EQ(resumed.passes, whole.passes);
        }
        const test::ThreadScope scope(1);
        expect_same_bits(
            fit_model(stream_of(collection), options, {.algorithm = algorithm, .tolerance = 1e-10})
                .model,
            whole.model);
        EXPECT_THROW((void)fit_model(stream_of(test::bumpy_spheres(39, 1)), options,
                                     {.algorithm = algorithm, .state = states.front()}),
                     InvalidInput);
    }
}

TEST(StreamedFit, GoesOnByGramWithAnotherMemoryToTheSameBits)
{
    const Collection collection = test::folded_spheres(150);
    const ModelOptions options{.modes = 4};
    std::vector<PassState> states;
    StreamOptions stream{.memory = 900'000, .algorithm = FitAlgorithm::Gram}; // some meshes at once
    stream.save = [&](const PassState& state) { states.push_back(state); };
    const StreamedFit whole = fit_model(stream_of(collection), options, stream);
    ASSERT_GT(states.size(), 1U);
    for (const std::uint64_t memory : {std::uint64_t{0}, std::uint64_t{1'200'000}})
        for (const PassState& state : states)
            expect_same_bits(
                fit_model(stream_of(collection), options,
                          {.memory = memory, .algorithm = FitAlgorithm::Gram, .state = state})
                    .model,
                whole.model);
}

TEST(StreamedFit, TakesGramForFewMeshesOrAllModesWhereItsMatricesFit)
{
    const auto algorithm = [](Index meshes, const ModelOptions& options, std::uint64_t memory) {
        return algorithm_for(meshes, options, {.memory = memory});
    };
    constexpr std::uint64_t plenty = std::uint64_t{1} << 40;
    EXPECT_EQ(algorithm(1000, {.modes = 4}, plenty), FitAlgorithm::Gram);
    EXPECT_EQ(algorithm(1001, {.modes = 4}, plenty), FitAlgorithm::Krylov);
    EXPECT_EQ(algorithm(1001, {.modes = 100}, plenty), FitAlgorithm::Gram); // 24 s are more
    EXPECT_EQ(algorithm(5000, {}, plenty), FitAlgorithm::Gram);
    EXPECT_EQ(algorithm(5000, {.variance = 0.9}, plenty), FitAlgorithm::Krylov);
    EXPECT_EQ(algorithm(1000, {.modes = 4}, 60'000'000), FitAlgorithm::Krylov); // 32 MB of matrices
    EXPECT_EQ(algorithm(1000, {.modes = 4}, 70'000'000), FitAlgorithm::Gram);
    EXPECT_EQ(algorithm_for(10, {}, {.algorithm = FitAlgorithm::Krylov}), FitAlgorithm::Krylov);
}

TEST(StreamedFit, MeasuresOnceWhereItHasAFolderForThatToTheSameBits)
{
    const test::TemporaryDirectory folder;
    const Collection collection = test::folded_spheres(40);
    for (const SpaceOptions& space : spaces()) {
        const ModelOptions options{.modes = 4, .space = space};
        StreamOptions stream{.algorithm = FitAlgorithm::Gram};
        const StreamedFit passes = fit_model(stream_of(collection), options, stream);
        stream.scratch = folder.path();
        std::vector<PassState> states;
        stream.save = [&](const PassState& state) { states.push_back(state); };
        const StreamedFit once = fit_model(stream_of(collection), options, stream);
        expect_same_bits(once.model, passes.model);
        EXPECT_EQ(once.passes, once.model.mode_dihedral_angles.cols() > 0 ? 2 : 1);
        EXPECT_TRUE(folder.names().empty());
        // What is on disc ends with a run: one that is resumed goes in passes.
        ASSERT_EQ(states.size(), 1U);
        stream.state = states.front();
        expect_same_bits(fit_model(stream_of(collection), options, stream).model, passes.model);
        stream.state.reset();
        stream.scratch = folder / "missing";
        expect_same_bits(fit_model(stream_of(collection), options, stream).model, passes.model);
    }
}

TEST(StreamedFit, HasTheSameBitsForOneTwoAndFourProcesses)
{
    const Collection collection = test::folded_spheres(150);
    for (const FitAlgorithm algorithm : {FitAlgorithm::Gram, FitAlgorithm::Krylov}) {
        // So little that Gram cannot hold all meshes in one pass.
        const std::uint64_t memory = algorithm == FitAlgorithm::Gram ? 900'000 : 2'000'000;
        const auto fits = [&](int count, const std::optional<PassState>& state,
                              std::vector<PassState>* states) {
            std::vector<std::optional<StreamedFit>> found(static_cast<std::size_t>(count));
            test::run_as_ranks(count, [&](const Ranks& ranks) {
                StreamOptions stream{.memory = memory, .algorithm = algorithm, .tolerance = 1e-9};
                stream.ranks = ranks;
                stream.state = state;
                if (states != nullptr && ranks.is_root())
                    stream.save = [states](const PassState& s) { states->push_back(s); };
                found[static_cast<std::size_t>(ranks.number)] =
                    fit_model(stream_of(collection), {.modes = 4}, stream);
            });
            return found;
        };
        std::vector<PassState> states;
        const StreamedFit alone = *fits(1, {}, &states).front();
        EXPECT_GT(states.size(), algorithm == FitAlgorithm::Gram ? 1U : 0U);
        for (const int count : {2, 4})
            for (const std::optional<StreamedFit>& fit : fits(count, {}, nullptr)) {
                expect_same_bits(fit->model, alone.model);
                EXPECT_EQ(fit->model.reference_points, alone.model.reference_points);
                EXPECT_EQ(fit->model.total_variance, alone.model.total_variance);
                EXPECT_EQ(fit->passes, alone.passes);
                EXPECT_EQ(fit->error, alone.error);
            }
        expect_same_bits(fits(2, states[states.size() / 2], nullptr)[1]->model, alone.model);
        expect_near(alone.model,
                    fit_model(stream_of(collection), {.modes = 4},
                              {.memory = memory, .algorithm = algorithm, .tolerance = 1e-9})
                        .model,
                    1e-7);
    }
}

TEST(StreamedFit, SaysHowFarItIsAndStopsWhenItIsTold)
{
    const Collection collection = test::bumpy_spheres(20, 2);
    std::vector<std::string> stages;
    StreamOptions stream;
    stream.progress = [&](std::string_view stage, std::size_t done, std::size_t total) {
        EXPECT_LE(done, total);
        if (stages.empty() || stages.back() != stage)
            stages.emplace_back(stage);
    };
    const StreamedFit fit = fit_model(stream_of(collection), {.modes = 3}, stream);
    EXPECT_EQ(static_cast<int>(stages.size()), fit.passes);
    EXPECT_EQ(stages.front(), "pass 1, inner products, kB");
    stream.progress = [](std::string_view, std::size_t, std::size_t) {
        throw Interrupted("stopped");
    };
    EXPECT_THROW((void)fit_model(stream_of(collection), {.modes = 3}, stream), Interrupted);
}

} // namespace
} // namespace shape
