// SPDX-License-Identifier: MIT

#include "libshape/report/render.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
#include "libshape/report/rasterise.h"
#include "libshape/report/srgb.h"
#include "libshape/report/studio.h"

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

// --- Colour ---------------------------------------------------------------------------------------

Vector3f decoded(Colour colour)
{
    return Eigen::Vector3d(srgb_decoded(colour.red), srgb_decoded(colour.green),
                           srgb_decoded(colour.blue))
        .cast<float>();
}

// --- What is seen ---------------------------------------------------------------------------------

/// What a ray through a sample meets first.
struct Sample
{
    float depth = -std::numeric_limits<float>::max();
    int face = -1; ///< -1 where there is none.
    Vector3f weights;
};

/// The samples of an image, made a band of rows at a time.
class SampleBands
{
public:
    SampleBands(const Faces& faces, const Points& points, const RenderOptions& options)
        : faces_(faces), width_(samples * options.width), height_(samples * options.height)
    {
        const double step = options.pixel_size / samples;
        for (const auto& p : points.rowwise())
            seen_.emplace_back(
                static_cast<float>(0.5 * width_ + (p.x() - options.centre.x()) / step),
                static_cast<float>(0.5 * height_ - (p.y() - options.centre.y()) / step),
                static_cast<float>(p.z()));
    }

    /// Calls visit(sample) for the samples of a pixel that meet the mesh. Pixels go row by row, from
    /// the uppermost.
    template <class Visit>
    void for_pixel(int x, int y, const Visit& visit)
    {
        if (samples * y >= band_.end)
            fill(y);
        for (int row = samples * y; row < samples * (y + 1); ++row)
            for (int column = samples * x; column < samples * (x + 1); ++column)
                if (const Sample& sample = at(column, row); sample.face >= 0)
                    visit(sample);
    }

private:
    [[nodiscard]] Sample& at(int column, int row)
    {
        return buffer_[to_size(row - band_.begin) * to_size(width_) + to_size(column)];
    }

    /// Makes the band that starts with a row of pixels.
    void fill(int first_row)
    {
        const int rows = std::max(1, buffer_size / (width_ * samples)); // of pixels
        band_ = {samples * first_row, std::min(height_, samples * (first_row + rows))};
        buffer_.assign(to_size(width_) * to_size(band_.end - band_.begin), Sample{});
        for (Eigen::Index f = 0; f < faces_.rows(); ++f) {
            const Triangle corners = corners_of(faces_, f, seen_);
            const Vector3f depths(corners[0].z(), corners[1].z(), corners[2].z());
            rasterise(corners, width_, band_, [&](int x, int y, const Vector3f& weights) {
                Sample& sample = at(x, y);
                const float depth = weights.dot(depths);
                if (depth > sample.depth)
                    sample = {depth, static_cast<int>(f), weights};
            });
        }
    }

    const Faces& faces_;
    int width_, height_;         ///< In samples.
    std::vector<Vector3f> seen_; ///< Vertices, in samples from the upper left corner.
    Rows band_;                  ///< In the buffer.
    std::vector<Sample> buffer_;
};

// --- The surface there ----------------------------------------------------------------------------

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
    std::vector<std::vector<std::size_t>> faces_at(to_size(points.rows()));
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        for (int c = 0; c < 3; ++c)
            faces_at[to_size(faces(f, c))].push_back(to_size(f));
    const double smooth = std::cos(crease_angle * pi / 180.0);
    std::vector<Vector3f> normals;
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
        const Vector3d& own = face_normals[to_size(f)];
        for (int c = 0; c < 3; ++c) {
            Vector3d sum = Vector3d::Zero();
            for (const std::size_t g : faces_at[to_size(faces(f, c))]) {
                const Vector3d& other = face_normals[g];
                if (own.dot(other) >= smooth * own.norm() * other.norm())
                    sum += other;
            }
            normals.emplace_back(sum.normalized().cast<float>());
        }
    }
    return normals;
}

/// A mesh as what is to be shaded.
class Surface
{
public:
    Surface(const Faces& faces, const Points& points, const RenderOptions& options)
        : faces_(faces),
          normals_(corner_normals(faces, points, options.crease_angle)),
          colours_(to_size(points.rows()), decoded(options.surface))
    {
        for (const auto& p : points.rowwise())
            places_.emplace_back(p.transpose().cast<float>());
        std::transform(options.vertex_colours.begin(), options.vertex_colours.end(),
                       colours_.begin(), [](Colour colour) { return decoded(colour); });
    }

    [[nodiscard]] Patch patch(const Sample& sample) const
    {
        const Triangle corners = corners_of(faces_, sample.face, places_);
        const Triangle colours = corners_of(faces_, sample.face, colours_);
        Patch patch;
        for (std::size_t c = 0; c < 3; ++c) {
            const float weight = sample.weights[static_cast<Eigen::Index>(c)];
            patch.place += weight * corners[c];
            patch.normal += weight * normals_[3 * to_size(sample.face) + c];
            patch.colour += weight * colours[c];
        }
        patch.normal.normalize();
        patch.flat_normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
        if (patch.flat_normal.z() < 0.0F) { // the back of a face
            patch.normal = -patch.normal;
            patch.flat_normal = -patch.flat_normal;
            patch.colour *= 0.55F;
        }
        return patch;
    }

private:
    const Faces& faces_;
    std::vector<Vector3f> places_;  ///< View coordinates.
    std::vector<Vector3f> normals_; ///< One a corner, 3 f + c.
    std::vector<Vector3f> colours_; ///< One a vertex, linear RGB.
};

Patch mean_of(const std::vector<Patch>& patches)
{
    const auto count = static_cast<float>(patches.size());
    Patch mean;
    for (const Patch& patch : patches) {
        mean.place += patch.place / count;
        mean.normal += patch.normal / count;
        mean.flat_normal += patch.flat_normal / count;
        mean.colour += patch.colour / count;
    }
    return mean;
}

/// The sum of the light of some patches of one pixel. Where the surface is smooth within the pixel, their
/// mean is shaded, else each of them.
Vector3f light_of(const std::vector<Patch>& patches, const Studio& studio, double pixel_size)
{
    const Patch mean = mean_of(patches);
    // Normals within 11 degrees of the mean, and no step of depth: across an edge of the surface the mean
    // would have a normal and a place that are nowhere. Set by the looks of pictures, not measured.
    const auto near_mean = [&](const Patch& patch) {
        return patch.normal.dot(mean.normal) > 0.98F &&
               (patch.place - mean.place).norm() < 4.0 * pixel_size;
    };
    if (std::all_of(patches.begin(), patches.end(), near_mean))
        return static_cast<float>(patches.size()) * studio.shade(mean);
    Vector3f sum = Vector3f::Zero();
    for (const Patch& patch : patches)
        sum += studio.shade(patch);
    return sum;
}

void check_mesh(const Faces& faces, const Points& points)
{
    if (points.rows() == 0 || faces.rows() == 0)
        throw InvalidInput(join("the mesh has ", points.rows(), " vertices and ", faces.rows(),
                                " faces, a picture needs one of each at least"));
    for (Eigen::Index v = 0; v < points.rows(); ++v)
        if (!points.row(v).allFinite())
            throw InvalidInput(join("points: vertex ", v, " has a coordinate that is not finite"));
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        if (faces.row(f).minCoeff() < 0 || faces.row(f).maxCoeff() >= points.rows())
            throw InvalidInput(join("faces: face ", f, " names vertices ", faces(f, 0), ", ",
                                    faces(f, 1), ", ", faces(f, 2), ", must be in [0, ",
                                    points.rows() - 1, "]"));
}

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
    check_mesh(faces, points);
    // Area-weighted, so that dense regions do not count more; +z wins ties by a thousandth of the spread.
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
    // Models mostly stand along the axes: a view within 25 degrees of one is meant to be along it.
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(viewer[axis]) > std::cos(25.0 * pi / 180.0))
            viewer = std::copysign(1.0, viewer[axis]) * Vector3d::Unit(axis);
    // Open meshes show their outer side. The area vectors of closed ones cancel, but for the digits that
    // files have in single precision; these are seen along the positive axis, +z before +y before +x if equal.
    if (std::abs(facing.dot(viewer)) > 1e-6 * area)
        viewer *= std::copysign(1.0, facing.dot(viewer));
    else {
        Eigen::Index largest = 0;
        (viewer.cwiseAbs() + Vector3d(0.0, 1e-9, 2e-9)).maxCoeff(&largest);
        viewer *= std::copysign(1.0, viewer[largest]);
    }
    // +y is up; seen from above or below (within 0.06 degrees, where its last digits would decide), +x is right.
    const Vector3d right = Vector3d::UnitY().cross(viewer);
    return rotation_towards(viewer,
                            right.norm() > 1e-3 ? Vector3d(right.normalized()) : Vector3d::UnitX());
}

void check(const RenderOptions& options)
{
    constexpr int most = 32768; // coordinates of samples stay exact in float
    require(options.width >= 1 && options.width <= most, "RenderOptions.width", options.width,
            join("in [1, ", most, "]"));
    require(options.height >= 1 && options.height <= most, "RenderOptions.height", options.height,
            join("in [1, ", most, "]"));
    require(options.centre.allFinite(), "RenderOptions.centre",
            join(options.centre.x(), ", ", options.centre.y()), "finite");
    require_positive(options.pixel_size, "RenderOptions.pixel_size");
    require_not_negative(options.crease_angle, "RenderOptions.crease_angle");
}

Image render_mesh(const Faces& faces, const Points& points, const RenderOptions& options)
{
    check(options);
    check_mesh(faces, points);
    if (!options.vertex_colours.empty() &&
        static_cast<Eigen::Index>(options.vertex_colours.size()) != points.rows())
        throw InvalidInput(join("vertex_colours has ", options.vertex_colours.size(),
                                " entries, the mesh has ", points.rows(), " vertices"));
    Image image(options.width, options.height, options.background);
    const Studio studio(faces, points);
    const Surface surface(faces, points, options);
    const Vector3f background = decoded(options.background);
    SampleBands bands(faces, points, options);
    std::vector<Patch> patches; // of a pixel
    for (int y = 0; y < options.height; ++y)
        for (int x = 0; x < options.width; ++x) {
            patches.clear();
            bands.for_pixel(
                x, y, [&](const Sample& sample) { patches.push_back(surface.patch(sample)); });
            if (patches.empty())
                continue;
            const float all = samples * samples;
            const auto count = static_cast<float>(patches.size());
            const Vector3f light =
                (light_of(patches, studio, options.pixel_size) + (all - count) * background) / all;
            image.at(x, y) = {srgb_encoded(light.x()), srgb_encoded(light.y()),
                              srgb_encoded(light.z())};
        }
    return image;
}

} // namespace shape
