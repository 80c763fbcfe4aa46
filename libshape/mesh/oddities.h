// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

#include "libshape/mesh/collection.h"

namespace shape {

/// What a collection may have that is not a defect of any mesh and is seldom meant.
enum class OddityKind
{
    Seam,      ///< Boundary vertices lie on one another in all meshes (seam_vertices()).
    NearSeam,  ///< The same of some that lie near one another, but not on one another.
    Mirrored,  ///< Some meshes are mirror images of the others (compare_handedness()).
    Bent,      ///< Some sheets bend the other way, or are mirror images: nothing tells which.
    InsideOut, ///< All meshes, or all but those, are inside out.
    Size,      ///< Some meshes are far larger or smaller than the others (odd_sizes()).
    Stretched, ///< Some meshes are longer or shorter along one axis (stretched_meshes.h).
    Copies,    ///< Some meshes are the same one, in place or moved, give or take rounding.
    Coarse, ///< Coordinates are rounded to more than a hundredth of the edges (coordinate_spacing.h).
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
/// Cost: O(#F log #F + N #F), and for each pair of meshes of one size a comparison or two; O(N #V) for each mesh that is
/// nearly another one.
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

/// odd_sizes() in parts that stand apart from one another, ascending: sorted, a part ends where a size is 1.6 times the
/// one before it, and at those of the rest.
/// @param odd  As odd_sizes() gives them.
[[nodiscard]] std::vector<std::vector<std::size_t>> parts_of_odd_sizes(
    const std::vector<double>& sizes, const std::vector<std::size_t>& odd);

/// "bends the other way than the other 3 meshes, or is a mirror image of them, which such sheets do not tell", of `bent` of
/// `all` meshes (Handedness::bent).
[[nodiscard]] std::string describe_bent(std::size_t bent, std::size_t all);

/// "a, b and c", or the first ones "and 12 more".
[[nodiscard]] std::string list_names(const std::vector<std::string>& names,
                                     const std::vector<std::size_t>& chosen);

/// The same of all of them.
[[nodiscard]] std::string list_names(const std::vector<std::string>& names);

} // namespace shape
