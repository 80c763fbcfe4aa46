// SPDX-License-Identifier: MIT

#include "libshape/mesh/known_cut.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

using Triangle = std::array<int, 3>;
using Side = std::pair<int, int>; ///< From one vertex to the next.

Triangle row_of(const Faces& faces, Eigen::Index f)
{
    return {faces(f, 0), faces(f, 1), faces(f, 2)};
}

/// Whether the sides of the triangles that do not cancel are those of the polygon. As n - 2 triangles are the fewest
/// that n corners can bound, there is nothing beside them then.
bool is_cut_of(std::span<const int> vertices, std::span<const Triangle> triangles)
{
    std::vector<std::pair<Side, int>> sides; // lower vertex first, and which way it runs
    const auto add = [&](int from, int to, int sign) {
        if (from != to)
            sides.emplace_back(std::minmax(from, to), from < to ? sign : -sign);
    };
    for (const Triangle& t : triangles)
        for (std::size_t c = 0; c < 3; ++c)
            add(t[c], t[(c + 1) % 3], 1);
    for (std::size_t i = 0; i < vertices.size(); ++i)
        add(vertices[i], vertices[(i + 1) % vertices.size()], -1);
    std::ranges::sort(sides);
    for (auto begin = sides.begin(); begin != sides.end();) {
        int sum = 0;
        const Side side = begin->first;
        for (; begin != sides.end() && begin->first == side; ++begin)
            sum += begin->second;
        if (sum != 0)
            return false;
    }
    return true;
}

/// The triangles of a triangulation by their sides.
class TrianglesAtSides
{
public:
    explicit TrianglesAtSides(const Faces& faces) : faces_(faces)
    {
        sides_.reserve(3 * to_size(faces.rows()));
        for (Eigen::Index f = 0; f < faces.rows(); ++f)
            for (int c = 0; c < 3; ++c)
                sides_.emplace_back(Side{faces(f, c), faces(f, (c + 1) % 3)}, f);
        std::ranges::sort(sides_);
    }

    /// Those within a polygon, by crossing the sides that are not its own from triangle to triangle.
    [[nodiscard]] std::optional<std::vector<Triangle>> within(std::span<const int> vertices) const
    {
        std::vector<Side> own;
        for (std::size_t i = 0; i < vertices.size(); ++i)
            own.emplace_back(vertices[i], vertices[(i + 1) % vertices.size()]);
        std::vector<Side> open{own.front()};
        std::ranges::sort(own);
        std::vector<Eigen::Index> found;
        while (!open.empty() && found.size() < vertices.size() - 2) {
            const Side side = open.back();
            open.pop_back();
            const auto at = std::ranges::lower_bound(sides_, side, {},
                                                     [](const auto& each) { return each.first; });
            if (at == sides_.end() || at->first != side)
                return std::nullopt;
            found.push_back(at->second);
            const Triangle triangle = row_of(faces_, at->second);
            for (std::size_t c = 0; c < 3; ++c) {
                const Side next{triangle[c], triangle[(c + 1) % 3]};
                if (next != side && !std::ranges::binary_search(own, next))
                    open.emplace_back(next.second, next.first);
            }
        }
        std::ranges::sort(found); // as they stand in the triangulation
        std::vector<Triangle> triangles;
        for (const Eigen::Index f : found)
            triangles.push_back(row_of(faces_, f));
        if (triangles.size() + 2 != vertices.size() || !is_cut_of(vertices, triangles))
            return std::nullopt;
        return triangles;
    }

private:
    const Faces& faces_;
    std::vector<std::pair<Side, Eigen::Index>> sides_;
};

/// The triangles, each starting at its lowest vertex, in an order that does not depend on theirs.
std::vector<Triangle> sorted(std::span<const int> corners)
{
    std::vector<Triangle> triangles;
    triangles.reserve(corners.size() / 3);
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
        Triangle t{corners[i], corners[i + 1], corners[i + 2]};
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        triangles.push_back(t);
    }
    std::ranges::sort(triangles);
    return triangles;
}

} // namespace

std::vector<int> Fans::vertices_of(std::size_t polygon) const
{
    const std::size_t at = 3 * to_size(polygons[polygon]);
    std::vector<int> vertices{corners[at], corners[at + 1]};
    for (std::size_t i = 0; i + 2 < to_size(sizes[polygon]); ++i)
        vertices.push_back(corners[at + 3 * i + 2]);
    return vertices;
}

KnownCut cut_as_known(const Fans& fans, const Faces& known)
{
    KnownCut cut{{fans.corners.begin(), fans.corners.end()}, {}};
    std::optional<TrianglesAtSides> elsewhere;
    for (std::size_t p = 0; p < fans.polygons.size(); ++p) {
        std::vector<int> vertices = fans.vertices_of(p);
        std::optional<std::vector<Triangle>> triangles(std::in_place);
        const Eigen::Index first = fans.polygons[p];
        const Eigen::Index end = first + std::ssize(vertices) - 2;
        for (Eigen::Index f = first; f < std::min(end, known.rows()); ++f)
            triangles->push_back(row_of(known, f));
        if (end > known.rows() || !is_cut_of(vertices, *triangles)) {
            if (!elsewhere)
                elsewhere.emplace(known);
            triangles = elsewhere->within(vertices);
            if (!triangles) {
                std::ranges::reverse(vertices);
                triangles = elsewhere->within(vertices);
                if (triangles)
                    for (Triangle& triangle : *triangles)
                        std::swap(triangle[1], triangle[2]);
            }
        }
        if (!triangles) {
            cut.missed.push_back(p);
            continue;
        }
        auto next = cut.corners.begin() + 3 * first;
        for (const Triangle& triangle : *triangles)
            next = std::ranges::copy(triangle, next).out;
    }
    const std::span<const int> all(known.data(), to_size(known.size()));
    cut.has_all = cut.missed.empty() &&
                  (std::ranges::equal(cut.corners, all) || sorted(cut.corners) == sorted(all));
    return cut;
}

} // namespace shape::internal
