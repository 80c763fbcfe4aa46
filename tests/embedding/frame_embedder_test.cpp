// SPDX-License-Identifier: MIT

#include "libshape/embedding/frame_embedder.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <string_view>

#include "libshape/base/error.h"
#include "libshape/edge_space/paths.h"
#include "libshape/mesh/alignment.h"
#include "tests/support/dents.h"

namespace shape::internal {
namespace {

/// A plate whose dent pops to the other side, and the meshes between.
struct Plate
{
    const Collection pair = test::dents(8);
    const ShapeVectors vectors = shape_vectors(pair, Scale::None);

    /// Of the line, over t in [0, length].
    [[nodiscard]] FramePath frames(int count, double first = 0.0, double last = 1.0,
                                   double length = 1.0) const
    {
        FramePath along{{[=, this](double t) { return target(t / length); }, {0.0, length}}, {}};
        for (int i = 0; i < count; ++i)
            along.places.push_back(first + (last - first) * i / (count - 1));
        return along;
    }

    [[nodiscard]] ShapePoint target(double share) const
    {
        return blend(vectors, line_weights(2, share), LengthBlend::Plain);
    }

    /// Frame 5, placed as the first mesh.
    [[nodiscard]] Points fifth(const std::optional<FramePath>& along,
                               const EmbeddingOptions& options = {}) const
    {
        const FrameEmbedder embedder(pair.topology, pair.points, options, along);
        const ShapePoint wanted = along ? along->path.target(along->places[5]) : target(0.25);
        return embedder.embed(5, wanted, pair.points[0]).points;
    }

    [[nodiscard]] Points alone(double share, const EmbeddingOptions& options = {}) const
    {
        return placed(Embedder(pair.topology, pair.points, options).embed(target(share)).points);
    }

    [[nodiscard]] Points together(double share, const EmbeddingOptions& options = {}) const
    {
        const FramePath all = frames(2);
        return placed(
            PathEmbedder(pair.topology, pair.points, all.path, options).embed(share).points);
    }

    [[nodiscard]] Points placed(const Points& points) const
    {
        return best_rigid_motion(points, pair.points[0])(points);
    }
};

TEST(FrameEmbedder, FollowsThePathWhereFramesAreNoFartherApartThanAThirtiethOfIt)
{
    const Plate plate;
    EXPECT_EQ(plate.fifth(plate.frames(31)), plate.together(5.0 / 30.0));
    EXPECT_EQ(plate.fifth(plate.frames(30)), plate.alone(5.0 / 29.0));
    EXPECT_NE(plate.fifth(plate.frames(30)), plate.together(5.0 / 29.0));
    // Of a longer path, of a part of it that is walked back, and without one.
    EXPECT_EQ(plate.fifth(plate.frames(21, 0.0, 2.0, 4.0)),
              plate.fifth(plate.frames(21, 0.0, 0.5)));
    EXPECT_EQ(plate.fifth(plate.frames(21, 0.0, 0.5)), plate.together(0.5 * 5 / 20));
    EXPECT_EQ(plate.fifth(plate.frames(21, 0.5, 0.0)), plate.together(0.5 - 0.5 * 5 / 20));
    EXPECT_EQ(plate.fifth({}), plate.alone(0.25));
}

TEST(FrameEmbedder, PassesOptionsOnAndFollowsByTheFineMethodAlone)
{
    const Plate plate;
    const EmbeddingOptions smooth{.smoothness = 0.01};
    EXPECT_EQ(plate.fifth(plate.frames(31), smooth), plate.together(5.0 / 30.0, smooth));
    EXPECT_NE(plate.fifth(plate.frames(31), smooth), plate.together(5.0 / 30.0));
    EXPECT_EQ(plate.fifth(plate.frames(30), smooth), plate.alone(5.0 / 29.0, smooth));
    for (const EmbeddingOptions& options : {EmbeddingOptions{.quality = EmbeddingQuality::Preview},
                                            EmbeddingOptions{.method = EmbeddingMethod::Closure}})
        EXPECT_EQ(plate.fifth(plate.frames(31), options), plate.alone(5.0 / 30.0, options));
    EXPECT_EQ(plate.fifth(plate.frames(31), {.quality = EmbeddingQuality::Fine}),
              plate.together(5.0 / 30.0));
}

TEST(FrameEmbedder, EmbedsByThemselvesWhatIsBeyondThePath)
{
    const Plate plate;
    const FramePath along = plate.frames(51, -0.1, 1.1);
    const FrameEmbedder embedder(plate.pair.topology, plate.pair.points, {}, along);
    for (const std::size_t i : {std::size_t{0}, std::size_t{50}})
        EXPECT_EQ(embedder.embed(i, plate.target(along.places[i]), plate.pair.points[0]).points,
                  plate.alone(along.places[i]));
    EXPECT_EQ(embedder.embed(10, plate.target(along.places[10]), plate.pair.points[0]).points,
              plate.together(along.places[10]));
}

TEST(FrameEmbedder, PlacesMeshesAsTold)
{
    const Plate plate;
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(2.0, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
    const Points place =
        (plate.pair.points[0] * turn.transpose()).rowwise() + Eigen::RowVector3d(5.0, -3.0, 1.0);
    const double diagonal = bounding_box_diagonal(place);
    for (const int count : {5, 31}) {
        const FrameEmbedder embedder(plate.pair.topology, plate.pair.points, {},
                                     plate.frames(count));
        EXPECT_LT(
            (embedder.embed(0, plate.target(0.0), place).points - place).cwiseAbs().maxCoeff(),
            1e-6 * diagonal);
    }
}

TEST(FrameEmbedder, TellsOfAMotionAndRefusesWhatIsNone)
{
    const Plate plate;
    std::size_t calls = 0;
    const Progress progress = [&](std::string_view, std::size_t, std::size_t) { ++calls; };
    const FrameEmbedder embedder(plate.pair.topology, plate.pair.points, {}, plate.frames(31),
                                 progress);
    (void)embedder.embed(30, plate.target(1.0), plate.pair.points[0]);
    EXPECT_GT(calls, 0U);
    EXPECT_THROW((void)embedder.embed(31, plate.target(1.0), plate.pair.points[0]), InvalidInput);
    FramePath unordered = plate.frames(31);
    unordered.path.stations = {1.0, 0.0};
    EXPECT_THROW(FrameEmbedder(plate.pair.topology, plate.pair.points, {}, unordered),
                 InvalidInput);
}

} // namespace
} // namespace shape::internal
