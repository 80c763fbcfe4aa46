// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral/coherent_path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/dihedral/branch_crossings.h"
#include "libshape/embedding/dihedral/dihedral_system.h"
#include "libshape/embedding/energy/descent.h"
#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape::internal {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using AngleSum = LengthDihedralEnergy::AngleSum;

/// What nearly belongs to a mesh is oriented by its turns: its transitions agree with each other all but
/// in creases, and there they are wrong.
constexpr double followed_turn_share = 0.99;
/// How firmly the turning of a fold is held, in units of the bending of its edges: so that barriers of
/// stretched edges hardly shift it. With 4 and 10 in its place meshes slid off them.
constexpr double pace_stiffness = 100.0;
/// The share of the way to even steps of every angle that is wanted.
constexpr double evenness = 1.0 / 3.0;
/// Meshes of a crossing are held near the mean of their neighbours by this (hold_near()).
constexpr double neighbour_hold = 0.5;

/// Between two steps of a branch blended differences are smoothed by this many linear steps: more would
/// go on where the steps stopped, and every second mesh would lie elsewhere.
constexpr int smoothing_steps = 4;
/// Between two steps of a crossing its pace is held by this share: one face may lie on either side of
/// its neighbour there, and half-way it would be pressed flat.
constexpr double half_way_share = 0.1;

VectorXd in_rows(const Points& points)
{
    return points.reshaped<Eigen::RowMajor>();
}

Points as_points(const VectorXd& rows)
{
    return rows.reshaped<Eigen::RowMajor>(rows.size() / 3, 3);
}

/// The rotation vectors that differ from given ones by whole turns and are nearest to others.
VectorXd nearest_turns(VectorXd turns, const VectorXd& others)
{
    for (Eigen::Index k = 0; k < turns.size(); k += 3) {
        const Vector3d turn = turns.segment<3>(k);
        const double angle = turn.norm();
        if (!(angle > 1e-9))
            continue;
        const double wanted = turn.dot(others.segment<3>(k)) / angle;
        const double whole = std::round((wanted - angle) / (2.0 * std::numbers::pi));
        turns.segment<3>(k) += whole * 2.0 * std::numbers::pi / angle * turn;
    }
    return turns;
}

/// Sums of two points of the space, entry by entry.
ShapePoint sum(const ShapePoint& a, const ShapePoint& b)
{
    return {a.edge_lengths + b.edge_lengths, a.dihedral_angles + b.dihedral_angles,
            a.patch_turns + b.patch_turns};
}

/// A step of the path.
struct Step
{
    double t = 0.0;
    VectorXd points;         ///< In the order of the system, row by row.
    double hold = 0.0;       ///< How firmly near its positions (hold_near()).
    bool is_between = false; ///< Held between two branches: no minimum of E.
};

/// A part of the path, from one station to the next.
struct Part
{
    std::vector<Step> steps;
    std::vector<std::vector<int>> folds; ///< Edges of what crosses.
};

} // namespace

void check(const CoherentPathOptions& options)
{
    require_positive(options.smoothness, "CoherentPathOptions.smoothness");
    require_not_negative(options.anchor, "CoherentPathOptions.anchor");
    require_not_negative(options.position_anchor, "CoherentPathOptions.position_anchor");
    require_at_least(8, options.steps, "CoherentPathOptions.steps");
    require_at_least(2, options.branch_steps, "CoherentPathOptions.branch_steps");
    require_at_least(1, options.crossing_steps, "CoherentPathOptions.crossing_steps");
    require_at_least(0, options.sweeps, "CoherentPathOptions.sweeps");
    require_at_least(2, options.sweep_steps, "CoherentPathOptions.sweep_steps");
}

void check_stations(const std::vector<double>& stations)
{
    require_at_least(2, static_cast<int>(stations.size()), "number of stations");
    for (std::size_t i = 1; i < stations.size(); ++i)
        require(stations[i] > stations[i - 1], join("stations[", i, "]"), stations[i],
                join("> ", stations[i - 1], ": ascending"));
}

struct CoherentPath::State
{
    const DihedralEmbedder& embedder;
    DihedralSystem& system;
    Target target_at;
    CoherentPathOptions options;
    std::vector<Part> parts;

    State(const DihedralEmbedder& by, Target target, const CoherentPathOptions& with)
        : embedder(by), system(by.system()), target_at(std::move(target)), options(with)
    {
    }

    [[nodiscard]] const Topology& topology() const { return system.topology(); }

    [[nodiscard]] ShapePoint target(double t) const { return system.target_of(target_at(t)); }

    [[nodiscard]] LengthDihedralEnergy energy(const ShapePoint& target) const
    {
        return {topology(), target, options.smoothness};
    }

    [[nodiscard]] VectorXd descended(LengthDihedralEnergy& energy, VectorXd start, int steps) const
    {
        Descender descender(energy, system.laplacian.single_precision());
        return descender
            .descend(std::move(start), {.max_linear_steps = steps,
                                        .first_linear_steps = std::min(steps, 12),
                                        .value_tolerance = 1e-24 * topology().edge_count()})
            .points;
    }

    /// How a mesh differs from a target, its angles and turns by the branch nearest to what is given.
    [[nodiscard]] ShapePoint difference(const VectorXd& points, const ShapePoint& target,
                                        const ShapePoint* near = nullptr) const
    {
        const Points mesh = as_points(points);
        VectorXd angles = dihedral_angles(topology(), mesh) - target.dihedral_angles;
        VectorXd turns(0);
        if (target.patch_turns.size() > 0)
            turns = system.reference.turns(topology(), mesh);
        if (near != nullptr) {
            angles =
                near->dihedral_angles + (angles - near->dihedral_angles).unaryExpr(&wrapped_angle);
            turns = nearest_turns(std::move(turns), target.patch_turns + near->patch_turns);
        } else {
            angles = angles.unaryExpr(&wrapped_angle).eval();
            turns = nearest_turns(std::move(turns), target.patch_turns);
        }
        return {edge_lengths(topology(), mesh) - target.edge_lengths, std::move(angles),
                turns - target.patch_turns};
    }

    /// The linear start towards what nearly belongs to a mesh, and a descent to the target.
    /// @param hold  Of the target's positions, if it has any.
    [[nodiscard]] VectorXd followed(const ShapePoint& target, const ShapePoint& difference,
                                    int steps, double hold) const
    {
        LengthDihedralEnergy to = energy(target);
        const auto start = system.starts.borrow();
        const VectorXd companion = in_rows(start->points(target, 3));
        const double share = start->turn_share();
        VectorXd points = started(*start, target, difference, share);
        if (target.positions.rows() > 0)
            hold_near({{in_rows(target.positions), hold}}, points, to);
        else if (share > 0.0)
            hold_near({{companion, share * options.anchor}}, points, to);
        return descended(to, std::move(points), steps);
    }

    /// @param share  Of turns in the start of the target itself. Where its transitions agree with each other
    ///     they are right, with what is added to them too; else turns orient what nearly belongs to a mesh.
    static VectorXd started(LinearStart& start, const ShapePoint& target,
                            const ShapePoint& difference, double share)
    {
        ShapePoint near = sum(target, difference);
        // Differences of a short edge may exceed it: a tenth is still an edge, for a start.
        near.edge_lengths = near.edge_lengths.cwiseMax(0.1 * target.edge_lengths);
        return in_rows(start.points(near, 0, share > 0.0 ? followed_turn_share : 0.0));
    }

    /// A mesh moved rigidly onto another.
    static VectorXd fitted(const VectorXd& moving, const VectorXd& fixed)
    {
        const Points points = as_points(moving);
        return in_rows(best_rigid_motion(points, as_points(fixed))(points));
    }

    /// Meshes and how firmly one is held near each.
    using Holds = std::vector<std::pair<VectorXd, double>>;

    /// Holds a mesh near several others at once: near their mean, weighted.
    static void hold_near(const Holds& holds, const VectorXd& points, LengthDihedralEnergy& energy)
    {
        double weights = 0.0;
        VectorXd mean = VectorXd::Zero(points.size());
        for (const auto& [mesh, weight] : holds) {
            if (!(weight > 0.0))
                continue;
            mean += weight * fitted(mesh, points);
            weights += weight;
        }
        if (weights > 0.0)
            energy.hold_near(mean / weights, weights);
    }

    /// Embeds the mesh of a station.
    void embed(Step& step) const
    {
        DihedralEmbeddingOptions fine;
        fine.smoothness = options.smoothness;
        fine.position_anchor = options.position_anchor;
        const DihedralEmbedding made = embedder.embed(target_at(step.t), fine);
        step.points = in_rows(system.unit * renumbered(system.renumbering, made.points));
        step.hold = made.position_hold;
    }

    /// How firmly the first and the last step are held goes over into each other by a constant factor a step.
    static void spread_holds(std::vector<Step>& steps)
    {
        const double first = steps.front().hold;
        const double last = steps.back().hold;
        if (!(std::min(first, last) > 0.0))
            return;
        for (std::size_t i = 1; i + 1 < steps.size(); ++i)
            steps[i].hold = hold_between(
                first, last, static_cast<double>(i) / static_cast<double>(steps.size() - 1));
    }

    static double hold_between(double first, double last, double share)
    {
        return first > 0.0 ? first * std::pow(last / first, share) : 0.0;
    }

    /// Steps followed from the first to the last.
    void follow(std::vector<Step>& steps, const std::function<void()>& each) const
    {
        ShapePoint difference_before = difference(steps.front().points, target(steps.front().t));
        for (std::size_t i = 1; i < steps.size(); ++i) {
            const ShapePoint to = target(steps[i].t);
            steps[i].points = followed(to, difference_before, options.branch_steps, steps[i].hold);
            difference_before = difference(steps[i].points, to, &difference_before);
            each();
        }
    }

    [[nodiscard]] std::vector<BranchPlace> branch_places(const std::vector<Step>& steps) const
    {
        std::vector<BranchPlace> places(steps.size());
        parallel_for(steps.size(), 1, [&](std::size_t i, std::size_t) {
            LengthDihedralEnergy here = energy(target(steps[i].t));
            VectorXd gradient;
            (void)here.evaluate(steps[i].points, gradient);
            places[i] = {dihedral_angles(topology(), as_points(steps[i].points)),
                         here.edge_energies()};
        });
        return places;
    }

    /// Part of the way from one branch to the other.
    [[nodiscard]] VectorXd blended(const Step& first, const Step& second,
                                   const BranchCrossings& crossings, std::size_t place) const
    {
        const ShapePoint to = target(first.t);
        ShapePoint mixed = difference(first.points, to);
        const ShapePoint other = difference(second.points, to, &mixed);
        for (int e = 0; e < topology().edge_count(); ++e) {
            const double share = crossings.share(e, place);
            mixed.edge_lengths[e] += share * (other.edge_lengths[e] - mixed.edge_lengths[e]);
            mixed.dihedral_angles[e] +=
                share * (other.dihedral_angles[e] - mixed.dihedral_angles[e]);
        }
        mixed.patch_turns += crossings.share(place) * (other.patch_turns - mixed.patch_turns);
        return followed(
            to, mixed,
            crossings.folds.empty() ? options.branch_steps : std::max(2, options.sweep_steps / 4),
            first.hold);
    }

    /// A mesh of a crossing, relaxed between its neighbours.
    [[nodiscard]] VectorXd relaxed(const Part& part, std::size_t i) const
    {
        const auto angles = [&](std::size_t k) {
            return dihedral_angles(topology(), as_points(part.steps[k].points));
        };
        const VectorXd here = angles(i);
        const VectorXd back = (here - angles(i - 1)).unaryExpr(&wrapped_angle);
        const VectorXd ahead = (angles(i + 1) - here).unaryExpr(&wrapped_angle);
        ShapePoint to = target(part.steps[i].t);
        const VectorXd weights = energy(to).bend_weights();
        std::vector<AngleSum> sums;
        for (const std::vector<int>& fold : part.folds) {
            double way_back = 0.0;
            double way_ahead = 0.0;
            for (const int e : fold) {
                way_back += weights[e] * back[e] * back[e];
                way_ahead += weights[e] * ahead[e] * ahead[e];
            }
            way_back = std::sqrt(way_back);
            way_ahead = std::sqrt(way_ahead);
            const double way = way_back + way_ahead;
            if (!(way > 1e-9))
                continue;
            const double shift = 0.5 * (way_ahead - way_back) / way;
            if (auto pace = pace_of(fold, weights, here, back + ahead, shift))
                sums.push_back(*std::move(pace));
            for (const int e : fold) {
                const double even = here[e] + 0.5 * (ahead[e] - back[e]);
                to.dihedral_angles[e] += evenness * wrapped_angle(even - to.dihedral_angles[e]);
            }
        }
        LengthDihedralEnergy between = energy(to);
        between.hold_sums(std::move(sums));
        const VectorXd& points = part.steps[i].points;
        hold_near({{part.steps[i - 1].points, 0.5 * neighbour_hold},
                   {part.steps[i + 1].points, 0.5 * neighbour_hold},
                   {in_rows(to.positions), part.steps[i].hold}},
                  points, between);
        return descended(between, points, options.sweep_steps);
    }

    /// Holds how far a fold has turned along a direction: at `shift` of it from where it is.
    static std::optional<AngleSum> pace_of(const std::vector<int>& fold, const VectorXd& weights,
                                           const VectorXd& angles, const VectorXd& direction,
                                           double shift)
    {
        double square = 0.0;
        for (const int e : fold)
            square += weights[e] * direction[e] * direction[e];
        // A direction of less than 1e-3 rad on one edge of weight mu = 0.01: it does not move.
        if (!(square > 1e-8))
            return std::nullopt;
        AngleSum pace;
        pace.edges = fold;
        pace.stiffness = pace_stiffness * square;
        for (const int e : fold) {
            pace.factors.push_back(weights[e] * direction[e] / square);
            pace.aims.push_back(angles[e] + shift * direction[e]);
        }
        return pace;
    }

    [[nodiscard]] Part solve(std::vector<Step> steps, const std::function<void()>& each) const
    {
        embed(steps.front());
        embed(steps.back());
        spread_holds(steps);
        std::vector<Step> reversed(steps.rbegin(), steps.rend());
        const std::array<std::vector<Step>*, 2> branches{&steps, &reversed};
        for (auto* const branch : branches)
            follow(*branch, each);
        std::reverse(reversed.begin(), reversed.end());
        const int width = std::min(options.crossing_steps, static_cast<int>(steps.size()) - 2);
        const BranchCrossings crossings =
            branch_crossings(topology(), branch_places(steps), branch_places(reversed), width);
        Part part;
        std::vector<std::size_t> between;
        for (std::size_t i = 0; i < steps.size(); ++i) {
            steps[i].is_between = crossings.is_between(i);
            if (steps[i].is_between)
                between.push_back(i);
        }
        std::vector<VectorXd> meshes(between.size());
        parallel_for(between.size(), 1, [&](std::size_t k, std::size_t) {
            const std::size_t i = between[k];
            meshes[k] = blended(steps[i], reversed[i], crossings, i);
        });
        part.steps = std::move(steps);
        for (std::size_t i = 0; i < part.steps.size(); ++i)
            if (!part.steps[i].is_between && crossings.share(i) >= 1.0)
                part.steps[i].points = std::move(reversed[i].points);
        for (std::size_t k = 0; k < between.size(); ++k)
            part.steps[between[k]].points = std::move(meshes[k]);
        for (const FoldCrossing& fold : crossings.folds)
            part.folds.push_back(fold.edges);
        if (part.folds.empty()) { // nothing turns over
            for (Step& step : part.steps)
                step.is_between = false;
            return part;
        }
        for (int sweep = 0; sweep < options.sweeps; ++sweep) {
            parallel_for(between.size(), 1, [&](std::size_t k, std::size_t) {
                meshes[k] = relaxed(part, between[k]);
            });
            for (std::size_t k = 0; k < between.size(); ++k)
                part.steps[between[k]].points = std::move(meshes[k]);
            each();
        }
        return part;
    }

    /// Between two steps.
    [[nodiscard]] VectorXd between(const Part& part, std::size_t before, double t) const
    {
        const Step& a = part.steps[before];
        const Step& b = part.steps[before + 1];
        const double share = (t - a.t) / (b.t - a.t);
        ShapePoint mixed = difference(a.points, target(a.t));
        const ShapePoint other = difference(b.points, target(b.t), &mixed);
        mixed.edge_lengths += share * (other.edge_lengths - mixed.edge_lengths);
        mixed.dihedral_angles += share * (other.dihedral_angles - mixed.dihedral_angles);
        mixed.patch_turns += share * (other.patch_turns - mixed.patch_turns);
        ShapePoint to = target(t);
        LengthDihedralEnergy wanted = energy(to);
        const VectorXd mean = a.points + share * (fitted(b.points, a.points) - a.points);
        const double hold = hold_between(a.hold, b.hold, share);
        const VectorXd positions = in_rows(to.positions);
        VectorXd start;
        double weight = 0.0; // companions may be elsewhere than those of the steps
        {
            const auto linear = system.starts.borrow();
            (void)linear->points(to, 0);
            const double turns = linear->turn_share();
            start = started(*linear, to, mixed, turns);
            weight = options.anchor * turns;
        }
        // What the linear start makes of blended differences is right where the steps wind up against
        // each other, their mean where they are near; E knows.
        VectorXd gradient;
        if (wanted.evaluate(mean, gradient) < wanted.evaluate(start, gradient))
            start = mean;
        if (!a.is_between && !b.is_between) {
            hold_near({{start, weight}, {positions, hold}}, start, wanted);
            return descended(wanted, start, smoothing_steps);
        }
        const VectorXd direction = (dihedral_angles(topology(), as_points(b.points)) -
                                    dihedral_angles(topology(), as_points(a.points)))
                                       .unaryExpr(&wrapped_angle);
        const VectorXd even = to.dihedral_angles + mixed.dihedral_angles;
        const VectorXd weights = energy(to).bend_weights();
        std::vector<AngleSum> sums;
        for (const std::vector<int>& fold : part.folds) {
            if (auto pace = pace_of(fold, weights, even, direction, 0.0))
                sums.push_back(*std::move(pace));
            for (const int e : fold)
                to.dihedral_angles[e] += evenness * wrapped_angle(even[e] - to.dihedral_angles[e]);
        }
        LengthDihedralEnergy held = energy(to);
        for (AngleSum& pace : sums)
            pace.stiffness *= half_way_share;
        held.hold_sums(std::move(sums));
        hold_near({{mean, neighbour_hold}, {positions, hold}}, start, held);
        return descended(held, start, 4 * options.sweep_steps);
    }
};

CoherentPath::CoherentPath(const DihedralEmbedder& embedder, Target target,
                           std::vector<double> stations, const CoherentPathOptions& options,
                           const Progress& progress)
{
    check(options);
    check_stations(stations);
    state_ = std::make_unique<State>(embedder, std::move(target), options);
    const double length = stations.back() - stations.front();
    std::vector<std::vector<Step>> parts;
    std::size_t total = 0;
    for (std::size_t k = 1; k < stations.size(); ++k) {
        const double share = (stations[k] - stations[k - 1]) / length;
        const int count = std::max(8, static_cast<int>(std::lround(share * options.steps)));
        std::vector<Step> steps(to_size(count) + 1);
        for (int i = 0; i <= count; ++i) {
            const double s = static_cast<double>(i) / count;
            steps[to_size(i)].t = (1.0 - s) * stations[k - 1] + s * stations[k];
        }
        total += 2 * to_size(count) + to_size(options.sweeps);
        parts.push_back(std::move(steps));
    }
    std::size_t done = 0;
    const auto each = [&] {
        if (progress)
            progress("following the path", ++done, total);
    };
    for (std::vector<Step>& steps : parts)
        state_->parts.push_back(state_->solve(std::move(steps), each));
}

CoherentPath::~CoherentPath() = default;
CoherentPath::CoherentPath(CoherentPath&&) noexcept = default;
CoherentPath& CoherentPath::operator=(CoherentPath&&) noexcept = default;

DihedralEmbedding CoherentPath::at(double t) const
{
    const State& s = *state_;
    const auto part = std::find_if(s.parts.begin(), s.parts.end(),
                                   [&](const Part& p) { return t <= p.steps.back().t; });
    if (part == s.parts.end() || !(t >= s.parts.front().steps.front().t))
        throw InvalidInput(join("place ", t, " is outside the path, [",
                                s.parts.front().steps.front().t, ", ",
                                s.parts.back().steps.back().t, "]"));
    const std::vector<Step>& steps = part->steps;
    const auto after =
        std::find_if(steps.begin(), steps.end(), [&](const Step& step) { return t <= step.t; });
    // Places that are steps but for rounding are steps: 1/60 of the path is 1/60 of any part of it.
    const auto is_step = [&](const Step& step) {
        return std::abs(t - step.t) <= 1e-9 * (steps.back().t - steps.front().t);
    };
    DihedralEmbedding result;
    VectorXd points;
    result.converged = true;
    if (is_step(*after)) {
        points = after->points;
        result.converged = !after->is_between;
    } else if (is_step(*(after - 1))) {
        points = (after - 1)->points;
        result.converged = !(after - 1)->is_between;
    } else {
        points = s.between(*part, to_size(after - 1 - steps.begin()), t);
        result.iterations = s.options.sweep_steps;
        result.converged = !after->is_between && !(after - 1)->is_between;
    }
    const ShapePoint target = s.target(t);
    LengthDihedralEnergy energy = s.energy(target);
    VectorXd gradient;
    result.energy = energy.evaluate(points, gradient);
    result.points = s.system.result_of(points);
    if (target.positions.rows() > 0) {
        result.companion = s.system.result_of(in_rows(target.positions));
    } else if (target.patch_turns.size() > 0) {
        const auto start = s.system.starts.borrow();
        result.companion = s.system.result_of(in_rows(start->points(target, 3)));
    }
    return result;
}

} // namespace shape::internal
