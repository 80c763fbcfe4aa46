// SPDX-License-Identifier: MIT

#include "libshape/embedding/length_dihedral_energy.h"

#include <Eigen/Geometry>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/mesh/dihedral_angles.h"

namespace shape {

using Eigen::Vector3d;
using Eigen::VectorXd;

LengthDihedralEnergy::LengthDihedralEnergy(const Topology& topology, const ShapePoint& target,
                                           double smoothness)
    : topology_(topology), target_(target), smoothness_(smoothness)
{
    const int edges = topology.edge_count();
    if (target.edge_lengths.size() != edges || target.dihedral_angles.size() != edges)
        throw InvalidInput(join("target has ", target.edge_lengths.size(), " lengths and ",
                                target.dihedral_angles.size(), " dihedral angles, the topology ",
                                edges, " edges"));
    for (int e = 0; e < edges; ++e)
        if (!(target.edge_lengths[e] > 0.0 && std::isfinite(target.edge_lengths[e]) &&
              std::isfinite(target.dihedral_angles[e])))
            throw InvalidInput(join("target: edge ", e, " (", topology.edges()(e, 0), "-",
                                    topology.edges()(e, 1), ") has length ", target.edge_lengths[e],
                                    " and dihedral angle ", target.dihedral_angles[e],
                                    "; lengths must be > 0, both finite"));
    if (!(smoothness > 0.0 && std::isfinite(smoothness)))
        throw InvalidInput(join("smoothness is ", smoothness, ", must be > 0 and finite"));
}

double LengthDihedralEnergy::evaluate(const VectorXd& points, VectorXd& gradient) const
{
    const Topology& t = topology_;
    const auto point = [&](int v) { return points.segment<3>(3 * v); };

    // Normals as long as twice the area, and their inverse squares (0 where there is no area).
    Points normals(t.face_count(), 3);
    VectorXd inverse_square(t.face_count());
    parallel_for(
        static_cast<std::size_t>(t.face_count()), 2048, [&](std::size_t begin, std::size_t end) {
            for (int f = static_cast<int>(begin); f < static_cast<int>(end); ++f) {
                const Vector3d a = point(t.faces()(f, 0));
                const Vector3d n = (point(t.faces()(f, 1)) - a).cross(point(t.faces()(f, 2)) - a);
                normals.row(f) = n;
                const double square = n.squaredNorm();
                inverse_square[f] = square > 0.0 ? 1.0 / square : 0.0;
            }
        });

    // Per edge: dE/dl / l and dE/dtheta.
    VectorXd pull(t.edge_count());
    VectorXd moment(t.edge_count());
    const double energy = parallel_sum(
        static_cast<std::size_t>(t.edge_count()), 2048, [&](std::size_t begin, std::size_t end) {
            double sum = 0.0;
            for (int e = static_cast<int>(begin); e < static_cast<int>(end); ++e) {
                const Vector3d axis = point(t.edges()(e, 1)) - point(t.edges()(e, 0));
                const double length = axis.norm();
                const double strain = length / target_.edge_lengths[e] - 1.0;
                sum += strain * strain;
                pull[e] = length > 0.0 ? 2.0 * strain / (target_.edge_lengths[e] * length) : 0.0;
                moment[e] = 0.0;
                if (t.is_boundary_edge(e))
                    continue;
                const Vector3d left = normals.row(t.edge_halfedges()(e, 0) / 3);
                const Vector3d right = normals.row(t.edge_halfedges()(e, 1) / 3);
                const double angle =
                    std::atan2(axis.dot(left.cross(right)), length * left.dot(right));
                const double bend = wrapped_angle(angle - target_.dihedral_angles[e]);
                sum += smoothness_ * bend * bend;
                moment[e] = 2.0 * smoothness_ * bend;
            }
            return sum;
        });

    // A corner moves along the normal of its face: by how much, summed over the face's three edges.
    // Over edge i-j with opposite corner m, d theta / d x_m = -l n / |n|^2, and i and j share the
    // opposite of it in proportion to where the foot of m lies.
    Points along_normal(t.face_count(), 3);
    parallel_for(
        static_cast<std::size_t>(t.face_count()), 2048, [&](std::size_t begin, std::size_t end) {
            for (int f = static_cast<int>(begin); f < static_cast<int>(end); ++f) {
                Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
                for (int i = 0; i < 3; ++i) {
                    const int j = (i + 1) % 3;
                    const int m = (i + 2) % 3;
                    const double s = moment[t.face_edges()(f, i)];
                    const Vector3d axis = point(t.faces()(f, j)) - point(t.faces()(f, i));
                    const double length = axis.norm();
                    const double foot =
                        length > 0.0
                            ? (point(t.faces()(f, m)) - point(t.faces()(f, i))).dot(axis) / length
                            : 0.0;
                    sum[m] -= s * length;
                    sum[i] += s * (length - foot);
                    sum[j] += s * foot;
                }
                along_normal.row(f) = inverse_square[f] * sum;
            }
        });

    gradient.resize(points.size());
    parallel_for(static_cast<std::size_t>(t.vertex_count()), 1024,
                 [&](std::size_t begin, std::size_t end) {
                     for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
                         Vector3d sum = Vector3d::Zero();
                         const Vector3d here = point(v);
                         const auto pulled_from = [&](int h, int other) {
                             sum += pull[t.edge(h)] * (here - point(other));
                         };
                         for (const int h : t.outgoing(v)) {
                             sum += along_normal(h / 3, h % 3) * normals.row(h / 3).transpose();
                             pulled_from(h, t.target(h));
                             const int incoming = Topology::previous(h);
                             if (t.opposite(incoming) < 0) // the last edge of an open fan
                                 pulled_from(incoming, t.source(incoming));
                         }
                         gradient.segment<3>(3 * v) = sum;
                     }
                 });
    return energy;
}

} // namespace shape
