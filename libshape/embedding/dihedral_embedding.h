// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/fold_repair.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

struct DihedralEmbeddingOptions
{
    double smoothness = 5e-3;     ///< mu of length_dihedral_energy.h; > 0.
    int local_global_steps = 3;   ///< Face steps after the linear start; >= 0.
    int max_iterations = 120;     ///< Linear steps of descent.h; 0 stops after the face steps.
    int first_linear_steps = 8;   ///< Of descent.h.
    int steps_before_repair = 24; ///< Linear steps before folds are looked for.
    FoldRepairOptions folds = {};
    double decrease_tolerance = 2e-4; ///< Of descent.h.
};

/// What --quality preview does: 12 back-substitutions, and a light repair of folds.
inline constexpr DihedralEmbeddingOptions dihedral_preview{
    .local_global_steps = 2,
    .max_iterations = 9,
    .first_linear_steps = 5,
    .steps_before_repair = 4,
    .folds = {.regions = {.fold_angle = 2.0, .suspect_angle = 0.7, .rings = 3},
              .filling_sweeps = 5,
              .shaken_starts = 0,
              .descent = {.newton_steps = 5, .linear_steps = 8}}};

struct DihedralEmbedding
{
    Points points;       ///< #V by 3 [length], centroid at 0.
    double energy = 0.0; ///< E of length_dihedral_energy.h.
    int iterations = 0;  ///< Linear steps of descent.h.
    int back_substitutions =
        0;                  ///< With the factor of the vertex Laplacian, three right-hand sides.
    int repaired_folds = 0; ///< Regions that were turned back (fold_repair.h).
    bool converged = false;
};

/// Our embedding: the closed mesh nearest to wanted lengths and dihedral angles.
///
/// 1. Frames: every face laid out by lengths and angles, oriented patch by patch, transitions
///    trusted by how well the walks around their ends close (patch_frames.h, face_layout.h).
/// 2. Positions: one Laplace solve; then face steps, each rotating every face to its
///    best fit and solving again.
/// 3. Gauss-Newton steps on the energy, preconditioned by the same factor (descent.h); after the
///    first of them folds are turned back (fold_repair.h).
///
/// What depends on topology and references alone is kept: patches and the factor of the Laplacian
/// weighted by 1 / l^2.
class DihedralEmbedder
{
public:
    /// @param references  At least one mesh of the topology; its lengths weight the Laplacian, all
    ///     of them serve the repair of folds.
    /// @throws InvalidInput if there is none, or one has another size or edges of length 0.
    DihedralEmbedder(const Topology& topology, const std::vector<Points>& references);
    ~DihedralEmbedder();
    DihedralEmbedder(DihedralEmbedder&&) noexcept;
    DihedralEmbedder& operator=(DihedralEmbedder&&) noexcept;

    /// Lengths that break a triangle inequality are taken as they are, those <= 0 as in
    /// positive_lengths(): the nearest mesh results.
    /// @throws InvalidInput if point has other sizes or a value that is not finite, or options
    ///     break a rule.
    [[nodiscard]] DihedralEmbedding embed(const ShapePoint& point,
                                          const DihedralEmbeddingOptions& options = {}) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace shape
