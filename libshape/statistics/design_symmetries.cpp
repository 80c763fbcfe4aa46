// SPDX-License-Identifier: MIT

#include "libshape/statistics/design_symmetries.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Permutation = std::vector<int>;

constexpr double same =
    1e-10; ///< Squared lengths and products, of the largest squared length, that are equal.

double largest_squared_norm(const RowMatrix& rows)
{
    return rows.size() == 0 ? 0.0 : rows.rowwise().squaredNorm().maxCoeff();
}

/// Rows of length at most 1.
RowMatrix scaled(const RowMatrix& rows)
{
    const double largest = largest_squared_norm(rows);
    return largest > 0.0 ? RowMatrix(rows / std::sqrt(largest)) : rows;
}

/// Takes the direction of a row off all rows, if it has one.
void take_off(RowMatrix& rows, Index row)
{
    const double length = rows.row(row).norm();
    if (!(length > 0.0))
        return;
    const Eigen::RowVectorXd direction = rows.row(row) / length;
    rows -= (rows * direction.transpose()) * direction;
}

/// Counts the group by its stabilisers (Schreier and Sims): once the images of some cells are known, of which the rows span
/// all, those of the others are; its order is the product of the numbers of images that each of these cells has while those
/// before it stay.
class Symmetries
{
public:
    Symmetries(const RowMatrix& tested, const RowMatrix& nuisance, const std::vector<int>& kinds)
        : tested_(scaled(tested)), nuisance_(scaled(nuisance)), kinds_(kinds)
    {
        choose_base();
        const Index size = std::ssize(base_);
        RowMatrix of_tested(size, tested_.cols()), of_nuisance(size, nuisance_.cols());
        for (Index i = 0; i < size; ++i) {
            of_tested.row(i) = tested_.row(base_[to_size(i)]);
            of_nuisance.row(i) = nuisance_.row(base_[to_size(i)]);
        }
        to_tested_ = of_tested.completeOrthogonalDecomposition().pseudoInverse();
        to_nuisance_ = RowMatrix::Zero(0, size);
        if (nuisance_.cols() > 0)
            to_nuisance_ = of_nuisance.completeOrthogonalDecomposition().pseudoInverse();
        for (Index c = 0; c < tested_.rows(); ++c)
            by_key_.emplace_back(key_of(tested_.row(c), nuisance_.row(c)), static_cast<int>(c));
        std::ranges::sort(by_key_);
    }

    double log_count()
    {
        double order = 0.0; // its logarithm
        std::vector<Permutation> found;
        for (std::size_t level = base_.size(); level-- > 0;) {
            std::vector<int> orbit = orbit_of(base_[level], found);
            for (int c = 0; c < std::ssize(kinds_); ++c) {
                if (std::ranges::find(orbit, c) != orbit.end())
                    continue;
                images_.assign(base_.begin(), base_.begin() + static_cast<std::ptrdiff_t>(level));
                if (!may_be_image(c))
                    continue;
                images_.push_back(c);
                if (auto symmetry = extended()) {
                    found.push_back(std::move(*symmetry));
                    orbit = orbit_of(base_[level], found);
                }
            }
            order += std::log(static_cast<double>(orbit.size()));
        }
        return order;
    }

private:
    /// Cells of which the rows span all others, both tested and nuisance.
    void choose_base()
    {
        constexpr double nothing = 1e-6;
        RowMatrix tested = tested_, nuisance = nuisance_;
        for (;;) {
            Eigen::VectorXd left = tested.rowwise().squaredNorm();
            if (nuisance.cols() > 0)
                left = left.cwiseMax(nuisance.rowwise().squaredNorm());
            Index cell = 0;
            if (left.size() == 0 || left.maxCoeff(&cell) <= nothing * nothing)
                return;
            base_.push_back(static_cast<int>(cell));
            // What is left of a row is numerically nothing afterwards, but need not be 0.
            take_off(tested, cell);
            take_off(nuisance, cell);
            tested.row(cell).setZero();
            nuisance.row(cell).setZero();
        }
    }

    /// A number that equal rows share.
    [[nodiscard]] static double key_of(const Eigen::RowVectorXd& tested,
                                       const Eigen::RowVectorXd& nuisance)
    {
        double key = 0.0;
        double weight = 0.0;
        for (const auto* row : {&tested, &nuisance})
            for (const double number : *row)
                key += number / ++weight; // any weights do whose squares sum to less than 4
        return key;
    }

    [[nodiscard]] bool are_alike(int a, int b, int c, int d) const
    {
        return std::abs(tested_.row(a).dot(tested_.row(b)) - tested_.row(c).dot(tested_.row(d))) <=
                   same &&
               std::abs(nuisance_.row(a).dot(nuisance_.row(b)) -
                        nuisance_.row(c).dot(nuisance_.row(d))) <= same;
    }

    /// Whether a cell may be the image of the next one of the base, by its products with the images so far.
    bool may_be_image(int cell)
    {
        const std::size_t next = images_.size();
        const int from = base_[next];
        work_ += static_cast<double>(tested_.cols() + nuisance_.cols());
        if (kinds_[to_size(cell)] != kinds_[to_size(from)] || !are_alike(from, from, cell, cell))
            return false;
        for (std::size_t i = 0; i < next; ++i) {
            work_ += static_cast<double>(tested_.cols() + nuisance_.cols());
            if (!are_alike(base_[i], from, images_[i], cell))
                return false;
        }
        return true;
    }

    /// A symmetry with the images so far.
    std::optional<Permutation> extended()
    {
        constexpr double most_work = 1e9;
        if (images_.size() == base_.size())
            return all_images();
        const int from = base_[images_.size()];
        const auto with = [&](int cell) -> std::optional<Permutation> {
            if (work_ > most_work || !may_be_image(cell))
                return std::nullopt;
            images_.push_back(cell);
            std::optional<Permutation> symmetry = extended();
            images_.pop_back();
            return symmetry;
        };
        if (auto symmetry = with(from)) // most stay
            return symmetry;
        for (int cell = 0; cell < std::ssize(kinds_); ++cell)
            if (cell != from)
                if (auto symmetry = with(cell))
                    return symmetry;
        return std::nullopt;
    }

    /// Where the images of the base take all cells, if each comes to one of its kind.
    std::optional<Permutation> all_images()
    {
        const Index size = std::ssize(base_);
        RowMatrix of_tested(size, tested_.cols()), of_nuisance(size, nuisance_.cols());
        for (Index i = 0; i < size; ++i) {
            of_tested.row(i) = tested_.row(images_[to_size(i)]);
            of_nuisance.row(i) = nuisance_.row(images_[to_size(i)]);
        }
        const RowMatrix u = to_tested_ * of_tested;
        const RowMatrix v = to_nuisance_ * of_nuisance;
        Permutation result(kinds_.size());
        for (int c = 0; c < std::ssize(kinds_); ++c) {
            work_ += static_cast<double>(u.size() + v.size());
            const Eigen::RowVectorXd tested = tested_.row(c) * u;
            const Eigen::RowVectorXd nuisance =
                v.size() > 0 ? Eigen::RowVectorXd(nuisance_.row(c) * v) : nuisance_.row(c);
            const int image = cell_at(tested, nuisance, kinds_[to_size(c)]);
            if (image < 0)
                return std::nullopt;
            result[to_size(c)] = image;
        }
        return result;
    }

    [[nodiscard]] int cell_at(const Eigen::RowVectorXd& tested, const Eigen::RowVectorXd& nuisance,
                              int kind) const
    {
        constexpr double near =
            1e-8; // products to 1e-10 leave as much of rows that nearly depend on each other
        const double key = key_of(tested, nuisance);
        const double reach = 4.0 * near;
        for (auto at = std::ranges::lower_bound(by_key_, std::pair(key - reach, 0));
             at != by_key_.end() && at->first <= key + reach; ++at)
            if (kinds_[to_size(at->second)] == kind &&
                (tested_.row(at->second) - tested).norm() <= near &&
                (nuisance_.row(at->second) - nuisance).norm() <= near)
                return at->second;
        return -1;
    }

    static std::vector<int> orbit_of(int cell, const std::vector<Permutation>& symmetries)
    {
        std::vector<int> orbit{cell};
        for (std::size_t i = 0; i < orbit.size(); ++i)
            for (const Permutation& symmetry : symmetries)
                if (const int image = symmetry[to_size(orbit[i])];
                    std::ranges::find(orbit, image) == orbit.end())
                    orbit.push_back(image);
        return orbit;
    }

    RowMatrix tested_, nuisance_;
    std::vector<int> kinds_;
    std::vector<int> base_;
    RowMatrix to_tested_, to_nuisance_; ///< From images of the base to U and V.
    std::vector<std::pair<double, int>> by_key_;
    std::vector<int> images_; ///< Of the first cells of the base.
    double work_ = 0.0;
};

} // namespace

double design_symmetries(const RowMatrix& tested, const RowMatrix& nuisance,
                         const std::vector<int>& kinds)
{
    return Symmetries(tested, nuisance, kinds).log_count();
}

} // namespace shape::internal
