// SPDX-License-Identifier: MIT

#include "libshape/edge_space/shape_vectors.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
namespace {

using Eigen::Index;
using std::numbers::pi;

bool is_near_fold(double angle)
{
    return std::abs(angle) >= pi - pi / 3.0;
}

/// The rule of unify_branches() for one edge.
void unify_column(Eigen::Ref<Eigen::VectorXd, 0, Eigen::InnerStride<>> column)
{
    const double x = column.array().cos().sum();
    const double y = column.array().sin().sum();
    const double mean = std::atan2(y, x);
    const bool is_cancelled = std::hypot(x, y) <= 1e-12 * static_cast<double>(column.size());
    if (is_cancelled || !is_near_fold(mean))
        return;
    for (double& angle : column)
        if (is_near_fold(angle))
            angle = mean + wrapped_angle(angle - mean);
}

} // namespace

ShapeVectors encode(const Collection& collection, Scale scale)
{
    const auto rows = static_cast<Index>(collection.size());
    const Index edges = collection.topology.edge_count();
    ShapeVectors vectors{RowMatrix(rows, edges), RowMatrix(rows, edges), Eigen::VectorXd(rows)};
    parallel_for(collection.size(), 1, [&](std::size_t mesh, std::size_t) {
        const auto row = static_cast<Index>(mesh);
        const Eigen::VectorXd lengths = edge_lengths(collection.topology, collection.points[mesh]);
        const double size = lengths.sum();
        vectors.sizes[row] = size;
        vectors.edge_lengths.row(row) = lengths.transpose() / (scale == Scale::Unit ? size : 1.0);
        vectors.dihedral_angles.row(row) =
            dihedral_angles(collection.topology, collection.points[mesh]).transpose();
    });
    vectors.dihedral_angles = unify_branches(std::move(vectors.dihedral_angles));
    return vectors;
}

RowMatrix unify_branches(RowMatrix angles)
{
    if (angles.rows() == 0)
        return angles;
    parallel_for(static_cast<std::size_t>(angles.cols()), 256,
                 [&](std::size_t begin, std::size_t end) {
                     const auto first = static_cast<Index>(begin);
                     const auto count = static_cast<Index>(end - begin);
                     // Most edges are nowhere near the fold: leave them before any sine is taken.
                     const Eigen::RowVectorXd sharpest =
                         angles.middleCols(first, count).cwiseAbs().colwise().maxCoeff();
                     for (Index e = 0; e < count; ++e)
                         if (is_near_fold(sharpest[e]))
                             unify_column(angles.col(first + e));
                 });
    return angles;
}

ShapePoint blend(const ShapeVectors& vectors, const Eigen::VectorXd& weights, LengthBlend lengths)
{
    if (weights.size() != vectors.edge_lengths.rows())
        throw InvalidInput(join("blend: ", weights.size(), " weights for ",
                                vectors.edge_lengths.rows(), " meshes"));
    if (!weights.allFinite() || std::abs(weights.sum() - 1.0) > 1e-9)
        throw InvalidInput(join("blend: the weights sum to ", weights.sum(),
                                ", must be finite and sum to 1 within 1e-9"));
    ShapePoint point;
    point.dihedral_angles = vectors.dihedral_angles.transpose() * weights;
    if (lengths == LengthBlend::Plain)
        point.edge_lengths = vectors.edge_lengths.transpose() * weights;
    else
        point.edge_lengths =
            (vectors.edge_lengths.cwiseAbs2().transpose() * weights).cwiseMax(0.0).cwiseSqrt();
    return point;
}

} // namespace shape
