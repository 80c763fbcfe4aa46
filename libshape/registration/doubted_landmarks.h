// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "libshape/registration/scan_fit.h"
#include "libshape/registration/template_levels.h"

namespace shape::internal {

/// What a few rounds of the coarsest level make of a template.
struct CoarseTrial
{
    LevelMesh mesh;
    Eigen::VectorXd bent; ///< #E: squares of strains and of bends [rad^2].
    double score = 0.0;   ///< How much that bends and how far it is from the scan; 0 is best.
};

/// A trial that starts from some landmarks and is held by them.
using LandmarkTrial = std::function<CoarseTrial(const LandmarkPairs&)>;

/// Landmarks that the surface and the other landmarks do not bear out: left out, the template bends less and comes as
/// near, and the landmark's place on it comes out elsewhere. A pair that was put in the wrong place on the scan or on the template
/// looks alike; a limb that a pose has moved far does not, as without its landmark the template does not come near.
///
/// Only where the template is bent much around a landmark is it left out, the worst two first; if that explains it, others are
/// looked for among those that are left, and none is named if they explain no fit.
/// @param level  The coarsest one, in the template's size.
/// @param bent  CoarseTrial::bent of the fit on that level.
/// @param near  What lies nearer to its place is not doubted [length of the scan].
/// @return In the order in which they were found; none of fewer than four. More than half of them are never named.
/// Cost: one trial and two more for each landmark named, if any is bent around much.
[[nodiscard]] std::vector<DoubtedLandmark> doubted_landmarks(const TemplateLevel& level,
                                                             const LandmarkPairs& landmarks,
                                                             const Eigen::VectorXd& bent,
                                                             double near,
                                                             const LandmarkTrial& try_with);

/// Those of two or three landmarks that stand beside each other's names: with two rows of the scan exchanged, or three
/// in a circle, the trial's score is far better. (Four and more: mistaken_landmarks().) Asked only where the template is bent
/// much around one of them, or does not come near.
/// @param level  The coarsest one, in the template's size.
/// @param as_given  The trial of the landmarks as they are.
/// @param try_with  As above, but of two landmarks too.
/// @return Their names; none if they are all right as they are.
/// Cost: none, or a trial of two landmarks, five of three.
[[nodiscard]] std::vector<std::string> exchanged_landmarks(const TemplateLevel& level,
                                                           const LandmarkPairs& landmarks,
                                                           const CoarseTrial& as_given,
                                                           const LandmarkTrial& try_with);

} // namespace shape::internal
