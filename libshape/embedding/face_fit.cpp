// SPDX-License-Identifier: MIT

#include "libshape/embedding/face_fit.h"

#include "libshape/base/threads.h"
#include "libshape/mesh/rotation_fit.h"

namespace shape {

using Eigen::Matrix3d;

std::vector<Matrix3d> fit_faces(const Topology& topology, const FaceLayout& layout,
                                const Eigen::VectorXd& weights, const Points& points,
                                std::vector<Matrix3d> frames)
{
    // Every face's part of the fits: sum over its half-edges of w (x_b - x_a) u^T.
    std::vector<Matrix3d> covariances(frames.size());
    parallel_for(frames.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            Matrix3d sum = Matrix3d::Zero();
            for (int h = static_cast<int>(3 * f); h < static_cast<int>(3 * f + 3); ++h)
                sum +=
                    weights[topology.edge(h)] *
                    (points.row(topology.target(h)) - points.row(topology.source(h))).transpose() *
                    layout.halfedges.row(h);
            covariances[f] = sum;
        }
    });
    parallel_for(frames.size(), 512, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            Matrix3d sum = covariances[f];
            for (int h = static_cast<int>(3 * f); h < static_cast<int>(3 * f + 3); ++h) {
                const int opposite = topology.opposite(h);
                if (opposite < 0)
                    continue;
                const int edge = topology.edge(h);
                const auto neighbour = static_cast<std::size_t>(opposite / 3);
                const Matrix3d& across = layout.transitions[static_cast<std::size_t>(edge)];
                if (topology.edge_halfedges()(edge, 0) == h)
                    sum.noalias() += 0.5 * (covariances[neighbour] * across.transpose());
                else
                    sum.noalias() += 0.5 * (covariances[neighbour] * across);
            }
            frames[f] = nearest_rotation(sum, frames[f]);
        }
    });
    return frames;
}

} // namespace shape
