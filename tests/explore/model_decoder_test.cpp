// SPDX-License-Identifier: MIT

#include "libshape/explore/model_decoder.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "libshape/embedding/report.h"
#include "libshape/explore/block_of_model.h"
#include "libshape/model/shape_model.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

ShapeModel model_of(const SpaceOptions& space = {})
{
    return fit_model(test::bumpy_spheres(6, 3), {.modes = 4, .space = space});
}

ModelDecoder decoder_of(const ShapeModel& model, AddedDirections directions = {})
{
    return ModelDecoder(
        read_block(write_block(make_block(model, model.mode_count(), std::move(directions)))));
}

Eigen::VectorXd scores_of(const ShapeModel& model, double deviations)
{
    return deviations * model.variances.cwiseSqrt();
}

double distance(const Points& a, const Points& b)
{
    return (a - b).cwiseAbs().maxCoeff() / bounding_box_diagonal(b);
}

TEST(ModelDecoder, MakesTheMeshesOfTheEmbedder)
{
    for (const LengthCoordinates coordinates :
         {LengthCoordinates::Plain, LengthCoordinates::Squared, LengthCoordinates::Log}) {
        const ShapeModel model = model_of({.coordinates = coordinates});
        const ModelDecoder decoder = decoder_of(model);
        for (const EmbeddingQuality quality : {EmbeddingQuality::Preview, EmbeddingQuality::Fine}) {
            const Embedder embedder(model.topology, {model.reference_points}, {.quality = quality});
            const Eigen::VectorXd scores = scores_of(model, 0.7);
            const Embedding wanted = embedder.embed(model_point(model, scores, model.mean_size()));
            const DecodedModelPoint decoded =
                decoder.decode(scores, {}, model.mean_size(),
                               quality == EmbeddingQuality::Fine ? DihedralEmbeddingOptions()
                                                                 : dihedral_preview());
            EXPECT_LT(distance(decoded.embedding.points, wanted.points), 1e-5);
            EXPECT_NEAR(decoded.embedding.report.edge_rms, wanted.report.edge_rms,
                        1e-3 * wanted.report.edge_rms);
            EXPECT_EQ(decoded.embedding.report.status, wanted.report.status);
            EXPECT_NEAR(decoded.edge_error.maxCoeff(), decoded.embedding.report.edge_max, 1e-7);
        }
    }
}

TEST(ModelDecoder, AddsAsWellAreaWeightsAnglesAndPositions)
{
    const ShapeModel model = model_of(
        {.weighting = EdgeWeighting::Area, .dihedral_weight = 0.5, .position_weight = 3.0});
    const Eigen::VectorXd scores = scores_of(model, -0.5);
    const Embedder embedder(model.topology, {model.reference_points});
    EXPECT_LT(distance(decoder_of(model).decode(scores, {}, model.mean_size(), {}).embedding.points,
                       embedder.embed(model_point(model, scores, model.mean_size())).points),
              1e-5);
}

TEST(ModelDecoder, GivesPointsOfProcrustesSpaceAsTheyAre)
{
    const ShapeModel model = model_of({.kind = SpaceKind::Procrustes});
    const Eigen::VectorXd scores = scores_of(model, 2.0);
    const DecodedModelPoint decoded =
        decoder_of(model).decode(scores, {}, model.mean_size(), dihedral_preview());
    Points wanted = std::get<Points>(model_point(model, scores, model.mean_size()));
    wanted.rowwise() -= wanted.colwise().mean();
    EXPECT_LT(distance(decoded.embedding.points, wanted), 1e-6);
    EXPECT_EQ(decoded.embedding.report.status, EmbeddingStatus::Exact);
    EXPECT_TRUE(decoder_of(model).is_feasible(scores_of(model, 50.0), {}, model.mean_size()));
}

TEST(ModelDecoder, CountsFacesThatCross)
{
    const ShapeModel model = model_of();
    const ModelDecoder decoder = decoder_of(model);
    const Embedder embedder(model.topology, {model.reference_points});
    EXPECT_EQ(decoder.crossings(model.reference_points).all, 0);
    Points pierced = model.reference_points; // one vertex through the other side
    pierced.row(0) = 2.0 * pierced.colwise().mean() - 2.0 * pierced.row(0);
    const EmbeddingReport wanted = embedder.embed(DecodedShape(pierced)).report;
    const CrossingCount::Count found = decoder.crossings(pierced);
    EXPECT_GT(found.all, 0);
    EXPECT_EQ(found.all, wanted.self_intersections);
    EXPECT_EQ(found.in_no_reference, wanted.new_self_intersections);
    EXPECT_THROW((void)decoder.crossings(pierced.topRows(3)), InvalidInput);
}

TEST(ModelDecoder, AddsDirectionsToThePoint)
{
    const ShapeModel model = model_of();
    const double size = model.mean_size();
    const double step = 0.6 * std::sqrt(model.variances[0]);
    // The first mode once more, as a direction.
    const AddedDirections first{size * model.modes.topRows(1),
                                model.mode_dihedral_angles.topRows(1)};
    const ModelDecoder decoder = decoder_of(model, first);
    const Eigen::VectorXd amount = Eigen::VectorXd::Constant(1, step);
    EXPECT_LT(distance(decoder.decode({}, amount, size, {}).embedding.points,
                       decoder.decode(amount, {}, size, {}).embedding.points),
              1e-6);
}

TEST(ModelDecoder, DraftsAreMeasuredAndNearlyPreviews)
{
    const ShapeModel model = model_of();
    const double size = model.mean_size();
    const ModelDecoder decoder = decoder_of(model);
    for (const double deviations : {-0.9, -0.3, 0.0, 0.5, 1.0}) {
        const Eigen::VectorXd scores = scores_of(model, deviations);
        const DecodedModelPoint draft = decoder.draft(scores, {}, size);
        const DecodedModelPoint preview = decoder.decode(scores, {}, size, dihedral_preview());
        const EmbeddingReport& report = draft.embedding.report;
        // What one reads below a draft is what one sees.
        const auto target = std::get<ShapePoint>(model_point(model, scores, size));
        const EmbeddingReport measured =
            measure_embedding(model.topology, draft.embedding.points, target);
        const auto near = [](double found, double wanted) {
            EXPECT_NEAR(found, wanted, 1e-9 * wanted + 1e-12);
        };
        near(report.edge_rms, measured.edge_rms);
        near(report.edge_max, measured.edge_max);
        near(report.edge_p99, measured.edge_p99);
        near(report.dihedral_rms_deg, measured.dihedral_rms_deg);
        near(report.dihedral_p99_deg, measured.dihedral_p99_deg);
        near(report.dihedral_max_deg, measured.dihedral_max_deg);
        EXPECT_EQ(report.inverted_faces, measured.inverted_faces);
        EXPECT_EQ(report.status, measured.status);
        const ResidualField field = residual_field(model.topology, draft.embedding.points, target);
        EXPECT_LT((draft.edge_error.cast<double>() - field.edge_error).cwiseAbs().maxCoeff(), 1e-6);
        EXPECT_LT(
            (draft.dihedral_drift.cast<double>() - field.dihedral_drift).cwiseAbs().maxCoeff(),
            1e-4);
        EXPECT_NEAR(draft.edge_error.maxCoeff(), measured.edge_max, 1e-7);
        EXPECT_LT(report.edge_rms, 2.0 * preview.embedding.report.edge_rms + 1e-4);
        EXPECT_LT(distance(draft.embedding.points, preview.embedding.points), 0.02);
        // Sizes are free.
        EXPECT_LT(distance(decoder.draft(scores, {}, 3.0 * size).embedding.points,
                           3.0 * draft.embedding.points),
                  1e-5);
    }
}

TEST(ModelDecoder, DraftsFollowAddedDirections)
{
    const ShapeModel model = model_of();
    const double size = model.mean_size();
    const double deviation = std::sqrt(model.variances[0]);
    const AddedDirections first{deviation * size * model.modes.topRows(1),
                                deviation * model.mode_dihedral_angles.topRows(1)};
    const ModelDecoder decoder = decoder_of(model, first);
    const Eigen::VectorXd amount = Eigen::VectorXd::Constant(1, 0.8);
    EXPECT_LT(distance(decoder.draft({}, amount, size).embedding.points,
                       decoder.draft(deviation * amount, {}, size).embedding.points),
              1e-3);
}

TEST(ModelDecoder, DraftsOfProcrustesSpaceAreExact)
{
    const ShapeModel model = model_of({.kind = SpaceKind::Procrustes});
    const Eigen::VectorXd scores = scores_of(model, 0.8);
    const ModelDecoder decoder = decoder_of(model);
    EXPECT_EQ(decoder.draft(scores, {}, model.mean_size()).embedding.points,
              decoder.decode(scores, {}, model.mean_size(), {}).embedding.points);
}

TEST(ModelDecoder, RefusesLinearVerticesOfAnotherMesh)
{
    ModelBlock block = make_block(model_of(), 1);
    block.linear.modes.conservativeResize(1, 3);
    EXPECT_NE(test::message_of<InvalidInput>([&] { (void)ModelDecoder(block); }), "");
}

TEST(ModelDecoder, KnowsWhereTriangleInequalitiesBreak)
{
    const ShapeModel model = model_of();
    const ModelDecoder decoder = decoder_of(model);
    const FeasibleRange range = feasible_range(model, 0, 1000.0);
    ASSERT_LT(range.high, 1000.0);
    const double deviation = std::sqrt(model.variances[0]);
    const auto at = [&](double share) {
        return Eigen::VectorXd::Constant(1, share * range.high * deviation);
    };
    EXPECT_TRUE(decoder.is_feasible(at(0.999), {}, model.mean_size()));
    EXPECT_FALSE(decoder.is_feasible(at(1.001), {}, model.mean_size()));
    const auto broken = [&](double share) {
        const auto faces = decoder.decode(at(share), {}, model.mean_size(), dihedral_preview());
        return std::count(faces.broken_faces.begin(), faces.broken_faces.end(), 1);
    };
    EXPECT_EQ(broken(0.999), 0);
    EXPECT_GT(broken(1.001), 0);
}

TEST(ModelDecoder, RefusesWhatTheModelHasNot)
{
    const ShapeModel model = model_of();
    const ModelDecoder decoder = decoder_of(model);
    const auto decoding = [&](const Eigen::VectorXd& scores, const Eigen::VectorXd& amounts,
                              double size) {
        return
            [&decoder, scores, amounts, size] { (void)decoder.decode(scores, amounts, size, {}); };
    };
    const Eigen::VectorXd none;
    for (const auto& decode : {decoding(Eigen::VectorXd::Zero(5), none, 1.0),
                               decoding(none, Eigen::VectorXd::Zero(1), 1.0),
                               decoding(Eigen::VectorXd::Constant(1, std::nan("")), none, 1.0),
                               decoding(none, none, 0.0)})
        EXPECT_NE(test::message_of<InvalidInput>(decode), "");
}

TEST(ModelBlock, IsReadAsItWasWritten)
{
    const ModelBlock block = make_block(model_of(), 2, {}, 0.01);
    const std::vector<unsigned char> bytes = write_block(block);
    const ModelBlock read = read_block(bytes);
    EXPECT_TRUE(read.topology == block.topology);
    EXPECT_EQ(read.modes, block.modes);
    EXPECT_EQ(read.linear.mean, block.linear.mean);
    EXPECT_EQ(read.linear.modes, block.linear.modes);
    EXPECT_EQ(read.modes.rows(), 2);
    EXPECT_EQ(read.smoothness, 0.01);
    EXPECT_EQ(write_block(read), bytes);
}

TEST(ModelBlock, RefusesEveryBlockThatEndsEarly)
{
    const std::vector<unsigned char> bytes = write_block(make_block(model_of(), 1));
    for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 97)
        EXPECT_THROW((void)read_block({bytes.data(), size}), InvalidInput) << size;
}

/// Damage must throw or change numbers, never read or write elsewhere: for the sanitizers too.
TEST(ModelBlock, SurvivesDamagedBytes)
{
    const std::vector<unsigned char> bytes = write_block(make_block(model_of(), 1));
    int refused = 0;
    for (std::size_t at = 0; at < bytes.size(); at += 1 + bytes.size() / 211) {
        std::vector<unsigned char> damaged = bytes;
        damaged[at] ^= 0xffU;
        try {
            (void)read_block(damaged);
        } catch (const Error&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 0);
}

TEST(ModelBlock, RefusesDirectionsThatDoNotFit)
{
    const ShapeModel edge = model_of();
    const AddedDirections small{RowMatrix::Zero(1, 3), RowMatrix::Zero(1, 3)};
    EXPECT_THROW((void)make_block(edge, 1, small), InvalidInput);
    const Eigen::Index edges = edge.topology.edge_count();
    const AddedDirections fitting{RowMatrix::Zero(1, edges), RowMatrix::Zero(1, edges)};
    EXPECT_THROW((void)make_block(model_of({.kind = SpaceKind::Procrustes}), 1, fitting),
                 InvalidInput);
    EXPECT_THROW((void)make_block(edge, 5), InvalidInput);
}

} // namespace
} // namespace shape
