// SPDX-License-Identifier: MIT

#include "libshape/mesh/other_diagonals.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <utility>

#include "libshape/base/to_size.h"
#include "libshape/mesh/partition.h"

namespace shape::internal {
namespace {

using Triangle = std::array<int, 3>;
using Side = std::pair<int, int>;

/// Each starting at its lowest vertex, sorted.
std::vector<Triangle> sorted_triangles(const Faces& faces)
{
    std::vector<Triangle> triangles;
    triangles.reserve(to_size(faces.rows()));
    for (const auto& row : faces.rowwise()) {
        Triangle t{row[0], row[1], row[2]};
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        triangles.push_back(t);
    }
    std::ranges::sort(triangles);
    return triangles;
}

/// Sides of the triangles, lower vertex first, with the triangle; sorted.
std::vector<std::pair<Side, int>> sides_of(const std::vector<Triangle>& triangles)
{
    std::vector<std::pair<Side, int>> sides;
    sides.reserve(3 * triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            sides.emplace_back(std::minmax(triangles[i][c], triangles[i][(c + 1) % 3]),
                               static_cast<int>(i));
    std::ranges::sort(sides);
    return sides;
}

/// The loop around triangles, from its lowest vertex; empty unless it is one loop of as many different vertices as a
/// polygon of them has.
std::vector<int> loop_around(const std::vector<Triangle>& triangles)
{
    std::map<int, int> next;
    std::vector<Side> sides;
    for (const Triangle& t : triangles)
        for (std::size_t c = 0; c < 3; ++c)
            sides.emplace_back(t[c], t[(c + 1) % 3]);
    std::ranges::sort(sides);
    for (const Side& side : sides)
        if (!std::ranges::binary_search(sides, Side{side.second, side.first}) &&
            !next.emplace(side).second)
            return {};
    if (next.size() != triangles.size() + 2)
        return {};
    std::vector<int> loop{next.begin()->first};
    while (loop.size() <= next.size()) {
        const auto to = next.find(loop.back());
        if (to == next.end())
            return {};
        if (to->second == loop.front())
            break;
        loop.push_back(to->second);
    }
    return loop.size() == next.size() ? loop : std::vector<int>();
}

/// The loops of the patches, sorted; none if one is no polygon.
/// @param sides, sides_there  Of all these triangles, and of those of the other triangulation.
std::vector<std::vector<int>> loops_of_patches(const std::vector<Triangle>& triangles,
                                               const std::vector<std::pair<Side, int>>& sides,
                                               const std::vector<std::pair<Side, int>>& sides_there)
{
    Partition patches(triangles.size());
    for (std::size_t i = 1; i < sides.size(); ++i) {
        const auto& [side, triangle] = sides[i];
        if (side != sides[i - 1].first)
            continue;
        const auto there = std::ranges::lower_bound(sides_there, side, {},
                                                    [](const auto& each) { return each.first; });
        if (there == sides_there.end() || there->first != side)
            patches.unite(triangle, sides[i - 1].second);
    }
    std::map<int, std::vector<Triangle>> members;
    for (std::size_t i = 0; i < triangles.size(); ++i)
        members[patches.root(static_cast<int>(i))].push_back(triangles[i]);
    std::vector<std::vector<int>> loops;
    for (const auto& [root, patch] : members) {
        loops.push_back(loop_around(patch));
        if (loops.back().size() < 4)
            return {};
    }
    std::ranges::sort(loops);
    return loops;
}

} // namespace

std::optional<OtherDiagonals> other_diagonals(const Faces& reference, const Faces& other)
{
    if (reference.rows() != other.rows())
        return std::nullopt;
    const std::vector<Triangle> here = sorted_triangles(reference);
    const std::vector<Triangle> there = sorted_triangles(other);
    std::vector<Triangle> only_here, only_there;
    std::ranges::set_difference(here, there, std::back_inserter(only_here));
    std::ranges::set_difference(there, here, std::back_inserter(only_there));
    if (only_here.empty() || only_here.size() != only_there.size())
        return std::nullopt;
    const auto sides_here = sides_of(only_here);
    const auto sides_there = sides_of(only_there);
    const auto loops = loops_of_patches(only_here, sides_here, sides_there);
    if (loops.empty() || loops != loops_of_patches(only_there, sides_there, sides_here))
        return std::nullopt;
    return OtherDiagonals{std::ssize(loops),
                          std::ranges::count(loops, std::size_t{4}, &std::vector<int>::size),
                          loops.front()};
}

} // namespace shape::internal
