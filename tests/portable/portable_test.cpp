// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/embedder.h"
#include "libshape/explore/block_of_model.h"
#include "libshape/model/shape_model.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

/// What tests/portable/decode_block prints.
Points decoded(const std::string& arguments, Eigen::Index vertices)
{
    std::FILE* const pipe = popen((SHAPE_DECODE_BLOCK " " + arguments).c_str(), "r");
    Points points(vertices, 3);
    const std::size_t count =
        std::fread(points.data(), sizeof(double), to_size(points.size()), pipe);
    EXPECT_EQ(count, to_size(points.size()));
    EXPECT_EQ(pclose(pipe), 0);
    return points;
}

/// Of a mesh bent and stretched at random, smoothly.
Collection variations(const test::TestMesh& mesh)
{
    Collection collection{.topology = mesh.topology, .names = {}, .points = {}, .labels = {}};
    for (int i = 0; i < 5; ++i) {
        Points points = mesh.points;
        for (int v = 0; v < points.rows(); ++v)
            for (int k = 0; k < 3; ++k)
                points(v, k) *=
                    1.0 + 0.15 * std::sin(1.3 * i + k + 2.0 * mesh.points(v, (k + 1) % 3));
        collection.points.push_back(points);
        collection.names.push_back(join("mesh", i));
    }
    return collection;
}

/// The portable core has its own half-edges, factorisation and loops; meshes must be the same. Closed
/// meshes, a torus, and open ones with one and two boundary loops.
TEST(PortableCore, MakesTheMeshesOfTheLibrary)
{
    const test::TemporaryDirectory folder;
    const std::string file = (folder / "model.block").string();
    std::vector<test::TestMesh> meshes = test::sample_meshes();
    meshes.push_back(test::bumpy_sphere(4, 0.3, 2)); // of many patches
    for (const test::TestMesh& mesh : meshes) {
        const ShapeModel model = fit_model(variations(mesh), {.modes = 3});
        const auto bytes = write_block(make_block(model, model.mode_count()));
        test::write_bytes(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
        const Eigen::VectorXd scores = 0.6 * model.variances.cwiseSqrt();
        char numbers[200];
        std::snprintf(numbers, sizeof numbers, " %.17g %.17g %.17g %.17g", model.mean_size(),
                      scores[0], scores[1], scores[2]);
        for (const EmbeddingQuality quality : {EmbeddingQuality::Preview, EmbeddingQuality::Fine}) {
            const Embedder embedder(model.topology, {model.reference_points}, {.quality = quality});
            const Points wanted =
                embedder.embed(model_point(model, scores, model.mean_size())).points;
            const Points points =
                decoded(file + (quality == EmbeddingQuality::Fine ? " fine" : " preview") + numbers,
                        wanted.rows());
            EXPECT_LT((points - wanted).cwiseAbs().maxCoeff(), 1e-5 * bounding_box_diagonal(wanted))
                << mesh.name;
        }
    }
}

} // namespace
} // namespace shape
