// SPDX-License-Identifier: MIT

#include "libshape/model/shape_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/collections.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

using Eigen::Index;

/// A point of a model of edge space.
ShapePoint edge_point(const ShapeModel& model, const Eigen::VectorXd& scores, double size)
{
    return std::get<ShapePoint>(model_point(model, scores, size));
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(FitModel, CarriesWhatTheCollectionHas)
{
    Collection collection = test::bumpy_spheres(6, 1);
    collection.labels = {{"group", {"a", "b", "a", "b", "a", "b"}}};
    const ShapeVectors vectors = shape_vectors(collection, Scale::Unit);
    const ShapeModel model = fit_model(collection, {.modes = 3});
    EXPECT_EQ(model.mode_count(), 3);
    EXPECT_TRUE(model.topology == collection.topology);
    EXPECT_EQ(model.reference_points, collection.points[0]);
    EXPECT_EQ(model.names, collection.names);
    EXPECT_EQ(model.labels.at(0).values, collection.labels[0].values);
    EXPECT_EQ(model.sizes, vectors.sizes);
    EXPECT_DOUBLE_EQ(model.mean_size(), vectors.sizes.mean());
    EXPECT_LE((model.mean.transpose() - vectors.edge_lengths.colwise().mean()).norm(), 1e-16);
    EXPECT_LE(
        (model.mean_dihedral_angles.transpose() - vectors.dihedral_angles.colwise().mean()).norm(),
        1e-14);
    EXPECT_NEAR(model.mean.sum(), 1.0, 1e-14);
    // Unit-sum lengths vary in the plane of sum 1.
    EXPECT_LE(model.modes.rowwise().sum().cwiseAbs().maxCoeff(), 1e-12);
}

TEST(FitModel, GivesEveryMeshBackFromAllModesLengthsAndAnglesAlike)
{
    for (const Scale scale : {Scale::Unit, Scale::None}) {
        const Collection collection = test::bumpy_spheres(8, 2);
        const ShapeVectors vectors = shape_vectors(collection, Scale::None);
        const ShapeModel model = fit_model(collection, {.space = {.scale = scale}});
        ASSERT_EQ(model.mode_count(), 7);
        for (Index i = 0; i < 8; ++i) {
            const ShapePoint point =
                edge_point(model, model.scores.row(i).transpose(), model.sizes[i]);
            EXPECT_LE((point.edge_lengths - vectors.edge_lengths.row(i).transpose())
                          .cwiseAbs()
                          .maxCoeff(),
                      1e-13);
            EXPECT_LE((point.dihedral_angles - vectors.dihedral_angles.row(i).transpose())
                          .cwiseAbs()
                          .maxCoeff(),
                      1e-11);
        }
    }
}

TEST(FitModel, KnowsNoPose)
{
    const Collection collection = test::bumpy_spheres(7, 3);
    const ShapeModel here = fit_model(collection);
    const ShapeModel there = fit_model(test::moved(collection, 50));
    EXPECT_LE((here.scores - there.scores).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LE((here.variances - there.variances).cwiseAbs().maxCoeff(), 1e-12 * here.variances[0]);
    EXPECT_LE((here.mode_dihedral_angles - there.mode_dihedral_angles).norm(),
              1e-10 * here.mode_dihedral_angles.norm());
}

TEST(FitModel, OfTwoMeshesIsTheLineThroughThem)
{
    const Collection collection = test::bumpy_spheres(2, 4);
    const ShapeVectors vectors = shape_vectors(collection, Scale::Unit);
    const ShapeModel model = fit_model(collection);
    ASSERT_EQ(model.mode_count(), 1);
    const double distance = (vectors.edge_lengths.row(0) - vectors.edge_lengths.row(1)).norm();
    EXPECT_NEAR(model.variances[0], 0.5 * distance * distance, 1e-14 * distance * distance);
    EXPECT_NEAR(std::abs(model.scores(0, 0)), 0.5 * distance, 1e-14 * distance);
    // Between the two scores the model's points are the blends.
    const ShapePoint quarter = blend(vectors, Eigen::Vector2d(0.75, 0.25));
    const ShapePoint point =
        edge_point(model, Eigen::VectorXd::Constant(1, 0.5 * model.scores(0, 0)), 1.0);
    EXPECT_LE((point.edge_lengths - quarter.edge_lengths).norm(), 1e-15);
    EXPECT_LE((point.dihedral_angles - quarter.dihedral_angles).norm(), 1e-12);
}

TEST(FitModel, HasTheSameBitsForAnyThreadCount)
{
    const Collection collection = test::bumpy_spheres(20, 5);
    const auto fitted = [&](int threads) {
        const test::ThreadScope scope(threads);
        return fit_model(collection, {.variance = 0.9});
    };
    const ShapeModel one = fitted(1);
    const ShapeModel many = fitted(4);
    EXPECT_EQ(many.modes, one.modes);
    EXPECT_EQ(many.mode_dihedral_angles, one.mode_dihedral_angles);
    EXPECT_EQ(many.scores, one.scores);
}

TEST(FitModel, RefusesWhatBreaksARule)
{
    const Collection collection = test::bumpy_spheres(4, 6);
    EXPECT_THROW((void)fit_model(test::bumpy_spheres(1, 6)), InvalidInput);
    EXPECT_THROW((void)fit_model(test::bumpy_spheres(0, 6)), InvalidInput);
    EXPECT_THROW((void)fit_model(collection, {.modes = 4}), InvalidInput);
    EXPECT_THROW((void)fit_model(collection, {.modes = -1}), InvalidInput);
    EXPECT_THROW((void)fit_model(collection, {.variance = 0.0}), InvalidInput);
    EXPECT_THROW((void)fit_model(collection, {.variance = nan}), InvalidInput);
    EXPECT_NO_THROW((void)fit_model(collection, {.modes = 3}));
}

TEST(FitModel, RefusesMeshesThatDifferInPoseAlone)
{
    Collection collection = test::bumpy_spheres(1, 7);
    for (const double scale : {1.0, 2.0, 0.3}) {
        collection.names.push_back("copy");
        collection.points.push_back(scale * collection.points[0]);
    }
    collection = test::moved(collection, 8);
    EXPECT_THROW((void)fit_model(collection), InvalidInput);
    EXPECT_EQ(fit_model(collection, {.space = {.scale = Scale::None}}).mode_count(), 1);
}

TEST(ModelPoint, TakesMissingScoresForZeroAndScalesUnitLengths)
{
    const Collection collection = test::bumpy_spheres(5, 8);
    const ShapeModel model = fit_model(collection);
    const ShapePoint mean = edge_point(model, {}, 12.0);
    EXPECT_EQ(mean.edge_lengths, 12.0 * model.mean);
    EXPECT_EQ(mean.dihedral_angles, model.mean_dihedral_angles);
    const Eigen::Vector4d padded(0.01, -0.02, 0.0, 0.0);
    EXPECT_LE((edge_point(model, padded.head(2), 3.0).edge_lengths -
               edge_point(model, padded, 3.0).edge_lengths)
                  .norm(),
              1e-15);
    EXPECT_NEAR(edge_point(model, padded, 3.0).edge_lengths.sum(), 3.0, 1e-13);
    const ShapeModel plain = fit_model(collection, {.space = {.scale = Scale::None}});
    EXPECT_EQ(edge_point(plain, {}, 12.0).edge_lengths, plain.mean);
}

TEST(ModelPoint, RefusesWhatBreaksARule)
{
    const ShapeModel model = fit_model(test::bumpy_spheres(3, 9));
    EXPECT_THROW((void)model_point(model, Eigen::Vector3d::Zero(), 1.0), InvalidInput);
    EXPECT_THROW((void)model_point(model, Eigen::Vector2d(0, nan), 1.0), InvalidInput);
    for (const double size : {0.0, -1.0, nan})
        EXPECT_THROW((void)model_point(model, {}, size), InvalidInput);
}

TEST(Project, GivesTheMeshesOfTheModelTheirOwnScores)
{
    const Collection collection = test::bumpy_spheres(8, 10);
    const ShapeModel model = fit_model(collection);
    const Projection projection = project(model, test::moved(collection, 90));
    EXPECT_LE((projection.scores - model.scores).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LE(projection.residuals.maxCoeff(), 1e-14);
    EXPECT_LE((projection.sizes - model.sizes).cwiseAbs().maxCoeff(), 1e-11);
    EXPECT_EQ(projection.names, collection.names);
}

TEST(Project, SplitsTheDistanceFromTheMeanIntoScoresAndResidual)
{
    const ShapeModel model = fit_model(test::bumpy_spheres(8, 11), {.modes = 3});
    const Collection others = test::bumpy_spheres(5, 12);
    const ShapeVectors vectors = shape_vectors(others, Scale::Unit);
    const Projection projection = project(model, others);
    for (Index i = 0; i < 5; ++i) {
        const double distance = (vectors.edge_lengths.row(i) - model.mean.transpose()).norm();
        EXPECT_GT(projection.residuals[i], 1e-3 * distance);
        EXPECT_NEAR(std::hypot(projection.scores.row(i).norm(), projection.residuals[i]), distance,
                    1e-13 * distance);
    }
}

TEST(Project, RefusesAnotherTriangulation)
{
    const ShapeModel model = fit_model(test::bumpy_spheres(3, 13));
    const test::TestMesh torus = test::torus(5, 7);
    EXPECT_THROW((void)project(model, {torus.topology, {"torus"}, {torus.points}, {}}),
                 InvalidInput);
}

TEST(FeasibleRange, EndsWhereATriangleBreaksOrAtTheLimit)
{
    const ShapeModel model = fit_model(test::bumpy_spheres(8, 14));
    int ends = 0;
    for (int mode = 0; mode < model.mode_count(); ++mode)
        for (const double limit : {1.0, 10.0, 1000.0}) {
            const FeasibleRange range = feasible_range(model, mode, limit);
            for (const double end : {range.low, range.high}) {
                const auto breaks = [&](double deviations) {
                    const Eigen::VectorXd scores = deviations * std::sqrt(model.variances[mode]) *
                                                   Eigen::VectorXd::Unit(model.mode_count(), mode);
                    return !check_admissibility(model.topology,
                                                edge_point(model, scores, 1.0).edge_lengths)
                                .triangles.empty();
                };
                EXPECT_LE(std::abs(end), limit);
                EXPECT_FALSE(breaks(end * (1.0 - 1e-9)));
                if (std::abs(end) < limit) {
                    EXPECT_TRUE(breaks(end * (1.0 + 1e-9)));
                    ++ends;
                }
            }
            EXPECT_LT(range.low, 0.0);
            EXPECT_GT(range.high, 0.0);
        }
    EXPECT_GT(ends, 10);
}

TEST(FeasibleRange, RefusesWhatBreaksARule)
{
    const ShapeModel model = fit_model(test::bumpy_spheres(3, 15));
    EXPECT_THROW((void)feasible_range(model, -1), InvalidInput);
    EXPECT_THROW((void)feasible_range(model, 2), InvalidInput);
    EXPECT_THROW((void)feasible_range(model, 0, 0.0), InvalidInput);
    EXPECT_THROW((void)feasible_range(model, 0, nan), InvalidInput);
}

TEST(ModelOfRealFaces, HasThePublishedShares)
{
    if (!test::has_ict_faces())
        GTEST_SKIP() << "the dataset ict_faces600 is not there";
    const Collection faces = test::ict_faces();
    const ShapeModel model = fit_model(faces, {.modes = 3});
    const Eigen::VectorXd percent = 100.0 * model.variances / model.total_variance;
    EXPECT_NEAR(percent[0], 33.4, 0.05);
    EXPECT_NEAR(percent[1], 10.0, 0.05);
    EXPECT_NEAR(percent[2], 7.8, 0.05);

    // On the first mode the smiles stand apart: group means in standard deviations.
    const LabelColumn& expression = find_label(model.labels, "expression");
    const auto group_mean = [&](const std::string& value) {
        double sum = 0.0;
        int count = 0;
        for (std::size_t i = 0; i < faces.size(); ++i)
            if (expression.values[i] == value) {
                sum += model.scores(static_cast<Index>(i), 0);
                ++count;
            }
        EXPECT_EQ(count, 200);
        return sum / count / std::sqrt(model.variances[0]);
    };
    const double sign = group_mean("happy") > 0.0 ? 1.0 : -1.0;
    EXPECT_NEAR(sign * group_mean("happy"), 1.34, 0.01);
    EXPECT_NEAR(sign * group_mean("neutral"), -0.67, 0.01);
    EXPECT_NEAR(sign * group_mean("angry"), -0.67, 0.01);

    // Points along the first mode leave the set of meshes on the side where no face is.
    const double deviation = std::sqrt(model.variances[0]);
    const auto broken = [&](double deviations) {
        const ShapePoint point = edge_point(
            model, Eigen::VectorXd::Constant(1, sign * deviations * deviation), model.mean_size());
        return check_admissibility(model.topology, point.edge_lengths).triangles.size();
    };
    EXPECT_EQ(broken(-2.0), 8u);
    EXPECT_EQ(broken(-3.0), 29u);
    EXPECT_EQ(broken(0.0), 0u);
    EXPECT_NEAR((sign * model.scores.col(0)).minCoeff() / deviation, -1.25, 0.01);
}

} // namespace
} // namespace shape
