// SPDX-License-Identifier: MIT

#include "libshape/embedding/face_patches.h"

#include <algorithm>
#include <deque>
#include <utility>

namespace shape {
namespace {

std::size_t index(int i)
{
    return static_cast<std::size_t>(i);
}

} // namespace

FacePatches::FacePatches(const Topology& topology, int faces_per_patch)
    : edge_count(topology.edge_count()), largest(0)
{
    std::vector<int> patch_of(index(topology.face_count()), -1);
    std::vector<int> place_of(patch_of.size());
    std::deque<int> seeds{0};
    const auto take = [&](int face) {
        patch_of[index(face)] = static_cast<int>(begins.size()) - 1;
        place_of[index(face)] = static_cast<int>(faces.size()) - begins.back();
        faces.push_back(face);
    };
    while (!seeds.empty()) {
        const int seed = seeds.front();
        seeds.pop_front();
        if (patch_of[index(seed)] >= 0)
            continue;
        begins.push_back(static_cast<int>(faces.size()));
        take(seed);
        for (std::size_t i = index(begins.back()); i < faces.size(); ++i)
            for (int h = 3 * faces[i], end = h + 3; h < end; ++h) {
                const int opposite = topology.opposite(h);
                if (opposite < 0 || patch_of[index(opposite / 3)] >= 0)
                    continue;
                if (static_cast<int>(faces.size()) - begins.back() < faces_per_patch)
                    take(opposite / 3);
                else
                    seeds.push_back(opposite / 3);
            }
        largest = std::max(largest, static_cast<int>(faces.size()) - begins.back());
    }
    begins.push_back(static_cast<int>(faces.size()));

    ways.reserve(3 * faces.size());
    for (const int face : faces)
        for (int h = 3 * face; h < 3 * face + 3; ++h) {
            const int other = topology.opposite(h) < 0 ? -1 : topology.opposite(h) / 3;
            const bool inside = other >= 0 && patch_of[index(other)] == patch_of[index(face)];
            const int edge = topology.edge(h);
            ways.push_back({inside ? place_of[index(other)] : -1, edge,
                            h == topology.edge_halfedges()(edge, 0)});
        }

    for (int e = 0; e < topology.edge_count(); ++e) {
        if (topology.is_boundary_edge(e))
            continue;
        const int left = topology.edge_halfedges()(e, 0) / 3;
        const int right = topology.edge_halfedges()(e, 1) / 3;
        if (patch_of[index(left)] < patch_of[index(right)])
            bridges.push_back({e, left, right, true});
        else if (patch_of[index(left)] > patch_of[index(right)])
            bridges.push_back({e, right, left, false});
    }
    const auto patches = [&](const Bridge& bridge) {
        return std::pair(patch_of[index(bridge.lower_face)], patch_of[index(bridge.higher_face)]);
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

} // namespace shape
