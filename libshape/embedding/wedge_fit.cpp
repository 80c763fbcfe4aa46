// SPDX-License-Identifier: MIT

#include "libshape/embedding/wedge_fit.h"

#include "libshape/base/threads.h"
#include "libshape/mesh/rotation_fit.h"

namespace shape {

using Eigen::Matrix3d;

std::vector<Matrix3d> fit_wedges(const Topology& topology, const FaceLayout& layout,
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
    std::vector<Matrix3d> fits(static_cast<std::size_t>(topology.edge_count()));
    parallel_for(fits.size(), 512, [&](std::size_t begin, std::size_t end) {
        for (std::size_t e = begin; e < end; ++e) {
            const auto edge = static_cast<int>(e);
            if (topology.is_boundary_edge(edge))
                continue;
            const auto left = static_cast<std::size_t>(topology.edge_halfedges()(edge, 0) / 3);
            const auto right = static_cast<std::size_t>(topology.edge_halfedges()(edge, 1) / 3);
            fits[e] = nearest_rotation(
                covariances[left] + covariances[right] * layout.transitions[e].transpose(),
                frames[left]);
        }
    });
    parallel_for(frames.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            Matrix3d sum = Matrix3d::Zero();
            int wedges = 0;
            for (int h = static_cast<int>(3 * f); h < static_cast<int>(3 * f + 3); ++h) {
                if (topology.opposite(h) < 0)
                    continue;
                const int edge = topology.edge(h);
                const auto e = static_cast<std::size_t>(edge);
                if (topology.edge_halfedges()(edge, 0) == h)
                    sum += fits[e];
                else
                    sum += fits[e] * layout.transitions[e];
                ++wedges;
            }
            if (wedges > 0)
                frames[f] = sum / wedges;
        }
    });
    return frames;
}

} // namespace shape
