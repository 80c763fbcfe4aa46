// SPDX-License-Identifier: MIT

#include "libshape/registration/scan_fit.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/order_statistics.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/face_crossings.h"
#include "libshape/mesh/nearest_in_triangle.h"
#include "libshape/mesh/vertex_normals.h"
#include "libshape/registration/growth_energy.h"
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
constexpr int coarsest_rounds = 30, finer_rounds = 8;
constexpr int coarsest_steps = 60, finer_steps = 15;

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
constexpr int rounds_between_factors = 5;
/// ChosenStart::score. Right starts of faces stay below the first, wrong ones of faces and bodies are above 0.08;
/// above the second a person should look (docs/correspondence.md).
constexpr double sure_start = 0.015, doubtful_start = 0.04;
constexpr int tried_starts = 4, trial_rounds = 12;
constexpr int landmark_rounds = 12; // by landmarks alone, before the surface pulls

// Shares of the diagonal.
constexpr double counterpart_within = 0.01; // a finished fit lies nearer by far
constexpr double hand_placed = 0.003;       // what a landmark placed by hand is off by

/// What a report's figures may be before a person should look, and before the fit is not one: set by hand, well above
/// those of sound fits of faces, bodies and arms (docs/correspondence.md).
struct Bound
{
    double check, failed;
};
constexpr Bound unseen_share{0.15, 0.8};    // of the vertices; half a face leaves half of them
constexpr Bound scan_distance{0.005, 0.02}; // mean, over the diagonal
constexpr Bound strain_bound{0.15, 0.25};   // RMS
constexpr Bound landmark_miss{0.002, 0.03}; // over the diagonal
constexpr double landmark_off_scan = 0.01;  // over the diagonal
constexpr double growth_range = 3.0; // between parts of one shape, which no person's differ by
constexpr double odd_faces = 0.02;   // share that may cross or fold
constexpr double folded_angle = 120.0 * std::numbers::pi / 180.0; // no pose bends an edge so far

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

DistanceSummary summary_of(const std::vector<double>& distances)
{
    DistanceSummary summary;
    if (distances.empty())
        return summary;
    for (const double d : distances)
        summary.mean += d / static_cast<double>(distances.size());
    summary.p95 = quantile_of(distances, 0.95);
    summary.max = *std::max_element(distances.begin(), distances.end());
    return summary;
}

/// Lengths and angles of a level at rest.
ShapePoint shape_of(const TemplateLevel& level)
{
    return {edge_lengths(level.topology, level.rest), dihedral_angles(level.topology, level.rest)};
}

std::string percent(double share)
{
    return join(std::round(share * 1000.0) / 10.0, " %");
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
    VectorXd dihedral_angles_at_rest;
    double own_diagonal;
    FaceTree face_tree;
    int own_crossings; // of the template

    State(const Topology& topology, const Points& points, const FitOptions& with)
        : options(with),
          levels(template_levels(topology, points, least_vertices)),
          surface(points, topology.faces()),
          dihedral_angles_at_rest(dihedral_angles(topology, points)),
          own_diagonal(bounding_box_diagonal(points)),
          face_tree(topology, points),
          own_crossings(static_cast<int>(face_tree.crossings(points).size()))
    {
    }

    /// What is known of one scan. The template counts in its unit, `scale` times its own.
    struct Target
    {
        std::vector<TemplateLevel> levels;
        double diagonal;
        Surface scan;
        Points landmarks_here;  // on the template
        Points landmarks_there; // on the scan
        std::vector<std::string> names;
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
    void run_level(std::size_t number, const Target& target, const ShapePoint& rest,
                   const LevelRounds& schedule, LevelMesh& mesh) const;
    void finish(const Target& target, const ShapePoint& rest, LevelMesh& mesh, ScanFit& fit) const;
    struct ChosenStart
    {
        Similarity start;
        double score = 0.0; // 0 where there was nothing to choose
    };
    [[nodiscard]] ChosenStart choose_start(const std::vector<Similarity>& starts,
                                           const Target& target) const;
    void finish_landmarks(const Target& target, const ShapePoint& rest, LevelMesh& mesh) const;
    void judge(const Target& target, const ShapePoint& rest, const LevelMesh& mesh,
               ScanFit& fit) const;
    void set_status(const Target& target, ScanFit& fit) const;
};

void ScanFitter::State::add_landmark_pulls(const TemplateLevel& level,
                                           const std::vector<SurfacePoint>& marks,
                                           const Target& target, const Points& points,
                                           double weight, GrowthEnergy& energy) const
{
    const Faces& faces = level.topology.faces();
    for (std::size_t i = 0; i < marks.size(); ++i) {
        const Vector3d move = target.landmarks_there.row(static_cast<Index>(i)).transpose() -
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
        const auto i =
            std::find(target.names.begin(), target.names.end(), name) - target.names.begin();
        const int mine = loop_at(rims, level.rest, target.landmarks_here.row(i));
        const int other =
            loop_at(target.scan.rims, target.scan.points, target.landmarks_there.row(i));
        if (mine >= 0 && other >= 0)
            named.emplace_back(mine, other);
    }
    // A landmark is one vertex against all those that the surface pulls; a tolerance weakens it.
    const double blur = target.landmark_tolerance / (hand_placed * target.diagonal);
    const double landmark_weight = 30.0 / (1.0 + blur * blur);

    if (schedule.landmarks_first && !marks.empty())
        // Nothing pulls against them yet: a tenth moves the mesh as a whole and does not dent it.
        for (int round = 0; round < landmark_rounds; ++round) {
            energy.clear_pulls(mesh.points);
            add_landmark_pulls(level, marks, target, mesh.points, 0.1 * landmark_weight, energy);
            energy.prepare();
            (void)energy.step(mesh.points, mesh.growth, schedule.linear_steps);
        }

    const int last_changing =
        std::max(1, schedule.rounds - (schedule.to == 1.0 ? settling_rounds : 1));
    for (int round = 0; round < schedule.rounds; ++round) {
        const double done =
            schedule.from + (schedule.to - schedule.from) *
                                std::min(1.0, static_cast<double>(round) / last_changing);
        const PullRule rule{
            .weight = first_weight * std::pow(last_weight / first_weight, done) * in_edges,
            .scale = target.diagonal * first_scale * std::pow(last_scale / first_scale, done)};
        energy.clear_pulls(mesh.points);
        add_surface_pulls(target.scan, level.topology, mesh.points, rule, energy);
        add_rim_pulls(target.scan, rims, mesh.points, named,
                      {.weight = rim_weight * rule.weight, .scale = rule.scale}, energy);
        add_landmark_pulls(level, marks, target, mesh.points,
                           landmark_weight * std::max(rule.weight, 0.1), energy);
        if (round % rounds_between_factors == 0)
            energy.prepare();
        (void)energy.step(mesh.points, mesh.growth, schedule.linear_steps);
    }
}

/// The best start after a few rounds on the coarsest level from each: where the template bends least and comes nearest.
/// A start that a pose has moved far from the best rigid one wins by that.
ScanFitter::State::ChosenStart ScanFitter::State::choose_start(
    const std::vector<Similarity>& starts, const Target& target) const
{
    if (starts.size() == 1)
        return {starts.front()};
    const TemplateLevel& level = target.levels.back();
    const ShapePoint rest = shape_of(level);
    const GrowthEnergy energy = energy_of(level, rest);
    LevelRounds trial = rounds_of(levels.size() - 1, levels.size());
    trial.rounds = trial_rounds;
    std::size_t best = 0;
    double least = 0.0;
    for (std::size_t i = 0; i < starts.size(); ++i) {
        LevelMesh mesh{starts[i].motion(level.rest), VectorXd::Zero(level.rest.rows())};
        run_level(levels.size() - 1, target, rest, trial, mesh);
        const VectorXd strains = energy.strains(mesh.points, mesh.growth);
        const VectorXd bends = dihedral_angles(level.topology, mesh.points) -
                               dihedral_angles(level.topology, level.rest);
        double bent = 0.0;
        for (const double bend : bends)
            bent += wrapped_angle(bend) * wrapped_angle(bend);
        const ClosestPoints tree(mesh.points, level.topology.faces());
        // Bends and distances count alike at 1 rad and 2 % of the diagonal; what the template lacks is not held
        // against a start beyond 10 %.
        const Index stride = std::max<Index>(1, target.scan.points.rows() / 500);
        double apart = 0.0;
        Index samples = 0;
        for (Index p = 0; p < target.scan.points.rows(); p += stride, ++samples)
            apart +=
                std::min(tree.nearest(target.scan.points.row(p)).distance, 0.1 * target.diagonal);
        apart /= 0.02 * target.diagonal * static_cast<double>(samples);
        const double score =
            (strains.squaredNorm() + bent) / static_cast<double>(strains.size()) + apart * apart;
        // Where it lies already is meant, unless the unit is another one or a start is clearly better.
        const bool is_meant = starts.front().scale == 1.0;
        constexpr double clearly_better = 0.8;
        if (i == 0 || score < (best == 0 && is_meant ? clearly_better : 1.0) * least) {
            best = i;
            least = score;
        }
        if (i == 0 && is_meant && score < sure_start)
            break;
    }
    return {starts[best], least};
}

void ScanFitter::State::judge(const Target& target, const ShapePoint& rest, const LevelMesh& mesh,
                              ScanFit& fit) const
{
    const Topology& topology = levels.front().topology;
    const Points normals = vertex_normals(mesh.points, topology.faces());
    const double near = counterpart_within * target.diagonal;
    const auto count = to_size(mesh.points.rows());
    fit.distance.resize(mesh.points.rows());
    fit.seen.assign(count, 0);
    parallel_for(count, 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const auto row = static_cast<Index>(v);
            const SurfacePoint any = target.scan.tree.nearest(mesh.points.row(row));
            fit.distance[row] = any.distance;
            NearestRule rule;
            rule.normal = normals.row(row);
            rule.least_cosine = 0.0;
            rule.within = near;
            const SurfacePoint pair = target.scan.tree.nearest(mesh.points.row(row), rule);
            // At a rim, what lies a little beyond it is not seen; a template's own rim may lie on it.
            const bool is_end = pair.face >= 0 && target.scan.ends_at(pair) &&
                                pair.distance > hand_placed * target.diagonal;
            fit.seen[v] = pair.face >= 0 && !is_end ? 1 : 0;
        }
    });
    std::vector<double> of_seen;
    for (std::size_t v = 0; v < count; ++v)
        if (fit.seen[v] != 0)
            of_seen.push_back(fit.distance[static_cast<Index>(v)]);
    fit.unseen_vertices = static_cast<int>(count - of_seen.size());
    fit.fit_to_scan = summary_of(of_seen);

    constexpr Index most_samples = 20000; // the mean of so many is right to a percent
    const ClosestPoints tree(mesh.points, topology.faces());
    const Points samples = target.scan.points(
        Eigen::seq(0, target.scan.points.rows() - 1,
                   (target.scan.points.rows() + most_samples - 1) / most_samples),
        Eigen::all);
    std::vector<double> distances(to_size(samples.rows()));
    parallel_for(distances.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            distances[i] = tree.nearest(samples.row(static_cast<Index>(i))).distance;
    });
    fit.scan_to_fit = summary_of(distances);

    const GrowthEnergy energy = energy_of(target.levels.front(), rest);
    const VectorXd strains = energy.strains(mesh.points, mesh.growth);
    fit.strain_rms = std::sqrt(strains.squaredNorm() / static_cast<double>(strains.size()));
    fit.growth = mesh.growth.array().exp();
    const std::vector<double> growth(fit.growth.begin(), fit.growth.end());
    fit.growth_low = quantile_of(growth, 0.01);
    fit.growth_high = quantile_of(growth, 0.99);
    const VectorXd angles = dihedral_angles(topology, mesh.points);
    std::vector<char> folded(to_size(topology.face_count()), 0);
    for (int e = 0; e < topology.edge_count(); ++e)
        if (std::abs(wrapped_angle(angles[e] - dihedral_angles_at_rest[e])) > folded_angle)
            for (const int h : topology.edge_halfedges().row(e))
                if (h >= 0)
                    folded[to_size(Topology::face(h))] = 1;
    fit.folded_faces = static_cast<int>(std::count(folded.begin(), folded.end(), 1));
    fit.crossing_pairs =
        std::max(0, static_cast<int>(face_tree.crossings(mesh.points).size()) - own_crossings);
    fit.diagonal = bounding_box_diagonal(mesh.points);

    const auto marks = on_level(target.levels.front(), target.landmarks_here);
    fit.landmark_errors.resize(std::ssize(marks));
    for (std::size_t i = 0; i < marks.size(); ++i)
        fit.landmark_errors[static_cast<Index>(i)] =
            (position(marks[i], topology.faces(), mesh.points) -
             target.landmarks_there.row(static_cast<Index>(i)).transpose())
                .norm();

    set_status(target, fit);
}

void ScanFitter::State::set_status(const Target& target, ScanFit& fit) const
{
    const auto say = [&](FitStatus status, std::string reason) {
        fit.status = std::max(fit.status, status);
        fit.reasons.push_back(std::move(reason));
    };
    const auto hold = [&](double value, const Bound& bound, const std::string& reason) {
        if (value > bound.check)
            say(value > bound.failed ? FitStatus::Failed : FitStatus::Check, reason);
    };
    const double unseen = fit.unseen_vertices / static_cast<double>(fit.seen.size());
    hold(unseen, unseen_share, join(percent(unseen), " of the vertices have no counterpart"));
    const double apart = fit.scan_to_fit.mean / fit.diagonal;
    hold(apart, scan_distance, join("the scan is ", percent(apart), " of the diagonal away"));
    hold(fit.strain_rms, strain_bound, join("edges are strained by ", percent(fit.strain_rms)));
    if (fit.growth_high > growth_range * fit.growth_low)
        say(FitStatus::Check,
            join("parts grew by factors from ", fit.growth_low, " to ", fit.growth_high));
    const double odd = odd_faces * levels.front().topology.face_count();
    if (fit.crossing_pairs > odd)
        say(FitStatus::Check, join(counted(fit.crossing_pairs, "pair"), " of faces cross"));
    if (fit.folded_faces > odd)
        say(FitStatus::Check, join(counted(fit.folded_faces, "face"), " folded"));
    // A tolerance is a standard deviation.
    const double tolerated = 3.0 * target.landmark_tolerance / fit.diagonal;
    for (Index i = 0; i < fit.landmark_errors.size(); ++i) {
        const double missed = fit.landmark_errors[i] / fit.diagonal;
        const std::string& name = target.names[to_size(i)];
        hold(missed,
             {std::max(tolerated, landmark_miss.check), std::max(tolerated, landmark_miss.failed)},
             join("landmark '", name, "' is missed by ", percent(missed), " of the diagonal"));
        const double off =
            target.scan.tree.nearest(target.landmarks_there.row(i)).distance / fit.diagonal;
        if (off > std::max(tolerated, landmark_off_scan))
            say(FitStatus::Check,
                join("landmark '", name, "' lies ", percent(off), " of the diagonal off the scan"));
    }
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
    constexpr int rounds = 4;
    constexpr double weight = 3e3; // some hundred times landmark_weight
    for (int round = 0; round < rounds; ++round) {
        energy.clear_pulls(mesh.points);
        add_surface_pulls(target.scan, level.topology, mesh.points,
                          {.weight = last_weight * in_edges, .scale = last_scale * target.diagonal},
                          energy);
        add_landmark_pulls(level, marks, target, mesh.points, weight, energy);
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

void check_landmarks(const LandmarkPairs& landmarks, const std::vector<std::string>& boundaries)
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
    if (count < 3)
        return;
    for (const Points* points : {&landmarks.on_template, &landmarks.on_scan}) {
        const Points centred = points->rowwise() - points->colwise().mean();
        const Eigen::VectorXd spread = Eigen::JacobiSVD<Eigen::MatrixXd>(centred).singularValues();
        if (!(spread[1] > 1e-3 * spread[0])) // less than the error of picking them by hand
            throw InvalidInput("landmarks: they lie on a line, which leaves a turn about it open");
    }
}

} // namespace

ScanFitter::State::Target ScanFitter::State::target_of(Surface scan, const LandmarkPairs& landmarks,
                                                       double scale) const
{
    std::vector<TemplateLevel> scaled = levels;
    for (TemplateLevel& level : scaled)
        level.rest *= scale;
    return {std::move(scaled),         scale * own_diagonal,
            std::move(scan),           scale * landmarks.on_template,
            landmarks.on_scan,         landmarks.names,
            options.landmark_tolerance};
}

void ScanFitter::State::finish(const Target& target, const ShapePoint& rest, LevelMesh& mesh,
                               ScanFit& fit) const
{
    finish_landmarks(target, rest, mesh);
    judge(target, rest, mesh, fit);
    fit.points = mesh.points;
}

ScanFit ScanFitter::fit(const Scan& scan, const LandmarkPairs& landmarks) const
{
    const State& s = *state_;
    check_landmarks(landmarks, s.options.boundaries);
    const auto [faces, turned] = turned_outwards(scan, s.surface);
    Surface surface(scan.points, faces);
    std::vector<Similarity> starts{Similarity{}};
    if (landmarks.names.size() >= 3)
        starts = {landmark_start(landmarks.on_template, landmarks.on_scan)};
    else if (s.options.search_start)
        starts = rigid_starts(s.surface, surface, tried_starts);
    const double scale = starts.front().scale;
    State::Target target = s.target_of(std::move(surface), landmarks, scale);
    const auto [start, score] = s.choose_start(starts, target);
    auto [oriented, more_turned] =
        oriented_like(scan.points, faces, Surface(start(s.surface.points), s.surface.faces));
    if (more_turned > 0)
        target.scan = Surface(scan.points, std::move(oriented));

    ScanFit fit;
    fit.scale = scale;
    fit.turned_faces = std::abs(turned - more_turned);
    const std::size_t count = s.levels.size();
    LevelMesh mesh{start.motion(target.levels.back().rest),
                   VectorXd::Zero(target.levels.back().rest.rows())};
    for (std::size_t number = count; number-- > 0;) {
        if (number + 1 < count)
            mesh = carried_to_finer(target.levels[number + 1], mesh, target.levels[number]);
        s.run_level(number, target, shape_of(target.levels[number]), rounds_of(number, count),
                    mesh);
    }
    s.finish(target, shape_of(target.levels.front()), mesh, fit);
    if (score > doubtful_start) {
        fit.status = std::max(fit.status, FitStatus::Check);
        fit.reasons.emplace_back(
            "from no start did the template come near without bending much: "
            "it may lie the wrong way round; give landmarks");
    }
    return fit;
}

ScanFit ScanFitter::fit_again(const Scan& scan, const LandmarkPairs& landmarks, const ScanFit& from,
                              const ShapePoint& rest, Sliding sliding) const
{
    const State& s = *state_;
    check_landmarks(landmarks, s.options.boundaries);
    const Topology& topology = s.levels.front().topology;
    if (from.points.rows() != topology.vertex_count())
        throw InvalidInput(join("fit_again: the earlier fit has ", from.points.rows(),
                                " vertices, the template ", topology.vertex_count()));
    const auto [faces, turned] =
        oriented_like(scan.points, scan.faces, Surface(from.points, topology.faces()));
    const State::Target target = s.target_of(Surface(scan.points, faces), landmarks, from.scale);
    ScanFit fit;
    fit.scale = from.scale;
    fit.turned_faces = turned;
    LevelMesh mesh{from.points, VectorXd::Zero(from.points.rows())};
    s.run_level(0, target, rest, sliding == Sliding::Free ? free_rounds : held_rounds, mesh);
    s.finish(target, rest, mesh, fit);
    return fit;
}

} // namespace shape
