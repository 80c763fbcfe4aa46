// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/embedding/repair/fold_regions.h"
#include "libshape/embedding/repair/region_repair.h"
#include "libshape/linalg/single_precision_solve.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

struct DihedralSystem;

struct DihedralEmbeddingOptions
{
    /// Angles weigh this much against lengths: mu of length_dihedral_energy.h; > 0.
    double smoothness = usual_smoothness;
    /// From the second repair on a mesh whose target has turns is held near where it started by at most
    /// this (nu of hold_near()), less where transitions agree (turn_share()) or E resists; >= 0.
    double anchor = 0.05;
    /// A mesh whose target has positions is held near them by this from the start on (nu of hold_near()),
    /// from the second repair on up to a hundred times as firmly where E hardly resists; >= 0.
    double position_anchor = 1.0;
    /// The linear start is followed by this many face steps; >= 0.
    int local_global_steps = 3;
    /// Hot spots are solved before the descent.
    bool relax_start = false;
    /// The descent takes at most this many linear steps (descent.h); 0 leaves out what follows the start.
    int max_iterations = 120;
    /// The first Newton step of a descent takes this many of them; >= 2.
    int first_linear_steps = 12;
    /// Folds are repaired after this many linear steps; ascending, >= 0. Those beyond max_iterations
    /// are left out.
    std::vector<int> repairs = {24, 60};
    /// Edges that these options select are repaired as folds.
    FoldRegionOptions folds = {};
    /// Hot spots and folds are solved anew as these options say.
    RegionRepairOptions repair = {};
    /// The descent has converged once a Newton step of k linear steps lowers E by
    /// <= k * decrease_tolerance * E; >= 0.
    double decrease_tolerance = 1e-4;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const DihedralEmbeddingOptions& options);

/// What --quality preview does: 12 back-substitutions, and no fold stays.
[[nodiscard]] DihedralEmbeddingOptions dihedral_preview();

struct DihedralEmbedding
{
    Points points; ///< #V by 3 [length], centroid at 0.
    Points
        companion; ///< The same, of the positions of the point, or of the start that its turns led
                   ///< to; none if it has neither.
    double energy = 0.0; ///< E of length_dihedral_energy.h, without what holds it near.
    int iterations = 0;  ///< Linear steps of descent.h.
    int back_substitutions =
        0;                    ///< With the factor of the vertex Laplacian, three right-hand sides.
    int repaired_regions = 0; ///< region_repair.h
    double position_hold =
        0.0; ///< nu of hold_near() that held it near its positions at the end; 0 without any.
    bool converged = false;
};

/// Root mean square of the distances of vertices over the diagonal of the bounding box of points [1].
[[nodiscard]] double relative_distance(const Points& points, const Points& companion);

/// The embedding of libshape: the closed mesh nearest to wanted lengths and dihedral angles.
///
/// 1. Frames: every face laid out by lengths and angles, oriented patch by patch, transitions
///    trusted by how well the walks around their ends close (patch_frames.h, face_layout.h).
/// 2. Positions: one Laplace solve; then face steps, each rotating every face to its
///    best fit and solving again.
/// 3. Gauss-Newton steps on the energy, preconditioned by the same factor (descent.h); between them
///    folds are turned back (fold_regions.h, region_repair.h). From the first of these on a mesh whose
///    target has turns is held near its linear start, weakly; from the second on as firmly as the
///    energy allows, which the way it went meanwhile shows (docs/embedding.md). One whose target has
///    positions is held near these all the way, at the end as well the more firmly the less E resists. A preview starts with the hot spots
///    (hot_spots.h): what is wrong with a start is in a few places, where global steps are small.
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

    /// With the factor of another one of the same arguments, for where nothing can be factorised.
    /// @throws InvalidInput as well if it is of another size.
    DihedralEmbedder(const Topology& topology, const std::vector<Points>& references,
                     SinglePrecisionSolve factor);
    ~DihedralEmbedder();
    DihedralEmbedder(DihedralEmbedder&&) noexcept;
    DihedralEmbedder& operator=(DihedralEmbedder&&) noexcept;

    /// Lengths that break a triangle inequality are taken as they are, those <= 0 as in
    /// positive_lengths(): the nearest mesh results.
    /// @throws InvalidInput if point has other sizes, a value that is not finite, or an angle beyond 1e9 rad, or options
    ///     break a rule.
    [[nodiscard]] DihedralEmbedding embed(const ShapePoint& point,
                                          const DihedralEmbeddingOptions& options = {}) const;

    /// A mesh after one sweep, and its edges as the energy measured them last.
    struct Swept
    {
        Points points;                ///< #V by 3 [length].
        Eigen::VectorXd edge_lengths; ///< #E [length].
        Eigen::VectorXd
            bends; ///< #E; theta - theta*, wrapped; 0 on the boundary and beside a face without area [rad].
        int linear_steps = 0;
        bool converged = false;
    };

    /// Step 3 alone, without repairs, from a mesh that is near: one Gauss-Newton step of as many linear
    /// steps. Costs a fifth of a preview.
    /// @param start  #V by 3, of whatever size and place.
    /// @param linear_steps  >= 2.
    /// @throws InvalidInput, NumericalError as embed(), or if start has another size.
    [[nodiscard]] Swept sweep(const ShapePoint& point, const Points& start, int linear_steps,
                              double smoothness = DihedralEmbeddingOptions().smoothness) const;

    /// What takes the most time to find.
    [[nodiscard]] const SinglePrecisionSolve& factor() const;

    /// What is kept.
    [[nodiscard]] DihedralSystem& system() const { return *system_; }

private:
    std::unique_ptr<DihedralSystem> system_;
};

} // namespace shape::internal
