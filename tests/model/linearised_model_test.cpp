// SPDX-License-Identifier: MIT

#include "libshape/model/linearised_model.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "libshape/mesh/alignment.h"
#include "libshape/synthetic/synthetic.h"
#include "tests/support/files.h"

namespace shape {
namespace {

ShapeModel faces_model(SpaceKind space, Scale scale)
{
    return fit_model(make_synthetic("faces", {.count = 3, .vertices = 300}),
                     {.space = {.kind = space, .scale = scale}});
}

void expect_orthonormal_and_descending(const LinearisedModel& linear)
{
    const Eigen::Index count = linear.variances.size();
    EXPECT_LE((linear.basis.transpose() * linear.basis - Eigen::MatrixXd::Identity(count, count))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-9);
    EXPECT_GT(linear.variances.minCoeff(), 0.0);
    for (Eigen::Index k = 1; k < count; ++k)
        EXPECT_LE(linear.variances[k], linear.variances[k - 1]);
}

TEST(LinearisedModel, IsTheModelWherePositionsAreItsCoordinates)
{
    const ShapeModel model = faces_model(SpaceKind::Procrustes, Scale::None);
    const LinearisedModel linear = linearise(model);
    expect_orthonormal_and_descending(linear);
    ASSERT_EQ(linear.variances.size(), model.variances.size());
    EXPECT_LE((linear.variances - model.variances).cwiseAbs().maxCoeff(),
              1e-9 * model.variances[0]);
    // Whatever the signs of the basis, scores give back the points that they are the scores of.
    const Eigen::MatrixXd ours = linear.basis * linear.scores.transpose();
    const Eigen::MatrixXd theirs = model.modes.transpose() * model.scores.transpose();
    EXPECT_LE((ours.transpose() * ours - theirs.transpose() * theirs).cwiseAbs().maxCoeff(),
              1e-9 * theirs.squaredNorm());
}

TEST(LinearisedModel, IsNearTheMeshesOfAModelOfEdgeLengths)
{
    const ShapeModel model = faces_model(SpaceKind::Edge, Scale::Unit);
    const LinearisedModel linear = linearise(model, 3);
    expect_orthonormal_and_descending(linear);
    const Embedder embedder(model.topology, {model.reference_points});
    // The share of the moves of a mode that the basis explains is all of them.
    for (int mode = 0; mode < 3; ++mode) {
        Eigen::VectorXd scores = Eigen::VectorXd::Zero(3);
        scores[mode] = std::sqrt(model.variances[mode]);
        const Points mesh = embedder.embed(model_point(model, scores, model.mean_size())).points;
        const Points moved = best_rigid_motion(mesh, linear.mean)(mesh) - linear.mean;
        const Eigen::VectorXd move = moved.reshaped<Eigen::RowMajor>();
        const Eigen::VectorXd rest = move - linear.basis * (linear.basis.transpose() * move);
        EXPECT_LE(rest.norm(), 0.2 * move.norm()) << mode;
        EXPECT_GT(move.norm(), 0.0);
    }
    // One standard deviation of score is one of the linearised model, mode by mode in sum.
    const double scattered =
        (linear.scores.rowwise() - linear.scores.colwise().mean()).squaredNorm() /
        static_cast<double>(linear.scores.rows() - 1);
    EXPECT_NEAR(scattered, linear.variances.sum(), 1e-9 * linear.variances.sum());
}

TEST(LinearisedModel, RefusesModesThatAreNotThere)
{
    const ShapeModel model = faces_model(SpaceKind::Procrustes, Scale::None);
    for (const int modes : {-1, model.mode_count() + 1})
        EXPECT_NE(test::message_of<InvalidInput>([&] {
                      (void)linearise(model, modes);
                  }).find("must be in [0, "),
                  std::string::npos);
}

} // namespace
} // namespace shape
