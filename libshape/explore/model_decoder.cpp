// SPDX-License-Identifier: MIT

#include "libshape/explore/model_decoder.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/residual_field.h"
#include "libshape/linalg/added_rows.h"
#include "libshape/mesh/alignment.h"

namespace shape::internal {
namespace {

using Eigen::VectorXd;

void check_count(const char* name, const VectorXd& values, Eigen::Index most)
{
    if (values.size() > most)
        throw InvalidInput(join("decoder: ", values.size(), " ", name, ", at most ", most));
    if (!values.allFinite())
        throw InvalidInput(join("decoder: ", name, " that are not finite"));
}

std::vector<char> broken_faces(const Topology& topology, const VectorXd& lengths)
{
    std::vector<char> broken(to_size(topology.face_count()), 0);
    for (int f = 0; f < topology.face_count(); ++f) {
        const auto edges = topology.face_edges().row(f);
        const Eigen::Array3d sides(lengths[edges[0]], lengths[edges[1]], lengths[edges[2]]);
        const double longest = sides.maxCoeff();
        broken[to_size(f)] = !(longest < sides.sum() - longest);
    }
    return broken;
}

/// edge_residuals() of a mesh whose edges are measured already.
EdgeResiduals residuals_of(const DihedralEmbedder::Swept& swept, const ShapePoint& target)
{
    constexpr double degrees = 180.0 / std::numbers::pi;
    return {(swept.edge_lengths - target.edge_lengths)
                .cwiseAbs()
                .cwiseQuotient(positive_lengths(target.edge_lengths)),
            degrees * swept.bends.cwiseAbs()};
}

} // namespace

ModelDecoder::ModelDecoder(ModelBlock block)
    : block_(std::move(block)),
      references_{block_.reference_points},
      crossings_(std::make_unique<CrossingCount>(block_.topology, references_))
{
    if (std::holds_alternative<EdgeSpace>(block_.space)) {
        if (block_.factor.size() != 1)
            throw InvalidInput("decoder: a model of edge space needs its factor");
        const Eigen::Index vertices = 3 * block_.topology.vertex_count();
        if (block_.linear.mean.size() != vertices || block_.linear.modes.cols() != vertices ||
            block_.linear.directions.rows() != block_.directions.edge_lengths.rows() ||
            (block_.linear.directions.rows() > 0 && block_.linear.directions.cols() != vertices))
            throw InvalidInput("decoder: the linear vertices do not fit the mesh");
        embedder_.emplace(block_.topology, references_, std::move(block_.factor.front()));
    }
    block_.factor.clear();
}

DecodedShape ModelDecoder::point(const VectorXd& scores, const VectorXd& amounts, double size) const
{
    check_count("scores", scores, block_.modes.rows());
    check_count("amounts", amounts, block_.directions.edge_lengths.rows());
    const auto& [lengths, angles] = block_.directions;
    DecodedShape shape = shape::decode(
        block_.space, with_rows_added(block_.mean, block_.modes, scores),
        with_rows_added(block_.mean_dihedral_angles, block_.mode_dihedral_angles, scores), size);
    if (ShapePoint* const target = std::get_if<ShapePoint>(&shape)) {
        target->edge_lengths = with_rows_added(std::move(target->edge_lengths), lengths, amounts);
        target->dihedral_angles =
            with_rows_added(std::move(target->dihedral_angles), angles, amounts);
        if (amounts.size() > 0 && !amounts.isZero(0.0))
            target->positions.resize(0, 3); // differences say nothing of them
    }
    return shape;
}

bool ModelDecoder::is_feasible(const VectorXd& scores, const VectorXd& amounts, double size) const
{
    const DecodedShape shape = point(scores, amounts, size);
    const ShapePoint* const target = std::get_if<ShapePoint>(&shape);
    if (target == nullptr)
        return true;
    const std::vector<char> broken = broken_faces(block_.topology, target->edge_lengths);
    return std::find(broken.begin(), broken.end(), 1) == broken.end();
}

DecodedModelPoint ModelDecoder::decode(const VectorXd& scores, const VectorXd& amounts, double size,
                                       DihedralEmbeddingOptions options) const
{
    DecodedShape shape = point(scores, amounts, size);
    if (Points* const points = std::get_if<Points>(&shape))
        return linear(std::move(*points));
    const ShapePoint& target = std::get<ShapePoint>(shape);
    options.smoothness = block_.smoothness;
    DecodedModelPoint result;
    EdgeResiduals residuals;
    result.embedding = embed_by_dihedrals(*embedder_, block_.topology, block_.reference_points,
                                          target, options, &residuals);
    add_fields(target, residuals, result);
    return result;
}

DecodedModelPoint ModelDecoder::draft(const VectorXd& scores, const VectorXd& amounts,
                                      double size) const
{
    DecodedShape shape = point(scores, amounts, size);
    if (Points* const points = std::get_if<Points>(&shape))
        return linear(std::move(*points));
    const ShapePoint& target = std::get<ShapePoint>(shape);
    // The first linear steps do most; from some thousand vertices on there is no time for others (docs/experiments/explore.md).
    const int vertices = block_.topology.vertex_count();
    const int linear_steps = vertices > 30000 ? 2 : vertices > 8000 ? 3 : vertices > 3000 ? 4 : 9;
    const DihedralEmbedder::Swept swept = embedder_->sweep(
        target, first_order(scores, amounts, size), linear_steps, block_.smoothness);
    DecodedModelPoint result;
    Points& points = result.embedding.points;
    points = best_rigid_motion(swept.points, block_.reference_points)(swept.points);
    points.rowwise() -= centroid(points);
    // The sweep measured the edges last, and a rigid motion changes none.
    const EdgeResiduals residuals = residuals_of(swept, target);
    result.embedding.report =
        report_of(block_.topology, points, swept.edge_lengths, target, residuals);
    result.embedding.report.iterations = swept.linear_steps;
    result.embedding.report.converged = swept.converged;
    add_fields(target, residuals, result);
    return result;
}

CrossingCount::Count ModelDecoder::crossings(const Points& points) const
{
    if (points.rows() != block_.topology.vertex_count())
        throw InvalidInput(join("decoder: ", points.rows(), " points of a mesh with ",
                                block_.topology.vertex_count(), " vertices"));
    return crossings_->count(points);
}

/// Of Procrustes space, where nothing is solved.
DecodedModelPoint ModelDecoder::linear(Points points) const
{
    const Topology& topology = block_.topology;
    DecodedModelPoint result;
    result.embedding = as_embedding(topology, std::move(points));
    result.edge_error = result.dihedral_drift = Eigen::VectorXf::Zero(topology.vertex_count());
    result.broken_faces.assign(to_size(topology.face_count()), 0);
    return result;
}

Points ModelDecoder::first_order(const VectorXd& scores, const VectorXd& amounts, double size) const
{
    const LinearVertices& known = block_.linear;
    Points points = known.mean;
    Eigen::Map<VectorXd> values(points.data(), points.size());
    const auto add = [&](const FloatRows& rows, const VectorXd& weights) {
        constexpr Eigen::Index piece = 1024; // as in with_rows_added()
        for (Eigen::Index first = 0; first < values.size(); first += piece) {
            const Eigen::Index count = std::min(piece, values.size() - first);
            for (Eigen::Index k = 0; k < std::min(rows.rows(), weights.size()); ++k)
                if (weights[k] != 0.0)
                    values.segment(first, count) +=
                        weights[k] * rows.row(k).segment(first, count).transpose().cast<double>();
        }
    };
    add(known.modes, scores);
    if (scale_of(block_.space) == Scale::Unit)
        points *= size / known.size;
    add(known.directions, amounts);
    return points;
}

void ModelDecoder::add_fields(const ShapePoint& target, const EdgeResiduals& residuals,
                              DecodedModelPoint& to) const
{
    const ResidualField field = residual_field(block_.topology, residuals);
    to.edge_error = field.edge_error.cast<float>();
    to.dihedral_drift = field.dihedral_drift.cast<float>();
    if (to.embedding.report.status == EmbeddingStatus::Infeasible)
        to.broken_faces = broken_faces(block_.topology, target.edge_lengths);
    else
        to.broken_faces.assign(to_size(block_.topology.face_count()), 0);
}

} // namespace shape::internal
