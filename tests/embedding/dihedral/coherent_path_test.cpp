// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral/coherent_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/edge_space/paths.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/collections.h"
#include "tests/support/dents.h"

namespace shape {
using namespace internal;
namespace {

struct Dents
{
    Collection pair = test::dents(12);
    ShapeVectors vectors = shape_vectors(pair, Scale::None);
    DihedralEmbedder embedder{pair.topology, pair.points};

    [[nodiscard]] CoherentPath path(const CoherentPathOptions& options = {},
                                    const std::vector<double>& stations = {0.0, 1.0},
                                    const Progress& progress = {}) const
    {
        return {embedder,
                [this](double t) { return blend(vectors, line_weights(2, t), LengthBlend::Plain); },
                stations, options, progress};
    }
};

TEST(CoherentPath, DoesWhatItsOptionsSay)
{
    const Dents dents;
    const Points usual = dents.path().at(0.4).points;
    EXPECT_EQ(dents.path().at(0.4).points, usual);
    for (const CoherentPathOptions& other : std::vector<CoherentPathOptions>{{.smoothness = 0.01},
                                                                             {.anchor = 0.0},
                                                                             {.steps = 30},
                                                                             {.branch_steps = 40},
                                                                             {.crossing_steps = 18},
                                                                             {.sweeps = 5},
                                                                             {.sweep_steps = 12}})
        EXPECT_NE(dents.path(other).at(0.5).points, dents.path().at(0.5).points);
}

TEST(CoherentPath, RelaxesCrossingsByAsManyLinearStepsAsItIsToldTo)
{
    const Dents dents; // a fourth of the steps, which branches take, is the same
    EXPECT_NE(dents.path({.sweep_steps = 27}).at(0.5).points, dents.path().at(0.5).points);
}

TEST(CoherentPath, HoldsStepsNearTheirCompanionsAsFirmlyAsItIsToldTo)
{
    const Collection pair = test::bumpy_spheres(2, 5); // no fold turns over
    const ShapeVectors vectors = shape_vectors(pair, Scale::None);
    const DihedralEmbedder embedder(pair.topology, pair.points);
    const auto middle = [&](double anchor) { // where a step lies
        return CoherentPath(
                   embedder,
                   [&](double t) { return blend(vectors, line_weights(2, t), LengthBlend::Plain); },
                   {0.0, 1.0}, {.anchor = anchor, .steps = 8})
            .at(0.5)
            .points;
    };
    EXPECT_NE(middle(0.01), middle(10.0));
}

TEST(CoherentPath, PassesThroughItsStationsAndCountsItsSteps)
{
    const Dents dents;
    std::size_t last = 0;
    std::size_t all = 0;
    const CoherentPath path =
        dents.path({.steps = 20}, {0.0, 0.25, 1.0},
                   [&](std::string_view, std::size_t done, std::size_t total) {
                       EXPECT_EQ(done, last + 1);
                       last = done;
                       all = total;
                   });
    EXPECT_GT(last, 0U);
    EXPECT_LE(last, all);
    for (const double t : {0.0, 1.0}) {
        const DihedralEmbedding mesh = path.at(t);
        EXPECT_TRUE(mesh.converged);
        EXPECT_LT((edge_lengths(dents.pair.topology, mesh.points) -
                   dents.vectors.edge_lengths.row(0).transpose())
                      .cwiseAbs()
                      .maxCoeff(),
                  1e-9);
    }
    const ShapePoint target = blend(dents.vectors, line_weights(2, 0.25), LengthBlend::Plain);
    EXPECT_LT((path.at(0.25).points - dents.embedder.embed(target).points).cwiseAbs().maxCoeff(),
              1e-9);
    EXPECT_THROW((void)path.at(1.1), InvalidInput);
    EXPECT_THROW((void)path.at(-0.1), InvalidInput);
}

TEST(CoherentPath, GoesWithoutTurns)
{
    const Dents dents;
    const CoherentPath path(dents.embedder,
                            [&](double t) {
                                ShapePoint target =
                                    blend(dents.vectors, line_weights(2, t), LengthBlend::Plain);
                                target.patch_turns.resize(0);
                                return target;
                            },
                            {0.0, 1.0}, {.steps = 16});
    const DihedralEmbedding mesh = path.at(0.21);
    EXPECT_EQ(mesh.companion.rows(), 0);
    EXPECT_LT((edge_lengths(dents.pair.topology, mesh.points) -
               dents.vectors.edge_lengths.row(0).transpose())
                  .cwiseQuotient(dents.vectors.edge_lengths.row(0).transpose())
                  .cwiseAbs()
                  .maxCoeff(),
              0.02);
}

TEST(CoherentPath, HoldsStepsAndWhatLiesBetweenThemNearPositionsAsFirmlyAsStations)
{
    const Collection pair = test::bumpy_spheres(2, 5);
    const ShapeVectors vectors = shape_vectors(pair, Scale::None);
    const DihedralEmbedder embedder(pair.topology, pair.points);
    const Points second = best_rigid_motion(pair.points[1], pair.points[0])(pair.points[1]);
    const auto target = [&](double t) {
        ShapePoint point = blend(vectors, line_weights(2, t), LengthBlend::Plain);
        point.patch_turns.resize(0);
        // Shrunken at both ends, so that lengths resist everywhere and the anchor stays as it is.
        point.positions = 0.9 * ((1.0 - t) * pair.points[0] + t * second);
        return point;
    };
    const auto distance = [&](const Points& points, double t) {
        const Points positions = target(t).positions;
        return relative_distance(best_rigid_motion(positions, points)(positions), points);
    };
    double last = std::numeric_limits<double>::infinity();
    for (const double anchor : {0.0, 30.0, 300.0}) {
        const CoherentPath path(embedder, target, {0.0, 1.0},
                                {.position_anchor = anchor, .steps = 8});
        const DihedralEmbedding end = embedder.embed(target(1.0), {.position_anchor = anchor});
        EXPECT_NEAR(distance(path.at(1.0).points, 1.0), distance(end.points, 1.0), 1e-9);
        double farthest = 0.0;
        for (const double t : {0.25, 0.4, 0.5, 0.56}) { // steps, and places between two
            const DihedralEmbedding mesh = path.at(t);
            EXPECT_EQ(mesh.companion.rows(), pair.points[0].rows());
            // Alone it is held as firmly.
            EXPECT_NEAR(distance(mesh.points, t),
                        distance(embedder.embed(target(t), {.position_anchor = anchor}).points, t),
                        0.03 * distance(end.points, 1.0))
                << anchor << ' ' << t;
            farthest = std::max(farthest, distance(mesh.points, t));
        }
        EXPECT_LT(farthest, 0.9 * last);
        last = farthest;
    }
}

} // namespace
} // namespace shape
