// SPDX-License-Identifier: MIT

#include "libshape/mesh/coincident_vertices.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/rounded.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/coordinate_spacing.h"
#include "libshape/mesh/partition.h"

namespace shape {
using namespace internal;
namespace {

void check(std::span<const Points> meshes)
{
    if (meshes.empty())
        throw InvalidInput("meshes is empty, must hold at least one");
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        if (meshes[i].rows() != meshes.front().rows())
            throw InvalidInput(join("meshes[", i, "] has ", meshes[i].rows(),
                                    " vertices, meshes[0] ", meshes.front().rows()));
        if (!meshes[i].allFinite())
            throw InvalidInput(join("meshes[", i, "] has a coordinate that is not finite"));
    }
}

/// The groups among some vertices, ascending: two lie on one another if each is within the reach of the other. They are
/// sorted along a direction in which hardly two of different places are that near, so that few come into question for
/// each.
/// @param reach  Of each vertex [length].
std::vector<VertexGroup> groups_among(const VertexGroup& vertices, const Points& points,
                                      const Eigen::VectorXd& reach)
{
    constexpr int most_joined = 64; // of a heap in one place the rest are joined by way of these
    const Eigen::Vector3d direction(0.4472135954999579, 0.7071067811865476, 0.5477225575051661);
    std::vector<std::pair<double, int>> order; // place along the direction, and entry of vertices
    for (const int v : vertices)
        order.emplace_back(points.row(v) * direction, static_cast<int>(order.size()));
    std::sort(order.begin(), order.end());
    const auto vertex = [&](std::size_t place) { return vertices[to_size(order[place].second)]; };
    Partition partition(vertices.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const int v = vertex(i);
        int joined = 0;
        for (std::size_t j = i + 1; j < order.size() && joined < most_joined &&
                                    order[j].first - order[i].first <= reach[v];
             ++j) {
            const int w = vertex(j);
            if ((points.row(v) - points.row(w)).norm() > std::min(reach[v], reach[w]))
                continue;
            partition.unite(order[i].second, order[j].second);
            ++joined;
        }
    }
    std::vector<VertexGroup> groups(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i)
        groups[to_size(partition.root(static_cast<int>(i)))].push_back(vertices[i]);
    std::erase_if(groups, [](const VertexGroup& group) { return group.size() < 2; });
    return groups;
}

/// What of some groups lies on one another in all meshes, by the lowest vertex.
std::vector<VertexGroup> groups_in_all(
    std::vector<VertexGroup> groups, std::span<const Points> meshes,
    const std::function<Eigen::VectorXd(const Points& points)>& reach_of)
{
    for (const Points& points : meshes) {
        if (groups.empty())
            break;
        const Eigen::VectorXd reach = reach_of(points);
        std::vector<VertexGroup> parts;
        for (const VertexGroup& group : groups)
            for (VertexGroup& part : groups_among(group, points, reach))
                parts.push_back(std::move(part));
        groups = std::move(parts);
    }
    std::sort(groups.begin(), groups.end());
    return groups;
}

/// The ends of edges that one face alone has, ascending.
VertexGroup boundary_vertices(const Faces& faces)
{
    std::vector<std::pair<int, int>> edges;
    for (const auto& face : faces.rowwise())
        for (int c = 0; c < 3; ++c)
            if (face[c] != face[(c + 1) % 3])
                edges.push_back(std::minmax({face[c], face[(c + 1) % 3]}));
    std::sort(edges.begin(), edges.end());
    VertexGroup vertices;
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        while (end < edges.size() && edges[end] == edges[begin])
            ++end;
        if (end - begin == 1)
            vertices.insert(vertices.end(), {edges[begin].first, edges[begin].second});
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
}

/// The shortest edge at each vertex [length]; infinite where there is none.
Eigen::VectorXd shortest_edges(const Faces& faces, const Points& points)
{
    Eigen::VectorXd shortest =
        Eigen::VectorXd::Constant(points.rows(), std::numeric_limits<double>::infinity());
    for (const auto& face : faces.rowwise())
        for (int c = 0; c < 3; ++c) {
            const int v = face[c];
            const int w = face[(c + 1) % 3];
            const double length = (points.row(v) - points.row(w)).norm();
            shortest[v] = std::min(shortest[v], length);
            shortest[w] = std::min(shortest[w], length);
        }
    return shortest;
}

/// How near to each vertex another one of a seam is: within the tolerance [1], a tenth of the shortest edges at both
/// allowing, or as near as coordinates tell anywhere.
Eigen::VectorXd reach_of(const Faces& faces, const Points& points, double tolerance)
{
    // On rims of real faces, hands and raw scans no two vertices are nearer than 0.6 of the shortest edges there.
    constexpr double share_of_edge = 0.1;
    const double diagonal = bounding_box_diagonal(points);
    return (share_of_edge * shortest_edges(faces, points))
        .cwiseMin(tolerance * diagonal)
        .cwiseMax(coincidence * diagonal);
}

std::size_t count_vertices(const std::vector<VertexGroup>& groups)
{
    std::size_t count = 0;
    for (const VertexGroup& group : groups)
        count += group.size();
    return count;
}

void check_index(int vertex, int vertex_count, const char* what)
{
    if (vertex < 0 || vertex >= vertex_count)
        throw InvalidInput(
            join(what, " names vertex ", vertex, ", must be in [0, ", vertex_count, ")"));
}

/// The faces in new numbers.
/// @param target  Of each vertex the one that stands for it; those that stand for themselves stay.
VertexChoice renamed(const Faces& faces, const std::vector<int>& target,
                     const std::vector<bool>& kept_vertices, const std::vector<bool>& kept_faces)
{
    VertexChoice choice;
    std::vector<int> number(target.size(), -1);
    for (std::size_t v = 0; v < target.size(); ++v)
        if (kept_vertices[v]) {
            number[v] = static_cast<int>(choice.vertices.size());
            choice.vertices.push_back(static_cast<int>(v));
        }
    const auto count = std::count(kept_faces.begin(), kept_faces.end(), true);
    choice.faces.resize(count, 3);
    Eigen::Index next = 0;
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        if (kept_faces[to_size(f)])
            choice.faces.row(next++) =
                faces.row(f).unaryExpr([&](int v) { return number[to_size(target[to_size(v)])]; });
    return choice;
}

} // namespace

std::vector<VertexGroup> coincident_vertices(std::span<const Points> meshes, double tolerance)
{
    check(meshes);
    require_not_negative(tolerance, "tolerance");
    VertexGroup all(to_size(meshes.front().rows()));
    std::iota(all.begin(), all.end(), 0);
    return groups_in_all({std::move(all)}, meshes, [&](const Points& points) -> Eigen::VectorXd {
        return Eigen::VectorXd::Constant(points.rows(), tolerance * bounding_box_diagonal(points));
    });
}

SeamVertices seam_vertices(const Faces& faces, std::span<const Points> meshes)
{
    // Set by hand: single precision at 50 diagonals from the origin, as scanners have it, leaves 1e-5.
    constexpr double near = 1e-3;
    constexpr double most_rounding = 1e-4;
    constexpr double spacings = 4.0;
    check(meshes);
    for (const int v : faces.reshaped())
        check_index(v, static_cast<int>(meshes.front().rows()), "faces");
    const auto reach_within = [&faces](double tolerance) {
        return [&faces, tolerance](const Points& points) {
            return reach_of(faces, points, tolerance);
        };
    };
    std::vector<VertexGroup> all =
        groups_in_all({boundary_vertices(faces)}, meshes, reach_within(near));
    if (all.empty())
        return {};
    double rounding = coincidence;
    for (const Points& points : meshes)
        if (const double diagonal = bounding_box_diagonal(points); diagonal > 0.0)
            rounding = std::max(rounding, spacings * coordinate_spacing(points) / diagonal);
    SeamVertices seams;
    seams.coincident = groups_in_all(all, meshes, reach_within(std::min(rounding, most_rounding)));
    for (VertexGroup& group : all)
        if (!std::binary_search(seams.coincident.begin(), seams.coincident.end(), group))
            seams.near.push_back(std::move(group));
    for (const Points& points : meshes)
        for (const VertexGroup& group : seams.near)
            for (const int v : group)
                seams.gap = std::max(seams.gap, (points.row(v) - points.row(group.front())).norm() /
                                                    bounding_box_diagonal(points));
    return seams;
}

std::string describe_coincident(const Faces& faces, const Points& points)
{
    if (points.rows() == 0 || !points.allFinite())
        return {};
    const SeamVertices seams = seam_vertices(faces, std::span(&points, 1));
    if (!seams.coincident.empty())
        return join("; ", count_vertices(seams.coincident), " of ", points.rows(),
                    " vertices lie on others: were they split along seams or sharp edges by an "
                    "exporter?");
    if (!seams.near.empty())
        return join("; ", count_vertices(seams.near), " of ", points.rows(),
                    " vertices lie near others, up to ", rounded(seams.gap),
                    " of the diagonal away: are these patches of one surface? Then merge vertices "
                    "by distance in the program that made it");
    return {};
}

VertexChoice weld(const Faces& faces, int vertex_count, const std::vector<VertexGroup>& groups)
{
    for (const int v : faces.reshaped())
        check_index(v, vertex_count, "faces");
    std::vector<int> target(to_size(vertex_count));
    std::iota(target.begin(), target.end(), 0);
    std::vector<bool> kept_vertices(target.size(), true);
    for (const VertexGroup& group : groups)
        for (const int v : group) {
            check_index(v, vertex_count, "groups");
            target[to_size(v)] = group.front();
            kept_vertices[to_size(v)] = v == group.front();
        }
    std::vector<bool> kept_faces(to_size(faces.rows()));
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
        const auto corner = [&](int c) { return target[to_size(faces(f, c))]; };
        kept_faces[to_size(f)] =
            corner(0) != corner(1) && corner(1) != corner(2) && corner(2) != corner(0);
    }
    return renamed(faces, target, kept_vertices, kept_faces);
}

VertexChoice keep_faces(const Faces& faces, int vertex_count, const std::vector<bool>& kept)
{
    if (std::ssize(kept) != faces.rows())
        throw InvalidInput(join("kept has ", kept.size(), " entries, must have one for each of ",
                                faces.rows(), " faces"));
    std::vector<int> target(to_size(vertex_count));
    std::iota(target.begin(), target.end(), 0);
    std::vector<bool> kept_vertices(target.size(), false);
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        if (kept[to_size(f)])
            for (const int v : faces.row(f)) {
                check_index(v, vertex_count, "faces");
                kept_vertices[to_size(v)] = true;
            }
    return renamed(faces, target, kept_vertices, kept);
}

Points chosen_points(const Points& points, const std::vector<int>& vertices)
{
    return points(vertices, Eigen::all);
}

} // namespace shape
