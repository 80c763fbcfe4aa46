// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/mesh/face_crossings.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

struct ContactGapOptions
{
    /// The surface around a face are the faces within this many rings; >= 0.
    int rings = 2;
    /// Surfaces are to be apart by this part of the edges around [1]; >= 0.
    double margin = 0.1;
    /// A gap asks for at most this part of the edges around more than there is [1]; > 0: what is far behind comes
    /// out step by step.
    double step = 0.06;
    /// Places farther behind a surface than this many of the edges around are left alone [1]; > 0. They lie behind
    /// something else.
    double deepest = 3.0;
    /// How firmly gaps are held: Gap::stiffness is this over the square of the edges around [1]; >= 0.
    double stiffness = 3.0;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const ContactGapOptions& options);

/// Gaps that keep the surfaces around pairs of faces apart, or bring them so if they cross: from every
/// vertex and every middle of an edge around one face of a pair to the nearest point of the surface
/// around the other, along the normal there.
///
/// Surfaces meet with their outsides (outwardness()), as solid bodies do. So of an edge that crosses a face the end
/// behind it is through, and with it what hangs together with this end by edges that cross nothing
/// (Baraff, Witkin, Kass 2003: global intersection analysis). Of other places it is only seen to that
/// they come no nearer than the margin: that they lie behind the plane of the nearest face says nothing about them.
/// Places whose own normals point where those of the other surface do, such as the far side of a thin
/// part, have no gap.
/// @param points  #V by 3, row by row in one vector [length].
/// @param pairs  Those that cross, and others to be kept from it.
/// @throws InvalidInput if an option breaks its rule.
/// Cost: O(#F), and about the number of pairs times the squared number of faces around one.
/// Same bits for any number of threads.
[[nodiscard]] std::vector<LengthDihedralEnergy::Gap> contact_gaps(
    const Topology& topology, const Eigen::VectorXd& points, const std::vector<FacePair>& pairs,
    const ContactGapOptions& options = {});

} // namespace shape::internal
