// SPDX-License-Identifier: MIT

#include "libshape/explore/block_of_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"
#include "libshape/mesh/alignment.h"

namespace shape::internal {
namespace {

using Eigen::Index;

/// By central differences of one standard deviation and of half a direction: along a mode to both
/// sides, so that what bends to either side cancels.
LinearVertices linear_vertices(const ShapeModel& model, const ModelBlock& block,
                               const DihedralEmbedder& embedder, const Progress& progress)
{
    const double size = model.mean_size();
    const Index modes = std::min<Index>(block.modes.rows(), most_linear_modes);
    const Index directions = block.directions.edge_lengths.rows();
    const Index vertices = 3 * model.topology.vertex_count();
    DihedralEmbeddingOptions options = dihedral_preview();
    options.smoothness = block.smoothness;
    const auto point = [&](const Eigen::VectorXd& scores) {
        return std::get<ShapePoint>(model_point(model, scores, size));
    };
    LinearVertices linear{.mean = embedder.embed(point({}), options).points,
                          .modes = FloatRows(modes, vertices),
                          .directions = FloatRows(directions, vertices),
                          .size = scale_of(model.space) == Scale::Unit ? size : 1.0};
    // The mesh of a point, turned as the mean lies.
    const auto mesh = [&](const ShapePoint& at) {
        const Points points = embedder.embed(at, options).points;
        return best_rigid_motion(points, linear.mean)(points);
    };
    for (Index i = 0; i < modes + directions; ++i) {
        if (progress)
            progress("vertices along modes", to_size(i), to_size(modes + directions));
        const double step = i < modes ? std::sqrt(model.variances[i]) : 0.5;
        if (!(step > 0.0)) { // a mode without variance
            linear.modes.row(i).setZero();
            continue;
        }
        const auto moved = [&](double by) {
            if (i < modes)
                return mesh(point(by * Eigen::VectorXd::Unit(i + 1, i)));
            ShapePoint at = point({});
            at.positions.resize(0, 3); // differences say nothing of them
            at.edge_lengths += by * block.directions.edge_lengths.row(i - modes).transpose();
            at.dihedral_angles += by * block.directions.dihedral_angles.row(i - modes).transpose();
            return mesh(at);
        };
        const Points change = (moved(step) - moved(-step)) / (2.0 * step);
        (i < modes ? linear.modes.row(i) : linear.directions.row(i - modes)) =
            change.reshaped<Eigen::RowMajor>().transpose().cast<float>();
    }
    return linear;
}

} // namespace

ModelBlock make_block(const ShapeModel& model, int modes, AddedDirections directions,
                      double smoothness, const Progress& progress)
{
    const bool embeds = std::holds_alternative<EdgeSpace>(model.space);
    const Index edges = model.topology.edge_count();
    if (modes < 0 || modes > model.mode_count())
        throw InvalidInput(
            join("model block: modes is ", modes, ", must be in [0, ", model.mode_count(), "]"));
    if (directions.edge_lengths.rows() != directions.dihedral_angles.rows() ||
        (directions.edge_lengths.rows() > 0 &&
         (!embeds || directions.edge_lengths.cols() != edges ||
          directions.dihedral_angles.cols() != edges)))
        throw InvalidInput("model block: directions need a model of edge space and its edges");
    ModelBlock block{.topology = model.topology,
                     .reference_points = model.reference_points,
                     .space = model.space,
                     .mean = model.mean,
                     .mean_dihedral_angles = model.mean_dihedral_angles,
                     .modes = model.modes.topRows(modes),
                     .mode_dihedral_angles = model.mode_dihedral_angles.topRows(modes),
                     .directions = std::move(directions),
                     .smoothness = smoothness,
                     .factor = {},
                     .linear = {}};
    if (embeds) {
        const DihedralEmbedder embedder(model.topology, {model.reference_points});
        block.linear = linear_vertices(model, block, embedder, progress);
        block.factor.push_back(embedder.factor());
    }
    return block;
}

} // namespace shape::internal
