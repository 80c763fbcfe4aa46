// SPDX-License-Identifier: MIT

#include "libshape/report/render.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using std::numbers::pi;

constexpr int samples = 3;           ///< A pixel is the mean of samples by samples.
constexpr int buffer_size = 1 << 22; ///< Samples at once; images of more are made in bands.

Eigen::Matrix3d rotation_towards(const Vector3d& viewer, const Vector3d& right)
{
    Eigen::Matrix3d rotation;
    rotation << right.transpose(), viewer.cross(right).transpose(), viewer.transpose();
    return rotation;
}

// --- Light ----------------------------------------------------------------------------------------

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

// --- Rasterisation --------------------------------------------------------------------------------

/// Rows of samples, from the upper edge of an image.
struct Rows
{
    int begin = 0;
    int end = 0;
};

/// Calls hit(x, y, weights) for every sample in these rows whose centre lies in the triangle.
template <class Hit>
void rasterise(const std::array<Vector3f, 3>& corners, int width, Rows rows, const Hit& hit)
{
    const auto& [a, b, c] = corners;
    const float area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0.0F)
        return;
    const auto first = [](float value, int begin) {
        return std::max(begin, static_cast<int>(std::ceil(value - 0.5F)));
    };
    const auto last = [](float value, int end) {
        return std::min(end - 1, static_cast<int>(std::floor(value - 0.5F)));
    };
    const int x0 = first(std::min({a.x(), b.x(), c.x()}), 0);
    const int x1 = last(std::max({a.x(), b.x(), c.x()}), width);
    const int y0 = first(std::min({a.y(), b.y(), c.y()}), rows.begin);
    const int y1 = last(std::max({a.y(), b.y(), c.y()}), rows.end);
    const float scale = 1.0F / area;
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const float px = static_cast<float>(x) + 0.5F;
            const float py = static_cast<float>(y) + 0.5F;
            const float v =
                scale * ((px - a.x()) * (c.y() - a.y()) - (py - a.y()) * (c.x() - a.x()));
            const float w =
                scale * ((b.x() - a.x()) * (py - a.y()) - (b.y() - a.y()) * (px - a.x()));
            const float u = 1.0F - v - w;
            if (u >= 0.0F && v >= 0.0F && w >= 0.0F)
                hit(x, y, Vector3f(u, v, w));
        }
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
        for (const auto& face : faces.rowwise()) {
            const std::array<Vector3f, 3> corners{seen[static_cast<std::size_t>(face[0])],
                                                  seen[static_cast<std::size_t>(face[1])],
                                                  seen[static_cast<std::size_t>(face[2])]};
            const Vector3f depths(corners[0].z(), corners[1].z(), corners[2].z());
            rasterise(corners, size, {0, size}, [&](int x, int y, const Vector3f& weights) {
                float& texel = depth_[static_cast<std::size_t>(y * size + x)];
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
        return depth_[static_cast<std::size_t>(y * size + x)] <= p.z();
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

/// Unit normals of the corners, 3 f + c: the mean over the faces at the vertex that meet this face
/// within the crease angle, weighted by area.
std::vector<Vector3f> corner_normals(const Faces& faces, const Points& points, double crease_angle)
{
    std::vector<Vector3d> face_normals;
    for (const auto& face : faces.rowwise()) {
        const Vector3d a = points.row(face[0]);
        const Vector3d b = points.row(face[1]);
        const Vector3d c = points.row(face[2]);
        face_normals.push_back((b - a).cross(c - a));
    }
    std::vector<std::vector<std::size_t>> faces_at(static_cast<std::size_t>(points.rows()));
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        for (int c = 0; c < 3; ++c)
            faces_at[static_cast<std::size_t>(faces(f, c))].push_back(static_cast<std::size_t>(f));
    const double smooth = std::cos(crease_angle * pi / 180.0);
    std::vector<Vector3f> normals;
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
        const Vector3d& own = face_normals[static_cast<std::size_t>(f)];
        for (int c = 0; c < 3; ++c) {
            Vector3d sum = Vector3d::Zero();
            for (const std::size_t g : faces_at[static_cast<std::size_t>(faces(f, c))]) {
                const Vector3d& other = face_normals[g];
                if (own.dot(other) >= smooth * own.norm() * other.norm())
                    sum += other;
            }
            normals.emplace_back(sum.normalized().cast<float>());
        }
    }
    return normals;
}

// --- Colour ---------------------------------------------------------------------------------------

float decoded(std::uint8_t channel)
{
    const double c = channel / 255.0;
    return static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

Vector3f decoded(Colour colour)
{
    return {decoded(colour.red), decoded(colour.green), decoded(colour.blue)};
}

std::uint8_t encoded(float linear)
{
    const double c = std::clamp(static_cast<double>(linear), 0.0, 1.0);
    const double srgb = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255.0 * srgb));
}

/// What a ray through a sample meets first.
struct Sample
{
    float depth = -std::numeric_limits<float>::max();
    int face = -1;
    Vector3f weights;
};

/// A piece of surface to shade; the mean of several is one as well.
struct Patch
{
    Vector3f place = Vector3f::Zero();
    Vector3f normal = Vector3f::Zero();
    Vector3f flat_normal = Vector3f::Zero();
    Vector3f colour = Vector3f::Zero();
};

} // namespace

Eigen::Matrix3d view_rotation(const ViewDirection& direction)
{
    const double azimuth = direction.azimuth * pi / 180.0;
    const double elevation = direction.elevation * pi / 180.0;
    const Vector3d viewer(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                          std::cos(azimuth) * std::cos(elevation));
    return rotation_towards(viewer, Vector3d(std::cos(azimuth), 0.0, -std::sin(azimuth)));
}

Eigen::Matrix3d automatic_view(const Faces& faces, const Points& points)
{
    // Area-weighted, so that dense regions do not count more; +z wins ties.
    Vector3d mean = Vector3d::Zero();
    Vector3d facing = Vector3d::Zero();
    double area = 0.0;
    Points centres(faces.rows(), 3);
    Eigen::VectorXd areas(faces.rows());
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
        const Vector3d a = points.row(faces(f, 0));
        const Vector3d b = points.row(faces(f, 1));
        const Vector3d c = points.row(faces(f, 2));
        const Vector3d normal = 0.5 * (b - a).cross(c - a);
        facing += normal;
        areas[f] = normal.norm();
        centres.row(f) = (a + b + c).transpose() / 3.0;
    }
    area = areas.sum();
    mean = centres.transpose() * areas / area;
    const Points away = centres.rowwise() - mean.transpose();
    Eigen::Matrix3d spread = away.transpose() * areas.asDiagonal() * away / area;
    spread(2, 2) -= 1e-3 * spread.trace();
    Vector3d viewer = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(viewer[axis]) > std::cos(25.0 * pi / 180.0))
            viewer = std::copysign(1.0, viewer[axis]) * Vector3d::Unit(axis);
    if (std::abs(facing.dot(viewer)) > 1e-6 * area)
        viewer *= std::copysign(1.0, facing.dot(viewer));
    else {
        Eigen::Index largest = 0;
        (viewer.cwiseAbs() + Vector3d(0.0, 1e-9, 2e-9)).maxCoeff(&largest);
        viewer *= std::copysign(1.0, viewer[largest]);
    }
    // +y is up; seen from above or below, +x is right.
    const Vector3d right = Vector3d::UnitY().cross(viewer);
    return rotation_towards(viewer,
                            right.norm() > 1e-3 ? Vector3d(right.normalized()) : Vector3d::UnitX());
}

Image render_mesh(const Faces& faces, const Points& points, const RenderOptions& options)
{
    if (options.width < 1 || options.height < 1 || !(options.pixel_size > 0.0))
        throw InvalidInput(join("width, height and pixel_size are ", options.width, ", ",
                                options.height, " and ", options.pixel_size, ", must be > 0"));
    if (!options.vertex_colours.empty() &&
        static_cast<Eigen::Index>(options.vertex_colours.size()) != points.rows())
        throw InvalidInput(join("vertex_colours has ", options.vertex_colours.size(),
                                " entries, the mesh has ", points.rows(), " vertices"));
    const int width = samples * options.width;
    const int height = samples * options.height;
    std::vector<Vector3f> places; // view coordinates
    std::vector<Vector3f> seen;   // in samples from the upper left corner
    for (const auto& p : points.rowwise()) {
        places.emplace_back(p.transpose().cast<float>());
        const double step = options.pixel_size / samples;
        seen.emplace_back(static_cast<float>(0.5 * width + (p.x() - options.centre.x()) / step),
                          static_cast<float>(0.5 * height - (p.y() - options.centre.y()) / step),
                          static_cast<float>(p.z()));
    }
    const auto corners_of = [&](const std::vector<Vector3f>& of, Eigen::Index f) {
        return std::array<Vector3f, 3>{of[static_cast<std::size_t>(faces(f, 0))],
                                       of[static_cast<std::size_t>(faces(f, 1))],
                                       of[static_cast<std::size_t>(faces(f, 2))]};
    };

    /// What is seen in some rows.
    const auto sampled = [&](Rows rows) {
        std::vector<Sample> buffer(static_cast<std::size_t>(width) *
                                   static_cast<std::size_t>(rows.end - rows.begin));
        for (Eigen::Index f = 0; f < faces.rows(); ++f) {
            const std::array<Vector3f, 3> corners = corners_of(seen, f);
            const Vector3f depths(corners[0].z(), corners[1].z(), corners[2].z());
            rasterise(corners, width, rows, [&](int x, int y, const Vector3f& weights) {
                Sample& sample = buffer[static_cast<std::size_t>(y - rows.begin) *
                                            static_cast<std::size_t>(width) +
                                        static_cast<std::size_t>(x)];
                const float depth = weights.dot(depths);
                if (depth > sample.depth)
                    sample = {depth, static_cast<int>(f), weights};
            });
        }
        return buffer;
    };

    const Eigen::RowVector3d low = points.colwise().minCoeff();
    const Eigen::RowVector3d high = points.colwise().maxCoeff();
    const Vector3f centre = (0.5 * (low + high)).transpose().cast<float>();
    const float reach = static_cast<float>(0.51 * (high - low).norm());
    const std::vector<Light> lights = studio();
    std::vector<ShadowMap> shadows;
    shadows.reserve(lights.size());
    for (const Light& light : lights)
        shadows.emplace_back(faces, places, centre, reach, light.direction);

    const std::vector<Vector3f> normals = corner_normals(faces, points, options.crease_angle);
    const Vector3f surface = decoded(options.surface);
    const auto patch_of = [&](const Sample& sample) {
        const std::array<Vector3f, 3> corners = corners_of(places, sample.face);
        Patch patch;
        for (int c = 0; c < 3; ++c) {
            const float weight = sample.weights[c];
            const auto corner = static_cast<std::size_t>(c);
            patch.place += weight * corners[corner];
            patch.normal += weight * normals[3 * static_cast<std::size_t>(sample.face) + corner];
            patch.colour += weight * (options.vertex_colours.empty()
                                          ? surface
                                          : decoded(options.vertex_colours[static_cast<std::size_t>(
                                                faces(sample.face, c))]));
        }
        patch.normal.normalize();
        patch.flat_normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
        if (patch.flat_normal.z() < 0.0F) { // the back of a face
            patch.normal = -patch.normal;
            patch.flat_normal = -patch.flat_normal;
            patch.colour *= 0.55F;
        }
        return patch;
    };
    const auto shade = [&](const Patch& patch) -> Vector3f {
        // Off the surface by about two texels of a shadow map, so that it does not shade itself.
        const Vector3f above = patch.place + 0.018F * reach * patch.flat_normal;
        Vector3f light_sum = Vector3f::Zero();
        float gloss = 0.0F;
        for (std::size_t i = 0; i < lights.size(); ++i) {
            const Light& light = lights[i];
            const float cosine = patch.normal.dot(light.direction);
            if (cosine <= 0.0F || !shadows[i].lit(above))
                continue;
            light_sum += cosine * light.radiance;
            if (light.gloss > 0.0F) {
                const Vector3f half = (light.direction + Vector3f::UnitZ()).normalized();
                gloss += light.gloss * std::pow(std::max(patch.normal.dot(half), 0.0F), 24.0F);
            }
        }
        return patch.colour.cwiseProduct(light_sum) + Vector3f::Constant(0.05F * gloss);
    };

    Image image(options.width, options.height, options.background);
    const Vector3f background = decoded(options.background);
    std::vector<Sample> buffer;
    Rows rows; // in the buffer
    std::vector<Patch> patches;
    for (int y = 0; y < options.height; ++y) {
        if (samples * y >= rows.end) {
            rows = {samples * y,
                    std::min(height, samples * (y + std::max(1, buffer_size / (width * samples))))};
            buffer = sampled(rows);
        }
        for (int x = 0; x < options.width; ++x) {
            patches.clear();
            for (int i = 0; i < samples * samples; ++i) {
                const auto row = static_cast<std::size_t>(samples * y + i / samples - rows.begin);
                const auto column = static_cast<std::size_t>(samples * x + i % samples);
                const Sample& sample = buffer[row * static_cast<std::size_t>(width) + column];
                if (sample.face >= 0)
                    patches.push_back(patch_of(sample));
            }
            if (patches.empty())
                continue;
            const auto count = static_cast<float>(patches.size());
            Patch mean;
            for (const Patch& patch : patches) {
                mean.place += patch.place / count;
                mean.normal += patch.normal / count;
                mean.flat_normal += patch.flat_normal / count;
                mean.colour += patch.colour / count;
            }
            // Where the surface is smooth within the pixel, its mean is shaded, else each sample.
            const auto near_mean = [&](const Patch& patch) {
                return patch.normal.dot(mean.normal) > 0.98F &&
                       (patch.place - mean.place).norm() < 4.0 * options.pixel_size;
            };
            Vector3f sum = Vector3f::Zero();
            if (std::all_of(patches.begin(), patches.end(), near_mean))
                sum = count * shade(mean);
            else
                for (const Patch& patch : patches)
                    sum += shade(patch);
            const float all = samples * samples;
            sum = (sum + (all - count) * background) / all;
            image.at(x, y) = {encoded(sum.x()), encoded(sum.y()), encoded(sum.z())};
        }
    }
    return image;
}

} // namespace shape
