// SPDX-License-Identifier: MIT

#include "libshape/statistics/principal_components.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/linalg/strips.h"
#include "libshape/linalg/symmetric_eigen.h"
#include "libshape/statistics/component_steps.h"
#include "libshape/statistics/inner_products.h"
#include "libshape/statistics/mean.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

void check_data(const RowMatrix& data, const PrincipalComponentsOptions& options)
{
    if (data.rows() < 2 || data.cols() == 0)
        throw InvalidInput(join("principal components: the data has ", data.rows(),
                                " observations of ", data.cols(),
                                " variables, must have at least 2 of at least 1"));
    if (!data.allFinite())
        throw InvalidInput("principal components: the data has an entry that is not finite");
    if (options.modes > data.rows() - 1)
        throw InvalidInput(join("principal components: modes is ", options.modes,
                                ", must be in [0, ", data.rows() - 1, "] for ", data.rows(),
                                " observations"));
}

/// weights^T x, in fixed strips of columns.
RowMatrix combine_rows(const RowMatrix& weights, const RowMatrix& x)
{
    RowMatrix combined(weights.cols(), x.cols());
    for_strips(x.cols(), 512, [&](Index first, Index count) {
        combined.middleCols(first, count).noalias() =
            weights.transpose() * x.middleCols(first, count);
    });
    return combined;
}

/// x modes^T, in fixed strips of rows.
RowMatrix coordinates(const RowMatrix& x, const RowMatrix& modes)
{
    RowMatrix scores(x.rows(), modes.rows());
    for_strips(x.rows(), 32, [&](Index first, Index count) {
        scores.middleRows(first, count).noalias() = x.middleRows(first, count) * modes.transpose();
    });
    return scores;
}

} // namespace

void check(const PrincipalComponentsOptions& options)
{
    require_at_least(0, options.modes, "PrincipalComponentsOptions.modes");
    require(options.variance > 0.0 && options.variance <= 1.0,
            "PrincipalComponentsOptions.variance", options.variance, "in (0, 1]");
    require(options.modes == 0 || options.variance == 1.0, "PrincipalComponentsOptions.variance",
            options.variance, "1 where modes, too, says how many are kept");
}

PrincipalComponents principal_components(RowMatrix data, const PrincipalComponentsOptions& options)
{
    check(options);
    check_data(data, options);
    PrincipalComponents result;
    result.mean = mean_of_rows(data);
    const double squares = data.squaredNorm();
    data.rowwise() -= result.mean.transpose();
    const RowMatrix& centred = data;
    { // what is N by N goes before the modes come
        const Eigen::MatrixXd gram = inner_products(centred);
        if (gram.trace() <= 1e-24 * squares) // deviations of 1e-12 of the values are their rounding
            throw InvalidInput(join("principal components: all ", data.rows(),
                                    " observations are equal, they have no modes"));
        result.total_variance = gram.trace() / static_cast<double>(data.rows() - 1);
        const Eigenpairs pairs = leading_eigenpairs(gram, options);
        result.weights = pairs.vectors * pairs.values.cwiseSqrt().cwiseInverse().asDiagonal();
    }
    result.modes = combine_rows(result.weights, centred);
    orthonormalise(result.modes, result.weights);
    const RowMatrix rotation = decorrelating_rotation(coordinates(centred, result.modes));
    mix_rows(rotation, result.modes);
    result.weights = result.weights * rotation;
    fix_signs(result.modes, result.weights);
    result.scores = coordinates(centred, result.modes);
    measure_variances(result);
    return result;
}

RowMatrix companion_modes(const PrincipalComponents& components, RowMatrix companion)
{
    if (companion.rows() != components.weights.rows())
        throw InvalidInput(join("companion has ", companion.rows(), " rows, the components have ",
                                components.weights.rows(), " observations"));
    // The weights of a mode sum to 0 up to rounding: centring keeps that rounding small.
    companion.rowwise() -= mean_of_rows(companion).transpose();
    return combine_rows(components.weights, companion);
}

} // namespace shape
