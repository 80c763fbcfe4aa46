// SPDX-License-Identifier: MIT

#include "libshape/embedding/closure/closure_embedding.h"

#include <cmath>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/closure/vertex_frames.h"
#include "libshape/embedding/closure/vertex_positions.h"
#include "libshape/embedding/start/local_frames.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape::internal {
namespace {

void check(const Topology& topology, const Eigen::VectorXd& lengths)
{
    const Admissibility admissibility = check_admissibility(topology, lengths);
    if (!admissibility.triangles.empty())
        throw NumericalError(describe(admissibility, topology, lengths));
}

} // namespace

ClosureEmbedding embed_by_closure(const Topology& topology, const ShapePoint& target,
                                  const LbfgsOptions& options, const Progress& progress)
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

} // namespace shape::internal
