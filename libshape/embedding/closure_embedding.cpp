// SPDX-License-Identifier: MIT

#include "libshape/embedding/closure_embedding.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/local_frames.h"
#include "libshape/embedding/vertex_frames.h"
#include "libshape/embedding/vertex_positions.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
namespace {

// TODO: check_admissibility() once it has landed.
std::vector<TriangleViolation> broken_triangles(const Topology& topology,
                                                const Eigen::VectorXd& lengths)
{
    std::vector<TriangleViolation> broken;
    for (int f = 0; f < topology.face_count(); ++f) {
        double sum = 0.0;
        double longest = 0.0;
        for (int c = 0; c < 3; ++c) {
            sum += lengths[topology.face_edges()(f, c)];
            longest = std::max(longest, lengths[topology.face_edges()(f, c)]);
        }
        if (longest >= sum - longest)
            broken.push_back({f, longest / (sum - longest) - 1.0});
    }
    std::sort(broken.begin(), broken.end(),
              [](const auto& a, const auto& b) { return a.excess > b.excess; });
    return broken;
}

void check(const Topology& topology, const Eigen::VectorXd& lengths)
{
    if (lengths.size() != topology.edge_count())
        throw InvalidInput(join("edge_lengths has ", lengths.size(), " entries, the topology ",
                                topology.edge_count(), " edges"));
    for (Eigen::Index e = 0; e < lengths.size(); ++e)
        if (!std::isfinite(lengths[e]) || lengths[e] <= 0.0)
            throw InvalidInput(
                join("length of edge ", e, " is ", lengths[e], ", must be finite and > 0"));
    const std::vector<TriangleViolation> broken = broken_triangles(topology, lengths);
    if (!broken.empty())
        throw NumericalError(join("the lengths of ", broken.size(),
                                  " face(s) break the triangle inequality; the worst is face ",
                                  broken.front().face,
                                  ", whose longest edge exceeds the others "
                                  "together by ",
                                  100.0 * broken.front().excess, " %"));
}

} // namespace

ClosureEmbedding embed_by_closure(const Topology& topology, const ShapePoint& target,
                                  const DihedralSolverOptions& options, const Progress& progress)
{
    const Eigen::VectorXd& lengths = target.edge_lengths;
    check(topology, lengths);
    const Points corners = corner_angles(topology, lengths);
    ClosureEmbedding result;
    result.solution = solve_dihedrals(topology, corners, target.dihedral_angles, options, progress);
    const std::vector<Eigen::Matrix3d> local =
        halfedge_frames(topology, corners, result.solution.dihedral_angles);
    const std::vector<Eigen::Matrix3d> frames =
        vertex_frames(topology, frame_transitions(topology, corners, local));
    result.points = vertex_positions(topology, lengths, local, frames);
    return result;
}

} // namespace shape
