// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "libshape/mesh/face_crossings.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"
#include "libshape/registration/scan_fit.h"
#include "libshape/registration/scan_surface.h"
#include "libshape/registration/template_levels.h"

namespace shape::internal {

/// What a landmark placed by hand is off by, over the diagonal.
inline constexpr double hand_placed = 0.003;
/// What is farther from a surface than this is not on it, over the diagonal. Set by hand: three times hand_placed.
inline constexpr double landmark_off = 0.01;

/// The template's own figures, which those of its fits are held against.
struct TemplateFigures
{
    Points points;
    Eigen::VectorXd dihedral_angles; ///< #E [rad].
    FaceTree face_tree;
    int crossings; ///< Pairs of its faces that pass through each other.

    TemplateFigures(const Topology& topology, const Points& at_rest);
};

/// A finished fit and what it was made to meet. Lengths are [length of the scan].
struct FitEvidence
{
    const Topology& topology;       ///< Of the template.
    const LevelMesh& mesh;          ///< The fit.
    const Eigen::VectorXd& strains; ///< #E, relative, growth taken off: GrowthEnergy::strains().
    const Surface& scan;
    double diagonal;     ///< Of the template's bounding box, at the size that it started with.
    double start_growth; ///< By which that is larger than its own size in the scan's unit.
    const LandmarkPairs& landmarks;
    const Eigen::VectorXd&
        off_template;          ///< Of each, distance from the template, over its diagonal.
    const Points& reached;     ///< Where each is on the fit.
    double landmark_tolerance; ///< Standard deviation.
};

/// Reasons why a start may be a wrong one: from none did the template come near without bending much; turned by an angle
/// [rad] it fits nearly as well.
[[nodiscard]] std::string doubt_of_bent_start();
[[nodiscard]] std::string doubt_of_rival_start(double turn);
/// Landmarks of these names, two or three, stand beside each other's names.
[[nodiscard]] std::string doubt_of_names(const std::vector<std::string>& exchanged);

/// Whether a reason is one of these.
[[nodiscard]] bool is_start_doubt(std::string_view reason);

/// The reason that a landmark gives.
/// @param diagonal  Of the fit [length of the scan].
[[nodiscard]] std::string doubt_of_landmark(const DoubtedLandmark& landmark, double diagonal);

/// Fills what ScanFit reports beside points, scale, start_doubt and turned_faces: a figure for all that can go wrong, and
/// from those its status, the worst that any calls for, with a reason for each.
///
/// A vertex is seen if a point of the scan lies within a hundredth of the diagonal of it, its normal no more than
/// 90 degrees from the vertex's, and that point is not on the scan's rim farther than hand_placed. The scan's surface
/// has a counterpart if it is as near to the fit, or within what its noise explains, or nearest to the template's end. Each figure has a
/// bound above which the fit is to be looked at and, most of them, one above which it is Failed; they stand in
/// fit_verdict.cpp, and docs/correspondence.md says what sound fits have.
/// Cost: O(#V log #V), and as much for at most 20,000 vertices of the scan. Same bits for any number of threads.
void judge(const FitEvidence& evidence, const TemplateFigures& own, ScanFit& fit);

} // namespace shape::internal
