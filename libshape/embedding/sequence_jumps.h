// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// How far a frame of a sequence is from the one before it, whatever their positions and
/// orientations.
struct SequenceStep
{
    double displacement =
        0.0;              ///< Largest distance between the positions of a vertex after the best
                          ///< rigid motion / bounding box diagonal of the first of the two [1].
    double bending = 0.0; ///< RMS change of the dihedral angles, wrapped, each edge weighted by
                          ///< the area of its faces in the first of the two [rad].
};

/// Each of the two catches what the other may miss: a limb that swings aside, a fold that turns over.
/// @throws InvalidInput if the points do not fit the topology.
[[nodiscard]] SequenceStep measure_step(const Topology& topology, const Points& before,
                                        const Points& after);

/// Two neighbouring frames that are much further apart than those around them.
struct SequenceJump
{
    std::size_t from = 0; ///< Index of the first of the two frames.
    double ratio = 0.0;   ///< Step / max(median of the steps nearby, least step).
};

struct JumpOptions
{
    /// A step is a jump where it exceeds this times the median of those nearby; > 0.
    double ratio = 5.0;
    /// This many steps on either side are nearby; > 0.
    std::size_t reach = 4;
    /// Displacements below this count as this [1]; > 0.
    double least_displacement = 2e-4;
    /// Bendings below this count as this [rad] (0.02 deg); > 0.
    double least_bending = 4e-4;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const JumpOptions& options);

/// Finds the steps s_k, from frame k to frame k + 1, with
///
///     s_k > ratio * max(median {s_j : 0 < |j - k| <= reach}, least step)
///
/// for the displacement or the bending. Where fewer than two steps are nearby, none stands out. The
/// median passes over single jumps nearby: a frame that is wrong alone gives two.
/// @throws InvalidInput if an option is out of its range.
[[nodiscard]] std::vector<SequenceJump> find_jumps(const std::vector<SequenceStep>& steps,
                                                   const JumpOptions& options = {});

} // namespace shape
