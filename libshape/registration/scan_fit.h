// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"
#include "libshape/registration/scan.h"

namespace shape {

/// Points that correspond: row i lies on the template and, by name, on the scan.
struct LandmarkPairs
{
    std::vector<std::string> names;
    Points on_template; ///< [length of the template]
    Points on_scan;     ///< [length of the scan]
};

struct FitOptions
{
    /// The weight of dihedral angles beside lengths (mu, docs/notation.md); > 0. Larger: folds and
    /// creases of the template are kept, missing parts continue more stiffly.
    double smoothness = 4.0;
    /// The weight that holds the growth factors of neighbours together; > 0. Larger: the parts of a shape
    /// grow alike.
    double growth_smoothness = 50.0;
    /// Landmarks are met to about this distance [length of the scan]; >= 0. 0: as exactly as 1e-3 of the
    /// diagonal.
    double landmark_tolerance = 0.0;
    /// Where the template starts is searched for; else it starts where it lies.
    bool search_start = true;
    /// Each is the name of a landmark at two boundary loops, that of the template and that of the scan,
    /// which correspond from end to end.
    std::vector<std::string> boundaries = {};
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const FitOptions& options);

/// Mean, 95 % quantile and largest of some distances [length of the scan].
struct DistanceSummary
{
    double mean = 0.0;
    double p95 = 0.0;
    double max = 0.0;
};

enum class FitStatus
{
    Good,
    Check,  ///< Look at it; `reasons` says why.
    Failed, ///< It is not a fit.
};

/// A landmark that the others and the surface do not bear out.
struct DoubtedLandmark
{
    std::string name;
    double off = 0.0; ///< From where it is without it to where it was put [length of the scan].
};

struct ScanFit
{
    Points points; ///< #V by 3: the template's vertices on the scan, in its frame and unit.
    Eigen::VectorXd growth;   ///< #V factors > 0 by which the template, in the scan's unit, grew.
    Eigen::VectorXd distance; ///< #V, to the scan [length of the scan].
    std::vector<char>
        seen; ///< #V: whether the scan has a counterpart; else the prior alone speaks.

    double scale = 1.0;              ///< 1, or a change of unit.
    DistanceSummary fit_to_scan;     ///< Of vertices that have a counterpart.
    DistanceSummary scan_to_fit;     ///< Of at most 20,000 vertices of the scan.
    Eigen::VectorXd landmark_errors; ///< One per landmark [length of the scan].
    double diagonal = 0.0;           ///< Of the bounding box of the fit [length of the scan].
    double strain_rms = 0.0;         ///< Of edges, relative, growth taken off.
    double growth_low = 1.0;         ///< 1 % quantile of growth.
    double growth_high = 1.0;        ///< 99 % quantile.
    int folded_faces =
        0; ///< With an edge that bends by > 120 degrees more or less than the template's.
    int crossing_pairs = 0; ///< Of faces that pass through each other, beyond the template's own.
    int unseen_vertices = 0;
    double unclaimed_share = 0.0; ///< Of the scan's surface: without counterpart in the fit, the
                                  ///< template's end not being the nearest.
    int contested_vertices = 0;   ///< Another part of the template lies in the same place.
    int turned_faces = 0;         ///< Of the scan: they faced inwards.
    FitStatus status = FitStatus::Good;
    std::vector<std::string> reasons; ///< Why it is not Good.
    std::string start_doubt; ///< The one of them that says that it may lie the wrong way round.
    /// Each is one of them: it may be in the wrong place, on the scan or on the template.
    std::vector<DoubtedLandmark> doubted_landmarks;
};

/// How far vertices move along the surface when a scan is fitted again.
enum class Sliding
{
    /// Little. For what a group of fits expects of one of them: it does not know how all of them slid
    /// alike, and what moves freely drifts.
    Held,
    /// As far as the expected lengths ask, at softer pulls. For what a model of known correspondences
    /// expects.
    Free,
};

/// Fits a template to scans: non-rigid registration by the energy that turns lengths and dihedral angles
/// into meshes, with one growth factor per vertex, coarse to fine (docs/correspondence.md).
class ScanFitter
{
public:
    /// @throws InvalidInput if an option breaks its rule, or the template has degenerate geometry.
    /// Cost: O(#V log #V).
    ScanFitter(const Topology& topology, const Points& points, const FitOptions& options = {});
    ~ScanFitter();
    ScanFitter(ScanFitter&&) noexcept;
    ScanFitter& operator=(ScanFitter&&) noexcept;

    /// @param landmarks  None, or >= 1; with >= 3 they give the start.
    /// @throws InvalidInput if there are three or more landmarks on a line, some but not all lie more than 20 diagonals off,
    ///     those of the template lie on it in another unit alone (1,000 times as large, ...), tables differ in size, or options.boundaries
    ///     names a landmark that is missing, or is not empty where the template or the scan has no boundary.
    /// A scan that the template does not fit throws nothing: see ScanFit::status. Times some factor, a scan and its
    /// landmarks have the same fit but for that factor and rounding, unless the scan is a part of a shape, say, whose size
    /// tells less than its unit (docs/correspondence.md); a change of unit changes no fit.
    /// Cost: about 3 s for 13,000 vertices. Same bits for any number of threads. Safe to call concurrently.
    [[nodiscard]] ScanFit fit(const Scan& scan, const LandmarkPairs& landmarks = {}) const;

    /// Fits again from an earlier fit of the same scan, by the finest level alone, with other lengths and
    /// angles in place of the template's: what a model expects of it (shape_prior.h).
    /// @param rest  #E lengths > 0 [length of the scan] and #E angles.
    /// @throws InvalidInput as fit(), or if `from` or `rest` is of another triangulation.
    /// Cost: about half of fit(); if it slides freely, as fit().
    [[nodiscard]] ScanFit fit_again(const Scan& scan, const LandmarkPairs& landmarks,
                                    const ScanFit& from, const ShapePoint& rest,
                                    Sliding sliding = Sliding::Held) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace shape
