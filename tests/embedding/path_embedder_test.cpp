// SPDX-License-Identifier: MIT

#include "libshape/embedding/path_embedder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/threads.h"
#include "libshape/edge_space/paths.h"
#include "libshape/embedding/sequence_jumps.h"
#include "libshape/mesh/alignment.h"
#include "tests/support/dents.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

TargetPath line(const ShapeVectors& vectors)
{
    return {[&vectors](double t) { return blend(vectors, line_weights(2, t), LengthBlend::Plain); },
            {0.0, 1.0}};
}

std::vector<SequenceStep> steps_of(const Topology& topology, const std::vector<Points>& meshes)
{
    std::vector<SequenceStep> steps;
    for (std::size_t i = 1; i < meshes.size(); ++i)
        steps.push_back(measure_step(topology, meshes[i - 1], meshes[i]));
    return steps;
}

double distance(const Points& a, const Points& b)
{
    return (best_rigid_motion(a, b)(a) - b).rowwise().norm().maxCoeff() / bounding_box_diagonal(b);
}

TEST(PathEmbedder, TurnsOverGraduallyWhatJumpsMeshByMesh)
{
    const Collection pair = test::dents(16);
    const ShapeVectors vectors = shape_vectors(pair, Scale::None);
    const TargetPath path = line(vectors);
    const PathEmbedder along(pair.topology, pair.points, path);
    const Embedder alone(pair.topology, pair.points);
    const auto meshes = [&](int frames, const auto& embed) {
        std::vector<Points> all;
        for (int i = 0; i < frames; ++i) {
            const Embedding mesh = embed(static_cast<double>(i) / (frames - 1));
            EXPECT_LT(mesh.report.edge_rms, 0.01);
            all.push_back(mesh.points);
        }
        return all;
    };
    const auto together = [&](double t) { return along.embed(t); };
    const auto apart = [&](double t) { return alone.embed(path.target(t)); };
    const std::vector<Points> frames = meshes(61, together);
    // By itself the dent pops within one step, 137 times as large as those around it.
    EXPECT_FALSE(find_jumps(steps_of(pair.topology, meshes(61, apart)), {.ratio = 100.0}).empty());
    EXPECT_TRUE(find_jumps(steps_of(pair.topology, frames), {.ratio = 10.0}).empty());
    EXPECT_TRUE(find_jumps(steps_of(pair.topology, meshes(121, together))).empty());
    EXPECT_LT(distance(frames.front(), pair.points[0]), 1e-9);
    EXPECT_LT(distance(frames.back(), pair.points[1]), 1e-9);
}

TEST(PathEmbedder, TakesLengthsOfTheWholeRange)
{
    // Without folds that turn over, which magnify rounding.
    const test::TestMesh sphere = test::bumpy_sphere(2, 0.3, 1);
    const Collection usual{
        sphere.topology, {"a", "b"}, {sphere.points, test::bumpy_sphere(2, 0.3, 2).points}, {}};
    const ShapeVectors vectors = shape_vectors(usual, Scale::None);
    const PathEmbedder expected(usual.topology, usual.points, line(vectors));
    for (const int exponent : {-196, -90, 90, 196}) {
        const double unit = std::ldexp(1.0, exponent);
        Collection pair = usual;
        for (Points& points : pair.points)
            points *= unit;
        const ShapeVectors scaled = shape_vectors(pair, Scale::None);
        const PathEmbedder along(pair.topology, pair.points, line(scaled));
        for (const double t : {0.0, 0.5, 0.8})
            EXPECT_LT(distance(along.embed(t).points / unit, expected.embed(t).points), 1e-6)
                << exponent << " " << t;
    }
}

TEST(PathEmbedder, HasTheSameBitsWhateverIsAskedFor)
{
    const Collection pair = test::dents(16);
    const ShapeVectors vectors = shape_vectors(pair, Scale::None);
    const int threads = thread_count();
    set_thread_count(1);
    const PathEmbedder one(pair.topology, pair.points, line(vectors));
    const Points middle = one.embed(0.5).points;
    const Points between = one.embed(0.4711).points;
    set_thread_count(3);
    const PathEmbedder other(pair.topology, pair.points, line(vectors));
    EXPECT_EQ(other.embed(0.4711).points, between);
    EXPECT_EQ(other.embed(0.5).points, middle);
    for (const double outside : {-0.01, 1.01})
        EXPECT_THROW((void)other.embed(outside), InvalidInput);
    set_thread_count(threads);
}

TEST(PathEmbedder, FollowsWhatDoesNotJumpAsTheEmbedderDoes)
{
    // A cylinder bent by a quarter of a turn: no folds, the minimum is one.
    const test::TestMesh mesh = test::open_cylinder(12, 20);
    Points bent = mesh.points;
    const double bottom = bent.col(2).minCoeff();
    const double length = bent.col(2).maxCoeff() - bottom;
    const double turn = 1.5;
    for (int v = 0; v < bent.rows(); ++v) {
        const Eigen::RowVector3d x = mesh.points.row(v);
        const double angle = turn * (x[2] - bottom) / length;
        const double radius = length / turn - x[0];
        bent.row(v) << radius * std::cos(angle), -1.2 * x[1], radius * std::sin(angle);
    }
    const Collection pair{mesh.topology, {"a", "b"}, {mesh.points, bent}, {}};
    const ShapeVectors vectors = shape_vectors(pair, Scale::None);
    const TargetPath path = line(vectors);
    const PathEmbedder along(pair.topology, pair.points, path);
    const Embedder alone(pair.topology, pair.points);
    for (const double t : {0.1, 0.25, 0.43, 0.7, 0.95}) {
        const Embedding one = along.embed(t);
        const Embedding other = alone.embed(path.target(t));
        EXPECT_LT(one.report.edge_rms, 1.1 * other.report.edge_rms + 1e-6) << t;
        EXPECT_LT(distance(one.points, other.points), 0.01) << t;
        EXPECT_TRUE(std::isfinite(one.report.companion_rms));
        EXPECT_EQ(one.report.new_self_intersections, other.report.new_self_intersections);
    }
}

TEST(PathEmbedder, WeighsAnglesAndAnchorsAsToldTo)
{
    const Collection pair = test::dents(8);
    const ShapeVectors vectors = shape_vectors(pair, Scale::None);
    const auto middle = [&](const EmbeddingOptions& options) {
        return PathEmbedder(pair.topology, pair.points, line(vectors), options).embed(0.3).points;
    };
    const Points usual = middle({});
    EXPECT_EQ(middle({.smoothness = default_smoothness}), usual);
    EXPECT_EQ(middle({.anchor = 0.02}), usual);
    EXPECT_NE(middle({.smoothness = 0.01}), usual);
    EXPECT_NE(middle({.anchor = 0.001}), usual);
}

TEST(PathEmbedder, RefusesWhatItCannotFollow)
{
    const Collection pair = test::dents(16);
    const ShapeVectors vectors = shape_vectors(pair, Scale::None);
    TargetPath path = line(vectors);
    EXPECT_THROW(
        PathEmbedder(pair.topology, pair.points, path, {.method = EmbeddingMethod::Multiscale}),
        InvalidInput);
    EXPECT_THROW(
        PathEmbedder(pair.topology, pair.points, path, {.quality = EmbeddingQuality::Preview}),
        InvalidInput);
    EXPECT_THROW(PathEmbedder(pair.topology, {}, path), InvalidInput);
    path.steps = 7;
    EXPECT_THROW(PathEmbedder(pair.topology, pair.points, path), InvalidInput);
    path.steps = 8;
    for (const std::vector<double>& stations :
         {std::vector<double>{0.5}, std::vector<double>{0.0, 0.0}}) {
        path.stations = stations;
        EXPECT_THROW(PathEmbedder(pair.topology, pair.points, path), InvalidInput);
    }
}

} // namespace
} // namespace shape
