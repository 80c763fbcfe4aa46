// SPDX-License-Identifier: MIT

#include "libshape/statistics/projection.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/linalg/strips.h"

namespace shape {
using namespace internal;

SubspaceProjection project_onto_subspace(const RowMatrix& data, const Eigen::VectorXd& mean,
                                         const RowMatrix& modes)
{
    if (data.cols() != mean.size() || modes.cols() != mean.size())
        throw InvalidInput(join("projection: the data has ", data.cols(), " variables, the mean ",
                                mean.size(), ", the modes ", modes.cols(), "; all must agree"));
    SubspaceProjection result{RowMatrix(data.rows(), modes.rows()), Eigen::VectorXd(data.rows())};
    for_strips(data.rows(), 32, [&](Eigen::Index first, Eigen::Index count) {
        RowMatrix rest = data.middleRows(first, count).rowwise() - mean.transpose();
        const RowMatrix scores = rest * modes.transpose();
        rest.noalias() -= scores * modes;
        result.scores.middleRows(first, count) = scores;
        result.residuals.segment(first, count) = rest.rowwise().norm();
    });
    return result;
}

} // namespace shape
