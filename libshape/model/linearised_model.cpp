// SPDX-License-Identifier: MIT

#include "libshape/model/linearised_model.h"

#include <Eigen/Eigenvalues>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/alignment.h"

namespace shape {
using namespace internal;

LinearisedModel linearise(const ShapeModel& model, int modes, const EmbeddingOptions& options,
                          const Progress& progress)
{
    if (modes < 0 || modes > model.mode_count())
        throw InvalidInput(
            join("modes is ", modes, ", must be in [0, ", model.mode_count(), "]; 0: all"));
    const int count = modes == 0 ? model.mode_count() : modes;
    const Embedder embedder(model.topology, {model.reference_points}, options);
    const auto report = [&](int done) {
        if (progress)
            progress("linearising", to_size(done), to_size(count));
    };
    LinearisedModel result;
    result.is_exact = std::holds_alternative<ProcrustesSpace>(model.space);
    result.mean = embedder.embed(model_point(model, {}, model.mean_size())).points;
    const auto mesh_at = [&](int mode, double deviations) {
        Eigen::VectorXd scores = Eigen::VectorXd::Zero(mode + 1);
        scores[mode] = deviations * std::sqrt(model.variances[mode]);
        const Points points = embedder.embed(model_point(model, scores, model.mean_size())).points;
        return best_rigid_motion(points, result.mean)(points);
    };
    Eigen::MatrixXd moves(result.mean.size(), count);
    for (int k = 0; k < count; ++k) {
        report(k);
        const Points move = 0.5 * (mesh_at(k, 1.0) - mesh_at(k, -1.0));
        moves.col(k) = move.reshaped<Eigen::RowMajor>();
    }
    report(count);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(moves.transpose() * moves);
    const Eigen::VectorXd& ascending = solver.eigenvalues();
    // Below 1e-12 of the largest, eigenvalues of inner products are their rounding.
    const double least = 1e-12 * ascending[count - 1];
    const auto kept = static_cast<int>((ascending.array() > std::max(least, 0.0)).count());
    if (kept == 0)
        throw NumericalError("the modes of the model move no vertex");
    const Eigen::MatrixXd vectors = solver.eigenvectors().rightCols(kept).rowwise().reverse();
    result.variances = ascending.tail(kept).reverse();
    const Eigen::VectorXd lengths = result.variances.cwiseSqrt();
    result.basis = moves * vectors * lengths.cwiseInverse().asDiagonal();
    const Eigen::VectorXd deviations = model.variances.head(count).cwiseSqrt();
    result.scores = model.scores.leftCols(count) * deviations.cwiseInverse().asDiagonal() *
                    vectors * lengths.asDiagonal();
    return result;
}

} // namespace shape
