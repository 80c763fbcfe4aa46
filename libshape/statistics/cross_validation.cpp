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
#include "libshape/statistics/component_steps.h"
#include "libshape/statistics/discriminant_analysis.h"
#include "libshape/statistics/regular_coordinates.h"

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
    // Below that the eigenvalues of inner products are their rounding.
    const Index count = (pairs.values.array() > smallest_variance_ratio * pairs.values[0]).count();
    if (count == 0)
        throw InvalidInput("cross-validation: all observations are equal; give some that differ");
    const VectorXd squares = pairs.values.head(count);
    return {pairs.vectors.leftCols(count) * squares.cwiseSqrt().asDiagonal(), squares};
}

/// The leading eigenvectors of diag(d) - B^T B, which has no eigenvalue < 0, the largest first, by subspace
/// iteration from the leading unit vectors.
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
        const MatrixXd best = ritz.eigenvectors().rightCols(count).rowwise().reverse();
        const VectorXd values = ritz.eigenvalues().tail(count).reverse();
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

/// Scores in the leading components of the observations that are learnt from, of these and of those left out.
struct FoldScores
{
    RowMatrix training;
    RowMatrix test;
    Grouping groups; ///< Of the former.
};

FoldScores scores_without(const Coordinates& all, const Grouping& groups,
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
    FoldScores scores{
        (training.rowwise() - mean) * axes, (test.rowwise() - mean) * axes, {groups.names, {}}};
    for (const int i : kept)
        scores.groups.group_of.push_back(groups.group_of[to_size(i)]);
    return scores;
}

/// Components of the observations that are learnt from; those that follow are rounding.
Index component_count(const Coordinates& all, const FoldScores& scores)
{
    Index count = 0;
    while (count < scores.training.cols() &&
           scores.training.col(count).squaredNorm() > smallest_variance_ratio * all.squares[0])
        ++count;
    return count;
}

std::vector<int> all_but(const std::vector<int>& left_out, Index count)
{
    std::vector<int> kept;
    for (int i = 0; i < count; ++i)
        if (!std::binary_search(left_out.begin(), left_out.end(), i))
            kept.push_back(i);
    return kept;
}

/// Observations less groups: so many modes can be learnt at most.
/// @throws InvalidInput if a group is empty without the fold, or there is no such mode.
int check_fold(const Grouping& groups, const std::string& fold, const std::vector<int>& kept)
{
    const auto group_count = to_size(groups.group_count());
    std::vector<bool> found(group_count, false);
    for (const int i : kept)
        found[to_size(groups.group_of[to_size(i)])] = true;
    for (std::size_t g = 0; g < group_count; ++g)
        if (!found[g])
            throw InvalidInput(join("cross-validation: without fold '", fold,
                                    "' nothing is left of group '", groups.names[g],
                                    "' to learn from; it needs observations in two folds, or "
                                    "leave them out"));
    if (kept.size() <= group_count)
        throw InvalidInput(join("cross-validation: without fold '", fold, "' there are ",
                                kept.size(), " observations in ", group_count,
                                " groups, too few to learn from; it takes one more than groups"));
    return static_cast<int>(kept.size() - group_count);
}

/// The observations of each fold, and those that it leaves to learn from.
struct Folds
{
    explicit Folds(const Grouping& grouping) : folds(grouping), left_out(members(grouping)) {}

    [[nodiscard]] const std::string& name(std::size_t fold) const { return folds.names[fold]; }
    [[nodiscard]] std::vector<int> kept(std::size_t fold) const
    {
        return all_but(left_out[fold], folds.size());
    }

    const Grouping& folds;
    std::vector<std::vector<int>> left_out;
};

void check_sizes(const MatrixXd& products, const Grouping& groups, const Grouping& folds, int modes)
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
}

/// Groups of the observations of one fold, learnt from the others.
std::vector<int> predict(const Coordinates& all, const Grouping& groups, const Folds& folds,
                         std::size_t fold, int modes)
{
    const std::vector<int> kept = folds.kept(fold);
    const auto require_modes = [&](Index components, Index most) {
        if (modes > most)
            throw InvalidInput(join("cross-validation: modes is ", modes, ", but without fold '",
                                    folds.name(fold), "' there are ", kept.size(),
                                    " observations of ", counted(components, "component"), " in ",
                                    groups.group_count(), " groups; it must be at most ", most));
    };
    const Index most = check_fold(groups, folds.name(fold), kept);
    require_modes(all.squares.size(), std::min<Index>(most, all.squares.size()));
    const FoldScores scores = scores_without(all, groups, folds.left_out[fold], kept, modes);
    const Index components = component_count(all, scores);
    require_modes(components, components);
    return classify(discriminant_analysis(scores.training, scores.groups), scores.test);
}

CrossValidation validate(const Coordinates& all, const Grouping& groups, const Folds& folds,
                         int modes)
{
    CrossValidation result;
    result.modes = modes;
    result.predicted.resize(groups.group_of.size());
    parallel_for(folds.left_out.size(), 1, [&](std::size_t f, std::size_t) {
        const std::vector<int> predicted = predict(all, groups, folds, f, modes);
        for (std::size_t k = 0; k < predicted.size(); ++k)
            result.predicted[to_size(folds.left_out[f][k])] = predicted[k];
    });
    result.confusion = Eigen::MatrixXi::Zero(groups.group_count(), groups.group_count());
    for (std::size_t i = 0; i < result.predicted.size(); ++i)
        ++result.confusion(groups.group_of[i], result.predicted[i]);
    result.accuracy =
        static_cast<double>(result.confusion.trace()) / static_cast<double>(groups.size());
    return result;
}

/// The most modes, at most `most`, that can be learnt without each fold.
int usable_modes(const Coordinates& all, const Grouping& groups, const Folds& folds, int most)
{
    std::size_t largest = 0;
    for (std::size_t f = 0; f < folds.left_out.size(); ++f) {
        most = std::min(most, check_fold(groups, folds.name(f), folds.kept(f)));
        largest = std::max(largest, folds.left_out[f].size());
    }
    most = std::min(most, static_cast<int>(all.squares.size()));
    // An observation that is left out takes one component with it at most, the mean of a group one direction.
    if (all.squares.size() >= most + static_cast<Index>(largest) + groups.group_count())
        return most;
    std::vector<Index> usable(folds.left_out.size());
    parallel_for(usable.size(), 1, [&](std::size_t f, std::size_t) {
        const FoldScores scores =
            scores_without(all, groups, folds.left_out[f], folds.kept(f), most);
        usable[f] = regular_coordinates(scores.training.leftCols(component_count(all, scores)),
                                        scores.groups);
    });
    const auto least = std::ranges::min_element(usable);
    if (*least == 0)
        throw NumericalError(join("cross-validation: without fold '",
                                  folds.name(to_size(least - usable.begin())),
                                  "' no group varies along the first component: nothing says how "
                                  "far apart they are; add observations that differ"));
    return static_cast<int>(*least);
}

} // namespace

CrossValidation cross_validate(const MatrixXd& products, const Grouping& groups,
                               const Grouping& folds, int modes)
{
    check_sizes(products, groups, folds, modes);
    return validate(principal_coordinates(products), groups, Folds(folds), modes);
}

CrossValidation cross_validate_up_to(const MatrixXd& products, const Grouping& groups,
                                     const Grouping& folds, int most)
{
    check_sizes(products, groups, folds, most);
    const Coordinates all = principal_coordinates(products);
    const Folds each(folds);
    return validate(all, groups, each, usable_modes(all, groups, each, most));
}

} // namespace shape
