// SPDX-License-Identifier: MIT

#include "libshape/model/unlike_meshes.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/collections.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

RowMatrix marks_of(const Collection& known, const Collection& meshes)
{
    const ShapeModel model = fit_model(known);
    return unlike_meshes(model, meshes, project(model, meshes).sizes);
}

TEST(UnlikeMeshes, AreMirrorImagesAndThoseOfAnotherUnit)
{
    const Collection known = test::bumpy_spheres(6, 1);
    Collection meshes = test::moved(known, 2);
    EXPECT_EQ(marks_of(known, meshes), RowMatrix::Zero(6, 3));
    meshes.points[1].col(0) *= -1.0;
    meshes.points[2] *= 1000.0;
    meshes.points[3] *= 0.001;
    RowMatrix expected = RowMatrix::Zero(6, 3);
    expected(1, 0) = expected(2, 1) = expected(3, 2) = 1.0;
    EXPECT_EQ(marks_of(known, meshes), expected);
}

TEST(UnlikeMeshes, AreFoundAmongOpenOnesToo)
{
    Collection known{test::open_patch(8, 1).topology, {}, {}, {}};
    for (unsigned seed = 1; seed <= 4; ++seed) {
        known.names.push_back(std::to_string(seed));
        known.points.push_back(test::open_patch(8, seed).points);
    }
    Collection meshes = test::moved(known, 5);
    EXPECT_EQ(marks_of(known, meshes), RowMatrix::Zero(4, 3));
    for (Points& points : meshes.points) // all of them: there is no majority to tell by
        points.col(1) *= -1.0;
    EXPECT_EQ(marks_of(known, meshes).col(0), Eigen::VectorXd::Ones(4));
}

} // namespace
} // namespace shape
