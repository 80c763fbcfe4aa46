// SPDX-License-Identifier: MIT

#include "libshape/model/covariate_effect.h"

#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/model/effect_weights.h"
#include "libshape/statistics/covariate_blocks.h"
#include "libshape/statistics/inner_products.h"
#include "libshape/statistics/mean.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

void check_count(const CovariateEffect& effect, const Eigen::VectorXd& covariates)
{
    if (covariates.size() != effect.regression.slopes.rows() || !covariates.allFinite())
        throw InvalidInput(join("covariates: there are ", covariates.size(), ", must be ",
                                effect.regression.slopes.rows(), " finite numbers"));
}

} // namespace

CovariateEffect covariate_effect(const Collection& collection, const ShapeSpace& space,
                                 const Eigen::MatrixXd& covariates, const Grouping& blocks)
{
    if (blocks.size() != covariates.rows())
        throw InvalidInput(
            join("covariates are of ", covariates.rows(), " meshes, blocks of ", blocks.size()));
    CovariateEffect effect;
    effect.space = space;
    RowMatrix coordinates = encode(space, collection);
    effect.design = block_design(covariates, blocks);
    const Grouping rows = covariate_rows(covariates, blocks);
    Eigen::VectorXd shares; // of the meshes in the means, if sets of them count once
    if (effect.design == BlockDesign::Nested || rows.group_count() < rows.size()) {
        const Eigen::MatrixXd weights = mean_weights(rows);
        effect.regression = head(
            regress(RowMatrix(weights.transpose() * coordinates),
                    columns_of_rows(weights.transpose() * covariates, blocks, rows, effect.design)),
            covariates.cols());
        effect.regression.weights = weights * effect.regression.weights;
        shares = weights.rowwise().mean();
    } else {
        effect.regression =
            head(regress(coordinates, with_blocks(covariates, blocks)), covariates.cols());
    }
    effect.scores = regression_scores(effect.regression, coordinates, 0);
    effect.products = centred_inner_products(std::move(coordinates));
    const RowMatrix angles = companions(space, collection);
    effect.mean_dihedral_angles =
        shares.size() > 0 ? Eigen::VectorXd(angles.transpose() * shares) : mean_of_rows(angles);
    effect.slope_dihedral_angles = effect.regression.weights.transpose() * angles;
    return effect;
}

DecodedShape expected_shape(const CovariateEffect& effect, const Eigen::VectorXd& covariates,
                            double size)
{
    check_count(effect, covariates);
    const Eigen::VectorXd change = covariates - effect.regression.covariate_means;
    return decode(
        effect.space, effect.regression.mean + effect.regression.slopes.transpose() * change,
        effect.mean_dihedral_angles + effect.slope_dihedral_angles.transpose() * change, size);
}

DecodedShape move_along_slopes(const CovariateEffect& effect, const Collection& mesh,
                               const Eigen::VectorXd& from, const Eigen::VectorXd& to)
{
    check_count(effect, from);
    check_count(effect, to);
    if (mesh.size() != 1)
        throw InvalidInput(join("move along slopes: ", mesh.size(), " meshes, must be one"));
    const Eigen::VectorXd change = to - from;
    return decode(effect.space,
                  encode(effect.space, mesh).row(0).transpose() +
                      effect.regression.slopes.transpose() * change,
                  companions(effect.space, mesh).row(0).transpose() +
                      effect.slope_dihedral_angles.transpose() * change,
                  sizes(effect.space, mesh)[0]);
}

} // namespace shape
