// SPDX-License-Identifier: MIT

#include "libshape/conformal/moebius.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

using Complex = std::complex<double>;
// Differences of 1e-13 need 16 digits of their own.
__extension__ typedef __float128 Quad; // NOLINT(modernize-use-using): cannot be __extension__

Eigen::Vector3d on_sphere(Complex z)
{
    const double norm = std::norm(z);
    if (norm > 1.0) { // divided by norm: no overflow
        const Complex inverse = 1.0 / std::conj(z);
        const double small = std::norm(inverse);
        return Eigen::Vector3d(2.0 * inverse.real(), 2.0 * inverse.imag(), small - 1.0) /
               (1.0 + small);
    }
    return Eigen::Vector3d(2.0 * z.real(), 2.0 * z.imag(), 1.0 - norm) / (1.0 + norm);
}

/// The value below which half of the weight lies.
double weighted_median(const Eigen::VectorXd& values, const Eigen::VectorXd& weights)
{
    std::vector<std::pair<double, double>> sorted;
    for (Eigen::Index i = 0; i < values.size(); ++i)
        sorted.emplace_back(values[i], weights[i]);
    std::sort(sorted.begin(), sorted.end());
    double rest = 0.5 * weights.sum();
    for (const auto& [value, weight] : sorted)
        if ((rest -= weight) <= 0.0)
            return value;
    return sorted.back().first;
}

class BalanceProblem
{
public:
    BalanceProblem(const Eigen::VectorXcd& positions, const Eigen::VectorXd& weights,
                   int infinite_vertex)
        : positions_(positions), weights_(weights / weights.sum()), infinite_(infinite_vertex)
    {
    }

    [[nodiscard]] StereographicFrame start() const
    {
        Eigen::VectorXd finite = weights_;
        finite[infinite_] = 0.0;
        const Complex centre(weighted_median(positions_.real(), finite),
                             weighted_median(positions_.imag(), finite));
        const double height = weighted_median((positions_.array() - centre).abs(), finite);
        return {centre, height};
    }

    /// sum_i w_i log((|z_i - centre|^2 + height^2) / height), infinity counted as its limit.
    [[nodiscard]] double energy(const StereographicFrame& frame) const
    {
        double sum = -std::log(frame.height);
        for (Eigen::Index v = 0; v < positions_.size(); ++v)
            if (v != infinite_)
                sum += 2.0 * weights_[v] *
                       std::log(std::hypot(std::abs(positions_[v] - frame.centre), frame.height));
        return sum;
    }

    /// Mean m of the points and J = 2 sum_i w_i (I - p_i p_i^T): gradient and Hessian of the
    /// energy at the centre of the ball are -2 m and 2 J.
    void derivatives(const StereographicFrame& frame, Eigen::Vector3d& mean,
                     Eigen::Matrix3d& hessian) const
    {
        mean = -weights_[infinite_] * Eigen::Vector3d::UnitZ();
        hessian = 2.0 * Eigen::Matrix3d::Identity();
        hessian(2, 2) -= 2.0 * weights_[infinite_];
        for (Eigen::Index v = 0; v < positions_.size(); ++v) {
            if (v == infinite_)
                continue;
            const Eigen::Vector3d p = on_sphere((positions_[v] - frame.centre) / frame.height);
            mean += weights_[v] * p;
            hessian -= 2.0 * weights_[v] * p * p.transpose();
        }
    }

private:
    const Eigen::VectorXcd& positions_;
    Eigen::VectorXd weights_;
    int infinite_;
};

/// The frame whose centre is the point c of the ball seen from `frame`; |c| < 1.
StereographicFrame moved(const StereographicFrame& frame, const Eigen::Vector3d& c)
{
    // Ball to upper half-space, the pole (0, 0, -1) to infinity.
    const double denominator = c.head<2>().squaredNorm() + (1.0 + c[2]) * (1.0 + c[2]);
    return {frame.centre + frame.height * Complex(2.0 * c[0], 2.0 * c[1]) / denominator,
            frame.height * (1.0 - c.squaredNorm()) / denominator};
}

} // namespace

MoebiusBalance balance_on_sphere(const Eigen::VectorXcd& positions, const Eigen::VectorXd& weights,
                                 int infinite_vertex)
{
    const BalanceProblem problem(positions, weights, infinite_vertex);
    MoebiusBalance result{problem.start(), 0.0, 0};
    Eigen::Vector3d mean;
    Eigen::Matrix3d hessian;
    problem.derivatives(result.frame, mean, hessian);
    result.residual = mean.norm();
    // The residual is the mean of points on the unit sphere: 1e-15 is its rounding. Steps of at
    // most 0.9 keep the frame inside the ball. The limit of iterations is for what
    // rounding keeps from ending.
    while (result.residual > 1e-15 && result.iterations < 100) {
        Eigen::Vector3d step = hessian.ldlt().solve(mean);
        step *= std::min(1.0, 0.9 / step.norm());
        const double energy = problem.energy(result.frame);
        StereographicFrame frame = moved(result.frame, step);
        // Near the minimum (1e-6 squared is rounding beside 1) the energy is flat, and full steps are good.
        while (result.residual > 1e-6 && problem.energy(frame) > energy && step.norm() > 1e-12) {
            step *= 0.5;
            frame = moved(result.frame, step);
        }
        problem.derivatives(frame, mean, hessian);
        ++result.iterations;
        if (result.residual < 1e-12 && mean.norm() >= result.residual) // rounding: it falls no more
            break;
        result.frame = frame;
        result.residual = mean.norm();
    }
    return result;
}

SpherePoints project_to_sphere(const PlanarLayout& layout, const StereographicFrame& frame,
                               int infinite_vertex)
{
    const Eigen::Index count = layout.positions.size();
    SpherePoints sphere{Points(count, 3), Points(count, 3)};
    for (Eigen::Index v = 0; v < count; ++v) {
        const Complex z = layout.positions[v];
        const Complex r = layout.remainders[v];
        const Quad x =
            (static_cast<Quad>(z.real()) + r.real() - frame.centre.real()) / frame.height;
        const Quad y =
            (static_cast<Quad>(z.imag()) + r.imag() - frame.centre.imag()) / frame.height;
        const Quad norm = x * x + y * y;
        const std::array<Quad, 3> p{2 * x / (1 + norm), 2 * y / (1 + norm),
                                    (1 - norm) / (1 + norm)};
        for (int k = 0; k < 3; ++k) {
            const Quad coordinate = p[to_size(k)];
            sphere.points(v, k) = static_cast<double>(coordinate);
            sphere.remainders(v, k) = static_cast<double>(coordinate - sphere.points(v, k));
        }
    }
    sphere.points.row(infinite_vertex) << 0.0, 0.0, -1.0;
    sphere.remainders.row(infinite_vertex).setZero();
    return sphere;
}

} // namespace shape::internal
