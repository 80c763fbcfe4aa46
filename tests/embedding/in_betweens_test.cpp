// SPDX-License-Identifier: MIT

#include "libshape/embedding/in_betweens.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/mesh/alignment.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

constexpr int frames = 25;
constexpr int every = 6;

/// A cylinder and the same one bent by 150 degrees, with a bulge.
Collection pair()
{
    const test::TestMesh mesh = test::open_cylinder(12, 20);
    Points bent = mesh.points;
    const double bottom = bent.col(2).minCoeff();
    const double length = bent.col(2).maxCoeff() - bottom;
    const double turn = 150.0 * std::numbers::pi / 180.0;
    for (int v = 0; v < bent.rows(); ++v) {
        const Eigen::RowVector3d x = mesh.points.row(v);
        const double angle = turn * (x[2] - bottom) / length;
        const double radius = length / turn - x[0];
        const double bulge = 1.2 + 0.2 * std::sin(7.0 * x[2]);
        bent.row(v) << radius * std::cos(angle), bulge * x[1], radius * std::sin(angle);
    }
    return {mesh.topology, {"a", "b"}, {mesh.points, bent}, {}};
}

ShapePoint target(const ShapeVectors& vectors, int frame)
{
    const double t = static_cast<double>(frame) / (frames - 1);
    return blend(vectors, Eigen::Vector2d(1.0 - t, t));
}

/// Every few frames by the method closure, each placed as the one before.
std::vector<Keyframe> keyframes(const Collection& collection, const ShapeVectors& vectors)
{
    const Embedder embedder(collection.topology, collection.points,
                            {.method = EmbeddingMethod::Closure});
    std::vector<Keyframe> keys;
    for (int frame = 0; frame < frames; frame += every) {
        const ShapePoint wanted = target(vectors, frame);
        Points points = embedder.embed(wanted).points;
        if (!keys.empty())
            points = best_rigid_motion(points, keys.back().points)(points);
        keys.push_back({static_cast<double>(frame), wanted, points});
    }
    return keys;
}

double distance(const Points& a, const Points& b)
{
    return (a - b).rowwise().norm().maxCoeff();
}

class BetweenKeyframes : public testing::Test
{
protected:
    [[nodiscard]] InBetweens by(EmbeddingMethod method) const
    {
        EmbeddingOptions options{.method = method};
        if (method == EmbeddingMethod::Dihedral)
            options.quality = EmbeddingQuality::Preview;
        return {collection_.topology, keys_, collection_.points, options};
    }
    [[nodiscard]] InBetweens by(KeyframeMotion motion) const
    {
        return {collection_.topology, keys_, motion};
    }
    [[nodiscard]] std::vector<InBetweens> all() const
    {
        std::vector<InBetweens> ways;
        ways.push_back(by(EmbeddingMethod::Multiscale));
        ways.push_back(by(EmbeddingMethod::Dihedral));
        ways.push_back(by(KeyframeMotion::Linear));
        ways.push_back(by(KeyframeMotion::Spline));
        return ways;
    }
    [[nodiscard]] Points at(const InBetweens& way, double time) const
    {
        const double t = time / (frames - 1);
        return way.embed(time, blend(vectors_, Eigen::Vector2d(1.0 - t, t))).points;
    }

    const Collection collection_ = pair();
    const ShapeVectors vectors_ = shape_vectors(collection_, Scale::None);
    const std::vector<Keyframe> keys_ = keyframes(collection_, vectors_);
};

TEST_F(BetweenKeyframes, KeyframesComeBackToTheBit)
{
    for (const InBetweens& way : all())
        for (const Keyframe& key : keys_)
            EXPECT_EQ(way.embed(key.time, key.target).points, key.points);
}

TEST_F(BetweenKeyframes, NothingJumpsAtAKeyframe)
{
    const double size = bounding_box_diagonal(collection_.points[0]);
    for (const InBetweens& way : all())
        for (std::size_t k = 1; k + 1 < keys_.size(); ++k)
            for (const double step : {-1e-6, 1e-6})
                EXPECT_LT(distance(at(way, keys_[k].time + step), keys_[k].points), 1e-5 * size);
}

TEST_F(BetweenKeyframes, NothingBendsAtAKeyframe)
{
    const auto bend = [&](const InBetweens& way, double time, double step) {
        const Points second = at(way, time + step) - 2.0 * at(way, time) + at(way, time - step);
        return second.rowwise().norm().maxCoeff() / step; // change of the velocity
    };
    std::vector<InBetweens> smooth = all();
    smooth.erase(smooth.begin() + 2); // straight lines have kinks, see below
    for (const InBetweens& way : smooth)
        for (std::size_t k = 1; k + 1 < keys_.size(); ++k)
            EXPECT_LT(bend(way, keys_[k].time, 1e-3), 0.1 * bend(way, keys_[k].time, 1.0)) << k;
    const InBetweens lines = by(KeyframeMotion::Linear);
    EXPECT_GT(bend(lines, keys_[2].time, 1e-3), 0.9 * bend(lines, keys_[2].time, 1.0));
}

TEST_F(BetweenKeyframes, StepsAreNoLargerAcrossKeyframes)
{
    for (const InBetweens& way : all()) {
        double across = 0.0;
        double elsewhere = 0.0;
        Points before = at(way, 0);
        for (int frame = 1; frame < frames; ++frame) {
            const Points now = at(way, frame);
            const bool is_across = frame % every == 0 || frame % every == 1;
            double& largest = is_across ? across : elsewhere;
            largest = std::max(largest, distance(before, now));
            before = now;
        }
        EXPECT_LT(across, 1.1 * elsewhere);
    }
}

TEST_F(BetweenKeyframes, TheReportMeasuresAgainstWhatWasWanted)
{
    const ShapePoint wanted = target(vectors_, 3);
    const Embedding between = by(EmbeddingMethod::Multiscale).embed(3.0, wanted);
    const EmbeddingReport measured =
        measure_embedding(collection_.topology, between.points, wanted);
    EXPECT_EQ(between.report.edge_rms, measured.edge_rms);
    EXPECT_GT(between.report.edge_rms, 0.0);
    EXPECT_LT(between.report.edge_rms, 0.02);
}

TEST_F(BetweenKeyframes, LinesAndSplinesAreWhatTheySay)
{
    const Points middle = 0.5 * (keys_[1].points + keys_[2].points);
    EXPECT_LT(distance(at(by(KeyframeMotion::Linear), 9.0), middle), 1e-13);
    const Points curve =
        (9.0 * (keys_[1].points + keys_[2].points) - keys_[0].points - keys_[3].points) / 16.0;
    EXPECT_LT(distance(at(by(KeyframeMotion::Spline), 9.0), curve), 1e-13);
}

TEST_F(BetweenKeyframes, RefuseWhatIsOutOfRange)
{
    const auto lines = [&](std::vector<Keyframe> keys) {
        (void)InBetweens(collection_.topology, std::move(keys), KeyframeMotion::Linear);
    };
    EXPECT_THROW(lines({keys_[0]}), InvalidInput);
    EXPECT_THROW(lines({keys_[1], keys_[0]}), InvalidInput);
    std::vector<Keyframe> other = keys_;
    other[1].points.conservativeResize(3, 3);
    EXPECT_THROW(lines(other), InvalidInput);
    other = keys_;
    other[1].target.edge_lengths.conservativeResize(3);
    EXPECT_THROW(lines(other), InvalidInput);
    const InBetweens way = by(KeyframeMotion::Linear);
    for (const double time : {-1.0, 25.0, static_cast<double>(NAN)})
        EXPECT_THROW((void)way.embed(time, keys_[0].target), InvalidInput) << time;
}

} // namespace
} // namespace shape
