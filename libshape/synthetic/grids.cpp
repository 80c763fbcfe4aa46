// SPDX-License-Identifier: MIT

#include "libshape/synthetic/grids.h"

#include "libshape/base/require.h"
#include "libshape/base/stop.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace shape::internal::synthetic {
namespace {

using std::numbers::pi;
using FaceList = std::vector<std::array<int, 3>>;

int disc_size(int rings)
{
    return 1 + 3 * rings * (rings + 1);
}

/// Faces of the disc; vertex(ring, index) numbers the vertices, indices run around cyclically.
template <class Vertex>
void add_disc(int rings, const Vertex& vertex, FaceList& faces)
{
    for (int ring = 1; ring <= rings; ++ring)
        for (int sector = 0; sector < 6; ++sector)
            for (int i = 0; i < ring; ++i) {
                const int outer = sector * ring + i;
                const int inner = sector * (ring - 1) + i;
                faces.push_back(
                    {vertex(ring, outer), vertex(ring, outer + 1), vertex(ring - 1, inner)});
                if (i + 1 < ring)
                    faces.push_back({vertex(ring - 1, inner), vertex(ring, outer + 1),
                                     vertex(ring - 1, inner + 1)});
            }
}

/// Number of a disc's vertex when rings are numbered from the centre.
int disc_vertex(int ring, int index)
{
    return ring == 0 ? 0 : disc_size(ring - 1) + index % (6 * ring);
}

} // namespace

Faces to_faces(const std::vector<std::array<int, 3>>& list)
{
    Faces faces(static_cast<Eigen::Index>(list.size()), 3);
    for (std::size_t f = 0; f < list.size(); ++f)
        faces.row(static_cast<Eigen::Index>(f)) << list[f][0], list[f][1], list[f][2];
    return faces;
}

double DiscVertex::angle() const
{
    return ring == 0 ? 0.0 : 2.0 * pi * index / (6.0 * ring);
}

Disc disc(int rings)
{
    FaceList faces;
    add_disc(rings, disc_vertex, faces);
    Disc result{to_faces(faces), {{0, 0}}};
    for (int ring = 1; ring <= rings; ++ring)
        for (int index = 0; index < 6 * ring; ++index)
            result.vertices.push_back({ring, index});
    return result;
}

void check(const TubeOptions& options)
{
    require_positive(options.length, "TubeOptions.length");
    require_positive(options.radius, "TubeOptions.radius");
    require_at_least(1, options.vertices, "TubeOptions.vertices");
    require_positive(options.stretch, "TubeOptions.stretch");
}

Tube tube(const TubeOptions& options)
{
    check(options);
    // m rings in each cap, n steps of 6 m vertices between the rims. Edges around are
    // 2 pi r / 6 m long; rows of equilateral triangles lie sqrt(3)/2 of that apart.
    const double row = std::sqrt(3.0) / 2.0 * 2.0 * pi * options.radius / 6.0 * options.stretch;
    const double wanted = options.vertices;
    const int m = std::max(
        2, static_cast<int>(std::lround(std::sqrt(wanted / (6.0 + 6.0 * options.length / row)))));
    const int around = 6 * m;
    const int caps = 2 * disc_size(m);
    const int n = std::max(
        2,
        1 + static_cast<int>(std::lround(static_cast<double>(options.vertices - caps) / around)));

    Tube result;
    FaceList faces;
    const auto add_cap = [&](bool top) {
        for (const DiscVertex& v : disc(m).vertices) {
            const double polar = pi / 2.0 * v.ring / m;
            const double beyond = options.radius * std::cos(polar);
            const double stagger = top && n % 2 == 1 ? pi / around : 0.0;
            result.vertices.push_back(
                {top ? options.length + beyond : -beyond, v.angle() + stagger, std::sin(polar)});
        }
    };
    // The rims of the caps are the first and the last ring of the tube.
    add_cap(false);
    add_disc(
        m, [](int ring, int index) { return disc_vertex(ring, index); }, faces);
    for (std::array<int, 3>& face : faces)
        std::swap(face[1], face[2]);
    const int rings_start = disc_size(m);
    for (int step = 1; step < n; ++step)
        for (int j = 0; j < around; ++j)
            result.vertices.push_back({options.length * step / n,
                                       2.0 * pi * (j + (step % 2 == 1 ? 0.5 : 0.0)) / around, 1.0});
    const int top_start = static_cast<int>(result.vertices.size());
    add_cap(true);
    add_disc(
        m, [&](int ring, int index) { return top_start + disc_vertex(ring, index); }, faces);

    const auto ring_vertex = [&](int step, int j) {
        if (step == 0)
            return disc_vertex(m, j);
        if (step == n)
            return top_start + disc_vertex(m, j);
        return rings_start + (step - 1) * around + j % around;
    };
    for (int step = 0; step < n; ++step)
        for (int j = 0; j < around; ++j) {
            const int low = ring_vertex(step, j);
            const int low_next = ring_vertex(step, j + 1);
            const int high = ring_vertex(step + 1, j);
            const int high_next = ring_vertex(step + 1, j + 1);
            // Odd rings are half a step ahead.
            if (step % 2 == 0)
                faces.insert(faces.end(), {{low, low_next, high}, {high, low_next, high_next}});
            else
                faces.insert(faces.end(), {{low, low_next, high_next}, {low, high_next, high}});
        }
    result.faces = to_faces(faces);
    return result;
}

Eigen::Vector3d CurveFrame::around(double radius, double angle) const
{
    return origin + radius * (std::cos(angle) * normal + std::sin(angle) * binormal);
}

CurveFrame frame_on(const Bend& bend, double along)
{
    const double curvature = bend.angle / bend.length;
    const double on_arc = std::clamp(along - bend.start, 0.0, bend.length);
    const double turn = curvature * on_arc;
    // Chord of the arc: sin(turn)/curvature and (1 - cos(turn))/curvature without cancellation.
    const double half = turn / 2.0;
    const double chord = half == 0.0 ? on_arc : on_arc * std::sin(half) / half;
    const Eigen::Vector3d tangent(std::cos(turn), std::sin(turn), 0.0);
    Eigen::Vector3d origin(std::min(along, bend.start) + chord * std::cos(half),
                           chord * std::sin(half), 0.0);
    origin += std::max(along - bend.start - bend.length, 0.0) * tangent;
    return {origin, tangent, Eigen::Vector3d(-std::sin(turn), std::cos(turn), 0.0),
            Eigen::Vector3d::UnitZ()};
}

Points place(const Tube& tube, const std::function<Eigen::Vector3d(const TubeVertex&)>& position)
{
    Points points(static_cast<Eigen::Index>(tube.vertices.size()), 3);
    for (std::size_t v = 0; v < tube.vertices.size(); ++v) {
        throw_if_stop_requested();
        points.row(static_cast<Eigen::Index>(v)) = position(tube.vertices[v]).transpose();
    }
    return points;
}

} // namespace shape::internal::synthetic
