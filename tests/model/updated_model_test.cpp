// SPDX-License-Identifier: MIT

#include "libshape/model/updated_model.h"

#include <gtest/gtest.h>

#include <numeric>

#include "libshape/base/error.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"
#include "tests/support/folded.h"

namespace shape {
namespace {

Collection part(const Collection& collection, std::size_t begin, std::size_t end)
{
    std::vector<std::size_t> meshes(end - begin);
    std::iota(meshes.begin(), meshes.end(), begin);
    return subset(collection, meshes);
}

void expect_near(const ShapeModel& a, const ShapeModel& b)
{
    const auto near = [](const auto& x, const auto& y) {
        return x.rows() == y.rows() && x.cols() == y.cols() &&
               (x - y).cwiseAbs().maxCoeff() <= 1e-10 * y.cwiseAbs().maxCoeff();
    };
    EXPECT_TRUE(near(a.mean, b.mean));
    EXPECT_TRUE(near(a.modes, b.modes));
    EXPECT_TRUE(near(a.mean_dihedral_angles, b.mean_dihedral_angles));
    EXPECT_TRUE(near(a.mode_dihedral_angles, b.mode_dihedral_angles));
    EXPECT_TRUE(near(a.variances, b.variances));
    EXPECT_TRUE(near(a.scores, b.scores));
    EXPECT_TRUE(near(a.sizes, b.sizes));
}

TEST(UpdatedModel, IsTheModelOfAllMeshes)
{
    for (Collection collection : {test::bumpy_spheres(30, 1), test::folded_spheres(30)}) {
        collection.labels = {{"number", {}}};
        for (std::size_t i = 0; i < 30; ++i)
            collection.labels[0].values.push_back(std::to_string(i));
        for (const Scale scale : {Scale::Unit, Scale::None}) {
            const SpaceOptions space{.scale = scale};
            const ModelOptions options{.modes = 5, .space = space};
            const ShapeModel expected = fit_model(collection, options);
            const ShapeModel updated =
                update_model(fit_model(part(collection, 0, 22), {.space = space}),
                             part(collection, 22, 30), options);
            expect_near(updated, expected);
            EXPECT_EQ(updated.names, expected.names);
            EXPECT_EQ(updated.labels[0].values, expected.labels[0].values);
            EXPECT_EQ(updated.reference_points, expected.reference_points);
        }
    }
}

TEST(UpdatedModel, TakesAModelOfEqualMeshesWhoseModesHoldAllVariance)
{
    Collection collection = test::bumpy_spheres(16, 3);
    collection.points[3] = collection.points[2];
    collection.points[7] = collection.points[0];
    collection.points[9] = (1.0 + 1e-14) * collection.points[4];
    ShapeModel old = fit_model(part(collection, 0, 12));
    ASSERT_EQ(old.mode_count(), 8); // of 11
    const Collection added = part(collection, 12, 16);
    const ModelOptions options{.modes = 5};
    expect_near(update_model(old, added, options), fit_model(collection, options));
    old.total_variance *= 1.0 + 1e-10; // one that has lost more than rounding
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)update_model(old, added);
              }).find("8 modes of 11"),
              std::string::npos);
}

TEST(UpdatedModel, SaysWhatItTakesInMemory)
{
    const ShapeModel model =
        fit_model(test::bumpy_spheres(10, 1)); // 9 modes, 120 edges, 42 vertices
    EXPECT_EQ(update_memory(model, 5), 8u * (2 * 120 * (9 + 14 + 15) + 3 * 42 * 5 + 3 * 15 * 15));
    EXPECT_EQ(update_memory(model, 5, {.modes = 3}),
              8u * (2 * 120 * (9 + 3 + 15) + 3 * 42 * 5 + 3 * 15 * 15));
}

TEST(UpdatedModel, RefusesWhatCouldNotBeThatModel)
{
    const Collection collection = test::bumpy_spheres(12, 1);
    const Collection old = part(collection, 0, 10);
    const Collection added = part(collection, 10, 12);
    const auto message = [&](const ModelOptions& options, const Collection& meshes) {
        return test::message_of<InvalidInput>(
            [&] { (void)update_model(fit_model(old, options), meshes); });
    };
    EXPECT_NE(message({.modes = 3}, added).find("3 modes of 9"), std::string::npos);
    EXPECT_NE(message({.space = {.weighting = EdgeWeighting::Area}}, added).find("depends on all"),
              std::string::npos);
    EXPECT_NE(message({.space = {.kind = SpaceKind::Procrustes}}, added).find("depends on all"),
              std::string::npos);
    EXPECT_NE(message({}, part(collection, 9, 11)).find("has a mesh"), std::string::npos);
    EXPECT_NE(message({}, part(collection, 0, 0)).find("no mesh to add"), std::string::npos);
    const test::TestMesh other = test::bumpy_sphere(2, 0.3, 1);
    EXPECT_NE(message({}, {other.topology, {"o"}, {other.points}, {}}).find("update: "),
              std::string::npos);
}

} // namespace
} // namespace shape
