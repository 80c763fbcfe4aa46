// SPDX-License-Identifier: MIT

#include "libshape/report/studio.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "libshape/base/to_size.h"
#include "libshape/report/rasterise.h"

namespace shape::internal {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using std::numbers::pi;

struct Light
{
    Vector3f direction; ///< From the surface to the light.
    Vector3f radiance;  ///< Linear RGB.
    float gloss = 0.0F; ///< Share of the highlight.
};

/// `count` directions spread evenly over the cap of that half angle around an axis.
std::vector<Vector3d> cap_directions(const Vector3d& axis, double half_angle, int count)
{
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), axis);
    const double golden = pi * (3.0 - std::sqrt(5.0));
    std::vector<Vector3d> directions;
    for (int i = 0; i < count; ++i) {
        const double z = 1.0 - (1.0 - std::cos(half_angle)) * (i + 0.5) / count;
        const double r = std::sqrt(1.0 - z * z);
        directions.push_back(turn *
                             Vector3d(r * std::cos(golden * i), r * std::sin(golden * i), z));
    }
    return directions;
}

/// A key light from the upper left, a dome that is brighter above, a rim light from behind.
std::vector<Light> studio()
{
    std::vector<Light> lights;
    const auto add = [&](const Vector3d& direction, const Vector3d& radiance, double gloss) {
        lights.push_back(
            {direction.cast<float>(), radiance.cast<float>(), static_cast<float>(gloss)});
    };
    const std::vector<Vector3d> key =
        cap_directions(Vector3d(-0.58, 0.48, 0.66).normalized(), 0.45, 14);
    for (const Vector3d& d : key)
        add(d, Vector3d(0.98, 0.94, 0.88) / 14.0, 1.0 / 14.0);
    const std::vector<Vector3d> dome =
        cap_directions(Vector3d(0.0, 0.35, 1.0).normalized(), 1.75, 30);
    for (const Vector3d& d : dome)
        add(d, Vector3d(0.70, 0.76, 0.86) * (0.75 + 0.45 * d.y()) / 30.0, 0.0);
    const std::vector<Vector3d> rim =
        cap_directions(Vector3d(0.85, 0.35, -0.35).normalized(), 0.25, 5);
    for (const Vector3d& d : rim)
        add(d, Vector3d(0.45, 0.48, 0.55) / 5.0, 0.0);
    return lights;
}

/// What a light sees: per texel the distance of the nearest surface, larger is nearer to the light.
class ShadowMap
{
public:
    ShadowMap(const Faces& faces, const std::vector<Vector3f>& points, Vector3f centre, float reach,
              const Vector3f& direction)
        : centre_(std::move(centre)),
          direction_(direction),
          scale_(0.5F * size / reach),
          depth_(size * size, nothing)
    {
        right_ = direction.unitOrthogonal();
        up_ = direction.cross(right_);
        std::vector<Vector3f> seen;
        seen.reserve(points.size());
        for (const Vector3f& p : points)
            seen.push_back(project(p));
        for (Eigen::Index f = 0; f < faces.rows(); ++f) {
            const Triangle corners = corners_of(faces, f, seen);
            const Vector3f depths(corners[0].z(), corners[1].z(), corners[2].z());
            rasterise(corners, size, {0, size}, [&](int x, int y, const Vector3f& weights) {
                float& texel = depth_[to_size(y * size + x)];
                texel = std::max(texel, weights.dot(depths));
            });
        }
    }

    /// Whether nothing that the light sees lies in front of a point.
    [[nodiscard]] bool lit(const Vector3f& point) const
    {
        const Vector3f p = project(point);
        const int x = std::clamp(static_cast<int>(p.x()), 0, size - 1);
        const int y = std::clamp(static_cast<int>(p.y()), 0, size - 1);
        return depth_[to_size(y * size + x)] <= p.z();
    }

private:
    static constexpr int size = 256;
    static constexpr float nothing = -std::numeric_limits<float>::max();

    [[nodiscard]] Vector3f project(const Vector3f& point) const
    {
        const Vector3f d = point - centre_;
        return {0.5F * size + scale_ * right_.dot(d), 0.5F * size + scale_ * up_.dot(d),
                direction_.dot(d)};
    }

    Vector3f centre_, direction_, right_, up_;
    float scale_;
    std::vector<float> depth_;
};

std::vector<Vector3f> single_precision(const Points& points)
{
    std::vector<Vector3f> places;
    places.reserve(to_size(points.rows()));
    for (const auto& p : points.rowwise())
        places.emplace_back(p.transpose().cast<float>());
    return places;
}

} // namespace

struct Studio::State
{
    std::vector<Light> lights = studio();
    std::vector<ShadowMap> shadows; ///< One for each light.
    float reach = 0.0F;             ///< Radius of a ball around the mesh [length].
};

Studio::Studio(const Faces& faces, const Points& points) : state_(std::make_unique<State>())
{
    const Eigen::RowVector3d low = points.colwise().minCoeff();
    const Eigen::RowVector3d high = points.colwise().maxCoeff();
    const Vector3f centre = (0.5 * (low + high)).transpose().cast<float>();
    state_->reach = static_cast<float>(0.51 * (high - low).norm());
    const std::vector<Vector3f> places = single_precision(points);
    state_->shadows.reserve(state_->lights.size());
    for (const Light& light : state_->lights)
        state_->shadows.emplace_back(faces, places, centre, state_->reach, light.direction);
}

Studio::~Studio() = default;

Vector3f Studio::shade(const Patch& patch) const
{
    // Off the surface by about two texels of a shadow map, so that it does not shade itself.
    const Vector3f above = patch.place + 0.018F * state_->reach * patch.flat_normal;
    Vector3f light_sum = Vector3f::Zero();
    float gloss = 0.0F;
    for (std::size_t i = 0; i < state_->lights.size(); ++i) {
        const Light& light = state_->lights[i];
        const float cosine = patch.normal.dot(light.direction);
        if (cosine <= 0.0F || !state_->shadows[i].lit(above))
            continue;
        light_sum += cosine * light.radiance;
        if (light.gloss > 0.0F) {
            const Vector3f half = (light.direction + Vector3f::UnitZ()).normalized();
            gloss += light.gloss * std::pow(std::max(patch.normal.dot(half), 0.0F), 24.0F);
        }
    }
    return patch.colour.cwiseProduct(light_sum) + Vector3f::Constant(0.05F * gloss);
}

} // namespace shape::internal
