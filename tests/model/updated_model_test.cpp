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
            const auto near = [](const auto& a, const auto& b) {
                return (a - b).cwiseAbs().maxCoeff() <= 1e-10 * b.cwiseAbs().maxCoeff();
            };
            EXPECT_TRUE(near(updated.mean, expected.mean));
            EXPECT_TRUE(near(updated.modes, expected.modes));
            EXPECT_TRUE(near(updated.mean_dihedral_angles, expected.mean_dihedral_angles));
            EXPECT_TRUE(near(updated.mode_dihedral_angles, expected.mode_dihedral_angles));
            EXPECT_TRUE(near(updated.variances, expected.variances));
            EXPECT_TRUE(near(updated.scores, expected.scores));
            EXPECT_TRUE(near(updated.sizes, expected.sizes));
            EXPECT_EQ(updated.names, expected.names);
            EXPECT_EQ(updated.labels[0].values, expected.labels[0].values);
            EXPECT_EQ(updated.reference_points, expected.reference_points);
        }
    }
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
