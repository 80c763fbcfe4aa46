// SPDX-License-Identifier: MIT

#include "libshape/registration/rigid_start.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "libshape/base/stop.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/unit_ratio.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Centroid and covariance of a surface: those of its faces are a quarter those of their corners' mean and
/// three quarters those of their middle.
struct Moments
{
    Vector3d centroid = Vector3d::Zero();
    Matrix3d covariance = Matrix3d::Zero();

    explicit Moments(const Surface& surface)
    {
        double area = 0.0;
        const auto for_faces = [&](const auto& body) {
            for (const auto& face : surface.faces.rowwise()) {
                const Vector3d a = surface.points.row(face[0]), b = surface.points.row(face[1]),
                               c = surface.points.row(face[2]);
                body((b - a).cross(c - a).norm(), a, b, c);
            }
        };
        for_faces([&](double weight, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
            area += weight;
            centroid += weight * (a + b + c) / 3.0;
        });
        centroid /= area;
        for_faces([&](double weight, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
            for (const Vector3d& corner : {a, b, c})
                covariance +=
                    weight / (12.0 * area) * (corner - centroid) * (corner - centroid).transpose();
            const Vector3d middle = (a + b + c) / 3.0 - centroid;
            covariance += 0.75 * weight / area * middle * middle.transpose();
        });
    }
    [[nodiscard]] double size() const { return std::sqrt(covariance.trace()); }
    /// Principal axes, right-handed, in columns.
    [[nodiscard]] Matrix3d axes() const
    {
        Matrix3d axes = Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance).eigenvectors();
        if (axes.determinant() < 0.0)
            axes.col(0) *= -1.0;
        return axes;
    }
};

/// The 24 rotations that take coordinate axes to coordinate axes.
std::vector<Matrix3d> turns_of_a_cube()
{
    std::vector<Matrix3d> turns;
    std::array<int, 3> order{0, 1, 2};
    do {
        for (int signs = 0; signs < 8; ++signs) {
            Matrix3d turn = Matrix3d::Zero();
            for (int k = 0; k < 3; ++k)
                turn(order[to_size(k)], k) = (signs >> k & 1) != 0 ? -1.0 : 1.0;
            if (turn.determinant() > 0.0)
                turns.push_back(turn);
        }
    } while (std::next_permutation(order.begin(), order.end()));
    return turns;
}

/// Rotations spread evenly: a spiral of axes over the sphere, turned on by the golden angle.
std::vector<Matrix3d> spread_rotations(int count)
{
    std::vector<Matrix3d> rotations;
    constexpr double golden = std::numbers::pi * 2.0 * (2.0 - std::numbers::phi);
    for (int i = 0; i < count; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / count;
        const double r = std::sqrt(1.0 - z * z);
        const Vector3d axis(r * std::cos(golden * i), r * std::sin(golden * i), z);
        const double turn = 2.0 * std::numbers::pi * std::fmod(i * std::numbers::sqrt2, 1.0);
        rotations.push_back((Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), axis) *
                             Eigen::Quaterniond(Eigen::AngleAxisd(turn, Vector3d::UnitZ())))
                                .toRotationMatrix());
    }
    return rotations;
}

Points every(const Points& points, Index count)
{
    const Index stride = std::max<Index>(1, points.rows() / count);
    return points(Eigen::seq(0, points.rows() - 1, stride), Eigen::all);
}

/// Mean of the least four fifths: a scan's holes and a template's missing parts are the rest.
double trimmed_mean(std::vector<double> values)
{
    const std::size_t kept = std::max<std::size_t>(1, values.size() * 4 / 5);
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(kept) - 1,
                     values.end());
    double sum = 0.0;
    std::sort(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(kept));
    for (std::size_t i = 0; i < kept; ++i)
        sum += values[i];
    return sum / static_cast<double>(kept);
}

/// Iterated closest points from a motion: four fifths of the samples count.
/// @return The trimmed mean distance before the last step.
double improve(const Points& samples, const Surface& fixed, int steps, RigidMotion& motion)
{
    double score = 0.0;
    for (int step = 0; step < steps; ++step) {
        const Points moved = motion(samples);
        Points nearest(moved.rows(), 3);
        std::vector<double> distances;
        for (Index i = 0; i < moved.rows(); ++i) {
            throw_if_stop_requested();
            nearest.row(i) = fixed.tree.near_point(moved.row(i));
            distances.push_back((nearest.row(i) - moved.row(i)).norm());
        }
        score = trimmed_mean(distances);
        std::vector<double> sorted = distances;
        const auto cut = sorted.begin() + std::ssize(sorted) * 4 / 5;
        std::nth_element(sorted.begin(), cut, sorted.end());
        std::vector<Index> kept;
        for (Index i = 0; i < moved.rows(); ++i)
            if (distances[to_size(i)] <= *cut)
                kept.push_back(i);
        motion =
            best_rigid_motion(Points(samples(kept, Eigen::all)), Points(nearest(kept, Eigen::all)));
    }
    return score;
}

/// Sizes that differ by less are in one unit, and what they differ by is growth or a part that is missing.
constexpr double same_unit = 2.5;

/// Looks for ways in which a surface lies on another one.
struct Search
{
    const Surface& moving;
    const Surface& fixed;
    const Moments& of_moving;
    const Moments& of_fixed;

    struct Candidate
    {
        RigidMotion motion;
        double score;
    };
    /// @param first  Stays as it is: a bent pose may lie better than closest points know. Others have its scale.
    [[nodiscard]] std::vector<Similarity> starts(const Similarity& first, int count) const
    {
        std::vector<Similarity> starts{first};
        if (count == 1)
            return starts;
        // Closest points that have slid along the surface from how the first is turned are elsewhere.
        const double elsewhere = 0.2 * of_fixed.size();
        const auto centre = [&](const RigidMotion& motion) -> Vector3d {
            return motion.rotation * (first.scale * of_moving.centroid) + motion.translation;
        };
        for (const Candidate& c : candidates(first.scale)) {
            const auto is_like = [&](const Similarity& start) {
                const bool is_first = &start == &starts.front();
                return turn_angle(start.motion.rotation.transpose() * c.motion.rotation) <
                           same_way &&
                       (!is_first || (centre(start.motion) - centre(c.motion)).norm() < elsewhere);
            };
            if (std::ssize(starts) < count && std::none_of(starts.begin(), starts.end(), is_like))
                starts.push_back({first.scale, c.motion});
        }
        return starts;
    }

    /// The best first.
    [[nodiscard]] std::vector<Candidate> candidates(double scale) const
    {
        std::vector<Candidate> candidates;
        const auto add = [&](const Matrix3d& rotation) {
            candidates.push_back(
                {{rotation, of_fixed.centroid - scale * rotation * of_moving.centroid}, 0.0});
        };
        const Matrix3d from = of_moving.axes(), to = of_fixed.axes();
        for (const Matrix3d& turn : turns_of_a_cube())
            add(to * turn * from.transpose());
        // Each of 40 stands for the rotations within 45 degrees of it (a share of (a - sin a) / pi, a = 45 degrees, is
        // 1 / 40), from where closest points find home.
        for (const Matrix3d& rotation : spread_rotations(40))
            add(rotation);

        // First all by few samples, to choose those worth more: 64 x 60 points x 6 steps are 23,000 searches of nearest
        // points. What follows, 15 x (200 x 10 + 200), are 33,000: both stages cost about alike.
        const Points few = scale * every(moving.points, 60);
        parallel_for(candidates.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                candidates[i].score = improve(few, fixed, 6, candidates[i].motion);
        });
        const auto better = [](const Candidate& a, const Candidate& b) {
            return a.score < b.score;
        };
        std::stable_sort(candidates.begin(), candidates.end(), better);
        candidates.resize(15);

        const Points more = scale * every(moving.points, 200);
        const Points of_scan = every(fixed.points, 200);
        parallel_for(candidates.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                Candidate& c = candidates[i];
                c.score = improve(more, fixed, 10, c.motion);
                const Points back = Similarity{scale, c.motion}.inverse(of_scan);
                std::vector<double> distances;
                for (Index k = 0; k < back.rows(); ++k)
                    distances.push_back(
                        scale *
                        (moving.tree.near_point(back.row(k)) - back.row(k).transpose()).norm());
                c.score += trimmed_mean(std::move(distances));
            }
        });
        std::stable_sort(candidates.begin(), candidates.end(), better);
        return candidates;
    }
};

} // namespace

Points Similarity::operator()(const Points& points) const
{
    return motion(scale * points);
}

Points Similarity::inverse(const Points& points) const
{
    return ((points.rowwise() - motion.translation.transpose()) * motion.rotation) / scale;
}

double spread(const Points& points)
{
    return (points.rowwise() - points.colwise().mean()).norm();
}

double turn_angle(const Matrix3d& rotation)
{
    return Eigen::AngleAxisd(rotation).angle();
}

double change_of_unit(double ratio)
{
    if (ratio <= same_unit && ratio >= 1.0 / same_unit)
        return 1.0;
    double change = ratio;
    double nearest = std::log(same_unit);
    for (const UnitRatio& units : unit_ratios)
        for (const double exact : {units.value, 1.0 / units.value})
            if (const double apart = std::abs(std::log(ratio / exact)); apart < nearest) {
                nearest = apart;
                change = exact;
            }
    return change;
}

Similarity landmark_start(const Points& from, const Points& to)
{
    Similarity start;
    start.scale = spread(to) / spread(from);
    start.motion = best_rigid_motion(start.scale * from, to);
    return start;
}

std::vector<Similarity> rigid_starts(const Surface& moving, const Surface& fixed, int count)
{
    const Moments of_moving(moving), of_fixed(fixed);
    const Search search{moving, fixed, of_moving, of_fixed};
    const double size = of_fixed.size() / of_moving.size();
    const double unit = change_of_unit(size);
    const Vector3d shift = of_fixed.centroid - size * of_moving.centroid;
    std::vector<Similarity> starts = search.starts({size, {Matrix3d::Identity(), shift}}, count);
    constexpr double alike = 0.1; // growth does the rest
    const bool are_alike = std::abs(std::log(size / unit)) < alike;
    for (const Similarity& start : search.starts({unit, RigidMotion{}}, are_alike ? 1 : count))
        starts.push_back(start);
    return starts;
}

} // namespace shape::internal
