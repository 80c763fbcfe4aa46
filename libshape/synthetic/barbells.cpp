// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/synthetic/generators.h"
#include "libshape/synthetic/grids.h"

namespace shape::internal::synthetic {
namespace {

using std::numbers::pi;

enum class Ends
{
    Round, ///< Spheres.
    Lobed, ///< Knobs with four lobes.
};

// The grid is a tube that holds an end, the bar and an end.
constexpr double end_length = 2.4;
constexpr double bar_radius = 0.3;
// Triangles of a tube of radius 1: on a bar of length sqrt(12), the mean of 1 and 12, they are as
// long as they are wide. With fewer rings plain length differences would count the bar for more.
const double bar_length = std::sqrt(12.0) / bar_radius;

/// A point of an end that points along +x and joins the bar at x = 0.
/// @param along  From the pole of the cap at -1 to end_length at the bar.
Eigen::Vector3d end_point(Ends ends, double along, double angle)
{
    // The angle of the meridian seen from the centre of the sphere, 0 at the pole.
    const double last = pi - std::asin(bar_radius);
    const double share =
        along < 0.0 ? std::acos(std::min(-along, 1.0)) / pi : 0.5 + 0.5 * along / end_length;
    const double swept = last * share;
    double x = std::cos(last) - std::cos(swept);
    double r = std::sin(swept);
    if (ends == Ends::Lobed) {
        r += std::max(r - bar_radius * share, 0.0) * (0.15 + 0.35 * std::cos(4.0 * angle));
        x *= 0.75;
    }
    return {x, r * std::cos(angle), r * std::sin(angle)};
}

Eigen::Vector3d barbell_point(const TubeVertex& v, Ends ends, double bar)
{
    const double tube_length = 2.0 * end_length + bar_length;
    if (v.along <= end_length)
        return end_point(ends, v.along, v.angle);
    const double to_end = tube_length - v.along;
    if (to_end <= end_length) {
        const Eigen::Vector3d p = end_point(ends, to_end, v.angle);
        return {bar - p.x(), p.y(), p.z()};
    }
    return {bar * (v.along - end_length) / bar_length, bar_radius * std::cos(v.angle),
            bar_radius * std::sin(v.angle)};
}

/// Two bars: a short and a long one. More: in equal ratios from 1 to 12.
std::vector<double> bar_lengths(int count)
{
    if (count == 2)
        return {2.0, 6.0};
    std::vector<double> bars;
    for (int i = 0; i < count; ++i)
        bars.push_back(std::pow(12.0, i / (count - 1.0)));
    return bars;
}

} // namespace

Collection make_barbells(const SyntheticOptions& options)
{
    if (options.count % 2 != 0)
        throw InvalidInput(join("dataset 'barbells': count is ", options.count,
                                ", must be even: each bar has two kinds of ends"));
    const std::vector<double> bars = bar_lengths(options.count / 2);
    const Tube grid = tube(
        {.length = 2.0 * end_length + bar_length, .radius = 1.0, .vertices = options.vertices});
    Members members(grid.faces, {"ends", "bar"});
    for (const Ends ends : {Ends::Round, Ends::Lobed})
        for (std::size_t i = 0; i < bars.size(); ++i) {
            const double bar = bars[i];
            const std::string kind = ends == Ends::Round ? "a" : "b";
            const std::string size = bars.size() > 2 ? padded(static_cast<int>(i), 2)
                                     : i == 0        ? "short"
                                                     : "long";
            members.add(
                "barbell_" + kind + "_" + size,
                place(grid, [&](const TubeVertex& v) { return barbell_point(v, ends, bar); }),
                {kind, size});
        }
    return members.take();
}

} // namespace shape::internal::synthetic
