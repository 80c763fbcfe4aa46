// SPDX-License-Identifier: MIT

#include "libshape/embedding/face_layout.h"

#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/embedding/local_frames.h"

namespace shape {

FaceLayout lay_out_faces(const Topology& topology, const Eigen::VectorXd& lengths,
                         const Points& corner_angles, const Eigen::VectorXd& dihedral_angles)
{
    if (lengths.size() != topology.edge_count() ||
        dihedral_angles.size() != topology.edge_count() ||
        corner_angles.rows() != topology.face_count())
        throw InvalidInput(
            join("face layout: ", lengths.size(), " lengths, ", dihedral_angles.size(),
                 " dihedral angles and ", corner_angles.rows(), " rows of corner angles for ",
                 topology.edge_count(), " edges and ", topology.face_count(), " faces"));
    constexpr double pi = std::numbers::pi;
    FaceLayout layout;
    layout.halfedges.resize(topology.halfedge_count(), 3);
    Eigen::VectorXd headings(topology.halfedge_count()); // angle to half-edge 3 f
    parallel_for(static_cast<std::size_t>(topology.face_count()), 4096,
                 [&](std::size_t begin, std::size_t end) {
                     for (int f = static_cast<int>(begin); f < static_cast<int>(end); ++f) {
                         headings[3 * f] = 0.0;
                         headings[3 * f + 1] = pi - corner_angles(f, 1);
                         headings[3 * f + 2] = pi + corner_angles(f, 0);
                         for (int h = 3 * f; h < 3 * f + 3; ++h) {
                             const double l = lengths[topology.edge(h)];
                             layout.halfedges.row(h) << l * std::cos(headings[h]),
                                 l * std::sin(headings[h]), 0.0;
                         }
                     }
                 });
    layout.transitions.assign(static_cast<std::size_t>(topology.edge_count()),
                              Eigen::Matrix3d::Identity());
    parallel_for(static_cast<std::size_t>(topology.edge_count()), 2048,
                 [&](std::size_t begin, std::size_t end) {
                     for (int e = static_cast<int>(begin); e < static_cast<int>(end); ++e) {
                         if (topology.is_boundary_edge(e))
                             continue;
                         // Turn to the edge, bend about it, turn back from the opposite half-edge.
                         layout.transitions[static_cast<std::size_t>(e)] =
                             turn_about_z(headings[topology.edge_halfedges()(e, 0)]) *
                             turn_about_x(dihedral_angles[e]) *
                             turn_about_z(pi - headings[topology.edge_halfedges()(e, 1)]);
                     }
                 });
    return layout;
}

} // namespace shape
