// SPDX-License-Identifier: MIT

#include "libshape/mesh/handedness.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/triangle_area.h"

namespace shape {
using namespace internal;
namespace {

/// So many angles tell a mesh from its mirror image (their cosine is 1 or -1, give or take the shape), and
/// the cost of large meshes stays that of small ones.
constexpr int most_angles = 2000;

/// Half-edges that run around each loop of the boundary, faces on their left.
std::vector<std::vector<int>> boundary_loops(const Topology& topology)
{
    std::vector<int> leaving(to_size(topology.vertex_count()), -1);
    for (int e = 0; e < topology.edge_count(); ++e)
        if (topology.is_boundary_edge(e)) {
            const int h = topology.edge_halfedges()(e, 0);
            leaving[to_size(topology.source(h))] = h;
        }
    std::vector<std::vector<int>> loops;
    for (int& start : leaving) {
        if (start < 0)
            continue;
        loops.emplace_back();
        for (int h = start; h >= 0;) {
            loops.back().push_back(h);
            int& next = leaving[to_size(topology.target(h))];
            leaving[to_size(topology.source(h))] = -1;
            h = next;
        }
    }
    return loops;
}

double volume_of(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b,
                 const Eigen::RowVector3d& c)
{
    return a.dot(b.cross(c)) / 6.0;
}

struct Measures
{
    double volume = 0.0;   ///< [length^3], openings filled by fans.
    double area = 0.0;     ///< [length^2] of the faces.
    double openings = 0.0; ///< [length^2] of the fans.
};

Measures measure(const Topology& topology, const std::vector<std::vector<int>>& loops,
                 const Points& points)
{
    const Eigen::RowVector3d origin = points.colwise().mean(); // far from the mesh, digits are lost
    const auto at = [&](int v) -> Eigen::RowVector3d { return points.row(v) - origin; };
    Measures sum;
    for (const auto& face : topology.faces().rowwise()) {
        const Eigen::RowVector3d a = at(face[0]);
        const Eigen::RowVector3d b = at(face[1]);
        const Eigen::RowVector3d c = at(face[2]);
        sum.volume += volume_of(a, b, c);
        sum.area += triangle_area(a, b, c);
    }
    for (const std::vector<int>& loop : loops) {
        Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
        for (const int h : loop)
            centre += at(topology.source(h)) / static_cast<double>(loop.size());
        for (const int h : loop) {
            const Eigen::RowVector3d a = at(topology.target(h));
            const Eigen::RowVector3d b = at(topology.source(h));
            sum.volume += volume_of(centre, a, b);
            sum.openings += triangle_area(centre, a, b);
        }
    }
    return sum;
}

/// Which side of the surface is its inside: +1 if the faces run as they should, -1 if they are turned
/// inside out, 0 if that cannot be told.
int outward_sign(const Measures& m)
{
    // A sphere has a fill of 0.094. A closed surface has a sign unless its volume is rounding. The fans of
    // an open one are a guess: below a fifth of a sphere's, or where they are large beside the surface, as
    // over a sheet or a bowl, they decide and not the surface.
    const bool is_closed = m.openings == 0.0;
    const double fill = m.volume / std::pow(m.area, 1.5);
    if (std::abs(fill) <= (is_closed ? 1e-9 : 0.02) || m.openings > 0.25 * m.area)
        return 0;
    return fill > 0.0 ? 1 : -1;
}

/// Dihedral angles at edges drawn evenly from the interior, of norm 1 (or 0: flat), a row a mesh.
Eigen::MatrixXd angle_directions(const Topology& topology, std::span<const Points> meshes)
{
    std::vector<int> interior;
    for (int e = 0; e < topology.edge_count(); ++e)
        if (!topology.is_boundary_edge(e))
            interior.push_back(e);
    const std::size_t count = std::min<std::size_t>(interior.size(), most_angles);
    Eigen::MatrixXd angles(meshes.size(), count);
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        const auto at = [&](int v) -> Eigen::Vector3d { return meshes[i].row(v).transpose(); };
        for (std::size_t k = 0; k < count; ++k) {
            const int e = interior[k * interior.size() / count];
            const int h = topology.edge_halfedges()(e, 0);
            const int back = topology.edge_halfedges()(e, 1);
            angles(row, static_cast<Eigen::Index>(k)) = dihedral_angle(
                at(topology.source(h)), at(topology.target(h)),
                at(topology.target(Topology::next(h))), at(topology.target(Topology::next(back))));
        }
        if (const double norm = angles.row(row).norm(); norm > 0.0)
            angles.row(row) /= norm;
    }
    return angles;
}

/// +1 or -1 for each mesh by the side of the common direction that its angles lie on, 0 in between.
std::vector<int> sides(const Eigen::MatrixXd& directions)
{
    Eigen::VectorXd common = directions.row(0).transpose();
    for (int round = 0; round < 4; ++round) { // a fixed number, so that it ends
        const Eigen::VectorXd signs = (directions * common).array().sign();
        common = (directions.transpose() * signs).normalized();
    }
    // Meshes of one kind have cosines near 1 and their mirror images near -1; what lies within 60 to 120
    // degrees, as flat or rough meshes do, is left alone.
    std::vector<int> result;
    for (const double cosine : directions* common)
        result.push_back(cosine > 0.5 ? 1 : cosine < -0.5 ? -1 : 0);
    return result;
}

} // namespace

double signed_volume(const Topology& topology, const Points& points)
{
    if (points.rows() != topology.vertex_count())
        throw InvalidInput(join("points has ", points.rows(), " rows, must have ",
                                topology.vertex_count(), ", one a vertex"));
    return measure(topology, boundary_loops(topology), points).volume;
}

Handedness compare_handedness(const Topology& topology, std::span<const Points> meshes)
{
    for (std::size_t i = 0; i < meshes.size(); ++i)
        if (meshes[i].rows() != topology.vertex_count())
            throw InvalidInput(join("meshes[", i, "] has ", meshes[i].rows(),
                                    " vertices, must have ", topology.vertex_count()));
    if (meshes.empty())
        return {};
    const std::vector<std::vector<int>> loops = boundary_loops(topology);
    std::vector<int> outward(meshes.size());
    parallel_for(meshes.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            outward[i] = outward_sign(measure(topology, loops, meshes[i]));
    });
    const std::vector<int> side =
        topology.is_closed() ? outward : sides(angle_directions(topology, meshes));

    const auto count = [&](int which) { return std::count(side.begin(), side.end(), which); };
    int odd = count(1) < count(-1) ? 1 : -1;
    if (count(1) == count(-1) && count(1) > 0) { // those inside out, if that can be told
        const auto first = std::find_if(side.begin(), side.end(), [](int s) { return s != 0; });
        const auto i = to_size(first - side.begin());
        odd = outward[i] < 0 ? *first : -*first;
    }
    Handedness result;
    bool has_others = false;
    result.inside_out = true;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        if (side[i] == odd) {
            result.mirrored.push_back(i);
        } else {
            has_others = true;
            result.inside_out = result.inside_out && outward[i] < 0;
        }
    }
    result.inside_out = result.inside_out && has_others;
    return result;
}

bool is_mirror_image(const Topology& topology, const Points& mesh, const Points& reference)
{
    const std::array<Points, 2> both{reference, mesh};
    return !compare_handedness(topology, both).mirrored.empty();
}

} // namespace shape
