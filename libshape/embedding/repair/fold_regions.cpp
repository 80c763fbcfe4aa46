// SPDX-License-Identifier: MIT

#include "libshape/embedding/repair/fold_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "libshape/base/gathered_vectors.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/base/vectorised.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/hinge.h"
#include "libshape/mesh/vertex_regions.h"

namespace shape::internal {
namespace {

using Eigen::VectorXd;

// Every edge's dihedral angle, atan2(u . (l x r), |u| l . r) with the edge u = b - a and normals l, r of the
// triangles beside it. In memory the corners of a block of 128 edges, copied from the rows of the mesh:
//
//     a   x: x0 x1 .. x127   y: y0 .. y127   z: z0 .. z127,   then b, c, d the same
//
// so that the arithmetic and the arc tangents run on whole registers: dihedral_angle() edge by edge spends
// most of its time in atan2. Angles are compared before they are wrapped: few are near
// the bound.

/// Vectors in the direction of the dihedral angles of hinges (mesh/hinge.h).
SHAPE_VECTORISED void bends(int count, const VectorRows& a, const VectorRows& b,
                            const VectorRows& c, const VectorRows& d, Row& __restrict sines,
                            Row& __restrict cosines)
{
    for (int i = 0; i < count; ++i) {
        const Vector3<double> edge = b[i] - a[i];
        const auto normals = hinge_normals(edge, c[i] - a[i], d[i] - a[i]);
        const auto angle =
            hinge_angle(edge, std::sqrt(dot(edge, edge)), normals.left, normals.right);
        sines[i] = angle.sine;
        cosines[i] = angle.cosine;
    }
}

struct Suspect
{
    int edge;
    double drift; ///< |theta - theta*| [rad]
};

/// Of the edges [begin, end).
std::vector<Suspect> suspects_among(const Topology& t, const VectorXd& points,
                                    const VectorXd& dihedral_angles, double suspect_angle,
                                    int begin, int end)
{
    std::vector<Suspect> suspects;
    for (int first = begin; first < end; first += block_size) {
        const int count = std::min(block_size, end - first);
        std::array<std::array<int, 4>, block_size> hinges;
        for (int i = 0; i < count; ++i) {
            std::array<int, 4>& hinge = hinges[to_size(i)];
            hinge = hinge_corners(t, first + i);
            if (hinge[3] < 0) // the boundary, which is not looked at
                hinge[3] = hinge[2];
        }
        std::array<VectorRows, 4> corners;
        for (int k = 0; k < 4; ++k)
            gather(count, points.data(), {hinges[0].data() + k, 4}, corners[to_size(k)]);
        Row sines, cosines, angles;
        bends(count, corners[0], corners[1], corners[2], corners[3], sines, cosines);
        vector_angles(sines, cosines, to_size(count), angles);
        for (int e = first; e < first + count; ++e) {
            const double difference = angles[e - first] - dihedral_angles[e];
            if (std::abs(difference) <= suspect_angle || t.is_boundary_edge(e))
                continue;
            const double drift = std::abs(wrapped_angle(difference));
            if (drift > suspect_angle)
                suspects.push_back({e, drift});
        }
    }
    return suspects;
}

} // namespace

void check(const FoldRegionOptions& options)
{
    require_not_negative(options.suspect_angle, "FoldRegionOptions.suspect_angle");
    require(options.fold_angle >= options.suspect_angle && std::isfinite(options.fold_angle),
            "FoldRegionOptions.fold_angle", options.fold_angle,
            join(">= suspect_angle, ", options.suspect_angle, ", and finite"));
    require_at_least(0, options.rings, "FoldRegionOptions.rings");
}

std::vector<std::vector<int>> folded_regions(const Topology& t, const VectorXd& points,
                                             const VectorXd& dihedral_angles,
                                             const FoldRegionOptions& options)
{
    check(options);
    constexpr std::size_t grain = 64 * block_size; // so much that handing it over costs little
    const auto edges = to_size(t.edge_count());
    std::vector<std::vector<Suspect>> suspects((edges + grain - 1) / grain);
    parallel_for(edges, grain, [&](std::size_t begin, std::size_t end) {
        suspects[begin / grain] = suspects_among(t, points, dihedral_angles, options.suspect_angle,
                                                 static_cast<int>(begin), static_cast<int>(end));
    });

    std::vector<int> seeds;
    std::vector<char> folded(to_size(t.vertex_count()), 0);
    for (const std::vector<Suspect>& part : suspects)
        for (const auto& [edge, drift] : part) {
            for (const int h : {t.edge_halfedges()(edge, 0), t.edge_halfedges()(edge, 1)}) {
                seeds.push_back(t.source(h));
                seeds.push_back(t.source(Topology::previous(h)));
            }
            if (drift > options.fold_angle)
                folded[to_size(t.edges()(edge, 0))] = 1;
        }
    std::vector<std::vector<int>> regions = regions_around(t, seeds, options.rings);
    std::erase_if(regions, [&](const std::vector<int>& region) {
        return std::none_of(region.begin(), region.end(),
                            [&](int v) { return folded[to_size(v)] != 0; });
    });
    return regions;
}

} // namespace shape::internal
