// SPDX-License-Identifier: MIT

#include "libshape/edge_space/shape_vectors.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/patch_turns.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
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
    const double mean = circular_mean(column.array().cos().sum(), column.array().sin().sum(),
                                      static_cast<double>(column.size()));
    for (double& angle : column)
        angle = on_branch(angle, mean);
}

} // namespace

double circular_mean(double cosines, double sines, double count)
{
    // Unit vectors that cancel leave a sum of about 1e-16 * count, of any direction.
    return std::hypot(cosines, sines) <= 1e-12 * count ? 0.0 : std::atan2(sines, cosines);
}

double on_branch(double angle, double mean)
{
    if (!is_near_fold(mean) || !is_near_fold(angle))
        return angle;
    const double apart =
        angle - mean; // the choice alone depends on it: the mean's rounding changes no bit
    return apart > pi ? angle - 2.0 * pi : apart <= -pi ? angle + 2.0 * pi : angle;
}

ShapeVectors shape_vectors(const Collection& collection, Scale scale)
{
    const auto rows = static_cast<Index>(collection.size());
    ShapeVectors vectors{RowMatrix(rows, collection.topology.edge_count()),
                         companion_angles(collection),
                         Eigen::VectorXd(rows),
                         {}};
    if (collection.size() > 0)
        vectors.patch_turns =
            PatchTurns(collection.topology, collection.points.front()).of(collection.points);
    parallel_for(collection.size(), 1, [&](std::size_t mesh, std::size_t) {
        const auto row = static_cast<Index>(mesh);
        const Eigen::VectorXd lengths = edge_lengths(collection.topology, collection.points[mesh]);
        const double size = lengths.sum();
        vectors.sizes[row] = size;
        vectors.edge_lengths.row(row) = lengths.transpose() / (scale == Scale::Unit ? size : 1.0);
    });
    return vectors;
}

RowMatrix companion_angles(const Collection& collection)
{
    RowMatrix angles(static_cast<Index>(collection.size()), collection.topology.edge_count());
    parallel_for(collection.size(), 1, [&](std::size_t mesh, std::size_t) {
        angles.row(static_cast<Index>(mesh)) =
            dihedral_angles(collection.topology, collection.points[mesh]).transpose();
    });
    return unify_branches(std::move(angles));
}

RowMatrix unify_branches(RowMatrix angles)
{
    if (angles.rows() == 0)
        return angles;
    parallel_for(to_size(angles.cols()), 256, [&](std::size_t begin, std::size_t end) {
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
    if (vectors.patch_turns.rows() == weights.size())
        point.patch_turns = vectors.patch_turns.transpose() * weights;
    if (lengths == LengthBlend::Plain)
        point.edge_lengths = vectors.edge_lengths.transpose() * weights;
    else
        point.edge_lengths =
            (vectors.edge_lengths.cwiseAbs2().transpose() * weights).cwiseMax(0.0).cwiseSqrt();
    return point;
}

} // namespace shape
