// SPDX-License-Identifier: MIT

#include "libshape/embedding/repair/fold_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "libshape/base/blocks.h"
#include "libshape/base/threads.h"
#include "libshape/base/vector_math.h"
#include "libshape/base/vectorised.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/vertex_regions.h"

namespace shape::internal {
namespace {

using Eigen::VectorXd;

using Values = std::array<double, block_size>; // of a block of edges
struct Vectors
{
    Values x, y, z;
};

/// Vectors in the direction of the dihedral angles of hinges: edges a-b, c on the left, d on the
/// right.
SHAPE_VECTORISED void bends(int count, const Vectors& a, const Vectors& b, const Vectors& c,
                            const Vectors& d, Values& __restrict sines, Values& __restrict cosines)
{
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        const double ux = b.x[i] - a.x[i], uy = b.y[i] - a.y[i], uz = b.z[i] - a.z[i];
        const double px = c.x[i] - a.x[i], py = c.y[i] - a.y[i], pz = c.z[i] - a.z[i];
        const double qx = d.x[i] - a.x[i], qy = d.y[i] - a.y[i], qz = d.z[i] - a.z[i];
        const double lx = uy * pz - uz * py, ly = uz * px - ux * pz, lz = ux * py - uy * px;
        const double rx = qy * uz - qz * uy, ry = qz * ux - qx * uz, rz = qx * uy - qy * ux;
        sines[i] = ux * (ly * rz - lz * ry) + uy * (lz * rx - lx * rz) + uz * (lx * ry - ly * rx);
        cosines[i] = std::sqrt(ux * ux + uy * uy + uz * uz) * (lx * rx + ly * ry + lz * rz);
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
        std::array<Vectors, 4> hinge;
        for (int i = 0; i < count; ++i) {
            const int left = t.edge_halfedges()(first + i, 0);
            const int right = t.edge_halfedges()(first + i, 1);
            const std::array<int, 4> corners = {
                t.edges()(first + i, 0), t.edges()(first + i, 1),
                t.source(Topology::previous(left)),
                t.source(Topology::previous(right < 0 ? left : right))};
            for (std::size_t k = 0; k < 4; ++k) {
                const double* const point = points.data() + 3 * corners[k];
                hinge[k].x[static_cast<std::size_t>(i)] = point[0];
                hinge[k].y[static_cast<std::size_t>(i)] = point[1];
                hinge[k].z[static_cast<std::size_t>(i)] = point[2];
            }
        }
        Values sines, cosines, angles;
        bends(count, hinge[0], hinge[1], hinge[2], hinge[3], sines, cosines);
        vector_angles(sines.data(), cosines.data(), static_cast<std::size_t>(count), angles.data());
        for (int e = first; e < first + count; ++e) {
            const double difference =
                angles[static_cast<std::size_t>(e - first)] - dihedral_angles[e];
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

std::vector<std::vector<int>> folded_regions(const Topology& t, const VectorXd& points,
                                             const VectorXd& dihedral_angles,
                                             const FoldRegionOptions& options)
{
    constexpr std::size_t grain = 64 * block_size;
    const auto edges = static_cast<std::size_t>(t.edge_count());
    std::vector<std::vector<Suspect>> suspects((edges + grain - 1) / grain);
    parallel_for(edges, grain, [&](std::size_t begin, std::size_t end) {
        suspects[begin / grain] = suspects_among(t, points, dihedral_angles, options.suspect_angle,
                                                 static_cast<int>(begin), static_cast<int>(end));
    });

    std::vector<int> seeds;
    std::vector<char> folded(static_cast<std::size_t>(t.vertex_count()), 0);
    for (const std::vector<Suspect>& part : suspects)
        for (const auto& [edge, drift] : part) {
            for (const int h : {t.edge_halfedges()(edge, 0), t.edge_halfedges()(edge, 1)}) {
                seeds.push_back(t.source(h));
                seeds.push_back(t.source(Topology::previous(h)));
            }
            if (drift > options.fold_angle)
                folded[static_cast<std::size_t>(t.edges()(edge, 0))] = 1;
        }
    std::vector<std::vector<int>> regions = regions_around(t, seeds, options.rings);
    std::erase_if(regions, [&](const std::vector<int>& region) {
        return std::none_of(region.begin(), region.end(),
                            [&](int v) { return folded[static_cast<std::size_t>(v)] != 0; });
    });
    return regions;
}

} // namespace shape::internal
