// SPDX-License-Identifier: MIT

#include "libshape/explore/model_decoder.h"

#include <algorithm>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/residual_field.h"

namespace shape::internal {
namespace {

using Eigen::VectorXd;

/// to += sum of weights times rows.
void add_rows(const FloatRows& rows, const VectorXd& weights, VectorXd& to)
{
    for (Eigen::Index k = 0; k < weights.size(); ++k)
        if (weights[k] != 0.0)
            to += weights[k] * rows.row(k).transpose().cast<double>();
}

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

} // namespace

ModelDecoder::ModelDecoder(ModelBlock block) : block_(std::move(block))
{
    if (std::holds_alternative<EdgeSpace>(block_.space)) {
        if (block_.factor.size() != 1)
            throw InvalidInput("decoder: a model of edge space needs its factor");
        embedder_.emplace(block_.topology, std::vector<Points>{block_.reference_points},
                          std::move(block_.factor.front()));
    }
    block_.factor.clear();
}

DecodedShape ModelDecoder::point(const VectorXd& scores, const VectorXd& amounts, double size) const
{
    check_count("scores", scores, block_.modes.rows());
    check_count("amounts", amounts, block_.directions.edge_lengths.rows());
    VectorXd coordinates = block_.mean;
    VectorXd companion = block_.mean_dihedral_angles;
    add_rows(block_.modes, scores, coordinates);
    add_rows(block_.mode_dihedral_angles, scores, companion);
    DecodedShape shape = shape::decode(block_.space, coordinates, companion, size);
    if (ShapePoint* const target = std::get_if<ShapePoint>(&shape)) {
        add_rows(block_.directions.edge_lengths, amounts, target->edge_lengths);
        add_rows(block_.directions.dihedral_angles, amounts, target->dihedral_angles);
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
    const Topology& topology = block_.topology;
    DecodedModelPoint result;
    if (Points* const points = std::get_if<Points>(&shape)) {
        result.embedding = as_embedding(topology, std::move(*points));
        result.edge_error = result.dihedral_drift = Eigen::VectorXf::Zero(topology.vertex_count());
        result.broken_faces.assign(to_size(topology.face_count()), 0);
        return result;
    }
    const ShapePoint& target = std::get<ShapePoint>(shape);
    options.smoothness = block_.smoothness;
    result.embedding =
        embed_by_dihedrals(*embedder_, topology, block_.reference_points, target, options);
    const ResidualField field = residual_field(topology, result.embedding.points, target);
    result.edge_error = field.edge_error.cast<float>();
    result.dihedral_drift = field.dihedral_drift.cast<float>();
    result.broken_faces = broken_faces(topology, target.edge_lengths);
    return result;
}

} // namespace shape::internal
