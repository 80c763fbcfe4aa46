// SPDX-License-Identifier: MIT

#pragma once

#include <limits>
#include <optional>
#include <string>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/residual_field.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// What an embedding is worth.
enum class EmbeddingStatus
{
    Exact,       ///< Worst relative edge error <= 1e-6.
    Approximate, ///< The target may have no mesh, or the solver stopped short of it.
    Infeasible,  ///< The target breaks a triangle or vertex inequality: no mesh has these lengths.
};

/// How far a mesh is from the lengths and dihedral angles that it was made from.
struct EmbeddingReport
{
    EmbeddingStatus status = EmbeddingStatus::Approximate;
    std::string reason; ///< Why the target is infeasible, with the worst place; else empty.

    double edge_rms = 0.0;  ///< sqrt(mean (l - l*)^2) / mean(l*)  [1] (Rojas 2014, Fig. 12).
    double edge_max = 0.0;  ///< max |l - l*| / l*  [1]; below, l* <= 0 as in positive_lengths().
    double edge_p999 = 0.0; ///< 99.9 % quantile of the same [1].
    double edge_p99 = 0.0;  ///< 99 % quantile [1].

    double dihedral_rms_deg = 0.0; ///< RMS of |theta - theta*|, wrapped, over interior edges [deg].
    double dihedral_p99_deg = 0.0; ///< 99 % quantile [deg].
    double dihedral_max_deg = 0.0; ///< Largest [deg].

    double closure_energy = 0.0; ///< E of Rojas 2014 eq. 3 that the dihedral solver ended at; for
                                 ///< other methods that of the target's angles [1].
    /// How far the mesh is off in the large: RMS distance of its vertices from the companion
    /// mesh that the turns of the target lead to, after the best rigid motion, % of the diagonal of
    /// its bounding box. NaN if the target has no turns.
    double companion_rms = std::numeric_limits<double>::quiet_NaN();

    std::optional<int> self_intersections = {};     ///< Pairs of faces that cross each other.
    std::optional<int> new_self_intersections = {}; ///< Those that do so in no reference mesh.
    /// What new_self_intersections was before contact was avoided; nothing if that was not asked for.
    std::optional<int> avoidable_self_intersections = {};

    int inverted_faces = 0;     ///< Faces without area; or folded flat onto a neighbour (drift of
                                ///< an edge beyond 150 deg).
    int iterations = 0;         ///< Steps of the nonlinear solver.
    bool converged = false;     ///< The solver met its criterion.
    double seconds = 0.0;       ///< Wall time of this mesh alone [s].
    double setup_seconds = 0.0; ///< Wall time spent once for the topology [s].
};

/// Measures a mesh against its target: all figures but those of the solver (closure_energy, iterations,
/// converged, seconds, setup_seconds) and of references (companion_rms, and all pairs that cross).
/// @throws InvalidInput if points or target do not fit the topology.
[[nodiscard]] EmbeddingReport measure_embedding(const Topology& topology, const Points& points,
                                                const ShapePoint& target);

/// The same with edge_residuals() found before. @throws as they do.
[[nodiscard]] EmbeddingReport measure_embedding(const Topology& topology, const Points& points,
                                                const ShapePoint& target,
                                                const EdgeResiduals& residuals);

/// "exact", "approximate" or "infeasible".
[[nodiscard]] const char* name(EmbeddingStatus status);

} // namespace shape
