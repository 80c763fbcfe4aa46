// SPDX-License-Identifier: MIT

#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "libshape/base/progress.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"

namespace shape::internal {

struct CoherentPathOptions
{
    /// Angles weigh this much against lengths: mu of length_dihedral_energy.h; > 0.
    double smoothness = usual_smoothness;
    /// Branches are held near the companions of their targets by this (hold_near()); >= 0.
    double anchor = 0.01;
    /// Meshes of stations whose targets have positions are held near them by this
    /// (DihedralEmbeddingOptions::position_anchor), those between as firmly as these ended; >= 0.
    double position_anchor = 1.0;
    /// The path is solved at this many steps, dealt out to its parts; >= 8.
    int steps = 60;
    /// From step to step a branch descends by this many linear steps; >= 2.
    int branch_steps = 48;
    /// A fold turns over within this many steps, fewer where a part has fewer; >= 1.
    int crossing_steps = 14;
    /// Meshes of a crossing are relaxed this many times; >= 0.
    int sweeps = 14;
    /// Each relaxation takes this many linear steps; >= 2.
    int sweep_steps = 24;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const CoherentPathOptions& options);

/// @throws InvalidInput unless there are two or more, ascending.
void check_stations(const std::vector<double>& stations);

/// Meshes along a path of targets that change little where the targets do.
///
/// A target by itself gives the lowest minimum of E that is found, and two neighbours may end in
/// different ones: then a fold turns over from one to the next. Here every part of the path, from one
/// station to the next, is solved at even steps.
///
/// 1. Two branches: from either end the mesh is followed from step to step. What it differs by from its
///    target, in lengths, angles and turns, is added to the next target, which gives the linear start
///    (linear_start.h) of a descent (descent.h). No choice is made, so nothing jumps, and each
///    branch stays in the minimum of its end.
/// 2. Folds that they have in different ways cross from one to the other where that costs least
///    (branch_crossings.h), within crossing_steps: first with blended differences. That presses them
///    flat, against their lengths.
/// 3. So the meshes of the crossing are relaxed, all side by side (nudged elastic band: Henkelman,
///    Jonsson 2000). How far each fold has turned over between its neighbours is held (hold_sums()), a third of
///    the way to even steps of every angle is wanted, and the mesh is held near the mean of its
///    neighbours; how a fold turns is left to E, which lets it roll over from one end to the other.
///
/// Between the steps differences are blended and smoothed likewise. What comes out depends on the path and
/// its stations alone, not on which places are asked for.
class CoherentPath
{
public:
    using Target = std::function<ShapePoint(double)>;

    /// Costs about as much as 1.5 times options.steps embeddings; keeps 24 bytes a vertex and step.
    /// @param embedder  Must outlive the object.
    /// @param target  Safe to call concurrently.
    /// @param stations  Ascending, two at least: where the mesh of DihedralEmbedder::embed() is taken;
    ///     those of the meshes that the path goes through.
    /// @throws InvalidInput, NumericalError as DihedralEmbedder::embed(), or if stations do not ascend.
    CoherentPath(const DihedralEmbedder& embedder, Target target, std::vector<double> stations,
                 const CoherentPathOptions& options = {}, const Progress& progress = {});
    ~CoherentPath();
    CoherentPath(CoherentPath&&) noexcept;
    CoherentPath& operator=(CoherentPath&&) noexcept;

    /// @throws InvalidInput if t is not within the stations. Safe to call concurrently.
    [[nodiscard]] DihedralEmbedding at(double t) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace shape::internal
