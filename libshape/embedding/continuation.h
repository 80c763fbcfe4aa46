// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

struct ContinuationOptions
{
    double smoothness = 1e-4;         ///< mu of length_dihedral_energy.h; > 0.
    double decrease_tolerance = 1e-2; ///< As in gauss_newton.h.
    int max_iterations = 12;          ///< Gauss-Newton steps; >= 0.
};

struct ContinuedMesh
{
    Points points;       ///< #V by 3 [length], in the pose of the mesh before.
    double energy = 0.0; ///< E of length_dihedral_energy.h.
    int iterations = 0;
    bool converged = false;
};

/// Moves a mesh to a target nearby: the next mesh of a sequence. Its faces give the frames, which
/// the target's lengths and angles refine (face_fit.h); then Gauss-Newton steps. Edge lengths may
/// range over ten orders of magnitude.
/// @param from  #V by 3 [length], without degenerate faces.
/// @throws InvalidInput if a size is wrong, or target or options break a rule.
/// Cost: a sparse Cholesky factorisation of size 3 #V a step.
[[nodiscard]] ContinuedMesh continue_to(const Topology& topology, const Points& from,
                                        const ShapePoint& target,
                                        const ContinuationOptions& options = {});

} // namespace shape
