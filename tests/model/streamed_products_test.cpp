// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_products.h"

#include <gtest/gtest.h>

#include <string>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/statistics/inner_products.h"
#include "libshape/statistics/mean.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

/// More meshes than a tile of inner products has, of so many edges that memory for the products holds one
/// tile at a time.
Collection fine_spheres()
{
    const test::TestMesh sphere = test::icosphere(3);
    Collection collection{sphere.topology, {}, {}, {}};
    Random random(1);
    for (int i = 0; i < 150; ++i) {
        collection.names.push_back("sphere" + std::to_string(i));
        Points& points = collection.points.emplace_back(sphere.points);
        for (Eigen::Index v = 0; v < points.rows(); ++v)
            points.row(v) *= 1.0 + 0.01 * random.normal();
    }
    return collection;
}

TEST(StreamedProducts, AreThoseOfTheCollectionInMemoryForAnyMemoryAndFolder)
{
    const Collection collection = fine_spheres();
    for (const SpaceOptions& options :
         {SpaceOptions{}, SpaceOptions{.scale = Scale::None, .dihedral_weight = 0.3}}) {
        const ShapeSpace space = make_space(collection, options);
        const RowMatrix rows = encode(space, collection);
        const Eigen::MatrixXd expected = centred_inner_products(rows);
        const StreamedProducts all = measure_products(stream_of(collection), {.space = options});
        EXPECT_LE((all.products - expected).cwiseAbs().maxCoeff(),
                  1e-12 * expected.diagonal().maxCoeff());
        EXPECT_LE((all.mean - mean_of_rows(rows)).cwiseAbs().maxCoeff(),
                  1e-14 * rows.cwiseAbs().maxCoeff());
        EXPECT_TRUE(all.sizes == sizes(space, collection));
        EXPECT_EQ(all.reference_points, collection.points.front());
        EXPECT_EQ(all.passes, 1);
        // So little that several passes are taken, but for what is kept on disc.
        const test::TemporaryDirectory folder;
        const StreamedProductsOptions little{.space = options, .memory = 1'500'000};
        const StreamedProducts passes = measure_products(stream_of(collection), little);
        EXPECT_GT(passes.passes, 1);
        EXPECT_TRUE(passes.products == all.products);
        StreamedProductsOptions once = little;
        once.scratch = folder.path();
        const StreamedProducts kept = measure_products(stream_of(collection), once);
        EXPECT_EQ(kept.passes, 1);
        EXPECT_TRUE(kept.products == all.products);
        EXPECT_TRUE(kept.mean == all.mean);
        EXPECT_TRUE(kept.sizes == all.sizes);
    }
}

TEST(StreamedProducts, SayWhatMemoryTheyNeed)
{
    const Collection collection = test::bumpy_spheres(100, 1);
    const std::string message = test::message_of<LimitExceeded>(
        [&] { (void)measure_products(stream_of(collection), {.memory = 600'000}); });
    EXPECT_NE(message.find("100 meshes take 1 MiB"), std::string::npos) << message;
    EXPECT_THROW((void)measure_products(subset(stream_of(collection), {}), {}), InvalidInput);
    EXPECT_THROW(
        (void)measure_products(stream_of(collection), {.space = {.kind = SpaceKind::Procrustes}}),
        InvalidInput);
}

} // namespace
} // namespace shape
