// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

namespace shape {

/// What a discrete conformal map is worth.
enum class ConformalCertificate
{
    Exact,    ///< Eq. (13) holds on every edge and no face is reversed.
    Folded,   ///< Eq. (13) holds on every edge, but some faces are reversed.
    Repaired, ///< Eq. (13) holds on all edges but those that had to be flipped.
    Refined,  ///< The same, and local repair did not do: every edge was allowed to flip, and the
              ///< triangulation is the Delaunay triangulation of the result.
    Unsolved, ///< No map was found: a face stays broken, or a residual exceeds 1e-9.
};

/// "exact", "folded", "repaired", "refined" or "unsolved".
[[nodiscard]] const char* name(ConformalCertificate certificate);

/// How well eq. (13) of Rojas 2014, b_ij = exp((u_i + u_j) / 2) a_ij, holds on the edges of a mesh.
struct ConformalEdges
{
    Eigen::VectorXd
        residuals;            ///< #E, log(b_ij / a_ij) - (u_i + u_j) / 2, b measured on the result.
    std::vector<int> flipped; ///< Edges that the triangulation of the result lacks. Ascending.
    double worst = 0.0;       ///< max |residuals| over the edges that are not flipped.
};

} // namespace shape
