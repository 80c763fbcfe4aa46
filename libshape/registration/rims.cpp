// SPDX-License-Identifier: MIT

#include "libshape/registration/rims.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <utility>

#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

using Eigen::Vector3d;

std::vector<Rims::Edge> edges_of(const Rims& rims, int loop)
{
    std::vector<Rims::Edge> edges;
    for (const Rims::Edge& edge : rims.edges)
        if (edge.loop == loop)
            edges.push_back(edge);
    return edges;
}

Points outward_of(const std::vector<Rims::Edge>& edges, const Points& points)
{
    Points outward(std::ssize(edges), 3);
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const Vector3d from = points.row(edges[i].from), to = points.row(edges[i].to),
                       opposite = points.row(edges[i].opposite);
        const Vector3d along = (to - from).stableNormalized();
        const Vector3d away = from - opposite;
        outward.row(static_cast<Eigen::Index>(i)) =
            (away - away.dot(along) * along).stableNormalized();
    }
    return outward;
}

Faces as_faces(const std::vector<Rims::Edge>& edges)
{
    Faces faces(std::ssize(edges), 3);
    for (std::size_t i = 0; i < edges.size(); ++i)
        faces.row(static_cast<Eigen::Index>(i)) << edges[i].from, edges[i].to, edges[i].to;
    return faces;
}

} // namespace

Rims find_rims(const Faces& faces)
{
    struct Side
    {
        int low, high, halfedge;
    };
    std::vector<Side> sides;
    sides.reserve(to_size(faces.size()));
    for (int f = 0; f < faces.rows(); ++f)
        for (int k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax({faces(f, k), faces(f, (k + 1) % 3)});
            sides.push_back({low, high, 3 * f + k});
        }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::pair(a.low, a.high) != std::pair(b.low, b.high)
                   ? std::pair(a.low, a.high) < std::pair(b.low, b.high)
                   : a.halfedge < b.halfedge;
    });
    Rims rims;
    for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
        for (next = i + 1; next < sides.size() && sides[next].low == sides[i].low &&
                           sides[next].high == sides[i].high;)
            ++next;
        if (next > i + 1)
            continue;
        const int f = sides[i].halfedge / 3, k = sides[i].halfedge % 3;
        rims.edges.push_back({faces(f, k), faces(f, (k + 1) % 3), faces(f, (k + 2) % 3), -1});
    }
    // Loops: edges joined at their vertices.
    const int vertex_count = faces.size() > 0 ? faces.maxCoeff() + 1 : 0;
    std::vector<int> parent(to_size(vertex_count));
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int v) {
        while (parent[to_size(v)] != v)
            v = parent[to_size(v)] = parent[to_size(parent[to_size(v)])];
        return v;
    };
    for (const Rims::Edge& edge : rims.edges) {
        const auto [low, high] = std::minmax({root(edge.from), root(edge.to)});
        parent[to_size(high)] = low;
    }
    std::vector<int> number(parent.size(), -1);
    for (Rims::Edge& edge : rims.edges) {
        int& loop = number[to_size(root(edge.from))];
        if (loop < 0)
            loop = rims.loop_count++;
        edge.loop = loop;
    }
    return rims;
}

RimCurve::RimCurve(const Rims& rims, int loop, const Points& points)
    : edges(edges_of(rims, loop)),
      outward(outward_of(edges, points)),
      tree(points, as_faces(edges), outward)
{
    for (const Rims::Edge& edge : edges)
        length += (points.row(edge.to) - points.row(edge.from)).norm();
}

} // namespace shape::internal
