// SPDX-License-Identifier: MIT

#include "libshape/linalg/minimize.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/linalg/dense.h"

namespace shape {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t grain = 4096;

/// m^T v, the same bits for any number of threads.
VectorXd transposed_product(const RowMatrix& m, const VectorXd& v)
{
    const auto rows = static_cast<std::size_t>(m.rows());
    MatrixXd parts(m.cols(), static_cast<Eigen::Index>((rows + grain - 1) / grain));
    parallel_for(rows, grain, [&](std::size_t begin, std::size_t end) {
        const auto first = static_cast<Eigen::Index>(begin);
        const auto count = static_cast<Eigen::Index>(end - begin);
        parts.col(static_cast<Eigen::Index>(begin / grain)).noalias() =
            m.middleRows(first, count).transpose() * v.segment(first, count);
    });
    return parts.rowwise().sum();
}

/// v += m c.
void add_product(VectorXd& v, const RowMatrix& m, const VectorXd& c)
{
    parallel_for(static_cast<std::size_t>(v.size()), grain,
                 [&](std::size_t begin, std::size_t end) {
                     const auto first = static_cast<Eigen::Index>(begin);
                     const auto count = static_cast<Eigen::Index>(end - begin);
                     v.segment(first, count).noalias() += m.middleRows(first, count) * c;
                 });
}

double dot(const VectorXd& a, const VectorXd& b)
{
    return parallel_sum(static_cast<std::size_t>(a.size()), grain,
                        [&](std::size_t begin, std::size_t end) {
                            const auto first = static_cast<Eigen::Index>(begin);
                            const auto count = static_cast<Eigen::Index>(end - begin);
                            return a.segment(first, count).dot(b.segment(first, count));
                        });
}

/// The last steps s and the changes y of the gradient along them. Inner products are kept, so that
/// the two-loop recursion needs four passes over the vectors instead of four for every pair.
class History
{
public:
    History(Eigen::Index size, int memory)
        : steps_(RowMatrix::Zero(size, memory)),
          changes_(RowMatrix::Zero(size, memory)),
          products_(MatrixXd::Zero(memory, memory))
    {
    }

    /// Takes a pair if that keeps the Hessian positive definite; the oldest makes room.
    void add(const VectorXd& s, const VectorXd& y)
    {
        const double sy = dot(s, y);
        if (!(sy > 1e-12 * std::sqrt(dot(s, s) * dot(y, y))))
            return;
        const Eigen::Index memory = steps_.cols();
        const Eigen::Index slot = ages_.size() < static_cast<std::size_t>(memory)
                                      ? static_cast<Eigen::Index>(ages_.size())
                                      : ages_.front();
        if (ages_.size() == static_cast<std::size_t>(memory))
            ages_.pop_front();
        ages_.push_back(slot);
        steps_.col(slot) = s;
        changes_.col(slot) = y;
        products_.row(slot) = transposed_product(changes_, s).transpose();
        products_.col(slot) = transposed_product(steps_, y);
    }

    /// - H g by the two-loop recursion.
    [[nodiscard]] VectorXd direction(const VectorXd& gradient,
                                     const Preconditioner& precondition) const
    {
        VectorXd q = -gradient;
        if (ages_.empty())
            return precondition(q);
        const VectorXd sq = transposed_product(steps_, q);
        VectorXd alpha = VectorXd::Zero(sq.size());
        for (auto i = ages_.rbegin(); i != ages_.rend(); ++i)
            alpha[*i] = (sq[*i] - products_.row(*i).dot(alpha)) / products_(*i, *i);
        add_product(q, changes_, -alpha);
        VectorXd direction = precondition(q);
        const VectorXd yd = transposed_product(changes_, direction);
        VectorXd beta = VectorXd::Zero(yd.size());
        for (const Eigen::Index i : ages_)
            beta[i] = alpha[i] - (yd[i] + products_.col(i).dot(beta)) / products_(i, i);
        add_product(direction, steps_, beta);
        return direction;
    }

private:
    RowMatrix steps_;               ///< n by memory; columns not in use are 0.
    RowMatrix changes_;             ///< The same.
    MatrixXd products_;             ///< s_i . y_j
    std::deque<Eigen::Index> ages_; ///< Columns in use, the oldest first.
};

} // namespace

Minimum minimize(const Objective& objective, const Preconditioner& precondition,
                 Eigen::VectorXd start, const MinimizeOptions& options)
{
    if (options.memory < 1 || options.max_iterations < 0 || options.window < 1)
        throw InvalidInput(join("minimize: memory ", options.memory, ", max_iterations ",
                                options.max_iterations, ", window ", options.window,
                                "; must be >= 1, >= 0, >= 1"));
    Minimum result;
    result.point = std::move(start);
    VectorXd gradient(result.point.size());
    result.value = objective(result.point, gradient);
    result.evaluations = 1;
    if (!std::isfinite(result.value))
        throw NumericalError("minimize: the function is not finite at the start");

    History history(result.point.size(), options.memory);
    std::deque<double> window{result.value};
    VectorXd next_gradient(result.point.size());
    result.converged = result.value <= options.value_tolerance;
    while (!result.converged && result.iterations < options.max_iterations) {
        const VectorXd direction = history.direction(gradient, precondition);
        const double slope = dot(gradient, direction);
        if (!(slope < 0.0)) // also where the gradient vanishes
            break;
        double step = 1.0;
        VectorXd next = result.point + direction;
        double value = objective(next, next_gradient);
        ++result.evaluations;
        constexpr double smallest_step = 1e-9;
        while (!(value <= result.value + 1e-4 * step * slope) && step > smallest_step) {
            step *= 0.5;
            next = result.point + step * direction;
            value = objective(next, next_gradient);
            ++result.evaluations;
        }
        if (step <= smallest_step)
            break;
        history.add(next - result.point, next_gradient - gradient);
        result.point = std::move(next);
        result.value = value;
        gradient.swap(next_gradient);
        ++result.iterations;
        window.push_back(value);
        if (window.size() > static_cast<std::size_t>(options.window)) {
            result.converged = window.front() - value <= options.decrease_tolerance * value;
            window.pop_front();
        }
        result.converged = result.converged || value <= options.value_tolerance;
    }
    return result;
}

} // namespace shape
