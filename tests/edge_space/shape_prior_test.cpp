// SPDX-License-Identifier: MIT

#include "libshape/edge_space/shape_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"

namespace shape::test {
using namespace internal;
namespace {

using Eigen::VectorXd;

constexpr int edges = 200;

RowMatrix random_rows(int rows, double deviation, std::uint64_t seed)
{
    Random random(seed);
    RowMatrix values(rows, edges);
    for (double& value : values.reshaped())
        value = deviation * random.normal();
    return values;
}

ShapePrior some_prior(double noise)
{
    ShapePrior prior;
    prior.mean.edge_lengths = VectorXd::Ones(edges) + 0.2 * VectorXd::Random(edges);
    prior.mean.dihedral_angles = VectorXd::Zero(edges);
    prior.length_steps = random_rows(3, 0.05, 1);
    prior.angle_steps = random_rows(3, 0.05, 2);
    prior.noise = noise;
    return prior;
}

TEST(ShapePrior, FindsScoresAndSizeOfItsOwnShapesFromAFractionOfTheEdges)
{
    const ShapePrior prior = some_prior(1e-14);
    const VectorXd scores = (VectorXd(3) << 1.0, -0.5, 2.0).finished();
    const VectorXd truth =
        7.0 * (prior.mean.edge_lengths + prior.length_steps.transpose() * scores);
    VectorXd lengths = truth;
    std::vector<char> seen(edges, 0);
    for (int e = 0; e < edges; ++e)
        if (e % 4 == 0)
            seen[to_size(e)] = 1;
        else
            lengths[e] = 1e3; // does not count
    const ShapePosterior found = posterior(prior, lengths, seen);
    // Size and scores in turn approach the truth; the mean's direction is nearly no step's.
    EXPECT_NEAR(found.size, 7.0, 0.01);
    EXPECT_LT((found.scores - scores).norm(), 0.02);
    EXPECT_LT((found.point.edge_lengths - truth).norm(), 1e-3 * truth.norm());
    EXPECT_LT((found.point.dihedral_angles - prior.angle_steps.transpose() * scores).norm(), 0.02);
}

TEST(ShapePrior, MinimisesThePenalisedSquaresAtItsSize)
{
    const ShapePrior prior = some_prior(0.3);
    const VectorXd lengths = prior.mean.edge_lengths + random_rows(1, 0.2, 9).row(0).transpose();
    const ShapePosterior found = posterior(prior, lengths, std::vector<char>(edges, 1));
    // Of the normal equation (A A^T + noise) z = A (l / s - m), at a size that still moves by 1e-4.
    const VectorXd left = prior.length_steps * (lengths / found.size - prior.mean.edge_lengths -
                                                prior.length_steps.transpose() * found.scores) -
                          prior.noise * found.scores;
    EXPECT_LT(left.norm(), 1e-3 * (prior.length_steps * lengths).norm());
    ShapePrior firm = prior;
    firm.noise = 1e9;
    EXPECT_LT(posterior(firm, lengths, std::vector<char>(edges, 1)).scores.norm(), 1e-6);
}

TEST(ShapePrior, OfOtherShapesLeavesOneOut)
{
    ShapeVectors vectors{random_rows(6, 0.1, 3).array() + 1.0, random_rows(6, 0.1, 4), {}};
    const ShapePrior before = prior_of(vectors, 2, 1.0);
    vectors.edge_lengths.row(2).setConstant(100.0);
    vectors.dihedral_angles.row(2).setConstant(100.0);
    const ShapePrior after = prior_of(vectors, 2, 1.0);
    EXPECT_EQ(before.mean.edge_lengths, after.mean.edge_lengths);
    EXPECT_EQ(before.angle_steps, after.angle_steps);
    EXPECT_EQ(before.length_steps.rows(), 5);
    // Steps carry the covariance: sum a a^T = sum d d^T / (N - 1).
    const ShapePrior all = prior_of(vectors, -1, 1.0);
    const RowMatrix centred =
        vectors.edge_lengths.rowwise() - vectors.edge_lengths.colwise().mean();
    EXPECT_NEAR(all.length_steps.squaredNorm(), centred.squaredNorm() / 5.0,
                1e-9 * centred.squaredNorm());
}

TEST(ShapePrior, RefusesWhatIsNotAQuestion)
{
    ShapePrior prior = some_prior(1.0);
    const VectorXd lengths = VectorXd::Ones(edges);
    EXPECT_THROW((void)posterior(prior, lengths, std::vector<char>(edges, 0)), InvalidInput);
    EXPECT_THROW((void)posterior(prior, lengths, std::vector<char>(3, 1)), InvalidInput);
    EXPECT_THROW((void)posterior(prior, VectorXd::Ones(3), std::vector<char>(3, 1)), InvalidInput);
    prior.noise = 0.0;
    EXPECT_THROW((void)posterior(prior, lengths, std::vector<char>(edges, 1)), InvalidInput);
    const ShapeVectors two{random_rows(2, 0.1, 3).array() + 1.0, random_rows(2, 0.1, 4), {}};
    EXPECT_NO_THROW((void)prior_of(two, -1, 1.0));
    EXPECT_THROW((void)prior_of(two, 0, 1.0), InvalidInput); // one is left
    EXPECT_THROW((void)prior_of(two, 2, 1.0), InvalidInput);
    EXPECT_THROW((void)prior_of(two, -1, 0.0), InvalidInput);
}

} // namespace
} // namespace shape::test
