// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral/dihedral_embedding.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/dihedral/dihedral_system.h"
#include "libshape/embedding/energy/descent.h"
#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/embedding/repair/hot_spots.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/renumbering.h"

namespace shape::internal {
namespace {

using Eigen::VectorXd;

/// The weight (nu of hold_near()) at which the mesh shows how E resists: weak, so that asking costs little;
/// already with 0.01 edges lose up to 3 % (docs/experiments/embedding.md).
constexpr double probing_anchor = 0.003;

/// What is left of an anchor where E wants another mesh in the large.
/// @param resistance  #E d^2 / E, d being the relative_distance() of the mesh from the companion.
/// @param strong  The resistance that leaves a half.
double yielding(double anchor, double resistance, double strong)
{
    // The fourth power is nearly a switch, but without a jump.
    return anchor / (1.0 + std::pow(resistance / strong, 4));
}

/// Between the resistances, to probing_anchor, of pairs that are held near their turns at little cost (0.18 to 0.49:
/// arm, hands, face, walk) and of those that pay in edges (1.2 and 1.9: a hand, the body; docs/experiments/embedding.md).
constexpr double strong_against_turns = 0.6;

/// Between the resistances, to DihedralEmbeddingOptions::position_anchor, of faces and walks that a model had not seen
/// (0.02 to 0.09) and of means of poses, whose positions are shrunken (0.35 to 4; docs/experiments/embedding.md).
constexpr double strong_against_positions = 0.1;

/// Positions that E does not resist hold a mesh so many times as firmly.
constexpr double firm = 100.0;

} // namespace

void check(const DihedralEmbeddingOptions& options)
{
    require_positive(options.smoothness, "DihedralEmbeddingOptions.smoothness");
    require_not_negative(options.anchor, "DihedralEmbeddingOptions.anchor");
    require_not_negative(options.position_anchor, "DihedralEmbeddingOptions.position_anchor");
    require_at_least(0, options.local_global_steps, "DihedralEmbeddingOptions.local_global_steps");
    require_at_least(0, options.max_iterations, "DihedralEmbeddingOptions.max_iterations");
    require_at_least(2, options.first_linear_steps, "DihedralEmbeddingOptions.first_linear_steps");
    int before = 0;
    for (std::size_t i = 0; i < options.repairs.size(); before = options.repairs[i++])
        require(options.repairs[i] >= before, join("DihedralEmbeddingOptions.repairs[", i, "]"),
                options.repairs[i], join(">= ", before, ": ascending and not negative"));
    check(options.folds);
    check(options.repair);
    require_not_negative(options.decrease_tolerance, "DihedralEmbeddingOptions.decrease_tolerance");
}

DihedralEmbeddingOptions dihedral_preview()
{
    DihedralEmbeddingOptions preview;
    preview.local_global_steps = 2;
    preview.relax_start = true;
    preview.max_iterations = 9;
    preview.first_linear_steps = 4;
    preview.repairs = {9};
    preview.folds.fold_angle = 2.0; // what is about to turn over
    // No descent of the whole mesh follows that would finish what a repair leaves.
    preview.repair.filling_sweeps = 15;
    preview.repair.descent = {.newton_steps = 4, .linear_steps = 12};
    return preview;
}

DihedralEmbedder::DihedralEmbedder(const Topology& topology, const std::vector<Points>& references)
    : system_(std::make_unique<DihedralSystem>(topology, references))
{
}

DihedralEmbedder::DihedralEmbedder(const Topology& topology, const std::vector<Points>& references,
                                   SinglePrecisionSolve factor)
    : system_(std::make_unique<DihedralSystem>(topology, references, std::move(factor)))
{
}

const SinglePrecisionSolve& DihedralEmbedder::factor() const
{
    return system_->laplacian.single_precision();
}

DihedralEmbedder::~DihedralEmbedder() = default;
DihedralEmbedder::DihedralEmbedder(DihedralEmbedder&&) noexcept = default;
DihedralEmbedder& DihedralEmbedder::operator=(DihedralEmbedder&&) noexcept = default;

double relative_distance(const Points& points, const Points& companion)
{
    const double square = (points - companion).rowwise().squaredNorm().mean();
    return std::sqrt(square) / bounding_box_diagonal(points);
}

DihedralEmbedding DihedralEmbedder::embed(const ShapePoint& point,
                                          const DihedralEmbeddingOptions& options) const
{
    check(options);
    DihedralSystem& s = *system_;
    const Topology& topology = s.topology();
    const ShapePoint target = s.target_of(point);
    const bool has_companion = point.patch_turns.size() > 0;
    LengthDihedralEnergy energy(topology, target, options.smoothness);
    const auto start = s.starts.borrow();
    const Points& linear = start->points(target, options.local_global_steps);

    DihedralEmbedding result;
    result.back_substitutions = options.local_global_steps + 1;
    // Rounding: strains of 1e-12 an edge are none.
    const double nothing = 1e-24 * topology.edge_count();
    VectorXd points = linear.reshaped<Eigen::RowMajor>();
    const bool has_positions = target.positions.size() > 0;
    if (has_positions || has_companion)
        result.companion =
            s.result_of((has_positions ? target.positions : linear).reshaped<Eigen::RowMajor>());
    if (has_positions && options.position_anchor > 0.0) {
        result.position_hold = options.position_anchor;
        energy.hold_near(best_rigid_motion(target.positions, linear)(target.positions)
                             .reshaped<Eigen::RowMajor>(),
                         options.position_anchor);
    }
    int first_linear_steps = options.first_linear_steps;
    Descender descender(energy, s.laplacian.single_precision());
    const auto descend_to = [&](int iterations) {
        Descent descent = descender.descend(std::move(points),
                                            {.max_linear_steps = iterations - result.iterations,
                                             .first_linear_steps = first_linear_steps,
                                             .decrease_tolerance = options.decrease_tolerance,
                                             .value_tolerance = nothing});
        points = std::move(descent.points);
        result.iterations += descent.linear_steps;
        result.energy = descent.energy - energy.hold_energy(points);
        result.converged = descent.converged;
    };
    const auto repair = [&](std::vector<std::vector<int>> regions) {
        RegionRepair repaired = repair_regions(energy, s.references, std::move(points),
                                               std::move(regions), options.repair);
        points = std::move(repaired.points);
        result.energy -= repaired.decrease;
        result.repaired_regions += repaired.replaced;
        result.converged = result.converged && repaired.replaced == 0;
    };
    if (options.relax_start)
        repair(hot_spots(energy, points));
    // Folds show once what is rough about the start is gone. From then on the mesh is held near its companion, weakly
    // at first: how far it goes all the same says how firmly it may be held.
    const double probing = has_positions
                               ? options.position_anchor
                               : start->turn_share() * std::min(probing_anchor, options.anchor);
    for (std::size_t i = 0; i < options.repairs.size(); ++i) {
        if (options.repairs[i] > options.max_iterations || result.converged)
            break;
        descend_to(options.repairs[i]);
        repair(folded_regions(topology, points, target.dihedral_angles, options.folds));
        if (probing <= 0.0 || result.energy <= nothing ||
            result.iterations >= options.max_iterations)
            continue;
        const Points& companion = has_positions ? target.positions : linear;
        const Points here = points.reshaped<Eigen::RowMajor>(linear.rows(), 3);
        const Points aligned = best_rigid_motion(companion, here)(companion);
        double weight = probing;
        if (i > 0) {
            const double way = relative_distance(here, aligned);
            const double resistance = topology.edge_count() * way * way / result.energy;
            weight = has_positions ? probing + yielding((firm - 1.0) * probing, resistance,
                                                        strong_against_positions)
                                   : start->turn_share() *
                                         yielding(options.anchor, resistance, strong_against_turns);
        }
        energy.hold_near(aligned.reshaped<Eigen::RowMajor>(), weight);
        if (has_positions)
            result.position_hold = weight;
        first_linear_steps = options.first_linear_steps + options.first_linear_steps / 2;
        result.converged = false;
    }
    if (result.iterations == 0 ||
        (result.iterations < options.max_iterations && !result.converged)) {
        energy.keep_areas();
        descend_to(options.max_iterations);
    }
    result.back_substitutions += result.iterations;
    result.points = s.result_of(points);
    return result;
}

DihedralEmbedder::Swept DihedralEmbedder::sweep(const ShapePoint& point, const Points& start,
                                                int linear_steps, double smoothness) const
{
    const DihedralSystem& s = *system_;
    ShapePoint target = s.target_of(point);
    if (start.rows() != s.topology().vertex_count())
        throw InvalidInput(join("sweep: the start has ", start.rows(), " vertices, the topology ",
                                s.topology().vertex_count()));
    LengthDihedralEnergy energy(s.topology(), std::move(target), smoothness);
    Descender descender(energy, s.laplacian.single_precision());
    const Descent descent =
        descender.descend((s.unit * renumbered(s.renumbering, start)).reshaped<Eigen::RowMajor>(),
                          {.max_linear_steps = linear_steps, .first_linear_steps = linear_steps});
    if (!descent.is_measured)
        (void)energy.evaluate(descent.points);
    const int edges = s.topology().edge_count();
    Swept swept{s.result_of(descent.points), Eigen::VectorXd(edges), Eigen::VectorXd(edges),
                descent.linear_steps, descent.converged};
    for (int e = 0; e < edges; ++e) {
        const int before = s.renumbering.edges[to_size(e)];
        swept.edge_lengths[before] = energy.lengths()[e] / s.unit;
        swept.bends[before] = energy.bend(e);
    }
    return swept;
}

} // namespace shape::internal
