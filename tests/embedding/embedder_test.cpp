// SPDX-License-Identifier: MIT

#include "libshape/embedding/embedder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"
#include "libshape/embedding/multiscale/multiscale_embedding.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/collection.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/synthetic/synthetic.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

/// Largest distance after the best rigid motion, over the diagonal of the bounding box.
double rigid_distance(const Points& points, const Points& wanted)
{
    return (best_rigid_motion(points, wanted)(points) - wanted).rowwise().norm().maxCoeff() /
           bounding_box_diagonal(wanted);
}

/// A cylinder of radius 1 wound up about the y axis by `angle` [rad] over its length.
Points wound(const test::TestMesh& cylinder, double angle)
{
    Points points = cylinder.points;
    const double length = points.col(2).maxCoeff();
    for (int v = 0; v < points.rows(); ++v) {
        const double turn = angle * points(v, 2) / length;
        const double radius = length / angle - points(v, 0);
        points.row(v) << length / angle - radius * std::cos(turn), points(v, 1) + 0.6 * turn,
            radius * std::sin(turn);
    }
    return points;
}

TEST(Embedder, EveryMethodFindsAMeshFromItsOwnShape)
{
    for (const EmbeddingMethod method :
         {EmbeddingMethod::Dihedral, EmbeddingMethod::Closure, EmbeddingMethod::Multiscale})
        for (const test::TestMesh& mesh : test::sample_meshes()) {
            SCOPED_TRACE(mesh.name);
            const Embedder embedder(mesh.topology, {mesh.points}, {.method = method});
            const Embedding embedding = embedder.embed(test::shape_of(mesh.topology, mesh.points));
            EXPECT_LT(rigid_distance(embedding.points, mesh.points), 1e-9);
            EXPECT_EQ(embedding.report.status, EmbeddingStatus::Exact);
            EXPECT_EQ(embedding.report.inverted_faces, 0);
            EXPECT_TRUE(embedding.report.converged);
        }
}

TEST(Embedder, FindsAMeshFarFromItsReference)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.4, 1);
    const test::TestMesh other = test::bumpy_sphere(3, 0.4, 2);
    const Embedder embedder(mesh.topology, {other.points});
    EXPECT_LT(rigid_distance(embedder.embed(test::shape_of(mesh.topology, mesh.points)).points,
                             mesh.points),
              1e-9);
}

TEST(Embedder, GivesTheMirrorImageForNegatedAngles)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.4, 1);
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    target.dihedral_angles *= -1.0;
    const Points mirror = mesh.points * Eigen::Vector3d(-1, 1, 1).asDiagonal();
    EXPECT_LT(rigid_distance(Embedder(mesh.topology, {mesh.points}).embed(target).points, mirror),
              1e-9);
}

TEST(Embedder, ScalesWithTheUnitOfLength)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.4, 1);
    const test::TestMesh other = test::bumpy_sphere(3, 0.4, 2);
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    target.edge_lengths = 0.5 * (target.edge_lengths + edge_lengths(mesh.topology, other.points));
    const Points small = Embedder(mesh.topology, {mesh.points}).embed(target).points;
    target.edge_lengths *= 1024.0; // a power of two: rounding scales too
    const Points large = Embedder(mesh.topology, {1024.0 * mesh.points}).embed(target).points;
    EXPECT_LT(rigid_distance(large / 1024.0, small), 1e-12);
}

TEST(Embedder, TakesLengthsOfTheWholeRange)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.4, 1);
    const test::TestMesh other = test::bumpy_sphere(2, 0.4, 2);
    ShapePoint usual = test::shape_of(mesh.topology, mesh.points);
    usual.edge_lengths = 0.5 * (usual.edge_lengths + edge_lengths(mesh.topology, other.points));
    for (const EmbeddingMethod method :
         {EmbeddingMethod::Dihedral, EmbeddingMethod::Closure, EmbeddingMethod::Multiscale})
        for (const bool avoids : {false, true}) {
            const EmbeddingOptions options{.method = method, .avoid_contact = avoids};
            const Embedding expected =
                Embedder(mesh.topology, {mesh.points, other.points}, options).embed(usual);
            for (const int exponent : {-198, -150, -45, 45, 70, 150, 198}) { // 1e-60 to 1e60
                const double unit = std::ldexp(1.0, exponent);
                ShapePoint target = usual;
                target.edge_lengths *= unit;
                const Embedding found =
                    Embedder(mesh.topology, {unit * mesh.points, unit * other.points}, options)
                        .embed(target);
                EXPECT_LT(rigid_distance(found.points / unit, expected.points), 1e-6) << exponent;
                EXPECT_NEAR(found.report.edge_rms, expected.report.edge_rms, 1e-9) << exponent;
                EXPECT_EQ(found.report.status, expected.report.status) << exponent;
            }
        }
}

TEST(Embedder, UnwindsFarBeyondAFullTurn)
{
    const test::TestMesh cylinder = test::open_cylinder(10, 120);
    test::TestMesh straight = cylinder;
    straight.points.col(2) *= 40.0;
    const Points coil = wound(straight, 4.0 * 2.0 * std::numbers::pi);
    const ShapePoint a = test::shape_of(straight.topology, straight.points);
    const ShapePoint b = test::shape_of(straight.topology, coil);
    const Embedder embedder(straight.topology, {straight.points, coil});
    const ShapePoint half{0.5 * (a.edge_lengths + b.edge_lengths),
                          0.5 * (a.dihedral_angles + b.dihedral_angles)};
    const Embedding embedding = embedder.embed(half);
    EXPECT_LT(embedding.report.edge_max, 0.01);
    EXPECT_LT(embedding.report.dihedral_rms_deg, 2.0); // 1.46 at the minimum of the energy
    EXPECT_LT(rigid_distance(embedder.embed(b).points, coil), 1e-9);
}

TEST(Embedder, HasTheSameBitsForAnyThreadCount)
{
    const test::TestMesh mesh = test::bumpy_sphere(4, 0.4, 1);
    const test::TestMesh other = test::bumpy_sphere(4, 0.4, 2);
    const ShapePoint a = test::shape_of(mesh.topology, mesh.points);
    const ShapePoint b = test::shape_of(mesh.topology, other.points);
    const ShapePoint half{0.5 * (a.edge_lengths + b.edge_lengths),
                          0.5 * (a.dihedral_angles + b.dihedral_angles)};
    const int threads = thread_count();
    set_thread_count(1);
    const Points one = Embedder(mesh.topology, {mesh.points, other.points}).embed(half).points;
    set_thread_count(3);
    const Points three = Embedder(mesh.topology, {mesh.points, other.points}).embed(half).points;
    set_thread_count(threads);
    EXPECT_TRUE(one == three);
}

TEST(Embedder, AnInfeasibleTargetComesOutWholeAndSaysSo)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.2, 1);
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    const int edge = mesh.topology.face_edges()(77, 0);
    target.edge_lengths[edge] *= 2.5;
    const Embedding embedding = Embedder(mesh.topology, {mesh.points}).embed(target);
    EXPECT_EQ(embedding.report.status, EmbeddingStatus::Infeasible);
    EXPECT_NE(embedding.report.reason.find("triangle inequality"), std::string::npos);
    EXPECT_TRUE(embedding.points.allFinite());
    EXPECT_LT(embedding.report.edge_p99, 0.1);
    EXPECT_FALSE(embedding.instead);
    for (const EmbeddingMethod method : {EmbeddingMethod::Closure, EmbeddingMethod::Multiscale}) {
        const Embedder published(mesh.topology, {mesh.points}, {.method = method});
        const Embedding nearest = published.embed(target);
        EXPECT_EQ(nearest.points, embedding.points);
        EXPECT_EQ(nearest.instead, EmbeddingMethod::Dihedral);
        EXPECT_EQ(nearest.report.status, EmbeddingStatus::Infeasible);
        EXPECT_FALSE(published.embed(test::shape_of(mesh.topology, mesh.points)).instead);
    }
}

TEST(Embedder, LengthsBelowZeroAreInfeasibleAndTheRestOfTheMeshKeepsItsShape)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.2, 1);
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    const int edge = mesh.topology.face_edges()(77, 0);
    for (const double length : {0.0, -0.01, -1.0}) {
        SCOPED_TRACE(length);
        target.edge_lengths[edge] = length;
        const Embedding embedding = Embedder(mesh.topology, {mesh.points}).embed(target);
        EXPECT_EQ(embedding.report.status, EmbeddingStatus::Infeasible);
        EXPECT_TRUE(embedding.points.allFinite());
        EXPECT_LT(embedding.report.edge_p99, 0.3);
        EXPECT_LT(rigid_distance(embedding.points, mesh.points), 0.1);
        for (const EmbeddingMethod method : {EmbeddingMethod::Closure, EmbeddingMethod::Multiscale})
            EXPECT_EQ(
                Embedder(mesh.topology, {mesh.points}, {.method = method}).embed(target).points,
                embedding.points);
    }
}

TEST(Embedder, PreviewIsNoBetterThanFineAndBothReportTheirSteps)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.4, 1);
    const test::TestMesh other = test::bumpy_sphere(3, 0.4, 2);
    const ShapePoint a = test::shape_of(mesh.topology, mesh.points);
    const ShapePoint b = test::shape_of(mesh.topology, other.points);
    const ShapePoint half{0.5 * (a.edge_lengths + b.edge_lengths),
                          0.5 * (a.dihedral_angles + b.dihedral_angles)};
    const Embedding fine = Embedder(mesh.topology, {mesh.points}).embed(half);
    const Embedding preview =
        Embedder(mesh.topology, {mesh.points}, {.quality = EmbeddingQuality::Preview}).embed(half);
    EXPECT_LE(preview.report.iterations, 9);
    EXPECT_GT(fine.report.iterations, 9);
    EXPECT_LT(fine.report.edge_rms, preview.report.edge_rms);
    EXPECT_EQ(DihedralEmbedder(mesh.topology, {mesh.points})
                  .embed(half, dihedral_preview())
                  .back_substitutions,
              12);
}

TEST(Embedder, PlacesMeshesLikeTheFirstReferenceWithTheirCentroidAtZero)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.4, 1);
    const Points first = test::moved(mesh.points, 3);
    const Points wanted = first.rowwise() - centroid(first);
    const ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    for (const EmbeddingMethod method :
         {EmbeddingMethod::Dihedral, EmbeddingMethod::Closure, EmbeddingMethod::Multiscale}) {
        const Embedder embedder(mesh.topology, {first, mesh.points}, {.method = method});
        EXPECT_LT((embedder.embed(target).points - wanted).cwiseAbs().maxCoeff(), 1e-9);
    }
}

/// The point halfway between two meshes, which no mesh has.
ShapePoint halfway(const Topology& topology, const Points& first, const Points& second)
{
    const ShapePoint a = test::shape_of(topology, first);
    const ShapePoint b = test::shape_of(topology, second);
    return {0.5 * (a.edge_lengths + b.edge_lengths), 0.5 * (a.dihedral_angles + b.dihedral_angles)};
}

TEST(Embedder, TradesLengthsForAnglesBySmoothness)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.4, 1);
    const ShapePoint half =
        halfway(mesh.topology, mesh.points, test::bumpy_sphere(3, 0.4, 2).points);
    const auto report = [&](double smoothness) {
        return Embedder(mesh.topology, {mesh.points}, {.smoothness = smoothness})
            .embed(half)
            .report;
    };
    const EmbeddingReport rough = report(1e-4);
    const EmbeddingReport smooth = report(1e-1);
    EXPECT_LT(rough.edge_rms, 0.9 * smooth.edge_rms);
    EXPECT_LT(smooth.dihedral_rms_deg, 0.9 * rough.dihedral_rms_deg);
}

TEST(Embedder, HandsItsOptionsToTheMultiscaleMethod)
{
    const test::TestMesh mesh = test::torus(12, 30);
    const Points bent = mesh.points * Eigen::Vector3d(1.5, 0.8, 2.0).asDiagonal();
    const ShapePoint half = halfway(mesh.topology, mesh.points, bent);
    for (const std::uint64_t seed : {1U, 7U})
        for (const RegistrationStart start :
             {RegistrationStart::Incremental, RegistrationStart::Identity}) {
            const Points found = Embedder(mesh.topology, {mesh.points},
                                          {.method = EmbeddingMethod::Multiscale,
                                           .registration_start = start,
                                           .seed = seed})
                                     .embed(half)
                                     .points;
            const Points wanted =
                MultiscaleEmbedder(mesh.topology, mesh.points,
                                   {.seed = seed, .registration = {.start = start}})
                    .embed(half)
                    .points;
            EXPECT_LT(rigid_distance(found, wanted), 1e-12) << seed;
        }
}

TEST(DihedralEmbedder, SweepsInAnyUnit)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.4, 1);
    const test::TestMesh other = test::bumpy_sphere(2, 0.4, 2);
    const ShapePoint usual = test::shape_of(mesh.topology, mesh.points);
    const DihedralEmbedder::Swept expected =
        DihedralEmbedder(mesh.topology, {mesh.points}).sweep(usual, other.points, 9);
    for (const int exponent : {-150, 150}) {
        const double unit = std::ldexp(1.0, exponent);
        ShapePoint target = usual;
        target.edge_lengths *= unit;
        const DihedralEmbedder::Swept found = DihedralEmbedder(mesh.topology, {unit * mesh.points})
                                                  .sweep(target, unit * other.points, 9);
        EXPECT_LT(rigid_distance(found.points / unit, expected.points), 1e-6) << exponent;
        EXPECT_LT((found.edge_lengths / unit - expected.edge_lengths).cwiseAbs().maxCoeff(), 1e-6);
    }
}

TEST(DihedralEmbedder, ComesNearerByEveryStepOfItsStart)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.4, 1);
    const ShapePoint half =
        halfway(mesh.topology, mesh.points, test::bumpy_sphere(3, 0.4, 2).points);
    const DihedralEmbedder embedder(mesh.topology, {mesh.points});
    const auto energy = [&](int steps) {
        return embedder.embed(half, {.local_global_steps = steps, .max_iterations = 0}).energy;
    };
    EXPECT_LT(energy(1), energy(0));
    EXPECT_LT(energy(4), energy(1));
}

/// Two bumpy spheres and what lies half-way between them, with turns.
struct Pair
{
    Collection meshes;
    ShapePoint half;
};

Pair bumpy_pair()
{
    const test::TestMesh mesh = test::bumpy_sphere(4, 0.4, 1);
    Pair pair{{mesh.topology, {"a", "b"}, {mesh.points, test::bumpy_sphere(4, 0.4, 2).points}, {}},
              {}};
    pair.half = blend(shape_vectors(pair.meshes, Scale::None), Eigen::Vector2d(0.5, 0.5));
    return pair;
}

TEST(Embedder, GivesMeshesBackFromTheirTurns)
{
    const Pair pair = bumpy_pair();
    const Embedder embedder(pair.meshes.topology, pair.meshes.points);
    const ShapeVectors vectors = shape_vectors(pair.meshes, Scale::None);
    for (int i = 0; i < 2; ++i) {
        const Embedding embedding = embedder.embed(blend(vectors, Eigen::Vector2d::Unit(i)));
        EXPECT_EQ(embedding.report.status, EmbeddingStatus::Exact);
        EXPECT_LT(rigid_distance(embedding.points, pair.meshes.points[to_size(i)]), 1e-9);
        EXPECT_LT(embedding.report.companion_rms, 1e-7);
    }
}

TEST(Embedder, RigidMotionsOfInputsWithTurnsChangeNothing)
{
    Pair pair = bumpy_pair();
    const Points there = Embedder(pair.meshes.topology, pair.meshes.points).embed(pair.half).points;
    pair.meshes.points = {test::moved(pair.meshes.points[0], 4),
                          test::moved(pair.meshes.points[1], 5)};
    const ShapePoint half =
        blend(shape_vectors(pair.meshes, Scale::None), Eigen::Vector2d(0.5, 0.5));
    const Points here = Embedder(pair.meshes.topology, pair.meshes.points).embed(half).points;
    EXPECT_LT(rigid_distance(here, there), 1e-4); // steps are counted, and rounding differs
}

TEST(Embedder, AnchorHoldsTheMeshNearItsCompanion)
{
    const Pair pair = bumpy_pair();
    double last = std::numeric_limits<double>::infinity();
    for (const double anchor : {0.0, 1.0, 1e3}) {
        const Embedder embedder(pair.meshes.topology, pair.meshes.points, {.anchor = anchor});
        const double distance = embedder.embed(pair.half).report.companion_rms;
        EXPECT_LT(distance, last);
        last = distance;
    }
    EXPECT_GT(last, 0.0);
    // Without turns there is no companion, and the anchor holds nothing.
    ShapePoint alone = pair.half;
    alone.patch_turns = {};
    const Embedding free = Embedder(pair.meshes.topology, pair.meshes.points).embed(alone);
    EXPECT_TRUE(std::isnan(free.report.companion_rms));
    EXPECT_TRUE(
        free.points ==
        Embedder(pair.meshes.topology, pair.meshes.points, {.anchor = 1e3}).embed(alone).points);
}

/// Half-way between two meshes by lengths and angles, and where their vertices are half-way.
ShapePoint placed_half(const Pair& pair)
{
    ShapePoint half = pair.half;
    half.patch_turns = {};
    const Points& first = pair.meshes.points[0];
    const Points& second = pair.meshes.points[1];
    half.positions = 0.5 * (first + best_rigid_motion(second, first)(second));
    return half;
}

TEST(Embedder, PositionsHoldTheMeshMoreFirmlyTheMoreTheyWeigh)
{
    const Pair pair = bumpy_pair();
    const ShapePoint half = placed_half(pair);
    double last = std::numeric_limits<double>::infinity();
    double edges = 0.0;
    for (const double anchor : {0.0, 1.0, 1e3}) {
        const Embedder embedder(pair.meshes.topology, pair.meshes.points, {.anchor = anchor});
        const Embedding embedding = embedder.embed(half);
        const Points placed = best_rigid_motion(half.positions, embedding.points)(half.positions);
        EXPECT_NEAR((placed - embedding.points).norm() /
                        std::sqrt(static_cast<double>(placed.rows())) * 100.0 /
                        bounding_box_diagonal(embedding.points),
                    embedding.report.companion_rms, 1e-9);
        EXPECT_LT(embedding.report.companion_rms, 0.9 * last);
        EXPECT_GE(embedding.report.edge_rms, edges);
        last = embedding.report.companion_rms;
        edges = embedding.report.edge_rms;
    }
    // The default.
    EXPECT_EQ(
        Embedder(pair.meshes.topology, pair.meshes.points).embed(half).points,
        Embedder(pair.meshes.topology, pair.meshes.points, {.anchor = 1.0}).embed(half).points);
}

/// How far a mesh ends from its positions, once by one anchor all the way and once by the default, where it may become
/// firmer after the second repair [% of the diagonal].
std::pair<double, double> distances_from_positions(const test::TestMesh& mesh,
                                                   const ShapePoint& target)
{
    const DihedralEmbedder embedder(mesh.topology, {mesh.points});
    const auto distance = [&](const DihedralEmbeddingOptions& options) {
        const DihedralEmbedding embedding = embedder.embed(target, options);
        const Points& to = embedding.companion;
        return 100.0 *
               relative_distance(embedding.points, best_rigid_motion(to, embedding.points)(to));
    };
    return {distance({.repairs = {24}}), distance({})};
}

TEST(Embedder, PositionsHoldFirmlyWhereLengthsDoNotResist)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.2, 5);
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    target.positions = mesh.points;
    Random random(7);
    // Lengths that no mesh has, beside the positions of one that is in their middle.
    for (double& length : target.edge_lengths)
        length *= 1.0 + 0.03 * random.normal();
    const auto [constant, firmer] = distances_from_positions(mesh, target);
    EXPECT_GT(constant, 0.05);
    EXPECT_LT(firmer, 0.5 * constant);
    EXPECT_GT(firmer, 0.0);
}

TEST(Embedder, PositionsHoldNoFirmerWhereLengthsResist)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.2, 5);
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    // Shrunken along one axis, as blends of poses are.
    target.positions = mesh.points * Eigen::Vector3d(1.0, 1.0, 0.9).asDiagonal();
    const auto [constant, firmer] = distances_from_positions(mesh, target);
    EXPECT_GT(constant, 0.5);
    EXPECT_NEAR(firmer, constant, 0.02 * constant);
}

TEST(Embedder, PositionsMayHaveAnyPose)
{
    const Pair pair = bumpy_pair();
    const Embedder embedder(pair.meshes.topology, pair.meshes.points);
    ShapePoint half = placed_half(pair);
    const Points here = embedder.embed(half).points;
    half.positions = test::moved(half.positions, 9);
    EXPECT_LT(rigid_distance(embedder.embed(half).points, here), 1e-4); // rounding differs
}

TEST(Embedder, GivesMeshesBackFromTheirPositions)
{
    const Pair pair = bumpy_pair();
    ShapePoint point = blend(shape_vectors(pair.meshes, Scale::None), Eigen::Vector2d(0.0, 1.0));
    point.patch_turns = {};
    point.positions = test::moved(pair.meshes.points[1], 3);
    const Embedding embedding =
        Embedder(pair.meshes.topology, {pair.meshes.points[0]}).embed(point);
    EXPECT_EQ(embedding.report.status, EmbeddingStatus::Exact);
    EXPECT_LT(rigid_distance(embedding.points, pair.meshes.points[1]), 1e-6);
}

TEST(Embedder, RefusesPositionsOfAnotherMesh)
{
    const Pair pair = bumpy_pair();
    const Embedder embedder(pair.meshes.topology, pair.meshes.points);
    ShapePoint half = placed_half(pair);
    half.positions(3, 1) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)embedder.embed(half), InvalidInput);
    half.positions = Points::Zero(7, 3);
    EXPECT_THROW((void)embedder.embed(half), InvalidInput);
}

/// A straight cylinder and a helix of four turns: by relative turns far from each other, not by angles.
TEST(Embedder, LeavesWhatTransitionsAgreeOnToThem)
{
    const Collection helix = make_synthetic("helix");
    const Embedder embedder(helix.topology, helix.points);
    ShapePoint target = blend(shape_vectors(helix, Scale::None), Eigen::Vector2d(0.5, 0.5));
    const Points with_turns = embedder.embed(target).points;
    target.patch_turns = {};
    EXPECT_TRUE(with_turns == embedder.embed(target).points);
}

TEST(Embedder, CountsFacesThatPassThroughEachOtherAndThoseThatDoSoInNoReference)
{
    const test::TestMesh mesh = test::icosphere(3);
    Points crossing = mesh.points;
    crossing.row(0) *= -1.5; // through the other side
    const auto report = [&](const std::vector<Points>& references, const DecodedShape& shape) {
        return Embedder(mesh.topology, references).embed(shape).report;
    };
    const EmbeddingReport as_it_is = report({mesh.points}, crossing);
    EXPECT_GT(as_it_is.self_intersections, 0);
    EXPECT_EQ(as_it_is.new_self_intersections, as_it_is.self_intersections);
    const EmbeddingReport known = report({mesh.points, crossing}, crossing);
    EXPECT_EQ(known.self_intersections, as_it_is.self_intersections);
    EXPECT_EQ(known.new_self_intersections, 0);
    const EmbeddingReport sphere =
        report({mesh.points, crossing}, test::shape_of(mesh.topology, mesh.points));
    EXPECT_EQ(sphere.self_intersections, 0);
    EXPECT_EQ(as_embedding(mesh.topology, crossing).report.self_intersections, std::nullopt);
}

TEST(Embedder, HasTheSameBitsForAnyThreadCountAndPowerOfTwoWithTurns)
{
    Pair pair = bumpy_pair();
    const auto embedded = [&] {
        const ShapePoint half =
            blend(shape_vectors(pair.meshes, Scale::None), Eigen::Vector2d(0.5, 0.5));
        return Embedder(pair.meshes.topology, pair.meshes.points).embed(half).points;
    };
    const int threads = thread_count();
    set_thread_count(1);
    const Points one = embedded();
    set_thread_count(3);
    const Points three = embedded();
    set_thread_count(threads);
    EXPECT_TRUE(one == three);
    for (Points& points : pair.meshes.points)
        points *= 1024.0;
    EXPECT_LT(rigid_distance(embedded() / 1024.0, one), 1e-12);
}

TEST(Embedder, RefusesBadTurns)
{
    Pair pair = bumpy_pair();
    const Embedder embedder(pair.meshes.topology, pair.meshes.points);
    EXPECT_THROW(Embedder(pair.meshes.topology, pair.meshes.points, {.anchor = -1.0}),
                 InvalidInput);
    pair.half.patch_turns[2] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)embedder.embed(pair.half), InvalidInput);
    pair.half.patch_turns = VectorXd::Zero(3);
    EXPECT_THROW((void)embedder.embed(pair.half), InvalidInput);
}

TEST(Embedder, RefusesBadInput)
{
    const test::TestMesh mesh = test::tetrahedron();
    EXPECT_THROW(Embedder(mesh.topology, {}), InvalidInput);
    EXPECT_THROW(Embedder(mesh.topology, {Points::Zero(3, 3)}), InvalidInput);
    EXPECT_THROW(Embedder(mesh.topology, {Points::Zero(4, 3)}), InvalidInput);
    EXPECT_THROW(Embedder(mesh.topology, {mesh.points}, {.smoothness = 0.0}), InvalidInput);
    const Embedder embedder(mesh.topology, {mesh.points});
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    target.edge_lengths[3] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)embedder.embed(target), InvalidInput);
    target.edge_lengths.conservativeResize(3);
    EXPECT_THROW((void)embedder.embed(target), InvalidInput);
}

TEST(Embedder, RefusesAnglesWhoseSinesAreRounding)
{
    const test::TestMesh mesh = test::icosphere(0);
    for (const EmbeddingMethod method :
         {EmbeddingMethod::Dihedral, EmbeddingMethod::Closure, EmbeddingMethod::Multiscale}) {
        const Embedder embedder(mesh.topology, {mesh.points}, {.method = method});
        ShapePoint target = test::shape_of(mesh.topology, mesh.points);
        EXPECT_NO_THROW((void)embedder.embed(target));
        for (const double angle : {2e9, -1e197, std::numeric_limits<double>::quiet_NaN()}) {
            target.dihedral_angles[3] = angle;
            EXPECT_THROW((void)embedder.embed(target), InvalidInput) << angle;
        }
    }
}

TEST(EmbeddingReport, MeasuresWhatItSays)
{
    const test::TestMesh mesh = test::icosphere(1);
    const ShapePoint own = test::shape_of(mesh.topology, mesh.points);
    EXPECT_EQ(measure_embedding(mesh.topology, mesh.points, own).status, EmbeddingStatus::Exact);

    // Twice as large: every length is off by its half, no angle is.
    ShapePoint half = own;
    half.edge_lengths *= 2.0;
    const EmbeddingReport report = measure_embedding(mesh.topology, mesh.points, half);
    EXPECT_EQ(report.status, EmbeddingStatus::Approximate);
    EXPECT_NEAR(report.edge_max, 0.5, 1e-14);
    EXPECT_NEAR(report.edge_p99, 0.5, 1e-14);
    const VectorXd difference = 0.5 * half.edge_lengths;
    EXPECT_NEAR(report.edge_rms,
                std::sqrt(difference.array().square().mean()) / half.edge_lengths.mean(), 1e-14);
    EXPECT_LT(report.dihedral_max_deg, 1e-10);

    // One angle asked for 10 degrees more, once around the circle.
    ShapePoint bent = own;
    bent.dihedral_angles[7] += 10.0 * std::numbers::pi / 180.0 + 2.0 * std::numbers::pi;
    const EmbeddingReport drift = measure_embedding(mesh.topology, mesh.points, bent);
    EXPECT_NEAR(drift.dihedral_max_deg, 10.0, 1e-9);
    EXPECT_NEAR(drift.dihedral_rms_deg, 10.0 / std::sqrt(mesh.topology.edge_count()), 1e-9);

    // Hinges further off than 150 degrees are folded flat, with both of their faces.
    ShapePoint folded = own;
    folded.dihedral_angles[7] += 149.0 * std::numbers::pi / 180.0;
    EXPECT_EQ(measure_embedding(mesh.topology, mesh.points, folded).inverted_faces, 0);
    folded.dihedral_angles[7] += 2.0 * std::numbers::pi / 180.0;
    EXPECT_EQ(measure_embedding(mesh.topology, mesh.points, folded).inverted_faces, 2);

    Points collapsed = mesh.points;
    collapsed.row(0) = collapsed.row(mesh.topology.target(mesh.topology.outgoing(0)[0]));
    EXPECT_GE(measure_embedding(mesh.topology, collapsed, own).inverted_faces, 2);
}

TEST(EmbeddingReport, GivesTheQuantilesOfErrors)
{
    // Errors 0, 1, ..., 1919 times a unit: 99 % of 1920 are 1900.8, 99.9 % are 1918.08.
    const test::TestMesh mesh = test::icosphere(3);
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    ASSERT_EQ(target.edge_lengths.size(), 1920);
    for (int e = 0; e < 1920; ++e) {
        target.edge_lengths[e] /= 1.0 + 1e-4 * e;
        target.dihedral_angles[e] += 0.05 * e * std::numbers::pi / 180.0;
    }
    const EmbeddingReport report = measure_embedding(mesh.topology, mesh.points, target);
    EXPECT_NEAR(report.edge_max, 0.1919, 1e-12);
    EXPECT_NEAR(report.edge_p999, 0.1918, 1e-12);
    EXPECT_NEAR(report.edge_p99, 0.1900, 1e-12);
    EXPECT_NEAR(report.dihedral_max_deg, 95.95, 1e-9);
    EXPECT_NEAR(report.dihedral_p99_deg, 95.0, 1e-9);
}

} // namespace
} // namespace shape
