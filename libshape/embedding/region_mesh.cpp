// SPDX-License-Identifier: MIT

#include "libshape/embedding/region_mesh.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace shape {
namespace {

void sort_and_unite(std::vector<int>& numbers)
{
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

/// Elements of a that are not in b, both ascending.
std::vector<int> difference(const std::vector<int>& a, const std::vector<int>& b)
{
    std::vector<int> rest;
    std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(rest));
    return rest;
}

std::vector<int> faces_around(const Topology& t, const std::vector<int>& vertices)
{
    std::vector<int> faces;
    for (const int v : vertices)
        for (const int h : t.outgoing(v))
            faces.push_back(Topology::face(h));
    sort_and_unite(faces);
    return faces;
}

std::vector<int> corners_of(const Topology& t, const std::vector<int>& faces)
{
    std::vector<int> vertices;
    for (const int f : faces)
        for (int c = 0; c < 3; ++c)
            vertices.push_back(t.faces()(f, c));
    sort_and_unite(vertices);
    return vertices;
}

/// Places in lists that are ascending one after the other.
class LocalNumbers
{
public:
    void append(const std::vector<int>& ascending)
    {
        for (const int number : ascending)
            places_.emplace_back(number, static_cast<int>(places_.size()));
        sorted_ = places_;
        std::sort(sorted_.begin(), sorted_.end());
    }
    int operator()(int number) const
    {
        return std::lower_bound(sorted_.begin(), sorted_.end(), std::pair(number, 0))->second;
    }

private:
    std::vector<std::pair<int, int>> places_, sorted_;
};

/// Lists of the items that name a number: begins and items.
std::pair<std::vector<int>, std::vector<int>> grouped(int count,
                                                      const std::vector<std::pair<int, int>>& items)
{
    std::pair<std::vector<int>, std::vector<int>> groups;
    auto& [begins, members] = groups;
    begins.assign(static_cast<std::size_t>(count) + 1, 0);
    for (const auto& [number, item] : items)
        if (number < count)
            ++begins[static_cast<std::size_t>(number) + 1];
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
        begins[i + 1] += begins[i];
    members.resize(static_cast<std::size_t>(begins.back()));
    std::vector<int> next = begins;
    for (const auto& [number, item] : items)
        if (number < count)
            members[static_cast<std::size_t>(next[static_cast<std::size_t>(number)]++)] = item;
    return groups;
}

} // namespace

RegionMesh::RegionMesh(const Topology& t, std::vector<int> moving)
{
    sort_and_unite(moving);
    const std::vector<int> inner_faces = faces_around(t, moving);
    const std::vector<int> rim = difference(corners_of(t, inner_faces), moving);
    const std::vector<int> collar = difference(faces_around(t, rim), inner_faces);

    vertices = moving;
    vertices.insert(vertices.end(), rim.begin(), rim.end());
    std::vector<int> known = vertices;
    sort_and_unite(known);
    const std::vector<int> outer = difference(corners_of(t, collar), known);
    vertices.insert(vertices.end(), outer.begin(), outer.end());
    moving_vertices = static_cast<int>(moving.size());
    rim_vertices = static_cast<int>(rim.size());
    moving_faces = static_cast<int>(inner_faces.size());
    LocalNumbers local_vertex, local_face, local_edge;
    local_vertex.append(vertices);

    std::vector<int> faces = inner_faces;
    faces.insert(faces.end(), collar.begin(), collar.end());
    local_face.append(faces);
    std::vector<std::pair<int, int>> leaving;
    for (const int f : faces)
        for (int c = 0; c < 3; ++c) {
            corners.push_back(local_vertex(t.faces()(f, c)));
            leaving.emplace_back(corners.back(), static_cast<int>(leaving.size()));
        }
    std::tie(halfedge_begins, halfedges) = grouped(moving_vertices + rim_vertices, leaving);

    for (const int f : inner_faces)
        for (int c = 0; c < 3; ++c)
            edges.push_back(t.face_edges()(f, c));
    std::vector<int> of_faces = edges;
    sort_and_unite(edges);
    local_edge.append(edges);
    for (const int e : of_faces)
        face_edges.push_back(local_edge(e));
    std::vector<std::pair<int, int>> ending;
    for (const int e : edges) {
        const int local = static_cast<int>(sides.size()) / 2;
        const int left = t.edge_halfedges()(e, 0);
        const int right = t.edge_halfedges()(e, 1);
        for (const int h : {left, right < 0 ? left : right})
            sides.push_back(3 * local_face(Topology::face(h)) + h % 3);
        ends.push_back(local_vertex(t.source(left)));
        ends.push_back(local_vertex(t.target(left)));
        ending.emplace_back(ends.end()[-2], ~local);
        ending.emplace_back(ends.end()[-1], local);
    }
    std::tie(edge_begins, incident_edges) = grouped(moving_vertices, ending);
}

} // namespace shape
