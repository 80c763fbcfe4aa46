// SPDX-License-Identifier: MIT

#include "libshape/embedding/start/local_frames.h"

#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

constexpr std::size_t grain = 1024;

double corner(const Points& corner_angles, int halfedge)
{
    return corner_angles(halfedge / 3, halfedge % 3);
}

} // namespace

std::vector<Eigen::Matrix3d> halfedge_frames(const Topology& topology, const Points& corner_angles,
                                             const Eigen::VectorXd& dihedral_angles)
{
    if (corner_angles.rows() != topology.face_count())
        throw InvalidInput(join("corner_angles has ", corner_angles.rows(), " rows, the topology ",
                                topology.face_count(), " faces"));
    if (dihedral_angles.size() != topology.edge_count())
        throw InvalidInput(join("dihedral_angles has ", dihedral_angles.size(),
                                " entries, the topology ", topology.edge_count(), " edges"));
    std::vector<Eigen::Matrix3d> frames(to_size(topology.halfedge_count()));
    parallel_for(to_size(topology.vertex_count()), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            Eigen::Matrix3d frame = Eigen::Matrix3d::Identity();
            int before = -1;
            for (const int h : topology.outgoing(static_cast<int>(v))) {
                if (before >= 0)
                    frame = frame * turn_about_z(corner(corner_angles, before)) *
                            turn_about_x(-dihedral_angles[topology.edge(h)]);
                frames[to_size(h)] = frame;
                before = h;
            }
        }
    });
    return frames;
}

std::vector<Eigen::Matrix3d> frame_transitions(const Topology& topology,
                                               const Points& corner_angles,
                                               const std::vector<Eigen::Matrix3d>& frames)
{
    if (corner_angles.rows() != topology.face_count())
        throw InvalidInput(join("corner_angles has ", corner_angles.rows(), " rows, the topology ",
                                topology.face_count(), " faces"));
    if (frames.size() != to_size(topology.halfedge_count()))
        throw InvalidInput(join("frames has ", frames.size(), " entries, the topology ",
                                topology.halfedge_count(), " half-edges"));
    std::vector<Eigen::Matrix3d> transitions(to_size(topology.edge_count()));
    parallel_for(transitions.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t e = begin; e < end; ++e) {
            const int h = topology.edge_halfedges()(static_cast<Eigen::Index>(e), 0);
            const int next = Topology::next(h);
            transitions[e] = frames[to_size(h)] *
                             turn_about_z(std::numbers::pi - corner(corner_angles, next)) *
                             frames[to_size(next)].transpose();
        }
    });
    return transitions;
}

Eigen::Matrix3d turn_about_x(double angle)
{
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return Eigen::Matrix3d{{1.0, 0.0, 0.0}, {0.0, c, -s}, {0.0, s, c}};
}

Eigen::Matrix3d turn_about_z(double angle)
{
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return Eigen::Matrix3d{{c, -s, 0.0}, {s, c, 0.0}, {0.0, 0.0, 1.0}};
}

} // namespace shape::internal
