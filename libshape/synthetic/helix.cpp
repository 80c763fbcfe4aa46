// SPDX-License-Identifier: MIT

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/synthetic/generators.h"
#include "libshape/synthetic/grids.h"

namespace shape::internal::synthetic {
namespace {

using std::numbers::pi;

// Radius of the coil 1, rise of a turn, radius of the tube.
constexpr double rise = 0.8;
constexpr double tube_radius = 0.2;

/// Arc length of one turn.
double turn_length()
{
    return std::hypot(2.0 * pi, rise);
}

/// Around the +y axis; the frame does not turn about the tangent, so that a tube along the curve
/// keeps its rings and shears nowhere.
CurveFrame frame_on_helix(double along)
{
    const double t = 2.0 * pi * along / turn_length();
    const double climb = rise / turn_length();
    const double sweep = 2.0 * pi / turn_length();
    const Eigen::Vector3d out(std::cos(t), 0.0, -std::sin(t));
    const Eigen::Vector3d forward(-std::sin(t), 0.0, -std::cos(t));
    const Eigen::Vector3d tangent = sweep * forward + climb * Eigen::Vector3d::UnitY();
    const Eigen::Vector3d normal = -out;
    const Eigen::Vector3d binormal = tangent.cross(normal);
    // The Frenet frame turns with the torsion climb * sweep (coil radius 1).
    const double back = -climb * sweep * along;
    return {out + climb * along * Eigen::Vector3d::UnitY(), tangent,
            std::cos(back) * normal + std::sin(back) * binormal,
            std::cos(back) * binormal - std::sin(back) * normal};
}

struct Pair
{
    Tube grid;
    Points cylinder;
    Points helix;
};

Pair cylinder_and_helix(const SyntheticOptions& options)
{
    const int fewest = 200 * options.count; // a coarser tube folds over where it is wound
    Pair pair{tube({.length = options.count * turn_length(),
                    .radius = tube_radius,
                    .vertices = std::max(options.vertices, fewest)}),
              {},
              {}};
    pair.cylinder = place(pair.grid, [](const TubeVertex& v) {
        return frame_on(Bend{}, v.along).around(tube_radius * v.fill, v.angle);
    });
    pair.helix = place(pair.grid, [](const TubeVertex& v) {
        return frame_on_helix(v.along).around(tube_radius * v.fill, v.angle);
    });
    return pair;
}

} // namespace

Collection make_helix(const SyntheticOptions& options)
{
    const Pair pair = cylinder_and_helix(options);
    Members members(pair.grid.faces, {"turns"});
    members.add("cylinder", pair.cylinder, {"0"});
    members.add("helix", pair.helix, {join(options.count)});
    return members.take();
}

Collection make_noisy_helix(const SyntheticOptions& options)
{
    const Pair pair = cylinder_and_helix(options);
    const Topology topology(pair.grid.faces, static_cast<int>(pair.cylinder.rows()));
    const double sigma = 0.08 * edge_lengths(topology, pair.cylinder).mean();
    Random random(options.seed);
    const auto with_noise = [&](Points points) {
        for (Eigen::Index i = 0; i < points.size(); ++i)
            points.data()[i] += sigma * random.normal();
        return points;
    };
    Members members(pair.grid.faces, {"turns"});
    members.add("noisy_cylinder", with_noise(pair.cylinder), {"0"});
    members.add("noisy_helix", with_noise(pair.helix), {join(options.count)});
    return members.take();
}

} // namespace shape::internal::synthetic
