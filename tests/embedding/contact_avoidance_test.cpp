// SPDX-License-Identifier: MIT

#include "libshape/embedding/contact_avoidance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "libshape/base/random.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/embedder.h"
#include "libshape/embedding/path_embedder.h"
#include "libshape/mesh/alignment.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

/// A closed tube of radius 0.15 along more than one turn of a helix of radius 1, whose ends lie over each other
/// at a distance of 1.11 times `pitch`. Blends of pitches of both signs pass through themselves.
test::TestMesh turn(double pitch)
{
    constexpr int around = 10, along = 72;
    Random random(1);
    const double angle = 400.0 / 180.0 * std::numbers::pi;
    Points points(around * along + 2, 3);
    const auto axis = [&](double t) {
        return Eigen::RowVector3d(std::cos(t * angle), std::sin(t * angle), pitch * t);
    };
    for (int i = 0; i < along; ++i) {
        const double t = static_cast<double>(i) / (along - 1);
        const Eigen::RowVector3d out(std::cos(t * angle), std::sin(t * angle), 0.0);
        for (int k = 0; k < around; ++k) {
            const double side = 2.0 * std::numbers::pi * k / around;
            // Uneven, so that nothing lies exactly above anything else.
            const double radius = 0.15 * (1.0 + random.uniform(-0.03, 0.03));
            points.row(i * around + k) =
                axis(t) +
                radius * (std::cos(side) * out + std::sin(side) * Eigen::RowVector3d::UnitZ());
        }
    }
    points.row(around * along) = axis(0.0);
    points.row(around * along + 1) = axis(1.0);
    Faces faces(2 * around * along, 3);
    int row = 0;
    for (int k = 0; k < around; ++k) {
        const int next = (k + 1) % around;
        for (int i = 0; i + 1 < along; ++i) {
            const int a = i * around + k, b = i * around + next;
            faces.row(row++) << a, a + around, b;
            faces.row(row++) << b, a + around, b + around;
        }
        faces.row(row++) << around * along, k, next;
        faces.row(row++) << around * along + 1, (along - 1) * around + next,
            (along - 1) * around + k;
    }
    return {"turn", Topology(faces, static_cast<int>(points.rows())), points};
}

struct Turns
{
    test::TestMesh up = turn(0.5);
    test::TestMesh down = turn(-0.5);

    [[nodiscard]] ShapePoint blend(double t) const
    {
        const ShapePoint a = test::shape_of(up.topology, up.points);
        const ShapePoint b = test::shape_of(up.topology, down.points);
        return {(1.0 - t) * a.edge_lengths + t * b.edge_lengths,
                (1.0 - t) * a.dihedral_angles + t * b.dihedral_angles};
    }
    [[nodiscard]] Embedding embed(double t, const EmbeddingOptions& options) const
    {
        return Embedder(up.topology, {up.points, down.points}, options).embed(blend(t));
    }
};

EmbeddingOptions apart(EmbeddingMethod method = EmbeddingMethod::Dihedral)
{
    return {.method = method, .avoid_contact = true};
}

double distance(const Points& points, const Points& wanted)
{
    return (best_rigid_motion(points, wanted)(points) - wanted).rowwise().norm().maxCoeff() /
           bounding_box_diagonal(wanted);
}

TEST(ContactAvoidance, LeavesNoCrossingWhereNoInputHasOne)
{
    const Turns turns;
    const EmbeddingReport plain = turns.embed(0.3, {}).report;
    ASSERT_GT(plain.new_self_intersections, 20);
    ASSERT_EQ(plain.new_self_intersections, plain.self_intersections); // the inputs are free
    EXPECT_EQ(plain.avoidable_self_intersections, std::nullopt);
    const EmbeddingReport report = turns.embed(0.3, apart()).report;
    EXPECT_EQ(report.self_intersections, 0);
    EXPECT_EQ(report.new_self_intersections, 0);
    EXPECT_EQ(report.avoidable_self_intersections, plain.new_self_intersections);
    EXPECT_GE(report.edge_rms, plain.edge_rms); // which is what it costs
    EXPECT_LT(report.edge_rms, 0.01);
    EXPECT_EQ(report.inverted_faces, 0);
}

TEST(ContactAvoidance, ChangesNoBitOfAMeshThatIsFree)
{
    const Turns turns;
    const Embedding free = turns.embed(0.05, apart());
    EXPECT_EQ(free.report.avoidable_self_intersections, 0);
    EXPECT_TRUE(free.points == turns.embed(0.05, {}).points);
}

TEST(ContactAvoidance, TakesMeshesOfEveryMethodAndMeshesAsTheyAre)
{
    const Turns turns;
    const Embedding multiscale = turns.embed(0.3, apart(EmbeddingMethod::Multiscale));
    EXPECT_GT(multiscale.report.avoidable_self_intersections, 0);
    EXPECT_EQ(multiscale.report.new_self_intersections, 0);

    const Points crossing = turns.embed(0.3, {}).points;
    const Embedding given =
        Embedder(turns.up.topology, {turns.up.points}, apart()).embed(DecodedShape(crossing));
    EXPECT_GT(given.report.avoidable_self_intersections, 0);
    EXPECT_EQ(given.report.new_self_intersections, 0);
    EXPECT_GT(given.report.edge_rms, 0.0);
}

TEST(ContactAvoidance, SolvesMovedAndMirroredMeshesAsWell)
{
    // Which face is the nearest hangs on rounding, so meshes are alike, not the same.
    const Turns turns;
    const Embedding wanted = turns.embed(0.3, apart());
    const auto expect_alike = [&](const EmbeddingReport& report, const Points& points) {
        EXPECT_EQ(report.avoidable_self_intersections, wanted.report.avoidable_self_intersections);
        EXPECT_EQ(report.new_self_intersections, 0);
        EXPECT_NEAR(report.edge_rms, wanted.report.edge_rms, 0.5 * wanted.report.edge_rms);
        EXPECT_LT(distance(points, wanted.points), 0.01);
    };
    Turns moved = turns;
    moved.up.points = test::moved(turns.up.points, 3);
    moved.down.points = test::moved(turns.down.points, 4);
    const Embedding of_moved = moved.embed(0.3, apart());
    expect_alike(of_moved.report, of_moved.points);

    Turns mirrored = turns;
    Faces faces = turns.up.topology.faces();
    faces.col(1).swap(faces.col(2));
    const Topology turned(faces, turns.up.topology.vertex_count());
    Turns inside_out = turns; // the same surface, its faces clockwise
    for (Turns* other : {&mirrored, &inside_out})
        for (test::TestMesh* mesh : {&other->up, &other->down})
            mesh->topology = turned;
    for (test::TestMesh* mesh : {&mirrored.up, &mirrored.down})
        mesh->points.col(0) *= -1.0;
    const Embedding of_mirrored = mirrored.embed(0.3, apart());
    Points back = of_mirrored.points;
    back.col(0) *= -1.0;
    expect_alike(of_mirrored.report, back);
    const Embedding of_inside_out = inside_out.embed(0.3, apart());
    expect_alike(of_inside_out.report, of_inside_out.points);
}

TEST(ContactAvoidance, HasTheSameBitsForAnyThreadCount)
{
    const Turns turns;
    const auto embedded = [&](int threads) {
        const test::ThreadScope scope(threads);
        return turns.embed(0.3, apart()).points;
    };
    EXPECT_TRUE(embedded(1) == embedded(3));
}

TEST(ContactAvoidance, SaysWhatItCannotSolveAndGivesTheBetterMesh)
{
    // Half-way both ends of the tube lie in the same place: no side is nearer than the other.
    const Turns turns;
    const EmbeddingReport plain = turns.embed(0.5, {}).report;
    const EmbeddingReport report = turns.embed(0.5, apart()).report;
    EXPECT_EQ(report.avoidable_self_intersections, plain.new_self_intersections);
    EXPECT_GT(report.new_self_intersections, 0);
    EXPECT_LE(report.new_self_intersections, plain.new_self_intersections);
    EXPECT_LE(report.self_intersections, plain.self_intersections);
    EXPECT_LE(report.inverted_faces, plain.inverted_faces);
}

TEST(ContactAvoidance, LeavesWhatInputsHave)
{
    const Turns turns;
    const Points crossing = turns.embed(0.3, {}).points;
    const Embedding again = Embedder(turns.up.topology, {crossing}, apart())
                                .embed(test::shape_of(turns.up.topology, crossing));
    EXPECT_GT(again.report.self_intersections, 0);
    EXPECT_EQ(again.report.avoidable_self_intersections, 0);
}

TEST(ContactAvoidance, WorksAlongPaths)
{
    const Turns turns;
    const PathEmbedder path(turns.up.topology, {turns.up.points, turns.down.points},
                            {[&](double t) { return turns.blend(t); }, {0.0, 1.0}}, apart());
    const EmbeddingReport report = path.embed(0.3).report;
    EXPECT_GT(report.avoidable_self_intersections, 0);
    EXPECT_EQ(report.new_self_intersections, 0);
}

} // namespace
} // namespace shape
