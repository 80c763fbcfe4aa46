// SPDX-License-Identifier: MIT

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/synthetic/generators.h"
#include "libshape/synthetic/grids.h"
#include "libshape/synthetic/profiles.h"

namespace shape::internal::synthetic {
namespace {

using std::numbers::pi;

// The grid [mm]: knee end, shaft, hip end; the cap of the hip end is the femoral head.
constexpr double knee_end = 70.0;
constexpr double grid_shaft = 250.0;
constexpr double hip_end = 82.0;
constexpr double head_radius = 22.0;

struct Bone
{
    double shaft = grid_shaft;            ///< Length of the shaft [mm].
    double girth = 1.0;                   ///< The shaft is this thick, relative to the usual.
    double condyles = 1.0;                ///< Width of the knee end, relative.
    double trochanter = 1.0;              ///< Height of the great trochanter, relative.
    double neck_turn = 52.0 * pi / 180.0; ///< Between shaft and neck [rad].
};

Eigen::Vector3d bone_point(const TubeVertex& v, const Bone& bone)
{
    const double above_knee = v.along;
    const double above_shaft = v.along - knee_end - grid_shaft;
    const double shaft_share = std::clamp((v.along - knee_end) / grid_shaft, 0.0, 1.0);
    const double along = v.along + shaft_share * (bone.shaft - grid_shaft);
    const double medial = std::cos(v.angle);

    const double flare = 1.0 - ramp(above_knee, -5.0, 65.0);
    const double neck = ramp(above_shaft, 56.0, 76.0);
    const double core = (1.0 - flare) * (1.0 - neck) * 13.5 * bone.girth + neck * head_radius;
    const double great =
        bone.trochanter * bump(above_shaft, 20.0, 8.0) * std::pow(std::max(-medial, 0.0), 2);
    const double small = bump(above_shaft, 2.0, 8.0) * std::pow(std::max(medial, 0.0), 4);
    const double radius = core + 4.0 * bump(above_shaft, 14.0, 12.0) + 15.0 * great + 5.0 * small;
    const double width = v.fill * (radius + 38.0 * bone.condyles * flare);
    const double depth = v.fill * (radius + 27.0 * flare);

    const Bend bend{.start = knee_end + bone.shaft + 8.0, .length = 34.0, .angle = bone.neck_turn};
    const CurveFrame frame = frame_on(bend, along);
    Eigen::Vector3d p =
        frame.origin + width * medial * frame.normal + depth * std::sin(v.angle) * frame.binormal;
    const double lateral = width * medial;
    p.x() += 12.0 * great; // the trochanter's tip
    p.x() += 16.0 * bump(lateral, 0.0, 9.0) * flare * ramp(-above_knee, -25.0, 12.0); // notch
    p.z() += 9.0 * flare;                                    // condyles stand back
    p.z() -= 10.0 * std::pow(std::sin(pi * shaft_share), 2); // shaft bows forward
    // Along the shaft is up, the neck points to +x, the front to +z.
    return {p.y(), p.x(), -p.z()};
}

} // namespace

Collection make_femurs(const SyntheticOptions& options)
{
    const Tube grid = tube({.length = knee_end + grid_shaft + hip_end,
                            .radius = head_radius,
                            .vertices = options.vertices});
    Members members(grid.faces, {"kind", "ends", "shaft_mm"});
    const auto add = [&](const std::string& name, const std::string& kind, const std::string& ends,
                         const Bone& bone) {
        members.add(name, place(grid, [&](const TubeVertex& v) { return bone_point(v, bone); }),
                    {kind, ends, std::to_string(std::lround(bone.shaft))});
    };
    const auto stout = [](double shaft) {
        return Bone{
            .shaft = shaft, .condyles = 1.3, .trochanter = 1.8, .neck_turn = 36.0 * pi / 180.0};
    };
    struct Sketch
    {
        std::string name;
        std::string ends;
        Bone bone;
    };
    const std::vector<Sketch> sketches{{"femur_short", "slender", {.shaft = 200.0}},
                                       {"femur_long", "slender", {.shaft = 340.0}},
                                       {"femur_stout_short", "stout", stout(200.0)},
                                       {"femur_stout_long", "stout", stout(340.0)}};
    const int drawn = std::min(options.count, static_cast<int>(sketches.size()));
    for (const Sketch& sketch : std::span(sketches).first(to_size(drawn)))
        add(sketch.name, "sketch", sketch.ends, sketch.bone);
    Random random(options.seed);
    const auto around = [&](double mean, double spread) {
        return mean + spread * std::clamp(random.normal(), -2.5, 2.5);
    };
    for (int i = 0; i + drawn < options.count; ++i) {
        Bone bone;
        bone.shaft = around(270.0, 25.0);
        bone.girth = around(1.0, 0.07);
        bone.condyles = around(1.0, 0.06);
        bone.trochanter = around(1.0, 0.15);
        bone.neck_turn = around(52.0, 4.0) * pi / 180.0;
        add("femur_" + padded(i, 3), "individual", "own", bone);
    }
    return members.take();
}

} // namespace shape::internal::synthetic
