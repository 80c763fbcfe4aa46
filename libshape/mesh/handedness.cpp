// SPDX-License-Identifier: MIT

#include "libshape/mesh/handedness.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/order_statistics.h"
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

/// What keeps a surface from lying flat [rad]: the curvature within, and what a boundary turns by too much or too little
/// for a plane, as the ends of a tube do.
double curvature(const Topology& topology, const std::vector<std::vector<int>>& loops,
                 const Points& points)
{
    constexpr double pi = std::numbers::pi;
    std::vector<double> left(to_size(topology.vertex_count()), 2.0 * pi); // of the full angle
    for (const auto& face : topology.faces().rowwise())
        for (int c = 0; c < 3; ++c) {
            const Eigen::RowVector3d at = points.row(face[c]);
            const Eigen::RowVector3d a = points.row(face[(c + 1) % 3]) - at;
            const Eigen::RowVector3d b = points.row(face[(c + 2) % 3]) - at;
            left[to_size(face[c])] -= std::atan2(a.cross(b).norm(), a.dot(b));
        }
    double sum = 0.0;
    for (const std::vector<int>& loop : loops) {
        double turn = 0.0;
        for (const int h : loop) {
            double& at = left[to_size(topology.source(h))];
            turn += at - pi;
            at = 0.0;
        }
        sum += std::abs(std::abs(turn) - 2.0 * pi);
    }
    for (const double angle : left)
        sum += std::abs(angle);
    return sum;
}

// [rad]; set by hand: see may_bend_over() and compare_handedness()
constexpr double most_of_a_sheet = 1.0;
constexpr double most_of_a_membrane = 10.0;

/// How far each mesh bends along the direction that all have in common but for its sign; those left out that have
/// nothing of it though they are as rough as others.
/// @param sines  A row a mesh.
std::vector<double> bends_of(const Eigen::MatrixXd& sines, const std::vector<int>& side)
{
    const Eigen::VectorXd norms = sines.rowwise().norm();
    const double rough = 0.5 * median({norms.begin(), norms.end()});
    Eigen::VectorXd common = Eigen::VectorXd::Zero(sines.cols());
    for (Eigen::Index i = 0; i < sines.rows(); ++i)
        common += side[to_size(i)] * sines.row(i).transpose().normalized();
    common.normalize();
    std::vector<double> bends;
    for (Eigen::Index i = 0; i < sines.rows(); ++i)
        if (side[to_size(i)] != 0 || norms[i] < rough)
            bends.push_back(sines.row(i).dot(common));
    return bends;
}

/// Whether meshes bend to both sides of flat with nothing between, as left and right ones do, and not more and less
/// about it, as leaves that curl and membranes that swing.
bool has_gap(const std::vector<double>& bends)
{
    constexpr double least_gap = 10.0; // spreads, as odd_sizes() has it; of few, chance leaves six
    double squares = 0.0;
    double least = std::numeric_limits<double>::infinity(); // of those above 0
    double most = -least;                                   // of the others
    for (const bool above : {true, false}) {
        double sum = 0.0;
        double sum_of_squares = 0.0;
        double count = 0.0;
        for (const double bend : bends)
            if ((bend > 0.0) == above) {
                (above ? least : most) = above ? std::min(least, bend) : std::max(most, bend);
                sum += bend;
                sum_of_squares += bend * bend;
                count += 1.0;
            }
        if (count > 0.0)
            squares += std::max(0.0, sum_of_squares - sum * sum / count);
    }
    return least - most >=
           least_gap * std::sqrt(squares / static_cast<double>(std::ssize(bends) - 2));
}

/// Whether all bend as far as one another, to 10 %.
bool are_alike(const std::vector<double>& bends)
{
    double least = std::numeric_limits<double>::infinity();
    double most = 0.0;
    for (const double bend : bends) {
        least = std::min(least, std::abs(bend));
        most = std::max(most, std::abs(bend));
    }
    return most <= 1.1 * least;
}

/// Whether open meshes may as well bend more or less to either side.
bool is_guess(const Topology& topology, const std::vector<std::vector<int>>& loops,
              std::span<const Points> meshes, const Eigen::MatrixXd& sines,
              const std::vector<int>& side)
{
    constexpr std::size_t least_meshes = 5; // of fewer, how they vary is not known
    const std::vector<double> bends = bends_of(sines, side);
    if (bends.size() >= least_meshes)
        return !has_gap(bends);
    std::vector<double> curvatures;
    for (const Points& points : meshes)
        curvatures.push_back(curvature(topology, loops, points));
    const double usual = median(curvatures);
    return usual < most_of_a_sheet || (usual < most_of_a_membrane && !are_alike(bends));
}

/// Whether those that are mirrored have their insides on the other side than the rest, so far as that can be told.
bool are_turned_inside_out(const std::vector<int>& outward, const std::vector<int>& side, int odd)
{
    int others = 0;
    for (std::size_t i = 0; i < side.size(); ++i) {
        if (side[i] == 0)
            continue;
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
    const Eigen::MatrixXd sines =
        topology.is_closed() ? Eigen::MatrixXd() : all_bending(topology, meshes);
    const std::vector<int> side =
        topology.is_closed() ? sides_of_closed(measures) : sides(unit_rows(sines));

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
        !are_turned_inside_out(outward, side, odd) &&
        is_guess(topology, loops, meshes, sines, side))
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
    constexpr double alike = 1.5; // the mean of meshes is smoother than they are
    if (topology.is_closed())
        return false;
    if (mean_dihedral_angles.size() == 0)
        return !compare_handedness(topology, std::array{reference, mesh}).bent.empty();
    if (!is_mirror_image(topology, mesh, reference, mean_dihedral_angles))
        return false;
    if (may_bend_over(topology, mesh))
        return true;
    const std::vector<int> edges = compared_edges(topology);
    const Eigen::VectorXd mean = mean_dihedral_angles(edges).array().sin();
    const double ratio = std::abs(bending(topology, edges, mesh).dot(mean)) / mean.squaredNorm();
    return (ratio > alike || ratio < 1.0 / alike) &&
           curvature(topology, boundary_loops(topology), mesh) < most_of_a_membrane;
}

bool may_bend_over(const Topology& topology, const Points& points)
{
    if (points.rows() != topology.vertex_count())
        throw InvalidInput(join("points has ", points.rows(), " rows, must have ",
                                topology.vertex_count(), ", one a vertex"));
    return !topology.is_closed() && topology.genus() == 0 &&
           curvature(topology, boundary_loops(topology), points) < most_of_a_sheet;
}

} // namespace shape
