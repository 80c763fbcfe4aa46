// SPDX-License-Identifier: MIT

#include "libshape/embedding/face_layout.h"

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/vector_math.h"

namespace shape {
namespace {

using Eigen::Matrix3d;
using Eigen::VectorXd;

/// Cosine and sine of the corner between sides a and b, opposite side c; area4 is four times the area.
struct Corner
{
    double cosine, sine;

    Corner(double a, double b, double c, double area4)
        : cosine(std::clamp((a * a + b * b - c * c) / (2.0 * a * b), -1.0, 1.0)),
          sine(area4 / (2.0 * a * b))
    {
    }
};

/// Rz(h) Rx(t) Rz(pi - g): turn to the edge, bend about it, turn back from the opposite half-edge.
Matrix3d transition(double cos_h, double sin_h, double cos_t, double sin_t, double cos_g,
                    double sin_g)
{
    Matrix3d m;
    m << -cos_h * cos_g - sin_h * cos_t * sin_g, -cos_h * sin_g + sin_h * cos_t * cos_g,
        sin_h * sin_t, //
        -sin_h * cos_g + cos_h * cos_t * sin_g, -sin_h * sin_g - cos_h * cos_t * cos_g,
        -cos_h * sin_t, //
        sin_t * sin_g, -sin_t * cos_g, cos_t;
    return m;
}

} // namespace

FaceLayout lay_out_faces(const Topology& topology, const VectorXd& lengths,
                         const VectorXd& dihedral_angles)
{
    if (lengths.size() != topology.edge_count() || dihedral_angles.size() != topology.edge_count())
        throw InvalidInput(join("face layout: ", lengths.size(), " lengths and ",
                                dihedral_angles.size(), " dihedral angles for ",
                                topology.edge_count(), " edges"));
    FaceLayout layout;
    layout.halfedges.resize(topology.halfedge_count(), 3);
    parallel_for(
        static_cast<std::size_t>(topology.face_count()), 4096,
        [&](std::size_t begin, std::size_t end) {
            for (int f = static_cast<int>(begin); f < static_cast<int>(end); ++f) {
                const double a = lengths[topology.face_edges()(f, 0)];
                const double b = lengths[topology.face_edges()(f, 1)];
                const double c = lengths[topology.face_edges()(f, 2)];
                const double area4 =
                    std::sqrt(std::max(0.0, (a + b + c) * (b + c - a) * (c + a - b) * (a + b - c)));
                const Corner first(a, c, b, area4);
                const Corner second(a, b, c, area4);
                layout.halfedges.row(3 * f) << a, 0.0, 0.0;
                layout.halfedges.row(3 * f + 1) << -b * second.cosine, b * second.sine, 0.0;
                layout.halfedges.row(3 * f + 2) << -c * first.cosine, -c * first.sine, 0.0;
            }
        });
    layout.transitions.assign(static_cast<std::size_t>(topology.edge_count()),
                              Matrix3d::Identity());
    VectorXd sines(topology.edge_count());
    VectorXd cosines(topology.edge_count());
    parallel_for(static_cast<std::size_t>(topology.edge_count()), 2048,
                 [&](std::size_t begin, std::size_t end) {
                     sines_cosines(dihedral_angles.data() + begin, end - begin,
                                   sines.data() + begin, cosines.data() + begin);
                     for (int e = static_cast<int>(begin); e < static_cast<int>(end); ++e) {
                         if (topology.is_boundary_edge(e))
                             continue;
                         const auto left = layout.halfedges.row(topology.edge_halfedges()(e, 0));
                         const auto right = layout.halfedges.row(topology.edge_halfedges()(e, 1));
                         const double inverse = 1.0 / lengths[e];
                         layout.transitions[static_cast<std::size_t>(e)] =
                             transition(inverse * left[0], inverse * left[1], cosines[e], sines[e],
                                        inverse * right[0], inverse * right[1]);
                     }
                 });
    return layout;
}

VectorXd closure_cosines(const Topology& topology, const std::vector<Matrix3d>& transitions)
{
    VectorXd cosines = VectorXd::Ones(topology.vertex_count());
    parallel_for(static_cast<std::size_t>(topology.vertex_count()), 1024,
                 [&](std::size_t begin, std::size_t end) {
                     for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
                         if (topology.is_boundary_vertex(v))
                             continue;
                         Matrix3d walk = Matrix3d::Identity();
                         for (const int out : topology.outgoing(v)) {
                             const int h = Topology::previous(out);
                             const int e = topology.edge(h);
                             const Matrix3d& across = transitions[static_cast<std::size_t>(e)];
                             if (h == topology.edge_halfedges()(e, 0))
                                 walk *= across;
                             else
                                 walk *= across.transpose();
                         }
                         cosines[v] = std::clamp(0.5 * (walk.trace() - 1.0), -1.0, 1.0);
                     }
                 });
    return cosines;
}

} // namespace shape
