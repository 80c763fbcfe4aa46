// SPDX-License-Identifier: MIT

#include "libshape/mesh/coincident_vertices.h"

#include <algorithm>
#include <numeric>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
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

/// The groups among some vertices, ascending. They are sorted along a direction in which hardly two
/// of different places are as near as the tolerance, so that few come into question for each.
std::vector<VertexGroup> groups_among(const VertexGroup& vertices, const Points& points,
                                      double tolerance)
{
    const Eigen::Vector3d direction(0.4472135954999579, 0.7071067811865476, 0.5477225575051661);
    std::vector<std::pair<double, int>> order; // place along the direction, and entry of vertices
    for (const int v : vertices)
        order.emplace_back(points.row(v) * direction, static_cast<int>(order.size()));
    std::sort(order.begin(), order.end());
    const auto point = [&](int entry) { return points.row(vertices[to_size(entry)]); };
    Partition partition(vertices.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        for (std::size_t j = i + 1;
             j < order.size() && order[j].first - order[i].first <= tolerance; ++j)
            if ((point(order[i].second) - point(order[j].second)).norm() <= tolerance) {
                partition.unite(order[i].second, order[j].second);
                break; // what lies on both is joined by way of the second
            }
    std::vector<VertexGroup> groups(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i)
        groups[to_size(partition.root(static_cast<int>(i)))].push_back(vertices[i]);
    std::erase_if(groups, [](const VertexGroup& group) { return group.size() < 2; });
    return groups;
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
    std::vector<VertexGroup> groups(1);
    groups.front().resize(to_size(meshes.front().rows()));
    std::iota(groups.front().begin(), groups.front().end(), 0);
    for (const Points& points : meshes) {
        const double distance = tolerance * bounding_box_diagonal(points);
        std::vector<VertexGroup> parts;
        for (const VertexGroup& group : groups)
            for (VertexGroup& part : groups_among(group, points, distance))
                parts.push_back(std::move(part));
        groups = std::move(parts);
    }
    std::sort(groups.begin(), groups.end());
    return groups;
}

std::string describe_coincident(const Points& points)
{
    if (points.rows() == 0 || !points.allFinite())
        return {};
    std::size_t vertices = 0;
    for (const VertexGroup& group : coincident_vertices(std::span(&points, 1)))
        vertices += group.size();
    return vertices == 0
               ? std::string()
               : join("; ", vertices, " of ", points.rows(),
                      " vertices lie on others: were they split along seams or sharp edges "
                      "by an exporter?");
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
