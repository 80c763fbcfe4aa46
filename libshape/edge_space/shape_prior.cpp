// SPDX-License-Identifier: MIT

#include "libshape/edge_space/shape_prior.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A prior's lengths, however far its scores go, stay those of edges.
constexpr double least_length = 0.05; // of the mean's

std::vector<Index> all_but(Index count, Index without)
{
    std::vector<Index> rows;
    for (Index i = 0; i < count; ++i)
        if (i != without)
            rows.push_back(i);
    return rows;
}

} // namespace

ShapePosterior posterior(const ShapePrior& prior, const VectorXd& lengths,
                         const std::vector<char>& seen)
{
    const VectorXd& mean = prior.mean.edge_lengths;
    const Index count = mean.size(), modes = prior.length_steps.rows();
    if (lengths.size() != count || std::ssize(seen) != count ||
        prior.length_steps.cols() != count || prior.angle_steps.rows() != modes)
        throw InvalidInput(join("posterior: ", lengths.size(), " lengths and ", seen.size(),
                                " marks for a prior of ", count, " edges"));
    require_positive(prior.noise, "ShapePrior.noise");
    VectorXd mask(count);
    for (Index e = 0; e < count; ++e)
        mask[e] = seen[to_size(e)] != 0 ? 1.0 : 0.0;
    if (mask.sum() == 0.0)
        throw InvalidInput("posterior: no edge is seen");

    const RowMatrix steps = prior.length_steps * mask.asDiagonal();
    MatrixXd normal = steps * steps.transpose();
    normal.diagonal().array() += prior.noise;
    const Eigen::LLT<MatrixXd> solver(normal);
    ShapePosterior result;
    result.scores = VectorXd::Zero(modes);
    VectorXd predicted = mean;
    // Size and scores are found in turn; steps of unit sum change a size little, so that the first rounds do
    // most of it: after four a size still moves by about 1e-4 of itself (shape_prior_test.cpp).
    constexpr int rounds = 4;
    for (int round = 0; round < rounds; ++round) {
        const VectorXd part = predicted.cwiseProduct(mask);
        result.size = part.dot(lengths) / part.squaredNorm();
        if (modes > 0)
            result.scores = solver.solve(steps * (lengths / result.size - mean));
        predicted =
            (mean + prior.length_steps.transpose() * result.scores).cwiseMax(least_length * mean);
    }
    result.point.edge_lengths = result.size * predicted;
    result.point.dihedral_angles =
        prior.mean.dihedral_angles + prior.angle_steps.transpose() * result.scores;
    const VectorXd rest = (lengths - result.point.edge_lengths).cwiseProduct(mask);
    result.residual = std::sqrt(rest.squaredNorm() / mask.sum()) / lengths.mean();
    return result;
}

ShapePrior prior_of(const ShapeVectors& vectors, int without, double noise)
{
    const Index count = vectors.edge_lengths.rows();
    require(without >= -1 && without < count, "without", without, join("in [-1, ", count, ")"));
    require_positive(noise, "noise");
    const std::vector<Index> rows = all_but(count, without);
    if (rows.size() < 2)
        throw InvalidInput(join("a prior needs at least 2 shapes, there is ", rows.size()));
    const double scale = 1.0 / std::sqrt(static_cast<double>(rows.size()) - 1.0);
    const auto centred = [&](const RowMatrix& all, VectorXd& mean) {
        RowMatrix some = all(rows, Eigen::all);
        mean = some.colwise().mean();
        some.rowwise() -= mean.transpose();
        return RowMatrix(scale * some);
    };
    ShapePrior prior;
    prior.length_steps = centred(vectors.edge_lengths, prior.mean.edge_lengths);
    prior.angle_steps = centred(vectors.dihedral_angles, prior.mean.dihedral_angles);
    prior.noise = noise;
    return prior;
}

} // namespace shape
