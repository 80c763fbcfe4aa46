// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libshape/base/format.h"
#include "libshape/synthetic/generators.h"
#include "libshape/synthetic/grids.h"
#include "libshape/synthetic/profiles.h"

namespace shape::internal::synthetic {
namespace {

using std::numbers::pi;

// A life-size arm in centimetres: shoulder at 0, elbow, wrist, finger tips.
constexpr double length = 62.0;
constexpr double arm_radius = 4.5;
constexpr double elbow = 29.0;

/// Angle 0 is the inner side of the elbow (the biceps); `flexed` is 0 straight, 1 bent.
Eigen::Vector3d arm_point(const TubeVertex& vertex, const Bend& bend, double flexed)
{
    const double x = vertex.along;
    const double inner = std::cos(vertex.angle);
    const double side = std::sin(vertex.angle);
    double r = arm_radius + 1.2 * bump(x, 2.0, 6.0) // shoulder
               - 0.6 * bump(x, elbow, 3.5)          // elbow
               - 1.9 * ramp(x, 38.0, 50.0)          // wrist
               + 0.5 * bump(x, 36.0, 5.0);          // forearm
    r += (0.7 + 1.3 * flexed) * bump(x, 16.0 - 1.5 * flexed, 4.5) * std::max(inner, 0.0) * inner;
    r += (0.6 - 0.4 * flexed) * bump(x, 13.0, 6.0) * std::max(-inner, 0.0) * -inner;
    r += (0.3 + 0.9 * flexed) * bump(x, elbow + 0.5, 2.2) * std::pow(std::max(-inner, 0.0), 4);
    r += 0.6 * bump(x, 35.0, 4.0) * side * side;
    // The hand: flat across the bending plane, wide in it.
    const double hand = ramp(x, 49.0, 57.0);
    const double thickness = 1.0 - 0.45 * hand;
    const double width = 1.0 + 0.65 * hand - 0.35 * ramp(x, 59.0, 66.0);
    const CurveFrame frame = frame_on(bend, x);
    return frame.origin +
           vertex.fill * r * (width * inner * frame.normal + thickness * side * frame.binormal);
}

} // namespace

Collection make_arm(const SyntheticOptions& options)
{
    const Tube grid = tube({.length = length, .radius = arm_radius, .vertices = options.vertices});
    Members members(grid.faces, {"bend_deg"});
    for (int pose = 0; pose < options.count; ++pose) {
        const double flexed = static_cast<double>(pose) / (options.count - 1);
        const Bend bend{.start = elbow - 6.0, .length = 12.0, .angle = flexed * pi / 2.0};
        std::string name = pose == 0 ? "arm_straight" : "arm_bent";
        if (pose > 0 && pose + 1 < options.count)
            name = join("arm_", padded(pose, 4));
        members.add(
            std::move(name),
            place(grid, [&](const TubeVertex& vertex) { return arm_point(vertex, bend, flexed); }),
            {join(90.0 * flexed)});
    }
    return members.take();
}

Collection make_thin_cylinder(const SyntheticOptions& options)
{
    // Triangles twelve times as long as wide.
    const double axis = 20.0;
    const Tube grid =
        tube({.length = axis, .radius = 1.0, .vertices = options.vertices, .stretch = 12.0});
    Members members(grid.faces, {"bend_deg"});
    for (int pose = 0; pose < options.count; ++pose) {
        const double turn = pi / 2.0 * pose / (options.count - 1);
        const Bend bend{.start = 0.0, .length = axis, .angle = turn};
        std::string name = pose == 0 ? "thin_straight" : "thin_bent";
        if (pose > 0 && pose + 1 < options.count)
            name = join("thin_", padded(pose, 4));
        members.add(std::move(name),
                    place(grid,
                          [&](const TubeVertex& v) {
                              return frame_on(bend, v.along).around(v.fill, v.angle);
                          }),
                    {join(180.0 / pi * turn)});
    }
    return members.take();
}

} // namespace shape::internal::synthetic
