// SPDX-License-Identifier: MIT

#include "libshape/mesh/face_patches.h"

#include <algorithm>
#include <deque>
#include <utility>

#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

/// Patches of faces in a row: entry p of `begins` is the first of patch p in `faces`, the last entry
/// their end.
struct Rows
{
    std::vector<int> faces, begins;
    std::vector<int> patch_of; ///< Every face.
};

/// Breadth-first discs; the faces left over at the rim of one seed the next.
Rows discs(const Topology& topology, int faces_per_patch)
{
    Rows rows;
    rows.patch_of.assign(to_size(topology.face_count()), -1);
    std::deque<int> seeds{0};
    const auto is_taken = [&](int face) { return rows.patch_of[to_size(face)] >= 0; };
    const auto take = [&](int face) {
        rows.patch_of[to_size(face)] = static_cast<int>(rows.begins.size()) - 1;
        rows.faces.push_back(face);
    };
    while (!seeds.empty()) {
        const int seed = seeds.front();
        seeds.pop_front();
        if (is_taken(seed))
            continue;
        rows.begins.push_back(static_cast<int>(rows.faces.size()));
        take(seed);
        for (std::size_t i = to_size(rows.begins.back()); i < rows.faces.size(); ++i)
            for (int h = 3 * rows.faces[i], end = h + 3; h < end; ++h) {
                const int opposite = topology.opposite(h);
                if (opposite < 0 || is_taken(opposite / 3))
                    continue;
                if (static_cast<int>(rows.faces.size()) - rows.begins.back() < faces_per_patch)
                    take(opposite / 3);
                else
                    seeds.push_back(opposite / 3);
            }
    }
    rows.begins.push_back(static_cast<int>(rows.faces.size()));
    return rows;
}

/// Gives the faces of patches with fewer than `least` to a larger neighbour.
Rows without_crumbs(const Topology& topology, const Rows& rows, int least)
{
    const int count = static_cast<int>(rows.begins.size()) - 1;
    const auto size = [&](int p) { return rows.begins[to_size(p) + 1] - rows.begins[to_size(p)]; };
    const auto larger_neighbour = [&](int p) {
        for (int i = rows.begins[to_size(p)]; i < rows.begins[to_size(p) + 1]; ++i)
            for (int h = 3 * rows.faces[to_size(i)], end = h + 3; h < end; ++h)
                if (const int opposite = topology.opposite(h); opposite >= 0)
                    if (const int other = rows.patch_of[to_size(opposite / 3)];
                        size(other) >= least)
                        return other;
        return p;
    };
    std::vector<int> new_owner(to_size(count));
    for (int p = 0; p < count; ++p)
        new_owner[to_size(p)] = size(p) < least ? larger_neighbour(p) : p;

    // Owners in order, and the faces of each in theirs.
    std::vector<int> sizes(to_size(count), 0);
    for (int p = 0; p < count; ++p)
        sizes[to_size(new_owner[to_size(p)])] += size(p);
    Rows kept{std::vector<int>(rows.faces.size()), {0}, std::vector<int>(rows.faces.size())};
    std::vector<int> number(to_size(count), -1);
    for (int p = 0; p < count; ++p)
        if (sizes[to_size(p)] > 0) {
            number[to_size(p)] = static_cast<int>(kept.begins.size()) - 1;
            kept.begins.push_back(kept.begins.back() + sizes[to_size(p)]);
        }
    std::vector<int> next(kept.begins);
    for (const int face : rows.faces) {
        const int p = number[to_size(new_owner[to_size(rows.patch_of[to_size(face)])])];
        kept.patch_of[to_size(face)] = p;
        kept.faces[to_size(next[to_size(p)]++)] = face;
    }
    return kept;
}

} // namespace

FacePatches::FacePatches(const Topology& topology, int faces_per_patch)
    : edge_count(topology.edge_count())
{
    Rows rows = without_crumbs(topology, discs(topology, faces_per_patch), faces_per_patch / 8);
    const std::vector<int>& patch_of = rows.patch_of;
    faces = std::move(rows.faces);
    begins = std::move(rows.begins);
    std::vector<int> place_of(faces.size());
    for (int p = 0; p < count(); ++p) {
        largest = std::max(largest, size(p));
        for (int i = 0; i < size(p); ++i)
            place_of[to_size(faces[to_size(begin(p) + i)])] = i;
    }

    ways.reserve(3 * faces.size());
    for (const int face : faces)
        for (int h = 3 * face; h < 3 * face + 3; ++h) {
            const int other = topology.opposite(h) < 0 ? -1 : topology.opposite(h) / 3;
            const bool inside = other >= 0 && patch_of[to_size(other)] == patch_of[to_size(face)];
            const int edge = topology.edge(h);
            ways.push_back({inside ? place_of[to_size(other)] : -1, edge,
                            h == topology.edge_halfedges()(edge, 0)});
        }

    for (int e = 0; e < topology.edge_count(); ++e) {
        if (topology.is_boundary_edge(e))
            continue;
        const int left = topology.edge_halfedges()(e, 0) / 3;
        const int right = topology.edge_halfedges()(e, 1) / 3;
        if (patch_of[to_size(left)] < patch_of[to_size(right)])
            bridges.push_back({e, left, right, true});
        else if (patch_of[to_size(left)] > patch_of[to_size(right)])
            bridges.push_back({e, right, left, false});
    }
    const auto patches = [&](const Bridge& bridge) {
        return std::pair(patch_of[to_size(bridge.lower_face)],
                         patch_of[to_size(bridge.higher_face)]);
    };
    std::stable_sort(bridges.begin(), bridges.end(),
                     [&](const Bridge& a, const Bridge& b) { return patches(a) < patches(b); });
    for (std::size_t b = 0; b < bridges.size(); ++b) {
        if (b > 0 && patches(bridges[b]) == patches(bridges[b - 1]))
            continue;
        const auto [lower, higher] = patches(bridges[b]);
        const bool next = !pairs.empty() && pairs.back().lower == lower;
        pairs.push_back({lower, higher, next ? pairs.back().rank + 1 : 0, b});
    }
}

} // namespace shape::internal
