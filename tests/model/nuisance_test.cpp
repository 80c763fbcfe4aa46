// SPDX-License-Identifier: MIT

#include "libshape/model/nuisance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/collections.h"
#include "tests/support/meshes.h"
#include "tests/support/seams.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

DifferenceVector bend(const Collection& spheres)
{
    Collection collection = spheres;
    collection.labels = {{"person", {"a", "b", "c", "a", "b", "c"}},
                         {"pose", {"rest", "rest", "rest", "bent", "bent", "bent"}}};
    return mean_difference(collection, {.pair_by = "person",
                                        .from_label = "pose",
                                        .from_value = "rest",
                                        .to_label = "pose",
                                        .to_value = "bent"});
}

Collection one(const Collection& collection, std::size_t mesh)
{
    return subset(collection, {mesh});
}

TEST(Nuisance, OfAllModesRemovedLeavesTheMeanInTheSizeOfTheMesh)
{
    const Collection collection = test::bumpy_spheres(6, 1);
    const ShapeModel model = fit_model(collection);
    const Nuisance nuisance = leading_modes(model, model.mode_count());
    const VectorXd none = VectorXd::Zero(model.mode_count());
    for (std::size_t i = 0; i < 6; ++i) {
        const auto shape = std::get<ShapePoint>(with_amounts(nuisance, one(collection, i), none));
        const double size = model.sizes[static_cast<Eigen::Index>(i)];
        EXPECT_LE((shape.edge_lengths - size * model.mean).norm(), 1e-12 * size);
        EXPECT_LE((shape.dihedral_angles - model.mean_dihedral_angles).norm(), 1e-9);
    }
}

TEST(Nuisance, LeavesAMeshAloneThatKeepsItsAmounts)
{
    const Collection collection = test::bumpy_spheres(6, 2);
    const ShapeModel model = fit_model(collection, {.space = {.kind = SpaceKind::Procrustes}});
    const Nuisance nuisance = leading_modes(model, 2);
    const RowMatrix amounts = amounts_of(nuisance, collection);
    EXPECT_LE((amounts - model.scores.leftCols(2)).cwiseAbs().maxCoeff(), 1e-14);
    for (std::size_t i = 0; i < 6; ++i) {
        const auto same = std::get<Points>(
            with_amounts(nuisance, one(collection, i), amounts.row(static_cast<Eigen::Index>(i))));
        EXPECT_LE((edge_lengths(collection.topology, same) -
                   edge_lengths(collection.topology, collection.points[i]))
                      .norm(),
                  1e-12);
    }
}

TEST(Nuisance, GivesAllMeshesTheAmountsOfOne)
{
    const Collection collection = test::bumpy_spheres(6, 3);
    const ShapeVectors v = shape_vectors(collection, Scale::Unit);
    const ShapeModel model = fit_model(collection);
    const Nuisance nuisance = leading_modes(model, 2);
    const VectorXd wanted = model.scores.row(3).head(2);
    for (Eigen::Index i = 0; i < 6; ++i) {
        const auto shape =
            std::get<ShapePoint>(with_amounts(nuisance, one(collection, to_size(i)), wanted));
        const VectorXd scores =
            model.modes * (shape.edge_lengths / shape.edge_lengths.sum() - model.mean);
        EXPECT_LE((scores.head(2) - wanted).norm(), 1e-14);
        EXPECT_LE((scores.tail(3) - model.scores.row(i).tail(3).transpose()).norm(), 1e-14);
        EXPECT_NEAR(shape.edge_lengths.sum(), v.sizes[i], 1e-11);
    }
}

TEST(Nuisance, OfADifferenceIsItsDirection)
{
    const Collection collection = test::bumpy_spheres(6, 4);
    const DifferenceVector difference = bend(collection);
    const Nuisance nuisance = direction_of(difference);
    EXPECT_NEAR(nuisance.directions.norm(), 1.0, 1e-14);
    // The means of the two groups lie apart by the length of the difference.
    const RowMatrix amounts = amounts_of(nuisance, collection);
    EXPECT_NEAR(amounts.topRows(3).mean(), 0.0, 1e-15);
    EXPECT_NEAR(amounts.bottomRows(3).mean(), difference.edge_lengths.norm(), 1e-15);
    const auto shape =
        std::get<ShapePoint>(with_amounts(nuisance, one(collection, 4), VectorXd::Zero(1)));
    const double share = amounts(4, 0) / difference.edge_lengths.norm();
    const ShapeVectors v = shape_vectors(collection, Scale::Unit);
    EXPECT_LE((shape.edge_lengths / v.sizes[4] -
               (v.edge_lengths.row(4).transpose() - share * difference.edge_lengths))
                  .norm(),
              1e-14);
    const ShapeVectors alone = shape_vectors(one(collection, 4), Scale::Unit);
    EXPECT_LE((shape.dihedral_angles -
               (alone.dihedral_angles.row(0).transpose() - share * difference.dihedral_angles))
                  .norm(),
              1e-12);
}

TEST(Nuisance, RefusesWhatBreaksARule)
{
    const Collection collection = test::bumpy_spheres(6, 5);
    const ShapeModel model = fit_model(collection);
    EXPECT_THROW((void)leading_modes(model, 0), InvalidInput);
    EXPECT_THROW((void)leading_modes(model, 6), InvalidInput);
    DifferenceVector difference = bend(collection);
    difference.edge_lengths.setZero();
    EXPECT_THROW((void)direction_of(difference), InvalidInput);
    const Nuisance nuisance = leading_modes(model, 2);
    EXPECT_THROW((void)with_amounts(nuisance, collection, VectorXd::Zero(2)), InvalidInput);
    EXPECT_THROW((void)with_amounts(nuisance, one(collection, 0), VectorXd::Zero(3)), InvalidInput);
    EXPECT_THROW(
        (void)with_amounts(nuisance, one(collection, 0), VectorXd::Constant(2, std::nan(""))),
        InvalidInput);
    const test::TestMesh finer = test::icosphere(2);
    const Collection other{finer.topology, {"finer"}, {finer.points}, {}};
    EXPECT_THROW((void)amounts_of(nuisance, other), InvalidInput);
    EXPECT_THROW((void)with_amounts(nuisance, other, VectorXd::Zero(2)), InvalidInput);
}

TEST(Nuisance, SaysHowTheTriangulationDiffers)
{
    const Collection collection = test::bumpy_spheres(6, 6);
    const ShapeModel model = fit_model(collection);
    const Topology reversed(test::reversed_faces(collection.topology.faces()),
                            collection.topology.vertex_count());
    const auto said = [&](const Nuisance& nuisance, const Points& points) -> std::string {
        try {
            (void)amounts_of(nuisance, {reversed, {"turned"}, {points}, {}});
        } catch (const InvalidInput& error) {
            return error.what();
        }
        return "";
    };
    for (const Nuisance& nuisance : {leading_modes(model, 2), direction_of(bend(collection))}) {
        const std::string turned = said(nuisance, collection.points[1]);
        EXPECT_NE(turned.find("mesh turned: face 0 is "), std::string::npos) << turned;
        EXPECT_NE(turned.find("inside out: reverse its faces"), std::string::npos) << turned;
        const std::string mirrored = said(nuisance, test::mirror_image(collection.points[1]));
        EXPECT_NE(mirrored.find("mirror image: mirror it back"), std::string::npos) << mirrored;
    }
}

} // namespace
} // namespace shape
