// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

#include "libshape/mesh/collection.h"

namespace shape {

/// A mesh that is far from all others.
struct OutlyingMesh
{
    std::size_t mesh = 0;
    /// Distance of its shape vector (unit sum) to the nearest other one that is not a copy of it [1].
    double distance = 0.0;
    /// The mean over the edges at a vertex of abs(log(l / l')), l' the nearest length of the edge in any other mesh (unit
    /// sums), less the median of that mean over its neighbours, or half of it if that is more; the largest [1].
    double length_gap = 0.0;
    /// Largest shift (vertex_shifts.h) of a vertex beyond three times the median over the meshes there, of those with other
    /// lengths; 0 if none of them is beyond the bound [1].
    double shift = 0.0;
    double region_shift =
        0.0; ///< The same among the vertices six edges away, whatever their lengths [1].
    /// How far a vertex stands out: the largest sqrt(h g), h the change of its height (vertex_shifts.h) beyond the median of
    /// that of its neighbours and three times the median over the meshes, g the mean over its edges that length_gap has [1].
    double spike = 0.0;
    int vertex = -1;     ///< Where the gap is that makes it one; -1 if only its distance does.
    std::string message; ///< A sentence with the figures and the likely causes.
};

/// Finds meshes that are far from all others, as those with exchanged vertices or landmarks are, or
/// those of which the registration failed. Groups of meshes near to one another are not outliers.
///
/// A mesh is one if, with the median m of a figure over all meshes and 1.4826 times the median
/// deviation d from it,
/// - distance > max(3 m, m + 8 d), and either distance > (4 + (4 + 50 / n) / p^2) s or off > (2 + 12 / n) s, or
/// - length_gap > max(0.6, 2.5 m, m + 5 d), or
/// - shift > max(0.9, 2 m, m + 5 d), m and d of vertices with any lengths, or
/// - region_shift > max(0.8, 4 m, m + 8 d), asked at 1,500 vertices at the most, or
/// - spike > max(0.5, 3 m, m + 8 d).
/// A vertex has other lengths where abs(log(l / l')), l' the median length of the edge, exceeds three times the median over the
/// meshes of that by 0.05 and more, in the mean over its edges.
/// The shifts are against most of the meshes, so that two with the same slip are found as well; they hardly change where a
/// joint bends further than any other, nor do lengths in one place alone. Of subsets of 5 to 20 poses and people of the
/// real collections 1 % have one that is named (of the faces 2.5 %), exchanged neighbours are found in 50 (vertebrae) to 90 %,
/// a vertex moved by two edges in any direction in 80 (vertebrae) to 98 %, exchanged vertices farther apart, in two meshes
/// too, in 95 % and more.
/// Of the n meshes that are within the first bound, s is the median distance from their mean,
/// p = (sum of variances)^2 / sum of squared variances the number of dimensions that they spread over, and `off` the distance
/// of the mesh from the directions that they vary in: in one or two of
/// them the last mesh is often ten times as far from the next one as others are, and sound. Of 5 to 30 meshes that vary
/// normally or lognormally (0.5) in one, two or three directions alone, 0 to 3 % of the collections name one.
/// The bounds are set by real collections (faces, hands, bodies, vertebrae) and copies of them with
/// two vertices exchanged. Of more than 1,000 meshes, m and d of the distance are those of 1,000 of them, spread
/// evenly, and so are s and p.
///
/// @return Ascending; none of fewer than five meshes.
/// Cost: O(min(N, 1000) N #E + N #E log N), and O(N #E) more for each mesh that is far from all of those 1,000.
[[nodiscard]] std::vector<OutlyingMesh> find_outlying_meshes(const Collection& collection);

} // namespace shape
