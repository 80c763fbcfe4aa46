// SPDX-License-Identifier: MIT

#include "libshape/registration/fit_verdict.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "libshape/base/counted.h"
#include "libshape/base/format.h"
#include "libshape/base/order_statistics.h"
#include "libshape/base/percent.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/vertex_normals.h"
#include "libshape/registration/closest_points.h"
#include "libshape/registration/landmark_checks.h"
#include "libshape/registration/landmark_units.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double counterpart_within = 0.01; // over the diagonal; a finished fit lies nearer by far

/// Of the distance that 90 % of the scan keep, which is its noise (1.6 standard deviations): a counterpart in the fit may be so
/// far. Set by hand.
constexpr double noise_quantile = 0.9, noise_reach = 3.0;
constexpr double noise_within = 0.03; // over the diagonal; beyond it is no noise

/// What a report's figures may be before a person should look, and before the fit is not one: set by hand, well above
/// those of sound fits of faces, bodies and arms (docs/correspondence.md).
struct Bound
{
    double check, failed;
};
constexpr Bound unseen_share{0.15, 0.8}; // of the vertices; half a face leaves half of them
/// Of the scan's surface, beyond what lies past the template's own end. Right fits leave 0.8 % at most, hands with a finger in
/// another one's place 1.4 % and more (docs/experiments/correspondence.md). A scan may hold more than the template, so this alone fails none.
constexpr double unclaimed_bound = 0.01;
/// Of the vertices: another part of the template claims their place too, say a finger that of its neighbour. None do so in
/// right fits, 0.6 % and more where parts lie in each other's place (docs/experiments/correspondence.md).
constexpr double contested_bound = 0.003;
constexpr double another_part = 0.1; // so far from each other at rest, over the diagonal
/// Normals of a vertex and of its place enclose at most some 70 degrees, as while it was pulled: the far sides of thin parts are
/// no rivals.
constexpr double same_side = 0.3;
constexpr Bound scan_distance{0.005, 0.02}; // mean, over the diagonal
constexpr Bound strain_bound{0.15, 0.25};   // RMS
constexpr Bound landmark_miss{0.002, 0.03}; // over the diagonal
constexpr double growth_range = 3.0; // between parts of one shape, which no person's differ by
constexpr double odd_faces = 0.02;   // share that may cross or fold
constexpr double folded_angle = 120.0 * std::numbers::pi / 180.0; // no pose bends an edge so far

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

/// Which vertices have a counterpart, and how far all of them and those are from the scan.
void measure_fit_to_scan(const FitEvidence& evidence, ScanFit& fit)
{
    const Points& points = evidence.mesh.points;
    const Surface& scan = evidence.scan;
    const Points normals = vertex_normals(points, evidence.topology.faces());
    const double near = counterpart_within * evidence.diagonal;
    const auto count = to_size(points.rows());
    fit.distance.resize(points.rows());
    fit.seen.assign(count, 0);
    parallel_for(count, 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const auto row = static_cast<Index>(v);
            const SurfacePoint any = scan.tree.nearest(points.row(row));
            fit.distance[row] = any.distance;
            NearestRule rule;
            rule.normal = normals.row(row);
            rule.least_cosine = 0.0;
            rule.within = near;
            const SurfacePoint pair = scan.tree.nearest(points.row(row), rule);
            // At a rim, what lies a little beyond it is not seen; a template's own rim may lie on it.
            const bool is_end = pair.face >= 0 && scan.ends_at(pair) &&
                                pair.distance > hand_placed * evidence.diagonal;
            fit.seen[v] = pair.face >= 0 && !is_end ? 1 : 0;
        }
    });
    std::vector<double> of_seen;
    for (std::size_t v = 0; v < count; ++v)
        if (fit.seen[v] != 0)
            of_seen.push_back(fit.distance[static_cast<Index>(v)]);
    fit.unseen_vertices = static_cast<int>(count - of_seen.size());
    fit.fit_to_scan = summary_of(of_seen);
}

/// Of the faces at every vertex [length^2].
VectorXd areas_at_vertices(const Surface& surface)
{
    VectorXd areas = VectorXd::Zero(surface.points.rows());
    for (const auto& face : surface.faces.rowwise()) {
        const Vector3d a = surface.points.row(face[0]);
        const Vector3d b = surface.points.row(face[1]), c = surface.points.row(face[2]);
        const double area = (b - a).cross(c - a).norm();
        for (const int v : face)
            areas[v] += area;
    }
    return areas;
}

/// Whether a nearest point of the fit lies where the template ends.
bool is_at_end(const SurfacePoint& point, const Topology& topology)
{
    if (point.barycentric.minCoeff() > 1e-9)
        return false;
    for (int k = 0; k < 3; ++k)
        if (point.barycentric[k] > 0.0 &&
            topology.is_boundary_vertex(topology.faces()(point.face, k)))
            return true;
    return false;
}

/// How many vertices lie at places of the scan from which the way back leads to another part of the template.
int contested_vertices(const FitEvidence& evidence, const TemplateFigures& own,
                       const ClosestPoints& fit_tree)
{
    const Points& points = evidence.mesh.points;
    const Surface& scan = evidence.scan;
    const Faces& faces = evidence.topology.faces();
    const Points normals = vertex_normals(points, faces);
    const double far = another_part * bounding_box_diagonal(own.points);
    std::vector<char> contested(to_size(points.rows()), 0);
    parallel_for(contested.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const auto row = static_cast<Index>(v);
            NearestRule rule;
            rule.least_cosine = same_side;
            rule.within = counterpart_within * evidence.diagonal;
            rule.normal = normals.row(row);
            const SurfacePoint place = scan.tree.nearest(points.row(row), rule);
            if (place.face < 0)
                continue;
            rule.normal = scan.normal_at(place);
            const SurfacePoint back = fit_tree.nearest(place.position, rule);
            if (back.face < 0)
                continue;
            Vector3d at_rest = Vector3d::Zero();
            for (int k = 0; k < 3; ++k)
                at_rest += back.barycentric[k] * own.points.row(faces(back.face, k)).transpose();
            contested[v] = (at_rest - own.points.row(row).transpose()).norm() > far ? 1 : 0;
        }
    });
    return static_cast<int>(std::count(contested.begin(), contested.end(), 1));
}

/// How far the scan is from the fit, and how much of it has no counterpart there.
void measure_scan_to_fit(const FitEvidence& evidence, const ClosestPoints& fit_tree, ScanFit& fit)
{
    constexpr Index most_samples = 20000; // the mean of so many is right to a percent
    const Surface& scan = evidence.scan;
    const Index stride = (scan.points.rows() + most_samples - 1) / most_samples;
    std::vector<SurfacePoint> nearest(to_size((scan.points.rows() + stride - 1) / stride));
    std::vector<double> distances(nearest.size());
    parallel_for(nearest.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            nearest[i] = fit_tree.nearest(scan.points.row(static_cast<Index>(i) * stride));
            distances[i] = nearest[i].distance;
        }
    });
    fit.scan_to_fit = summary_of(distances);

    // Not by normals: those of a noisy scan point anywhere, and what a wrong fit leaves out is far from all of it.
    const double near =
        std::clamp(noise_reach * quantile_of(distances, noise_quantile),
                   counterpart_within * evidence.diagonal, noise_within * evidence.diagonal);
    const VectorXd areas = areas_at_vertices(scan);
    double sum = 0.0, of_unclaimed = 0.0;
    for (std::size_t i = 0; i < distances.size(); ++i) {
        const double area = areas[static_cast<Index>(i) * stride];
        sum += area;
        if (distances[i] > near && !is_at_end(nearest[i], evidence.topology))
            of_unclaimed += area;
    }
    fit.unclaimed_share = sum > 0.0 ? of_unclaimed / sum : 0.0;
}

/// Faces with an edge that bends much more or less than the template's.
int folded_faces(const FitEvidence& evidence, const TemplateFigures& own)
{
    const Topology& topology = evidence.topology;
    const VectorXd angles = dihedral_angles(topology, evidence.mesh.points);
    std::vector<char> folded(to_size(topology.face_count()), 0);
    for (int e = 0; e < topology.edge_count(); ++e)
        if (std::abs(wrapped_angle(angles[e] - own.dihedral_angles[e])) > folded_angle)
            for (const int h : topology.edge_halfedges().row(e))
                if (h >= 0)
                    folded[to_size(Topology::face(h))] = 1;
    return static_cast<int>(std::count(folded.begin(), folded.end(), 1));
}

/// Strains, growth, folds and crossings: how the template was bent.
void measure_shape(const FitEvidence& evidence, const TemplateFigures& own, ScanFit& fit)
{
    const LevelMesh& mesh = evidence.mesh;
    const VectorXd& strains = evidence.strains;
    fit.strain_rms = std::sqrt(strains.squaredNorm() / static_cast<double>(strains.size()));
    fit.growth = evidence.start_growth * mesh.growth.array().exp();
    const std::vector<double> growth(fit.growth.begin(), fit.growth.end());
    fit.growth_low = quantile_of(growth, 0.01);
    fit.growth_high = quantile_of(growth, 0.99);
    fit.folded_faces = folded_faces(evidence, own);
    fit.crossing_pairs =
        std::max(0, static_cast<int>(own.face_tree.crossings(mesh.points).size()) - own.crossings);
    fit.diagonal = bounding_box_diagonal(mesh.points);
}

VectorXd landmark_errors(const FitEvidence& evidence)
{
    VectorXd errors(evidence.reached.rows());
    for (Index i = 0; i < errors.size(); ++i) {
        const Vector3d reached = evidence.reached.row(i);
        errors[i] = (reached - evidence.landmarks.on_scan.row(i).transpose()).norm();
    }
    return errors;
}

/// The worst status that any figure calls for, and why.
void set_status(const FitEvidence& evidence, ScanFit& fit)
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
    if (fit.unclaimed_share > unclaimed_bound)
        say(FitStatus::Check, join(percent(fit.unclaimed_share),
                                   " of the scan's surface has no counterpart in the fit"));
    const double contested = fit.contested_vertices / static_cast<double>(fit.seen.size());
    if (contested > contested_bound)
        say(FitStatus::Check, join(percent(contested),
                                   " of the vertices lie where another part of the template does"));
    const double apart = fit.scan_to_fit.mean / fit.diagonal;
    hold(apart, scan_distance, join("the scan is ", percent(apart), " of the diagonal away"));
    hold(fit.strain_rms, strain_bound, join("edges are strained by ", percent(fit.strain_rms)));
    if (fit.growth_high > growth_range * fit.growth_low)
        say(FitStatus::Check,
            join("parts grew by factors from ", fit.growth_low, " to ", fit.growth_high));
    const double odd = odd_faces * evidence.topology.face_count();
    if (fit.crossing_pairs > odd)
        say(FitStatus::Check, join(counted(fit.crossing_pairs, "pair"), " of faces cross"));
    if (fit.folded_faces > odd)
        say(FitStatus::Check, join(counted(fit.folded_faces, "face"), " folded"));
    // A tolerance is a standard deviation.
    const double tolerated = 3.0 * evidence.landmark_tolerance / fit.diagonal;
    // A fit to landmarks that are wrong has a size of its own: the scan's counts.
    const LandmarkPairs& landmarks = evidence.landmarks;
    const double scan_diagonal = bounding_box_diagonal(evidence.scan.points);
    const double near = std::max(3.0 * evidence.landmark_tolerance, landmark_off * scan_diagonal);
    const std::optional<std::string> other_unit =
        other_unit_of(landmarks.on_scan, evidence.scan, near, "the scan");
    if (other_unit)
        say(FitStatus::Check, *other_unit);
    if (const auto said =
            mistaken_landmarks(landmarks.names, landmarks.on_template, landmarks.on_scan))
        say(FitStatus::Check, *said);
    for (Index i = 0; i < fit.landmark_errors.size(); ++i) {
        const double missed = fit.landmark_errors[i] / fit.diagonal;
        const std::string& name = landmarks.names[to_size(i)];
        hold(missed,
             {std::max(tolerated, landmark_miss.check), std::max(tolerated, landmark_miss.failed)},
             join("landmark '", name, "' is missed by ", percent(missed), " of the diagonal"));
        const double off = evidence.scan.tree.nearest(landmarks.on_scan.row(i)).distance;
        if (!other_unit && off > near)
            say(FitStatus::Check, join("landmark '", name, "' lies ", percent(off / scan_diagonal),
                                       " of the diagonal off the scan"));
        if (evidence.off_template[i] > near / scan_diagonal)
            say(FitStatus::Check,
                join("landmark '", name, "' lies ", percent(evidence.off_template[i]),
                     " of the diagonal off the template"));
    }
}

constexpr std::string_view in_doubt = "it may lie the wrong way round: ";

} // namespace

std::string doubt_of_bent_start()
{
    return join(in_doubt,
                "from no start did the template come near without bending much; give landmarks");
}

std::string doubt_of_rival_start(double turn)
{
    return join(in_doubt, "turned by ", std::round(turn * 180.0 / std::numbers::pi),
                " degrees it fits nearly as well; give landmarks, or start where it lies if that "
                "is right");
}

std::string doubt_of_names(const std::vector<std::string>& exchanged)
{
    std::string names;
    for (std::size_t i = 0; i < exchanged.size(); ++i)
        names += join(i == 0                     ? ""
                      : i + 1 < exchanged.size() ? ", "
                                                 : " and ",
                      "'", exchanged[i], "'");
    return join(in_doubt, "landmarks ", names,
                " look exchanged; with other names among them it bends far less, or comes nearer");
}

std::string doubt_of_landmark(const DoubtedLandmark& landmark, double diagonal)
{
    return join("landmark '", landmark.name,
                "' may be in the wrong place, on the scan or on the template: left out, the "
                "template bends less, "
                "and its place comes out ",
                percent(landmark.off / diagonal), " of the diagonal away");
}

bool is_start_doubt(std::string_view reason)
{
    return reason.starts_with(in_doubt);
}

TemplateFigures::TemplateFigures(const Topology& topology, const Points& at_rest)
    : points(at_rest),
      dihedral_angles(shape::dihedral_angles(topology, at_rest)),
      face_tree(topology, at_rest),
      crossings(static_cast<int>(face_tree.crossings(at_rest).size()))
{
}

void judge(const FitEvidence& evidence, const TemplateFigures& own, ScanFit& fit)
{
    measure_fit_to_scan(evidence, fit);
    const ClosestPoints fit_tree(evidence.mesh.points, evidence.topology.faces());
    measure_scan_to_fit(evidence, fit_tree, fit);
    fit.contested_vertices = contested_vertices(evidence, own, fit_tree);
    measure_shape(evidence, own, fit);
    fit.landmark_errors = landmark_errors(evidence);
    set_status(evidence, fit);
}

} // namespace shape::internal
