// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_products.h"

#include <optional>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/model/mesh_passes.h"
#include "libshape/statistics/column_strips.h"
#include "libshape/statistics/tiled_gram.h"

namespace shape {
using namespace internal;

using Eigen::Index;

void check(const StreamedProductsOptions& options)
{
    check(options.space);
}

StreamedProducts measure_products(const MeshStream& meshes, const StreamedProductsOptions& options)
{
    check(options);
    const Index count = meshes.size();
    if (count < 1)
        throw InvalidInput("inner products need at least one mesh");
    MeshPasses passes(meshes, options.space, options.memory, options.progress);
    const std::uint64_t matrices = 4 * sizeof(double) * to_size(count) * to_size(count);
    if (matrices > passes.memory() / 2)
        throw LimitExceeded(join("the inner products of ", count, " meshes take ",
                                 (matrices >> 20) + 1, " MiB, which is more than half of the ",
                                 passes.memory() >> 20,
                                 " MiB allowed; allow more memory or choose fewer meshes"));
    StreamedProducts result;
    result.sizes.resize(count);
    const std::uint64_t row = sizeof(double) * to_size(passes.dimension());
    TiledGram gram(count, passes.dimension(), static_cast<Index>(passes.memory() / 4 / row));
    const auto first_pass = [&](const MeshPasses::Visit& take) {
        passes.run("inner products", passes.all(gram.tile()),
                   [&](Index first, const Collection& block, RowMatrix& rows) {
                       passes.encode(block, rows,
                                     result.sizes.segment(first, static_cast<Index>(block.size())));
                       if (first == 0) {
                           result.reference_points = block.points.front();
                           gram.start_at(rows.colwise().mean().transpose());
                       }
                       take(first, block, rows);
                   });
    };
    const auto strips = gram.pass_count() > 1 && !options.scratch.empty()
                            ? ColumnStrips::make(options.scratch, count, passes.dimension())
                            : std::nullopt;
    if (strips) {
        first_pass(
            [&](Index first, const Collection&, RowMatrix& rows) { strips->put(first, rows); });
        passes.rest();
        strips->for_each(
            [&](Index first, RowMatrix& columns) { gram.add_columns(first, columns); });
        gram.end_columns();
    }
    while (!gram.is_complete()) {
        if (gram.begin() == 0)
            first_pass(
                [&](Index first, const Collection&, RowMatrix& rows) { gram.add(first, rows); });
        else
            passes.run("inner products", {gram.begin(), count, gram.tile()},
                       [&](Index first, const Collection& block, RowMatrix& rows) {
                           passes.encode(block, rows);
                           gram.add(first, rows);
                       });
        gram.end_pass();
    }
    result.space = passes.space();
    result.products = gram.products();
    result.mean = gram.mean();
    result.passes = passes.count();
    return result;
}

} // namespace shape
