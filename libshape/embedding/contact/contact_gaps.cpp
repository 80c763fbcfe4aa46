// SPDX-License-Identifier: MIT

#include "libshape/embedding/contact/contact_gaps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/mesh/nearest_in_triangle.h"
#include "libshape/mesh/vertex_normals.h"

namespace shape::internal {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Gap = LengthDihedralEnergy::Gap;

void make_unique(std::vector<int>& values)
{
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
}

/// A face and the rings around it, all in ascending order.
struct Patch
{
    std::vector<int> faces, edges, vertices;
};
using Patches = std::map<int, Patch>; // by their faces in the middle

Patch patch_around(const Topology& topology, int face, int rings)
{
    Patch patch;
    patch.faces = {face};
    const auto take_corners = [&] {
        for (const int f : patch.faces)
            for (const int v : topology.faces().row(f))
                patch.vertices.push_back(v);
        make_unique(patch.vertices);
    };
    take_corners();
    for (int ring = 0; ring < rings; ++ring) {
        for (const int v : patch.vertices)
            for (const int h : topology.outgoing(v))
                patch.faces.push_back(Topology::face(h));
        make_unique(patch.faces);
        take_corners();
    }
    for (const int f : patch.faces)
        for (const int e : topology.face_edges().row(f))
            patch.edges.push_back(e);
    make_unique(patch.edges);
    return patch;
}

/// The middle of two vertices: an edge, or a vertex twice.
using Place = std::array<int, 2>;

Place place_of(const Topology& topology, int edge)
{
    return {topology.edges()(edge, 0), topology.edges()(edge, 1)};
}

/// A point of a face.
struct Foot
{
    int face = -1;
    Vector3d weights = Vector3d::Zero(); ///< Of its corners.
    Vector3d point = Vector3d::Zero();
    Vector3d normal = Vector3d::Zero(); ///< Of the surface there, unit length.
};

/// The mesh that gaps are found in.
class Surface
{
public:
    Surface(const Topology& topology, const VectorXd& points)
        : topology_(topology),
          points_(Points::Map(points.data(), topology.vertex_count(), 3)),
          outward_(outwardness(points_, topology.faces()) < 0.0 ? -1 : 1),
          normals_(static_cast<double>(outward_) * vertex_normals(points_, topology.faces()))
    {
    }

    /// Places that are through (contact_gaps()).
    [[nodiscard]] std::set<Place> through(const std::vector<FacePair>& pairs,
                                          const Patches& patches) const
    {
        std::map<int, int> crossings; // of edges
        std::set<int> inside, outside;
        std::set<int> around; // vertices that may be inside as well
        for (const auto& [f, g] : pairs)
            for (const auto& [own, other] : {std::pair(f, g), std::pair(g, f)})
                for (const int e : topology_.face_edges().row(own)) {
                    const auto ends = ends_at(e, other);
                    if (!ends)
                        continue;
                    ++crossings[e];
                    inside.insert(ends->first);
                    outside.insert(ends->second);
                    const std::vector<int>& near = patches.at(own).vertices;
                    around.insert(near.begin(), near.end());
                }
        std::vector<int> stack(inside.begin(), inside.end());
        while (!stack.empty()) {
            const int v = stack.back();
            stack.pop_back();
            for (const Topology::Spoke& spoke : topology_.spokes(v))
                if (crossings.count(spoke.edge) == 0 && outside.count(spoke.vertex) == 0 &&
                    around.count(spoke.vertex) > 0 && inside.insert(spoke.vertex).second)
                    stack.push_back(spoke.vertex);
        }
        std::set<Place> places;
        for (const int v : inside)
            places.insert({v, v});
        for (const auto& [edge, count] : crossings)
            if (count > 1) // in through one face and out through another, over an edge or a corner
                places.insert(place_of(topology_, edge));
        return places;
    }

    /// From a place to the nearest of some faces, if it is near any that it faces.
    [[nodiscard]] std::optional<Gap> gap(const Place& place, bool is_through,
                                         const std::vector<int>& faces,
                                         const ContactGapOptions& options) const
    {
        const auto [a, b] = place;
        const Vector3d here = 0.5 * (point(a) + point(b));
        const Foot foot = nearest(place, here, faces);
        if (foot.face < 0)
            return std::nullopt;
        const double edge = std::sqrt(0.5 * (square_around(a) + square_around(b)));
        const double reached = foot.normal.dot(here - foot.point);
        if (!(reached <= edge && reached >= (is_through ? -options.deepest * edge : 0.0)))
            return std::nullopt;
        Gap gap;
        gap.vertices = {a, b};
        gap.factors = {0.5, 0.5};
        for (int k = 0; k < 3; ++k) {
            gap.vertices.push_back(topology_.faces()(foot.face, k));
            gap.factors.push_back(-foot.weights[k]);
        }
        gap.direction = foot.normal;
        gap.least = std::min(options.margin * edge, reached + options.step * edge);
        gap.stiffness = options.stiffness / (edge * edge);
        return gap;
    }

private:
    [[nodiscard]] Vector3d point(int v) const { return points_.row(v); }

    /// The end of an edge behind a face that it crosses, and the one before it.
    [[nodiscard]] std::optional<std::pair<int, int>> ends_at(int edge, int face) const
    {
        const auto [p, q] = place_of(topology_, edge);
        const Eigen::RowVector3i t = topology_.faces().row(face);
        const auto at = [&](int v) { return points_.data() + 3 * v; };
        if (!crosses(at(p), at(q), {at(t[0]), at(t[1]), at(t[2])}))
            return std::nullopt;
        if (outward_ * side_of_plane(at(t[0]), at(t[1]), at(t[2]), at(p)) < 0)
            return std::pair(p, q);
        return std::pair(q, p);
    }

    [[nodiscard]] Foot nearest(const Place& place, const Vector3d& here,
                               const std::vector<int>& faces) const
    {
        const Vector3d normal = normals_.row(place[0]) + normals_.row(place[1]);
        std::vector<int> near(place.begin(), place.end()); // its own surface
        for (const int v : place)
            for (const Topology::Spoke& spoke : topology_.spokes(v))
                near.push_back(spoke.vertex);
        make_unique(near);
        Foot best;
        double least = std::numeric_limits<double>::infinity();
        for (const int f : faces) {
            const Eigen::RowVector3i t = topology_.faces().row(f);
            if (std::any_of(t.begin(), t.end(),
                            [&](int v) { return std::binary_search(near.begin(), near.end(), v); }))
                continue;
            const Vector3d w = nearest_in_triangle(here, point(t[0]), point(t[1]), point(t[2]));
            const auto mean = [&](const Points& values) -> Vector3d {
                return w[0] * values.row(t[0]) + w[1] * values.row(t[1]) + w[2] * values.row(t[2]);
            };
            const Vector3d foot = mean(points_);
            const double square = (here - foot).squaredNorm();
            if (!(square < least))
                continue;
            const Vector3d there = mean(normals_).stableNormalized();
            // Surfaces in contact face each other; at the rim of a contact they meet at up to a right angle,
            // which in a coarse mesh is a little more.
            constexpr double facing = 0.3;
            if (!(there.dot(normal) < facing * normal.norm()))
                continue;
            least = square;
            best = {f, w, foot, there};
        }
        return best;
    }

    /// Mean of the squared lengths of the edges at a vertex.
    [[nodiscard]] double square_around(int v) const
    {
        double sum = 0.0;
        for (const Topology::Spoke& spoke : topology_.spokes(v))
            sum += (point(spoke.vertex) - point(v)).squaredNorm();
        return sum / static_cast<double>(topology_.spokes(v).size());
    }

    const Topology& topology_;
    Points points_;
    int outward_;    // -1 if faces are clockwise seen from outside
    Points normals_; // of the vertices, outwards
};

/// Places around faces of pairs, and the faces that these cross, or are kept from.
std::map<Place, std::set<int>> places_around(const Topology& topology,
                                             const std::vector<FacePair>& pairs,
                                             const Patches& patches)
{
    std::map<Place, std::set<int>> opposite;
    for (const auto& [f, g] : pairs)
        for (const auto& [own, other] : {std::pair(f, g), std::pair(g, f)}) {
            for (const int v : patches.at(own).vertices)
                opposite[{v, v}].insert(other);
            for (const int e : patches.at(own).edges)
                opposite[place_of(topology, e)].insert(other);
        }
    return opposite;
}

} // namespace

void check(const ContactGapOptions& options)
{
    require_at_least(0, options.rings, "ContactGapOptions.rings");
    require_not_negative(options.margin, "ContactGapOptions.margin");
    require_positive(options.step, "ContactGapOptions.step");
    require_positive(options.deepest, "ContactGapOptions.deepest");
    require_not_negative(options.stiffness, "ContactGapOptions.stiffness");
}

std::vector<Gap> contact_gaps(const Topology& topology, const VectorXd& points,
                              const std::vector<FacePair>& pairs, const ContactGapOptions& options)
{
    check(options);
    Patches patches;
    for (const FacePair& pair : pairs)
        for (const int f : pair)
            if (patches.count(f) == 0)
                patches.emplace(f, patch_around(topology, f, options.rings));
    const auto opposite = places_around(topology, pairs, patches);
    const std::vector<std::pair<Place, std::set<int>>> places(opposite.begin(), opposite.end());
    const Surface surface(topology, points);
    const std::set<Place> through = surface.through(pairs, patches);
    std::vector<std::optional<Gap>> found(places.size());
    parallel_for(places.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto& [place, others] = places[i];
            std::vector<int> faces;
            for (const int other : others) {
                const std::vector<int>& some = patches.at(other).faces;
                faces.insert(faces.end(), some.begin(), some.end());
            }
            make_unique(faces);
            found[i] = surface.gap(place, through.count(place) > 0, faces, options);
        }
    });
    std::vector<Gap> gaps;
    for (std::optional<Gap>& gap : found)
        if (gap)
            gaps.push_back(*std::move(gap));
    return gaps;
}

} // namespace shape::internal
