// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_effect.h"

#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/require.h"
#include "libshape/edge_space/streamed_space.h"
#include "libshape/linalg/block_products.h"
#include "libshape/linalg/strips.h"
#include "libshape/model/effect_weights.h"
#include "libshape/model/mesh_passes.h"
#include "libshape/model/streamed_angles.h"
#include "libshape/statistics/tiled_gram.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Two passes for what the weights make of coordinates and angles.
class EffectPasses
{
public:
    EffectPasses(const MeshStream& meshes, const StreamedEffectOptions& options)
        : passes_(meshes, options.space, options.memory, options.progress),
          edges_(has_companions(passes_.space()) ? meshes.topology.edge_count() : 0)
    {
    }

    /// @param centre  D: about which sums round little; weights of slopes sum to 0.
    void run(const VectorXd& centre, const VectorXd& shares, CovariateEffect& effect)
    {
        const RowMatrix& weights = effect.regression.weights;
        RowMatrix all(weights.rows(), weights.cols() + 1); // the slopes, and the mean
        all << weights, shares;
        const Index tile = TiledGram::tile_rows(passes_.dimension());
        BranchSums branches(edges_);
        RowMatrix points = RowMatrix::Zero(all.cols(), passes_.dimension());
        passes_.run("slopes", passes_.all(tile),
                    [&](Index first, const Collection& block, RowMatrix& rows) {
                        passes_.encode(block, rows);
                        centre_rows(rows, centre);
                        add(all.middleRows(first, rows.rows()), rows, points);
                        if (edges_ > 0)
                            branches.add(block);
                    });
        effect.regression.slopes = points.topRows(weights.cols());
        effect.regression.mean = centre + points.bottomRows(1).transpose();
        RowMatrix angles = RowMatrix::Zero(all.cols(), edges_);
        if (edges_ > 0) {
            const VectorXd means = branches.means(passes_.meshes().size());
            passes_.run("slopes of angles", passes_.all(tile),
                        [&](Index first, const Collection& block, RowMatrix& rows) {
                            rows.resize(static_cast<Index>(block.size()), edges_);
                            measure_angles(block, rows);
                            internal::unify_branches(rows, means);
                            add(all.middleRows(first, rows.rows()), rows, angles);
                        });
        }
        effect.slope_dihedral_angles = angles.topRows(weights.cols());
        effect.mean_dihedral_angles = angles.bottomRows(1).transpose();
    }

    [[nodiscard]] int count() const { return passes_.count(); }

private:
    static void add(const RowMatrix& weights, const RowMatrix& rows, RowMatrix& sums)
    {
        constexpr Index strip = 2048; // columns worked on together
        for_strips(rows.cols(), strip, [&](Index first, Index count) {
            add_product_of_columns(weights, rows.middleCols(first, count),
                                   sums.middleCols(first, count));
        });
    }

    MeshPasses passes_;
    Index edges_;
};

} // namespace

void check(const StreamedEffectOptions& options)
{
    check(static_cast<const StreamedProductsOptions&>(options));
    require(static_cast<bool>(options.covariates), "StreamedEffectOptions.covariates", "empty",
            "set");
}

StreamedEffect covariate_effect(const MeshStream& meshes, const Grouping& blocks,
                                const StreamedEffectOptions& options)
{
    check(options);
    StreamedProducts measured = measure_products(meshes, options);
    StreamedEffect result;
    result.covariates = options.covariates(measured.sizes);
    EffectWeights found = effect_weights(result.covariates, blocks);
    CovariateEffect& effect = result.effect;
    effect.space = std::move(measured.space);
    effect.design = found.design;
    effect.regression = std::move(found.regression);
    const RowMatrix& weights = effect.regression.weights;
    // About any origin: the weights of slopes sum to 0, those of the mean to 1.
    const RowMatrix along = measured.products * weights;
    const VectorXd squares = (weights.transpose() * along).diagonal();
    result.slope_norms = squares.cwiseMax(0.0).cwiseSqrt();
    if (!(squares[0] > 0.0))
        throw InvalidInput("regression scores: the slope of covariate 0 is 0");
    effect.scores = (along.col(0).array() - found.shares.dot(along.col(0))) / squares[0] +
                    effect.regression.covariate_means[0];
    effect.regression.r_squared = explained_share(measured.products, found);
    effect.products = std::move(measured.products);
    result.sizes = std::move(measured.sizes);
    result.reference_points = std::move(measured.reference_points);
    result.passes = measured.passes;
    if (options.with_shapes) {
        EffectPasses passes(meshes, options);
        passes.run(measured.mean, found.shares, effect);
        result.passes += passes.count();
    }
    return result;
}

} // namespace shape
