// SPDX-License-Identifier: MIT

#include "libshape/mesh/handedness.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/order_statistics.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/alignment.h"
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

/// The volume for its area: 0.094 of a sphere, negative inside out.
double fill_of(const Measures& m)
{
    return m.area > 0.0 ? m.volume / std::pow(m.area, 1.5) : 0.0;
}

/// Which side of the surface is its inside: +1 if the faces run as they should, -1 if they are turned
/// inside out, 0 if that cannot be told.
int outward_sign(const Measures& m)
{
    // A closed surface has a sign unless its volume is rounding. The fans of an open one are a guess: below a fifth of
    // a sphere's, or where they are large beside the surface, as over a sheet or a bowl, they decide and not the
    // surface.
    const bool is_closed = m.openings == 0.0;
    const double fill = fill_of(m);
    if (std::abs(fill) <= (is_closed ? 1e-9 : 0.02) || m.openings > 0.25 * m.area)
        return 0;
    return fill > 0.0 ? 1 : -1;
}

/// Interior edges, drawn evenly.
std::vector<int> compared_edges(const Topology& topology)
{
    std::vector<int> interior;
    for (int e = 0; e < topology.edge_count(); ++e)
        if (!topology.is_boundary_edge(e))
            interior.push_back(e);
    const std::size_t count = std::min<std::size_t>(interior.size(), most_angles);
    std::vector<int> chosen;
    for (std::size_t k = 0; k < count; ++k)
        chosen.push_back(interior[k * interior.size() / count]);
    return chosen;
}

/// Sines of the dihedral angles there. A fold of 179 degrees and one of -179 are much the
/// same, and their sines are; a few of them would outweigh all other angles.
Eigen::VectorXd bending(const Topology& topology, const std::vector<int>& edges,
                        const Points& points)
{
    const auto at = [&](int v) -> Eigen::Vector3d { return points.row(v).transpose(); };
    Eigen::VectorXd sines(std::ssize(edges));
    for (std::size_t k = 0; k < edges.size(); ++k) {
        const int h = topology.edge_halfedges()(edges[k], 0);
        const int back = topology.edge_halfedges()(edges[k], 1);
        sines[static_cast<Eigen::Index>(k)] = std::sin(dihedral_angle(
            at(topology.source(h)), at(topology.target(h)), at(topology.target(Topology::next(h))),
            at(topology.target(Topology::next(back)))));
    }
    return sines;
}

/// What lies within 60 to 120 degrees, as flat or rough meshes and far poses do, is left alone.
int side_of(double cosine)
{
    return cosine > 0.5 ? 1 : cosine < -0.5 ? -1 : 0;
}

/// +1 or -1 for each mesh by the side of the others' common direction that it lies on, 0 in between.
/// @param directions  A row a mesh, of norm 1 or 0.
std::vector<int> sides(const Eigen::MatrixXd& directions)
{
    Eigen::VectorXd common = directions.row(0).transpose();
    Eigen::VectorXd signs;
    for (int round = 0; round < 4; ++round) { // a fixed number, so that it ends
        signs = (directions * common).array().sign();
        common = directions.transpose() * signs;
    }
    // Of few meshes each would agree with a direction that is partly its own, and of two that have nothing in
    // common one would be a mirror image whenever their cosine is below 0.
    std::vector<int> result;
    for (Eigen::Index i = 0; i < directions.rows(); ++i) {
        const Eigen::VectorXd others = common - signs[i] * directions.row(i).transpose();
        const double norm = others.norm();
        result.push_back(norm > 1e-9 ? side_of(directions.row(i).dot(others) / norm) : 0);
    }
    return result;
}

/// +1 or -1 for each closed mesh by the sign of its volume; 0 where that is small beside the others': the faces of a mesh
/// with permuted vertices cross one another, and their volumes cancel.
std::vector<int> sides_of_closed(const std::vector<Measures>& measures)
{
    constexpr double least_share = 0.25; // poses of bodies and vertebrae keep 0.7 and more
    std::vector<double> fills;
    for (const Measures& m : measures)
        fills.push_back(std::abs(fill_of(m)));
    const double least = least_share * median(fills);
    std::vector<int> result;
    for (const Measures& m : measures)
        result.push_back(std::abs(fill_of(m)) < least ? 0 : outward_sign(m));
    return result;
}

/// bending() of each mesh, a row each.
Eigen::MatrixXd all_bending(const Topology& topology, std::span<const Points> meshes)
{
    const std::vector<int> edges = compared_edges(topology);
    Eigen::MatrixXd sines(std::ssize(meshes), std::ssize(edges));
    for (std::size_t i = 0; i < meshes.size(); ++i)
        sines.row(static_cast<Eigen::Index>(i)) = bending(topology, edges, meshes[i]).transpose();
    return sines;
}

/// Rows of norm 1, or 0.
Eigen::MatrixXd unit_rows(Eigen::MatrixXd rows)
{
    for (auto row : rows.rowwise())
        row.normalize();
    return rows;
}

/// What keeps a surface from lying flat [rad]: the curvature at each vertex within, and what a boundary turns by too much
/// or too little for a plane, as the ends of a tube do.
struct Curvature
{
    Eigen::VectorXd within; ///< 0 on the boundary.
    double of_loops = 0.0;

    [[nodiscard]] double sum() const { return within.lpNorm<1>() + of_loops; }
};

Curvature curvature(const Topology& topology, const std::vector<std::vector<int>>& loops,
                    const Points& points)
{
    constexpr double pi = std::numbers::pi;
    Eigen::VectorXd left = Eigen::VectorXd::Constant(topology.vertex_count(), 2.0 * pi);
    for (const auto& face : topology.faces().rowwise())
        for (int c = 0; c < 3; ++c) {
            const Eigen::RowVector3d at = points.row(face[c]);
            const Eigen::RowVector3d a = points.row(face[(c + 1) % 3]) - at;
            const Eigen::RowVector3d b = points.row(face[(c + 2) % 3]) - at;
            left[face[c]] -= std::atan2(a.cross(b).norm(), a.dot(b));
        }
    Curvature found;
    for (const std::vector<int>& loop : loops) {
        double turn = 0.0;
        for (const int h : loop) {
            double& at = left[topology.source(h)];
            turn += at - pi;
            at = 0.0;
        }
        found.of_loops += std::abs(std::abs(turn) - 2.0 * pi);
    }
    found.within = std::move(left);
    return found;
}

// [rad]; set by hand: see may_bend_over() and compare_handedness()
constexpr double most_of_a_sheet = 1.0;
constexpr double most_of_a_membrane = 20.0;

/// The strain that laying flat what meshes have in common would take, without their noise: that has no mean over the
/// meshes, and none over a few rings either, as an angle that is too large at one vertex is too small beside it.
double common_strain(const Topology& topology, const std::vector<std::vector<int>>& loops,
                     std::span<const Points> meshes)
{
    constexpr int rounds = 5; // of which each gives half of the curvature to the neighbours
    Curvature common{Eigen::VectorXd::Zero(topology.vertex_count()), 0.0};
    const auto count = static_cast<double>(meshes.size());
    for (const Points& points : meshes) {
        const Curvature one = curvature(topology, loops, points);
        common.within += one.within / count;
        common.of_loops += one.of_loops / count;
    }
    for (int round = 0; round < rounds; ++round) {
        Eigen::VectorXd next = 0.5 * common.within;
        for (int v = 0; v < topology.vertex_count(); ++v) {
            const auto spokes = topology.spokes(v);
            for (const Topology::Spoke& spoke : spokes)
                next[spoke.vertex] += 0.5 * common.within[v] / static_cast<double>(spokes.size());
        }
        common.within = std::move(next);
    }
    return common.sum();
}

/// How far some vertices of a mesh are from those of another after the best rigid motion, by their size [1].
double distance_of(const Points& moving, const Points& fixed)
{
    const auto unit = [](Points points) {
        points.rowwise() -= points.colwise().mean().eval();
        const double size = points.norm();
        return size > 0.0 ? Points(points / size) : points;
    };
    const Points a = unit(moving);
    const Points b = unit(fixed);
    return (best_rigid_motion(a, b)(a) - b).norm();
}

/// Whether the mirror image of a mesh is much nearer to one of the others than the mesh is to any. It is not where its
/// middle was pushed through and its rim is where it was.
bool is_nearer_mirrored(const Points& mesh, const std::vector<const Points*>& others)
{
    constexpr double nearer = 0.7;
    constexpr Eigen::Index most_vertices = 500;
    constexpr std::size_t most_meshes = 20;
    std::vector<Eigen::Index> some;
    const Eigen::Index count = std::min(mesh.rows(), most_vertices);
    for (Eigen::Index k = 0; k < count; ++k)
        some.push_back(k * mesh.rows() / count);
    const Points as_is = mesh(some, Eigen::all);
    Points mirrored = as_is;
    mirrored.col(0) = -as_is.col(0);
    double direct = std::numeric_limits<double>::infinity();
    double reflected = direct;
    const std::size_t compared = std::min(others.size(), most_meshes);
    for (std::size_t k = 0; k < compared; ++k) {
        const Points other = (*others[k * others.size() / compared])(some, Eigen::all);
        direct = std::min(direct, distance_of(as_is, other));
        reflected = std::min(reflected, distance_of(mirrored, other));
    }
    return reflected < nearer * direct;
}

/// Whether an open surface may as well have been bent or pushed through as mirrored.
bool is_guess(const Topology& topology, const std::vector<std::vector<int>>& loops,
              std::span<const Points> meshes, const std::vector<std::size_t>& odd,
              const std::vector<int>& side)
{
    if (common_strain(topology, loops, meshes) < most_of_a_membrane)
        return true;
    std::vector<const Points*> others;
    for (std::size_t i = 0; i < meshes.size(); ++i)
        if (side[i] != 0 && side[i] != side[odd.front()])
            others.push_back(&meshes[i]);
    return !others.empty() && !std::ranges::all_of(odd, [&](std::size_t i) {
        return is_nearer_mirrored(meshes[i], others);
    });
}

/// Whether those that are mirrored have their insides on the other side than the rest, so far as that can be told: a bag
/// with a wide opening can be pulled inside out as well.
bool are_turned_inside_out(const std::vector<Measures>& measures, const std::vector<int>& outward,
                           const std::vector<int>& side, int odd)
{
    constexpr double most_open = 0.1; // of the area
    int others = 0;
    for (std::size_t i = 0; i < side.size(); ++i) {
        if (side[i] == 0)
            continue;
        if (measures[i].openings > most_open * measures[i].area)
            return false;
        const int expected = side[i] == odd ? -outward[i] : outward[i];
        if (expected == 0 || expected == -others)
            return false;
        others = expected;
    }
    return others != 0;
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
    std::vector<Measures> measures(meshes.size());
    parallel_for(meshes.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            measures[i] = measure(topology, loops, meshes[i]);
    });
    std::vector<int> outward;
    for (const Measures& m : measures)
        outward.push_back(outward_sign(m));
    const std::vector<int> side = topology.is_closed()
                                      ? sides_of_closed(measures)
                                      : sides(unit_rows(all_bending(topology, meshes)));

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
        } else if (side[i] != 0 || !topology.is_closed()) {
            has_others = true;
            result.inside_out = result.inside_out && outward[i] < 0;
        }
    }
    result.inside_out = result.inside_out && has_others;
    if (!result.mirrored.empty() && !topology.is_closed() &&
        !are_turned_inside_out(measures, outward, side, odd) &&
        is_guess(topology, loops, meshes, result.mirrored, side))
        std::swap(result.mirrored, result.bent);
    return result;
}

bool is_mirror_image(const Topology& topology, const Points& mesh, const Points& reference,
                     const Eigen::VectorXd& mean_dihedral_angles)
{
    const std::array<Points, 2> both{reference, mesh};
    if (topology.is_closed() || mean_dihedral_angles.size() == 0) {
        const Handedness found = compare_handedness(topology, both);
        return !found.mirrored.empty() || !found.bent.empty();
    }
    if (mean_dihedral_angles.size() != topology.edge_count() ||
        mesh.rows() != topology.vertex_count())
        throw InvalidInput(join("there are ", mean_dihedral_angles.size(), " mean angles and ",
                                mesh.rows(), " vertices, must be ", topology.edge_count(), " and ",
                                topology.vertex_count()));
    const std::vector<int> edges = compared_edges(topology);
    const Eigen::VectorXd mean = mean_dihedral_angles(edges).array().sin();
    const double norm = mean.norm();
    return norm > 0.0 && side_of(bending(topology, edges, mesh).normalized().dot(mean) / norm) < 0;
}

bool may_be_bent(const Topology& topology, const Points& mesh, const Points& reference,
                 const Eigen::VectorXd& mean_dihedral_angles)
{
    if (topology.is_closed())
        return false;
    if (mean_dihedral_angles.size() == 0)
        return !compare_handedness(topology, std::array{reference, mesh}).bent.empty();
    if (!is_mirror_image(topology, mesh, reference, mean_dihedral_angles))
        return false;
    return common_strain(topology, boundary_loops(topology), std::array{mesh}) < most_of_a_membrane;
}

bool may_bend_over(const Topology& topology, const Points& points)
{
    if (points.rows() != topology.vertex_count())
        throw InvalidInput(join("points has ", points.rows(), " rows, must have ",
                                topology.vertex_count(), ", one a vertex"));
    return !topology.is_closed() && topology.genus() == 0 &&
           curvature(topology, boundary_loops(topology), points).sum() < most_of_a_sheet;
}

} // namespace shape
