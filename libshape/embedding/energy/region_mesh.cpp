// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/region_mesh.h"

#include <cstddef>
#include <tuple>
#include <utility>

#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

/// Consecutive numbers for names >= 0 in the order in which they come; a table with linear probing.
class LocalNumbers
{
public:
    /// The number of a name, the next one if it is new; `names` are all in their order.
    int operator()(int name, std::vector<int>& names)
    {
        std::size_t slot = find(name, names);
        if (slots_[slot] < 0) {
            if (2 * names.size() >= slots_.size()) {
                slots_.assign(2 * slots_.size(), -1);
                for (std::size_t i = 0; i < names.size(); ++i)
                    slots_[find(names[i], names)] = static_cast<int>(i);
                slot = find(name, names);
            }
            slots_[slot] = static_cast<int>(names.size());
            names.push_back(name);
        }
        return slots_[slot];
    }

private:
    /// Where a name is or would be.
    [[nodiscard]] std::size_t find(int name, const std::vector<int>& names) const
    {
        constexpr std::size_t golden = 0x9E3779B9; // 2^32 / 1.618: spreads neighbours
        for (std::size_t i = golden * to_size(name) >> 7;; ++i) {
            const int number = slots_[i & (slots_.size() - 1)];
            if (number < 0 || names[to_size(number)] == name)
                return i & (slots_.size() - 1);
        }
    }

    std::vector<int> slots_ = std::vector<int>(1024, -1); // a power of 2
};

/// Lists of the items that name a number: begins and items.
std::pair<std::vector<int>, std::vector<int>> grouped(int count,
                                                      const std::vector<std::pair<int, int>>& items)
{
    std::pair<std::vector<int>, std::vector<int>> groups;
    auto& [begins, members] = groups;
    begins.assign(to_size(count) + 1, 0);
    for (const auto& [number, item] : items)
        if (number < count)
            ++begins[to_size(number) + 1];
    for (std::size_t i = 0; i < to_size(count); ++i)
        begins[i + 1] += begins[i];
    members.resize(to_size(begins.back()));
    std::vector<int> next = begins;
    for (const auto& [number, item] : items)
        if (number < count)
            members[to_size(next[to_size(number)]++)] = item;
    return groups;
}

} // namespace

RegionMesh::RegionMesh(const Topology& t, const std::vector<int>& moving)
{
    LocalNumbers local_vertex, local_face, local_edge;
    std::vector<int> faces;
    std::vector<std::pair<int, int>> leaving; // vertex, half-edge
    const auto add_faces_around = [&](int first, int end) {
        const auto known = static_cast<int>(faces.size());
        for (int v = first; v < end; ++v)
            for (const int h : t.outgoing(vertices[to_size(v)]))
                local_face(Topology::face(h), faces);
        for (auto f = known; f < static_cast<int>(faces.size()); ++f)
            for (int c = 0; c < 3; ++c) {
                corners.push_back(local_vertex(t.faces()(faces[to_size(f)], c), vertices));
                leaving.emplace_back(corners.back(), 3 * f + c);
            }
    };
    for (const int v : moving)
        local_vertex(v, vertices);
    moving_vertices = vertex_count();
    add_faces_around(0, moving_vertices);
    moving_faces = face_count();
    rim_vertices = vertex_count() - moving_vertices;
    add_faces_around(moving_vertices, moving_vertices + rim_vertices);
    std::tie(halfedge_begins, halfedges) = grouped(moving_vertices + rim_vertices, leaving);

    for (int h = 0; h < 3 * moving_faces; ++h)
        face_edges.push_back(local_edge(t.face_edges()(faces[to_size(h / 3)], h % 3), edges));
    std::vector<std::pair<int, int>> touching; // vertex, edge
    for (int e = 0; e < edge_count(); ++e) {
        const int left = t.edge_halfedges()(edges[to_size(e)], 0);
        const int right = t.edge_halfedges()(edges[to_size(e)], 1);
        for (const int h : {left, right < 0 ? left : right})
            sides.push_back(3 * local_face(Topology::face(h), faces) + h % 3);
        ends.push_back(local_vertex(t.source(left), vertices));
        ends.push_back(local_vertex(t.target(left), vertices));
        touching.emplace_back(ends.end()[-2], ~e);
        touching.emplace_back(ends.end()[-1], e);
    }
    std::tie(edge_begins, incident_edges) = grouped(moving_vertices, touching);
}

} // namespace shape::internal
