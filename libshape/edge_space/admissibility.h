// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libshape/edge_space/length_coordinates.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// A face whose longest edge is not shorter than the two others together.
struct TriangleViolation
{
    int face = -1;
    double excess = 0.0; ///< longest / (sum of the others) - 1  [1], >= 0; infinite if sum <= 0.
};

/// An interior vertex whose face angles close to no spherical polygon: one angle exceeds the sum
/// of the others (Rojas 2014, section 4).
struct VertexViolation
{
    int vertex = -1;
    double excess = 0.0; ///< largest angle - sum of the others [rad], > 1e-12 (rounding).
};

/// What keeps a length vector from being that of a mesh. Necessary conditions: a vector that
/// passes may still have no embedding.
struct Admissibility
{
    std::vector<TriangleViolation> triangles; ///< Worst first.
    std::vector<VertexViolation> vertices;    ///< Worst first; none of a broken triangle.

    [[nodiscard]] bool admissible() const { return triangles.empty() && vertices.empty(); }
};

/// Checks every triangle inequality (strict) and every spherical-polygon inequality. A link on the
/// unit sphere also needs no side longer than pi, which face angles never exceed; sums beyond 2 pi
/// are fine, the link may wind.
/// @param lengths  #E [length], finite.
/// @throws InvalidInput if lengths has another size or an entry that is not finite.
[[nodiscard]] Admissibility check_admissibility(const Topology& topology,
                                                const Eigen::VectorXd& lengths);

/// The lengths with those <= 0 raised to a hundredth of the mean, others to 1e-9 of it: what to aim at
/// where a point of a model has left the lengths behind. Such a point breaks triangle inequalities; this is not a repair.
/// @throws InvalidInput if an entry is not finite, or the mean not > 0.
[[nodiscard]] Eigen::VectorXd positive_lengths(const Eigen::VectorXd& lengths);

/// One sentence about the worst violations; empty if admissible.
[[nodiscard]] std::string describe(const Admissibility& admissibility, const Topology& topology,
                                   const Eigen::VectorXd& lengths);

/// The largest step t in [0, limit] such that the lengths f^-1(values + s * direction) keep every
/// triangle inequality for all s in [0, t); limit if none breaks before. Exact to rounding: roots of
/// linear, quadratic (squared) or convex (log) functions.
/// @param values  #E, f of lengths that keep every inequality themselves, otherwise 0 is returned.
/// @param direction  #E.
/// @throws InvalidInput if one has another size or an entry that is not finite.
[[nodiscard]] double feasible_step(const Topology& topology, const Eigen::VectorXd& values,
                                   const Eigen::VectorXd& direction, double limit,
                                   LengthCoordinates coordinates = LengthCoordinates::Plain);

} // namespace shape
