// SPDX-License-Identifier: MIT

#pragma once

#include <functional>
#include <vector>

#include "libshape/embedding/contact/contact_gaps.h"
#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/linalg/single_precision_solve.h"
#include "libshape/mesh/face_crossings.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

struct ContactSeparationOptions
{
    /// Angles weigh this much against lengths: mu of length_dihedral_energy.h; > 0.
    double smoothness = usual_smoothness;
    /// Which gaps are asked for in the first round.
    ContactGapOptions gaps = {};
    /// It gives up after this many rounds; >= 0.
    int rounds = 20;
    /// Once no pair is left, this many rounds more take back what was moved too far; >= 0.
    int refinements = 3;
    /// Each round takes this many linear steps (descent.h); >= 2.
    int linear_steps = 24;
    /// Gaps are stiffer by this factor from round to round; >= 1.
    double growth = 1.15;
    /// No edge may become longer or shorter by more than this part of itself [1]; > 0. Where faces are
    /// through over a large part, the last ones of them would cost single edges a fifth of their length.
    double stretch = 0.1;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const ContactSeparationOptions& options);

struct ContactSeparation
{
    Points points; ///< #V by 3 [length].
    int pairs = 0; ///< That still cross and are not allowed to.
};

/// Bends a mesh so that pairs of faces no longer cross, as little as can be: by E of
/// length_dihedral_energy.h whose wanted lengths and angles are the mesh's own, so that it is at its
/// minimum where nothing crosses. In every round the gaps (contact_gaps()) of all pairs that have crossed so far are found
/// anew, and E descends with them. Of all rounds that mesh is taken that has the fewest pairs, and of these
/// the least E; one with more crossings in all than at the start is not, nor one with a stretched edge, nor one
/// that is not acceptable.
/// @param faces  Of the topology.
/// @param allowed  Pairs that may cross, sorted.
/// @param factor  Of the Laplacian weighted by 1 / l^2 (edge_laplacian.h).
/// @return The points as they were if in no round at least half of the pairs are gone.
/// @throws InvalidInput if an option breaks its rule; NumericalError if E is not finite.
/// Same bits for any number of threads.
[[nodiscard]] ContactSeparation separate_contacts(
    const Topology& topology, const FaceTree& faces, const std::vector<FacePair>& allowed,
    const SinglePrecisionSolve& factor, const Points& points,
    const std::function<bool(const Points&)>& is_acceptable,
    const ContactSeparationOptions& options = {});

} // namespace shape::internal
