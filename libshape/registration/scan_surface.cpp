// SPDX-License-Identifier: MIT

#include "libshape/registration/scan_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/vertex_normals.h"

namespace shape::internal {

using Eigen::Vector3d;

Surface::Surface(Points vertices, Faces triangles)
    : points(std::move(vertices)),
      faces(std::move(triangles)),
      normals(vertex_normals(points, faces)),
      on_rim(to_size(points.rows()), 0),
      rims(find_rims(faces)),
      tree(points, faces)
{
    for (const Rims::Edge& edge : rims.edges)
        on_rim[to_size(edge.from)] = on_rim[to_size(edge.to)] = 1;
}

bool Surface::ends_at(const SurfacePoint& point) const
{
    if (point.barycentric.minCoeff() > 1e-9)
        return false;
    for (int k = 0; k < 3; ++k)
        if (point.barycentric[k] > 0.0 && on_rim[to_size(faces(point.face, k))] != 0)
            return true;
    return false;
}

Vector3d Surface::normal_at(const SurfacePoint& point) const
{
    Vector3d normal = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
        normal += point.barycentric[k] * normals.row(faces(point.face, k)).transpose();
    return normal.stableNormalized();
}

std::pair<Faces, int> oriented_like(const Points& points, const Faces& faces,
                                    const Surface& reference)
{
    // Patches: a union of faces over edges that exactly two run through, once each way.
    struct Side
    {
        int low, high, face, up;
    };
    std::vector<Side> sides;
    sides.reserve(to_size(faces.size()));
    for (int f = 0; f < faces.rows(); ++f)
        for (int k = 0; k < 3; ++k) {
            const int a = faces(f, k), b = faces(f, (k + 1) % 3);
            sides.push_back({std::min(a, b), std::max(a, b), f, a < b ? 1 : 0});
        }
    const auto key = [](const Side& s) { return std::pair(s.low, s.high); };
    std::sort(sides.begin(), sides.end(), [&](const Side& a, const Side& b) {
        return key(a) != key(b) ? key(a) < key(b) : a.face < b.face;
    });
    std::vector<int> parent(to_size(faces.rows()));
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int f) {
        while (parent[to_size(f)] != f)
            f = parent[to_size(f)] = parent[to_size(parent[to_size(f)])];
        return f;
    };
    for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
        for (next = i + 1; next < sides.size() && key(sides[next]) == key(sides[i]);)
            ++next;
        if (next == i + 2 && sides[i].up != sides[i + 1].up) {
            const auto [low, high] = std::minmax({root(sides[i].face), root(sides[i + 1].face)});
            parent[to_size(high)] = low;
        }
    }
    // Patches vote by some 20,000 faces in all: nearest points of every face of a large scan would take seconds.
    const auto stride = std::max<Eigen::Index>(1, faces.rows() / 20000);
    std::vector<double> votes(to_size((faces.rows() + stride - 1) / stride), 0.0);
    parallel_for(votes.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto face = faces.row(static_cast<Eigen::Index>(i) * stride);
            const Vector3d a = points.row(face[0]), b = points.row(face[1]),
                           c = points.row(face[2]);
            const SurfacePoint near = reference.tree.nearest((a + b + c) / 3.0);
            votes[i] = (b - a).cross(c - a).dot(reference.normal_at(near));
        }
    });
    std::vector<double> sums(parent.size(), 0.0);
    std::vector<double> sizes(parent.size(), 0.0);
    for (std::size_t i = 0; i < votes.size(); ++i) {
        const auto patch = to_size(root(static_cast<int>(i) * static_cast<int>(stride)));
        sums[patch] += votes[i];
        sizes[patch] += std::abs(votes[i]);
    }
    // A limb in another pose lies next to anything: only a clear majority counts.
    constexpr double clear_majority = 0.6;
    std::pair<Faces, int> result{faces, 0};
    for (int f = 0; f < faces.rows(); ++f) {
        const auto patch = to_size(root(f));
        if (sums[patch] < -clear_majority * sizes[patch]) {
            std::swap(result.first(f, 1), result.first(f, 2));
            ++result.second;
        }
    }
    return result;
}

} // namespace shape::internal
