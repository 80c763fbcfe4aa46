// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

#include "libshape/mesh/collection.h"

namespace shape {

/// What a collection may have that is not a defect of any mesh and is seldom meant.
enum class OddityKind
{
    Seam,      ///< Boundary vertices lie on one another in all meshes (coincident_vertices()).
    Mirrored,  ///< Some meshes are mirror images of the others (compare_handedness()).
    InsideOut, ///< All meshes, or all but those, are inside out.
    Size,      ///< Some meshes are far larger or smaller than the others (odd_sizes()).
    Copies,    ///< Some meshes are the same one, in place or moved (to 1e-6 of the diagonal).
};

/// One oddity: the kind, the meshes concerned, and a sentence with what, where and what to do.
struct Oddity
{
    OddityKind kind;
    std::vector<std::size_t> meshes; ///< Ascending.
    std::string message;
};

/// Finds what is odd about the meshes of a collection together.
/// @param collection  At least one mesh.
/// Cost: O(#V log #V + N #F), and for each pair of meshes of one size the edges up to the first that differs.
[[nodiscard]] std::vector<Oddity> find_oddities(const Collection& collection);

/// Sizes far from the others, as those of meshes in another unit are; ascending indices. Sorted, the
/// sizes are split where one is at least 5 times the one before it; or, of five and more,
/// - at least twice it and 10 times further (in the logarithm) than the sizes spread (1.4826 times the median
///   deviation from the median), or
/// - between two parts of which the logarithms have the pooled standard deviation s <= 0.1 (n and m members):
///   the sizes beside the split differ by 6 s, and by a factor of 2.3; or, for inches and centimetres, by 6 s,
///   and the logarithm of the ratio of the geometric means by at most max(0.05, 2 s sqrt(1/n + 1/m)) from that
///   of 2.54.
/// All but the largest part (the first of equal ones) are odd.
/// @param sizes  Each > 0.
[[nodiscard]] std::vector<std::size_t> odd_sizes(const std::vector<double>& sizes);

/// "a, b and c", or the first ones "and 12 more".
[[nodiscard]] std::string list_names(const std::vector<std::string>& names,
                                     const std::vector<std::size_t>& chosen);

} // namespace shape
