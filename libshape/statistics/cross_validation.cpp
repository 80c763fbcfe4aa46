// SPDX-License-Identifier: MIT

#include "libshape/statistics/cross_validation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/dense.h"
#include "libshape/linalg/symmetric_eigen.h"
#include "libshape/statistics/discriminant_analysis.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Points in the coordinates of all their principal components.
struct Coordinates
{
    RowMatrix rows;   ///< N by M, columns of mean 0.
    VectorXd squares; ///< M, descending: sums of squares of the columns.
};

Coordinates principal_coordinates(MatrixXd products)
{
    products.rowwise() -= products.colwise().mean().eval();
    products.colwise() -= products.rowwise().mean().eval();
    const Eigenpairs pairs = largest_eigenpairs(products, static_cast<int>(products.rows()));
    // Below 1e-12 of the largest the eigenvalues of inner products are their rounding.
    const Index count = (pairs.values.array() > 1e-12 * pairs.values[0]).count();
    const VectorXd squares = pairs.values.head(count);
    return {pairs.vectors.leftCols(count) * squares.cwiseSqrt().asDiagonal(), squares};
}

/// The leading eigenvectors of diag(d) - B^T B, which has no eigenvalue < 0, by subspace iteration
/// from the leading unit vectors.
MatrixXd leading_subspace(const VectorXd& d, const MatrixXd& b, Index count)
{
    // Where these are not enough, eigenvalues lie close to each other, and the whole problem is solved below.
    constexpr int most_steps = 300;
    constexpr double tolerance = 1e-9; // of the eigenvalues: scores to about as much
    const Index width = std::min(d.size(), 2 * count + 10);
    MatrixXd basis = MatrixXd::Identity(d.size(), width);
    for (int step = 0; step < most_steps; ++step) {
        const MatrixXd image = d.asDiagonal() * basis - b.transpose() * (b * basis);
        const Eigen::SelfAdjointEigenSolver<MatrixXd> ritz(basis.transpose() * image);
        const MatrixXd best = ritz.eigenvectors().rightCols(count);
        const VectorXd values = ritz.eigenvalues().tail(count);
        MatrixXd vectors = basis * best;
        const double residual =
            (image * best - vectors * values.asDiagonal()).colwise().norm().maxCoeff();
        if (residual <= tolerance * d[0])
            return vectors;
        basis = Eigen::HouseholderQR<MatrixXd>(image).householderQ() *
                MatrixXd::Identity(d.size(), width);
    }
    MatrixXd full = -b.transpose() * b;
    full.diagonal() += d;
    return largest_eigenpairs(full, static_cast<int>(count)).vectors;
}

/// Groups of the observations of one fold, learnt from the others.
std::vector<int> predict(const Coordinates& all, const Grouping& groups,
                         const std::vector<int>& left_out, const std::vector<int>& kept,
                         Index modes)
{
    const RowMatrix test = all.rows(left_out, Eigen::all);
    const RowMatrix training = all.rows(kept, Eigen::all);
    const auto count = static_cast<double>(kept.size());
    const Eigen::RowVectorXd mean = -test.colwise().sum() / count;
    MatrixXd removed(test.rows() + 1, test.cols());
    removed << test, std::sqrt(count) * mean;
    const MatrixXd axes = leading_subspace(all.squares, removed, modes);
    Grouping training_groups{groups.names, {}};
    for (const int i : kept)
        training_groups.group_of.push_back(groups.group_of[to_size(i)]);
    const DiscriminantAnalysis analysis =
        discriminant_analysis((training.rowwise() - mean) * axes, training_groups);
    return classify(analysis, (test.rowwise() - mean) * axes);
}

std::vector<int> all_but(const std::vector<int>& left_out, Index count)
{
    std::vector<int> kept;
    for (int i = 0; i < count; ++i)
        if (!std::binary_search(left_out.begin(), left_out.end(), i))
            kept.push_back(i);
    return kept;
}

void check_fold(const Coordinates& all, const Grouping& groups, const std::string& fold,
                const std::vector<int>& kept, int modes)
{
    const auto group_count = to_size(groups.group_count());
    std::vector<bool> found(group_count, false);
    for (const int i : kept)
        found[to_size(groups.group_of[to_size(i)])] = true;
    for (std::size_t g = 0; g < group_count; ++g)
        if (!found[g])
            throw InvalidInput(join("cross-validation: without fold '", fold,
                                    "' nothing is left of group '", groups.names[g],
                                    "' to learn from"));
    const auto most = static_cast<std::ptrdiff_t>(kept.size() - std::min(kept.size(), group_count));
    if (most < 1)
        throw InvalidInput(join("cross-validation: without fold '", fold, "' there are ",
                                kept.size(), " observations in ", group_count,
                                " groups, too few to learn from; it takes one more than groups"));
    if (modes > std::min<std::ptrdiff_t>(most, all.squares.size()))
        throw InvalidInput(join("cross-validation: modes is ", modes, ", but without fold '", fold,
                                "' there are ", kept.size(), " observations in ", group_count,
                                " groups; it must be at most ",
                                std::min<std::ptrdiff_t>(most, all.squares.size())));
}

} // namespace

CrossValidation cross_validate(const MatrixXd& products, const Grouping& groups,
                               const Grouping& folds, int modes)
{
    const Index count = products.rows();
    if (products.cols() != count || groups.size() != count || folds.size() != count || count == 0)
        throw InvalidInput(join("cross-validation: inner products are ", count, " by ",
                                products.cols(), ", groups ", groups.size(), ", folds ",
                                folds.size(), "; all must agree"));
    if (groups.group_count() < 2 || folds.group_count() < 2 || modes < 1)
        throw InvalidInput(join("cross-validation: ", counted(groups.group_count(), "group"), ", ",
                                counted(folds.group_count(), "fold"), ", ", counted(modes, "mode"),
                                "; there must be at least 2, 2 and 1"));
    const Coordinates all = principal_coordinates(products);
    const std::vector<std::vector<int>> left_out = members(folds);
    CrossValidation result;
    result.predicted.resize(to_size(count));
    parallel_for(left_out.size(), 1, [&](std::size_t f, std::size_t) {
        const std::vector<int> kept = all_but(left_out[f], count);
        check_fold(all, groups, folds.names[f], kept, modes);
        const std::vector<int> predicted = predict(all, groups, left_out[f], kept, modes);
        for (std::size_t k = 0; k < predicted.size(); ++k)
            result.predicted[to_size(left_out[f][k])] = predicted[k];
    });
    result.confusion = Eigen::MatrixXi::Zero(groups.group_count(), groups.group_count());
    for (std::size_t i = 0; i < result.predicted.size(); ++i)
        ++result.confusion(groups.group_of[i], result.predicted[i]);
    result.accuracy = static_cast<double>(result.confusion.trace()) / static_cast<double>(count);
    return result;
}

} // namespace shape
