// SPDX-License-Identifier: MIT

#include "libshape/registration/scan_fit.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/nearest_in_triangle.h"
#include "libshape/mesh/vertex_normals.h"
#include "libshape/registration/doubted_landmarks.h"
#include "libshape/registration/fit_verdict.h"
#include "libshape/registration/growth_energy.h"
#include "libshape/registration/landmark_checks.h"
#include "libshape/registration/landmark_units.h"
#include "libshape/registration/rigid_start.h"
#include "libshape/registration/scan_surface.h"
#include "libshape/registration/surface_pulls.h"
#include "libshape/registration/template_levels.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

// The schedule. Weights count in the mesh's edges, so they are stated for a mesh whose mean edge is its
// diagonal, and reach from the coarsest level's first round to the finest one's last. All found on
// tests/benchmarks/fit_table.py.
constexpr double first_weight = 140.0, last_weight = 5e4;
constexpr double first_scale = 0.1, last_scale = 0.005; // of Welsch's weights, of the diagonal
constexpr double coarse_share = 0.4;                    // of the way, which the coarsest level goes
constexpr double rim_weight = 10.0; // a rim's few vertices against all those of the surface
constexpr int least_vertices = 450; // of the coarsest level: limbs and noses are still there
constexpr int settling_rounds = 3;  // at the last weight, until the closest points stay the same

/// Rounds of closest points on one level: the part of the way they go, from the first weight to the last.
struct LevelRounds
{
    int rounds;
    int linear_steps;
    double from, to;
    bool landmarks_first;
    double growth_smoothness; // times that of the options
    bool slides_freely;
};
constexpr int coarsest_rounds = 30, finer_rounds = 5;
// Few: solved to the end, steps left limbs turned about their axes more often (measured, docs/experiments/correspondence.md).
constexpr int coarsest_steps = 12, finer_steps = 15;

/// What level `number` of `count` does when the coarsest comes first.
constexpr LevelRounds rounds_of(std::size_t number, std::size_t count)
{
    const bool is_coarsest = number + 1 == count, is_finest = number == 0;
    return {is_coarsest ? coarsest_rounds + (is_finest ? finer_rounds : 0) : finer_rounds,
            is_coarsest ? coarsest_steps : finer_steps,
            is_coarsest ? 0.0 : coarse_share,
            is_finest ? 1.0 : coarse_share,
            is_coarsest,
            1.0,
            false};
}
/// From an earlier fit, held to what is expected of it, growth too.
constexpr LevelRounds held_rounds{12, finer_steps, 0.7, 1.0, false, 100.0, false};
/// The facets of two triangulations of a surface do not agree: pulls as strong as those of the first fit make up
/// for that by sliding.
constexpr LevelRounds free_rounds{12, 2 * finer_steps, 0.3, 0.5, false, 100.0, true};
/// The preconditioner is factorised anew every N-th round, as the pulls have grown meanwhile. Set with the schedule
/// above.
constexpr int rounds_between_factors = 5;
/// CoarseTrial::score. Right starts of faces, bodies and an arm have at most 0.054, wrong ones 0.18 and more
/// (docs/experiments/correspondence.md).
constexpr double doubtful_start = 0.06;
/// A start of another orientation may be the right one if its score is below the first of these times the best one's
/// plus the second: of shapes that are nearly symmetric it is 1.0 to 1.3 times, of others 4.5 and more, and
/// below the second nothing speaks against a start.
constexpr double nearly_as_well = 2.0, as_well_as_it_gets = 1e-3;
/// Between starts whose scores are less apart, what is known without them decides.
constexpr double clearly_better = 0.8;
/// A landmark is doubted if without it its place comes out farther than this from where it was put, over the scan's
/// diagonal, and than so many standard deviations of what is tolerated. Right ones of the collections, placed to 1 %,
/// come out up to 5.9 % away (docs/experiments/correspondence.md).
constexpr double doubtful_distance = 0.06, tolerated_deviations = 3.0;
/// So many rigid starts are tried, each by so many rounds of the coarsest level, before the best of them goes on. Set by
/// hand.
constexpr int tried_starts = 4, trial_rounds = 12;
constexpr int landmark_rounds = 12; // by landmarks alone, before the surface pulls
constexpr int landmark_steps = 60;  // of each: landmarks tell the whole motion
/// How strongly one landmark without a tolerance pulls, beside a vertex that the surface pulls. Set by hand.
constexpr double landmark_strength = 30.0;
/// Landmarks pull as if the surface's weight were never below this, which it is in early rounds where edges are short
/// against the diagonal. Set by hand.
constexpr double least_landmark_base = 0.1;
/// So many rounds bring landmarks that are to be met exactly home. Set by hand.
constexpr int finishing_rounds = 4;

/// Landmarks of the template as points of a level's faces.
std::vector<SurfacePoint> on_level(const TemplateLevel& level, const Points& landmarks)
{
    std::vector<SurfacePoint> points;
    if (landmarks.rows() == 0)
        return points;
    const ClosestPoints tree(level.rest, level.topology.faces());
    for (const auto& landmark : landmarks.rowwise())
        points.push_back(tree.nearest(landmark));
    return points;
}

Vector3d position(const SurfacePoint& point, const Faces& faces, const Points& points)
{
    Vector3d sum = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
        sum += point.barycentric[k] * points.row(faces(point.face, k)).transpose();
    return sum;
}

/// The loop whose nearest point is nearest.
int loop_at(const Rims& rims, const Points& points, const Vector3d& landmark)
{
    int loop = -1;
    double least = 0.0;
    for (const Rims::Edge& edge : rims.edges) {
        const Vector3d a = points.row(edge.from), b = points.row(edge.to);
        const Vector3d w = nearest_in_triangle(landmark, a, b, b);
        const double distance = (w[0] * a + (w[1] + w[2]) * b - landmark).squaredNorm();
        if (loop < 0 || distance < least) {
            loop = edge.loop;
            least = distance;
        }
    }
    return loop;
}

/// Lengths and angles of a level at rest.
ShapePoint shape_of(const TemplateLevel& level)
{
    return {edge_lengths(level.topology, level.rest), dihedral_angles(level.topology, level.rest)};
}

} // namespace

void check(const FitOptions& options)
{
    require_positive(options.smoothness, "FitOptions.smoothness");
    require_positive(options.growth_smoothness, "FitOptions.growth_smoothness");
    require_not_negative(options.landmark_tolerance, "FitOptions.landmark_tolerance");
}

struct ScanFitter::State
{
    FitOptions options;
    std::vector<TemplateLevel> levels;
    Surface surface; // of the template
    double own_diagonal;
    TemplateFigures own_figures;

    State(const Topology& topology, const Points& points, const FitOptions& with)
        : options(with),
          levels(template_levels(topology, points, least_vertices)),
          surface(points, topology.faces()),
          own_diagonal(bounding_box_diagonal(points)),
          own_figures(topology, points)
    {
    }

    /// What is known of one scan, and the template at the size of a start.
    struct Target
    {
        std::vector<TemplateLevel> levels;
        double diagonal;
        Surface scan;
        Points landmarks_here; // on the template, at that size
        LandmarkPairs landmarks;
        double landmark_tolerance;
    };

    void add_landmark_pulls(const TemplateLevel& level, const std::vector<SurfacePoint>& marks,
                            const Target& target, const Points& points, double weight,
                            GrowthEnergy& energy) const;
    [[nodiscard]] GrowthEnergy energy_of(const TemplateLevel& level, const ShapePoint& rest,
                                         double growth_smoothness = 1.0,
                                         bool slides_freely = false) const;
    [[nodiscard]] Target target_of(Surface scan, const LandmarkPairs& landmarks,
                                   double scale) const;
    void resize(double scale, Target& target) const;
    void run_level(std::size_t number, const Target& target, const ShapePoint& rest,
                   const LevelRounds& schedule, LevelMesh& mesh) const;
    void finish(const Target& target, const ShapePoint& rest, double start_growth, LevelMesh& mesh,
                ScanFit& fit) const;
    [[nodiscard]] VectorXd bent_edges(const TemplateLevel& level, const ShapePoint& rest,
                                      const LevelMesh& mesh) const;
    [[nodiscard]] CoarseTrial try_start(const Similarity& start, Target& target) const;
    [[nodiscard]] CoarseTrial try_landmarks(const LandmarkPairs& landmarks,
                                            const std::vector<Similarity>& starts,
                                            Target& target) const;
    [[nodiscard]] std::vector<DoubtedLandmark> doubted(const Similarity& start,
                                                       const LevelMesh& coarsest,
                                                       Target& target) const;
    struct ChosenStart
    {
        Similarity start;
        std::string doubt;                // empty: none, or there was nothing to choose
        std::optional<CoarseTrial> trial; // nothing if there was nothing to choose
    };
    [[nodiscard]] ChosenStart choose_start(const std::vector<Similarity>& starts,
                                           Target& target) const;
    [[nodiscard]] std::string doubt_of_few(const std::vector<Similarity>& starts,
                                           const ChosenStart& chosen, Target& target) const;
    void finish_landmarks(const Target& target, const ShapePoint& rest, LevelMesh& mesh) const;
};

void ScanFitter::State::add_landmark_pulls(const TemplateLevel& level,
                                           const std::vector<SurfacePoint>& marks,
                                           const Target& target, const Points& points,
                                           double weight, GrowthEnergy& energy) const
{
    const Faces& faces = level.topology.faces();
    for (std::size_t i = 0; i < marks.size(); ++i) {
        const Vector3d move = target.landmarks.on_scan.row(static_cast<Index>(i)).transpose() -
                              position(marks[i], faces, points);
        for (int k = 0; k < 3; ++k)
            for (int axis = 0; axis < 3; ++axis)
                energy.add_pull(faces(marks[i].face, k), Vector3d::Unit(axis), move[axis],
                                weight * marks[i].barycentric[k]);
    }
}

GrowthEnergy ScanFitter::State::energy_of(const TemplateLevel& level, const ShapePoint& rest,
                                          double growth_smoothness, bool slides_freely) const
{
    return {level.topology,
            rest,
            {.smoothness = options.smoothness,
             .growth_smoothness = growth_smoothness * options.growth_smoothness,
             .slides_freely = slides_freely}};
}

/// The rounds of closest points on one level of the template.
void ScanFitter::State::run_level(std::size_t number, const Target& target, const ShapePoint& rest,
                                  const LevelRounds& schedule, LevelMesh& mesh) const
{
    const TemplateLevel& level = target.levels[number];
    GrowthEnergy energy =
        energy_of(level, rest, schedule.growth_smoothness, schedule.slides_freely);
    const double in_edges = energy.unit() / target.diagonal * energy.unit() / target.diagonal;
    const Rims rims = find_rims(level.topology.faces());
    const std::vector<SurfacePoint> marks = on_level(level, target.landmarks_here);
    std::vector<std::pair<int, int>> named;
    for (const std::string& name : options.boundaries) {
        const std::vector<std::string>& names = target.landmarks.names;
        const auto i = std::find(names.begin(), names.end(), name) - names.begin();
        const int mine = loop_at(rims, level.rest, target.landmarks_here.row(i));
        const int other =
            loop_at(target.scan.rims, target.scan.points, target.landmarks.on_scan.row(i));
        if (mine >= 0 && other >= 0) // else no loop at all is left on this level
            named.emplace_back(mine, other);
    }
    // A landmark is one vertex against all those that the surface pulls; a tolerance weakens it.
    const double blur = target.landmark_tolerance / (hand_placed * target.diagonal);
    const double landmark_weight = landmark_strength / (1.0 + blur * blur);

    if (schedule.landmarks_first && !marks.empty())
        // Nothing pulls against them yet: a tenth moves the mesh as a whole and does not dent it.
        for (int round = 0; round < landmark_rounds; ++round) {
            energy.clear_pulls(mesh.points);
            add_landmark_pulls(level, marks, target, mesh.points, 0.1 * landmark_weight, energy);
            energy.prepare();
            (void)energy.step(mesh.points, mesh.growth, landmark_steps);
        }

    const int last_changing =
        std::max(1, schedule.rounds - (schedule.to == 1.0 ? settling_rounds : 1));
    LastPairs last;
    for (int round = 0; round < schedule.rounds; ++round) {
        const double done =
            schedule.from + (schedule.to - schedule.from) *
                                std::min(1.0, static_cast<double>(round) / last_changing);
        const PullRule rule{
            .weight = first_weight * std::pow(last_weight / first_weight, done) * in_edges,
            .scale = target.diagonal * first_scale * std::pow(last_scale / first_scale, done)};
        energy.clear_pulls(mesh.points);
        add_surface_pulls(target.scan, level.topology, mesh.points, rule, energy, last);
        add_rim_pulls(target.scan, rims, mesh.points, named,
                      {.weight = rim_weight * rule.weight, .scale = rule.scale}, energy);
        add_landmark_pulls(level, marks, target, mesh.points,
                           landmark_weight * std::max(rule.weight, least_landmark_base), energy);
        if (round % rounds_between_factors == 0)
            energy.prepare();
        (void)energy.step(mesh.points, mesh.growth, schedule.linear_steps);
    }
}

/// What the first rounds make of a start.
CoarseTrial ScanFitter::State::try_start(const Similarity& start, Target& target) const
{
    resize(start.scale, target);
    const TemplateLevel& level = target.levels.back();
    const ShapePoint rest = shape_of(level);
    LevelRounds trial = rounds_of(levels.size() - 1, levels.size());
    trial.rounds = trial_rounds;
    LevelMesh mesh{start.motion(level.rest), VectorXd::Zero(level.rest.rows())};
    run_level(levels.size() - 1, target, rest, trial, mesh);

    VectorXd bent = bent_edges(level, rest, mesh);
    // Bends and distances count alike at 1 rad and 2 % of the diagonal; what the template lacks is not held
    // against a start beyond 10 %.
    const ClosestPoints tree(mesh.points, level.topology.faces());
    const Index stride = std::max<Index>(1, target.scan.points.rows() / 500);
    double apart = 0.0;
    Index samples = 0;
    for (Index p = 0; p < target.scan.points.rows(); p += stride, ++samples)
        apart += std::min(tree.nearest(target.scan.points.row(p)).distance, 0.1 * target.diagonal);
    apart /= 0.02 * target.diagonal * static_cast<double>(samples);
    const double score = bent.mean() + apart * apart;
    return {std::move(mesh), std::move(bent), score};
}

/// Squares of strains and bends of every edge of a level.
VectorXd ScanFitter::State::bent_edges(const TemplateLevel& level, const ShapePoint& rest,
                                       const LevelMesh& mesh) const
{
    VectorXd bent = energy_of(level, rest).strains(mesh.points, mesh.growth).cwiseAbs2();
    const VectorXd angles = dihedral_angles(level.topology, mesh.points);
    for (Index e = 0; e < bent.size(); ++e) {
        const double bend = wrapped_angle(angles[e] - rest.dihedral_angles[e]);
        bent[e] += bend * bend;
    }
    return bent;
}

/// The best start after a few rounds on the coarsest level from each: where the template bends least and comes nearest.
/// A start that a pose has moved far from the best rigid one wins by that.
ScanFitter::State::ChosenStart ScanFitter::State::choose_start(
    const std::vector<Similarity>& starts, Target& target) const
{
    if (starts.size() == 1)
        return {starts.front(), {}, std::nullopt};
    std::vector<CoarseTrial> trials;
    for (const Similarity& start : starts)
        trials.push_back(try_start(start, target));
    // The axes that the template has already are meant, and the size of the scan is that of the shape, unless another
    // start is clearly better.
    const auto handicapped = [&](std::size_t i) {
        double score = trials[i].score;
        if (turn_angle(starts[i].motion.rotation) >= same_way)
            score /= clearly_better;
        if (starts[i].scale != starts.front().scale)
            score /= clearly_better;
        return score;
    };
    std::size_t best = 0;
    for (std::size_t i = 1; i < starts.size(); ++i)
        if (handicapped(i) < handicapped(best))
            best = i;
    resize(starts[best].scale, target);
    const double score = trials[best].score;
    if (score > doubtful_start)
        return {starts[best], doubt_of_bent_start(), std::move(trials[best])};
    double rival_score = nearly_as_well * score + as_well_as_it_gets;
    double rival_turn = 0.0;
    for (const CoarseTrial& trial : trials) {
        const double turn =
            turn_angle(best_rigid_motion(trials[best].mesh.points, trial.mesh.points).rotation);
        if (turn >= same_way && trial.score < rival_score) {
            rival_score = trial.score;
            rival_turn = turn;
        }
    }
    std::string doubt = rival_turn > 0.0 ? doubt_of_rival_start(rival_turn) : std::string();
    return {starts[best], std::move(doubt), std::move(trials[best])};
}

/// A trial with other landmarks: from where three and more say, else the best from these starts.
CoarseTrial ScanFitter::State::try_landmarks(const LandmarkPairs& landmarks,
                                             const std::vector<Similarity>& starts,
                                             Target& target) const
{
    const LandmarkPairs given = std::exchange(target.landmarks, landmarks);
    std::optional<CoarseTrial> best;
    if (!is_on_line(landmarks.on_template) && !is_on_line(landmarks.on_scan))
        best = try_start(landmark_start(landmarks.on_template, landmarks.on_scan), target);
    else
        for (const Similarity& start : starts)
            if (CoarseTrial trial = try_start(start, target); !best || trial.score < best->score)
                best = std::move(trial);
    target.landmarks = given;
    return std::move(*best);
}

/// Whether two or three landmarks stand beside the wrong names. Leaves the target at another size.
std::string ScanFitter::State::doubt_of_few(const std::vector<Similarity>& starts,
                                            const ChosenStart& chosen, Target& target) const
{
    const LandmarkPairs given = target.landmarks;
    const std::vector<std::string> exchanged = exchanged_landmarks(
        levels.back(), given, chosen.trial ? *chosen.trial : try_start(chosen.start, target),
        [&](const LandmarkPairs& landmarks) { return try_landmarks(landmarks, starts, target); });
    return exchanged.empty() ? std::string() : doubt_of_names(exchanged);
}

/// The landmarks that the others do not bear out, where no exchange explains them.
/// @param coarsest  The fit on that level.
std::vector<DoubtedLandmark> ScanFitter::State::doubted(const Similarity& start,
                                                        const LevelMesh& coarsest,
                                                        Target& target) const
{
    const LandmarkPairs given = target.landmarks;
    if (mistaken_landmarks(given.names, given.on_template, given.on_scan))
        return {};
    const double near = std::max(doubtful_distance * bounding_box_diagonal(target.scan.points),
                                 tolerated_deviations * options.landmark_tolerance);
    const TemplateLevel& level = target.levels.back();
    const std::vector<DoubtedLandmark> named = doubted_landmarks(
        levels.back(), given, bent_edges(level, shape_of(level), coarsest), near,
        [&](const LandmarkPairs& landmarks) { return try_landmarks(landmarks, {start}, target); });
    resize(start.scale, target);
    return named;
}

/// Landmarks to be met exactly are: what is still missing is spread over the mesh by a few steps in which
/// nothing else moves far.
void ScanFitter::State::finish_landmarks(const Target& target, const ShapePoint& rest,
                                         LevelMesh& mesh) const
{
    if (target.landmarks_here.rows() == 0 || target.landmark_tolerance > 0.0)
        return;
    const TemplateLevel& level = target.levels.front();
    const std::vector<SurfacePoint> marks = on_level(level, target.landmarks_here);
    GrowthEnergy energy = energy_of(level, rest);
    const double in_edges = energy.unit() / target.diagonal * energy.unit() / target.diagonal;
    constexpr double weight = 3e3; // some hundred times landmark_weight
    LastPairs last;
    for (int round = 0; round < finishing_rounds; ++round) {
        energy.clear_pulls(mesh.points);
        add_surface_pulls(target.scan, level.topology, mesh.points,
                          {.weight = last_weight * in_edges, .scale = last_scale * target.diagonal},
                          energy, last);
        add_landmark_pulls(level, marks, target, mesh.points, weight, energy);
        if (round == 0) // what pulls stays about as strong
            energy.prepare();
        (void)energy.step(mesh.points, mesh.growth, 2 * finer_steps);
    }
}

ScanFitter::ScanFitter(const Topology& topology, const Points& points, const FitOptions& options)
{
    check(options);
    if (const auto defects = find_degenerate_geometry(topology.faces(), points); !defects.empty())
        throw InvalidInput(join("template: ", defects.front().message));
    state_ = std::make_unique<State>(topology, points, options);
}

ScanFitter::~ScanFitter() = default;
ScanFitter::ScanFitter(ScanFitter&&) noexcept = default;
ScanFitter& ScanFitter::operator=(ScanFitter&&) noexcept = default;

namespace {

/// The scan as it is, or all of it turned over if it is inside out as a whole.
std::pair<Faces, int> turned_outwards(const Scan& scan, const Surface& pattern)
{
    constexpr double surely = 0.01; // a flat one has nothing to tell
    std::pair<Faces, int> result{scan.faces, 0};
    if (outwardness(pattern.points, pattern.faces) * outwardness(scan.points, scan.faces) <
        -surely) {
        result.first.col(1).swap(result.first.col(2));
        result.second = static_cast<int>(scan.faces.rows());
    }
    return result;
}

void check_landmarks(const LandmarkPairs& landmarks, const std::vector<std::string>& boundaries,
                     const Points& on_template, const Points& on_scan)
{
    const auto count = std::ssize(landmarks.names);
    if (landmarks.on_template.rows() != count || landmarks.on_scan.rows() != count)
        throw InvalidInput(join("landmarks: ", count, " names, ", landmarks.on_template.rows(),
                                " points on the template and ", landmarks.on_scan.rows(),
                                " on the scan"));
    for (const std::string& name : boundaries)
        if (std::find(landmarks.names.begin(), landmarks.names.end(), name) ==
            landmarks.names.end())
            throw InvalidInput(join("boundary '", name, "' is not the name of a landmark"));
    const auto check = [&](const Points& points, const Points& surface, const std::string& whose) {
        check_not_zero(landmarks.names, points, surface, whose);
        check_not_far(landmarks.names, points, surface, whose);
        check_not_on_line(points, surface, whose);
    };
    check(landmarks.on_template, on_template, "the template");
    check(landmarks.on_scan, on_scan, "the scan");
}

void check_boundaries(const std::vector<std::string>& boundaries, const Surface& pattern,
                      const Surface& scan)
{
    for (const std::string& name : boundaries) {
        if (pattern.rims.edges.empty())
            throw InvalidInput(join("boundary '", name, "': the template has no boundary"));
        if (scan.rims.edges.empty())
            throw InvalidInput(join("boundary '", name, "': the scan has no boundary"));
    }
}

} // namespace

ScanFitter::State::Target ScanFitter::State::target_of(Surface scan, const LandmarkPairs& landmarks,
                                                       double scale) const
{
    Target target{levels,          own_diagonal,
                  std::move(scan), landmarks.on_template,
                  landmarks,       options.landmark_tolerance};
    resize(scale, target);
    return target;
}

void ScanFitter::State::resize(double scale, Target& target) const
{
    for (std::size_t i = 0; i < levels.size(); ++i)
        target.levels[i].rest = scale * levels[i].rest;
    target.diagonal = scale * own_diagonal;
    target.landmarks_here = scale * target.landmarks.on_template;
}

/// @param start_growth  By which the template was larger than at rest when its growth was 0.
void ScanFitter::State::finish(const Target& target, const ShapePoint& rest, double start_growth,
                               LevelMesh& mesh, ScanFit& fit) const
{
    finish_landmarks(target, rest, mesh);
    const TemplateLevel& level = target.levels.front();
    const VectorXd strains = energy_of(level, rest).strains(mesh.points, mesh.growth);
    const std::vector<SurfacePoint> marks = on_level(level, target.landmarks_here);
    Points reached(std::ssize(marks), 3);
    for (std::size_t i = 0; i < marks.size(); ++i)
        reached.row(static_cast<Index>(i)) =
            position(marks[i], level.topology.faces(), mesh.points);
    VectorXd off_template(target.landmarks.on_template.rows());
    for (Index i = 0; i < off_template.size(); ++i)
        off_template[i] =
            surface.tree.nearest(target.landmarks.on_template.row(i)).distance / own_diagonal;
    judge({.topology = level.topology,
           .mesh = mesh,
           .strains = strains,
           .scan = target.scan,
           .diagonal = target.diagonal,
           .start_growth = start_growth,
           .landmarks = target.landmarks,
           .off_template = off_template,
           .reached = reached,
           .landmark_tolerance = target.landmark_tolerance},
          own_figures, fit);
    fit.points = mesh.points;
    const auto doubt = [&](const std::string& reason) {
        fit.status = std::max(fit.status, FitStatus::Check);
        fit.reasons.push_back(reason);
    };
    if (!fit.start_doubt.empty())
        doubt(fit.start_doubt);
    for (const DoubtedLandmark& landmark : fit.doubted_landmarks)
        doubt(doubt_of_landmark(landmark, fit.diagonal));
}

ScanFit ScanFitter::fit(const Scan& scan, const LandmarkPairs& landmarks) const
{
    const State& s = *state_;
    check_landmarks(landmarks, s.options.boundaries, s.surface.points, scan.points);
    if (const auto said = other_unit_of(landmarks.on_template, s.surface,
                                        landmark_off * s.own_diagonal, "the template"))
        throw InvalidInput(*said);
    const auto [faces, turned] = turned_outwards(scan, s.surface);
    Surface surface(scan.points, faces);
    check_boundaries(s.options.boundaries, s.surface, surface);
    std::vector<Similarity> starts{Similarity{}};
    if (landmarks.names.size() >= 3)
        starts = {landmark_start(landmarks.on_template, landmarks.on_scan)};
    else if (s.options.search_start)
        starts = rigid_starts(s.surface, surface, tried_starts);
    State::Target target = s.target_of(std::move(surface), landmarks, starts.front().scale);
    const State::ChosenStart chosen = s.choose_start(starts, target);
    const Similarity& start = chosen.start;
    std::string doubt = chosen.doubt;
    if (landmarks.names.size() == 2 || landmarks.names.size() == 3)
        if (const std::string names = s.doubt_of_few(starts, chosen, target); !names.empty())
            doubt = names;
    s.resize(start.scale, target);
    auto [oriented, more_turned] =
        oriented_like(scan.points, faces, Surface(start(s.surface.points), s.surface.faces));
    if (more_turned > 0)
        target.scan = Surface(scan.points, std::move(oriented));

    ScanFit fit;
    fit.scale = change_of_unit(start.scale);
    fit.start_doubt = doubt;
    fit.turned_faces = std::abs(turned - more_turned);
    const std::size_t count = s.levels.size();
    LevelMesh mesh{start.motion(target.levels.back().rest),
                   VectorXd::Zero(target.levels.back().rest.rows())};
    for (std::size_t number = count; number-- > 0;) {
        if (number + 1 < count)
            mesh = carried_to_finer(target.levels[number + 1], mesh, target.levels[number]);
        s.run_level(number, target, shape_of(target.levels[number]), rounds_of(number, count),
                    mesh);
        if (number + 1 == count)
            fit.doubted_landmarks = s.doubted(start, mesh, target);
    }
    s.finish(target, shape_of(target.levels.front()), start.scale / fit.scale, mesh, fit);
    return fit;
}

ScanFit ScanFitter::fit_again(const Scan& scan, const LandmarkPairs& landmarks, const ScanFit& from,
                              const ShapePoint& rest, Sliding sliding) const
{
    const State& s = *state_;
    check_landmarks(landmarks, s.options.boundaries, s.surface.points, scan.points);
    const Topology& topology = s.levels.front().topology;
    if (from.points.rows() != topology.vertex_count())
        throw InvalidInput(join("fit_again: the earlier fit has ", from.points.rows(),
                                " vertices, the template ", topology.vertex_count()));
    const auto [faces, turned] =
        oriented_like(scan.points, scan.faces, Surface(from.points, topology.faces()));
    Surface surface(scan.points, faces);
    check_boundaries(s.options.boundaries, s.surface, surface);
    const double size = spread(from.points) / spread(s.surface.points);
    const State::Target target = s.target_of(std::move(surface), landmarks, size);
    ScanFit fit;
    fit.scale = from.scale;
    fit.start_doubt = from.start_doubt;
    fit.doubted_landmarks = from.doubted_landmarks;
    fit.turned_faces = turned;
    LevelMesh mesh{from.points, VectorXd::Zero(from.points.rows())};
    s.run_level(0, target, rest, sliding == Sliding::Free ? free_rounds : held_rounds, mesh);
    s.finish(target, rest, 1.0, mesh, fit);
    return fit;
}

} // namespace shape
