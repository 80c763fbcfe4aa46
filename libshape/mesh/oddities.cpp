// SPDX-License-Identifier: MIT

#include "libshape/mesh/oddities.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "libshape/base/counted.h"
#include "libshape/base/format.h"
#include "libshape/base/order_statistics.h"
#include "libshape/base/rounded.h"
#include "libshape/base/threads.h"
#include "libshape/mesh/coincident_vertices.h"
#include "libshape/mesh/congruent_meshes.h"
#include "libshape/mesh/coordinate_spacing.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/handedness.h"
#include "libshape/mesh/stretched_meshes.h"
#include "libshape/mesh/unit_ratio.h"

namespace shape {
using namespace internal;
namespace {

/// 1.4826 times the median deviation from the median, which is the standard deviation where logarithms of
/// sizes are normally distributed.
double spread_of(const std::vector<double>& logarithms)
{
    const double centre = median(logarithms);
    std::vector<double> deviations;
    for (const double value : logarithms)
        deviations.push_back(std::abs(value - centre));
    return 1.4826 * median(deviations);
}

/// Sums over the sorted logarithms of sizes, of which every split is judged at once.
class SortedSizes
{
public:
    explicit SortedSizes(std::vector<double> sorted) : sorted_(std::move(sorted))
    {
        const double centre = sorted_.empty() ? 0.0 : sorted_[sorted_.size() / 2];
        for (const double value : sorted_) {
            const double from_centre = value - centre;
            sums_.push_back(sums_.back() + from_centre);
            squares_.push_back(squares_.back() + from_centre * from_centre);
        }
    }

    /// Whether the first `count` and the others are two parts that each spread little for the gap between them,
    /// which is wide whatever the units, or whose geometric means have the ratio 2.54 of inches and centimetres as
    /// nearly as so few can show. Two kinds may differ so too, but seldom so clearly.
    [[nodiscard]] bool are_two_parts(std::size_t count) const
    {
        constexpr double largest_spread = 0.1; // bones of adults: 0.065; faces 0.05
        // All set by hand: three of eight vertebrae of adults in inches are found in 90 % of the draws, and of five or
        // six sizes that are uniform over a factor of 3, where nothing is in inches, 1 to 2 % are said to be.
        constexpr double least_gap = 6.0; // spreads: sizes of one kind seldom leave such a gap
        constexpr double least_tolerance =
            0.05;                        // sizes that hardly spread have errors of their own
        constexpr double wide_gap = 2.3; // of sizes of one kind with nothing between
        const std::size_t all = sorted_.size();
        const auto low = static_cast<double>(count);
        const auto high = static_cast<double>(all - count);
        const double low_sum = sums_[count];
        const double high_sum = sums_[all] - low_sum;
        const double squares =
            std::max(0.0, squares_[all] - low_sum * low_sum / low - high_sum * high_sum / high);
        const double spread = std::sqrt(squares / static_cast<double>(all - 2));
        const double gap = sorted_[count] - sorted_[count - 1];
        if (spread > largest_spread || gap < least_gap * spread)
            return false;
        const double ratio = high_sum / high - low_sum / low;
        const double error = spread * std::sqrt(1.0 / low + 1.0 / high);
        return gap >= std::log(wide_gap) ||
               std::abs(ratio - std::log(2.54)) <= std::max(least_tolerance, 2.0 * error);
    }

private:
    std::vector<double> sorted_;
    std::vector<double> sums_{0.0};    ///< Of the first ones, from the middle one.
    std::vector<double> squares_{0.0}; ///< Of the same.
};

/// "20 boundary vertices" of some groups, and where the first are.
struct SeamPlaces
{
    std::string vertices;
    std::string places;
};

SeamPlaces describe(const std::vector<VertexGroup>& groups, const Collection& collection)
{
    std::size_t vertices = 0;
    for (const VertexGroup& group : groups)
        vertices += group.size();
    return {join(vertices, " boundary vertices"),
            join(" at ", counted(groups.size(), "place"),
                 collection.size() == 1 ? " in mesh " : " in all meshes, first ",
                 collection.names.front(), ": vertices ", groups.front()[0], " and ",
                 groups.front()[1])};
}

void find_seams(const Collection& collection, std::vector<Oddity>& oddities)
{
    if (collection.topology.is_closed())
        return;
    const SeamVertices seams = seam_vertices(collection.topology.faces(), collection.points);
    std::vector<std::size_t> all(collection.size());
    std::iota(all.begin(), all.end(), 0);
    if (!seams.coincident.empty()) {
        const SeamPlaces seam = describe(seams.coincident, collection);
        oddities.push_back(
            {OddityKind::Seam, all,
             join(seam.vertices, " lie on one another", seam.places,
                  "; the surface is open along this seam and blends will tear there. Export "
                  "without splitting vertices (no UV, no normals; Blender: OBJ, or Merge by "
                  "Distance before), or weld them")});
    }
    if (!seams.near.empty()) {
        const SeamPlaces seam = describe(seams.near, collection);
        oddities.push_back(
            {OddityKind::NearSeam, all,
             join(seam.vertices, " lie near one another, up to ", rounded(seams.gap),
                  " of the diagonal apart,", seam.places,
                  "; if the surface is to be closed there, blends will tear it: merge vertices by "
                  "that distance before the export (Blender: Merge by Distance)")});
    }
}

/// "the other mesh" or "the other 5 meshes".
std::string the_others(std::size_t count)
{
    return count == 1 ? "the other mesh" : join("the other ", count, " meshes");
}

void find_orientation(const Collection& collection, std::vector<Oddity>& oddities)
{
    const Handedness found = compare_handedness(collection.topology, collection.points);
    if (!found.mirrored.empty())
        oddities.push_back(
            {OddityKind::Mirrored, found.mirrored,
             join(list_names(collection.names, found.mirrored),
                  found.mirrored.size() == 1 ? " is a mirror image" : " are mirror images", " of ",
                  the_others(collection.size() - found.mirrored.size()), " (their ",
                  collection.topology.is_closed() ? "volumes" : "dihedral angles",
                  " have opposite signs: turned inside out); mirror ",
                  found.mirrored.size() == 1 ? "it" : "them",
                  " back (one coordinate times -1, faces as they are) or leave ",
                  found.mirrored.size() == 1 ? "it" : "them", " out")});
    if (!found.bent.empty())
        oddities.push_back(
            {OddityKind::Bent, found.bent,
             join(list_names(collection.names, found.bent), " ",
                  describe_bent(found.bent.size(), collection.size()), "; mirror ",
                  found.bent.size() == 1 ? "it" : "them",
                  " back (one coordinate times -1, faces as they are) only if you know that")});
    if (!found.inside_out)
        return;
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < collection.size(); ++i)
        if (!std::binary_search(found.mirrored.begin(), found.mirrored.end(), i))
            others.push_back(i);
    oddities.push_back(
        {OddityKind::InsideOut, others,
         join(collection.size() == 1   ? "the mesh is"
              : found.mirrored.empty() ? "all meshes are"
                                       : "the other meshes are",
              " inside out (negative volume: faces run clockwise seen from outside); convex and "
              "concave change places. Reverse the faces of every mesh (Recalculate Outside / Flip "
              "normals on export)")});
}

/// "a and b are 12 times larger".
std::string compare_sizes(const std::string& names, bool is_one, double ratio)
{
    return join(names, is_one ? " is " : " are ", rounded(std::max(ratio, 1.0 / ratio)), " times ",
                ratio > 1.0 ? "larger" : "smaller");
}

void find_sizes(const Collection& collection, std::vector<Oddity>& oddities)
{
    std::vector<double> sizes;
    for (const Points& points : collection.points)
        sizes.push_back(edge_lengths(collection.topology, points).sum());
    const std::vector<std::size_t> odd = odd_sizes(sizes);
    if (odd.empty())
        return;
    std::vector<double> others;
    for (std::size_t i = 0; i < sizes.size(); ++i)
        if (!std::binary_search(odd.begin(), odd.end(), i))
            others.push_back(sizes[i]);
    const double usual = median(others);
    const std::vector<std::vector<std::size_t>> parts = parts_of_odd_sizes(sizes, odd);
    std::string text = join("sizes range from ", rounded(*std::ranges::min_element(sizes)), " to ",
                            rounded(*std::ranges::max_element(sizes)), ": ");
    for (std::size_t p = 0; p < parts.size(); ++p) {
        std::vector<double> those;
        for (const std::size_t i : parts[p])
            those.push_back(sizes[i]);
        const double ratio = median(those) / usual;
        const bool is_one = parts[p].size() == 1;
        const std::optional<UnitRatio> known = unit_ratio_near(ratio);
        text += compare_sizes(list_names(collection.names, parts[p]), is_one, ratio);
        if (parts.size() > 1)
            text += join(known ? join(" (", known->units, "?)") : "",
                         p + 1 < parts.size() ? ", "
                                              : join(" than ", the_others(others.size()),
                                                     "; export all in one unit, or scale them"));
        else
            text +=
                join(" than ", the_others(others.size()),
                     known ? join("; are they in ", known->units, "? Export all in one unit")
                           : join("; are all in one unit? If not, scale ", is_one ? "it" : "them"));
    }
    oddities.push_back({OddityKind::Size, odd, text});
}

void find_stretched(const Collection& collection, std::vector<Oddity>& oddities)
{
    StretchedMeshes found = stretched_meshes(collection.points);
    if (found.meshes.empty())
        return;
    const bool is_one = found.meshes.size() == 1;
    const bool is_longer = found.factor > 1.0;
    const std::string axis =
        found.axis < 0 ? std::string("one axis of theirs") : std::string(1, "xyz"[found.axis]);
    oddities.push_back(
        {OddityKind::Stretched, found.meshes,
         join(list_names(collection.names, found.meshes), is_one ? " is " : " are ",
              rounded(is_longer ? found.factor : 1.0 / found.factor), " times ",
              is_longer ? "longer" : "shorter", " along ",
              is_one && found.axis < 0 ? "one of its axes" : axis, " than ",
              the_others(collection.size() - found.meshes.size()),
              ", as a wrong voxel spacing or slice thickness makes ", is_one ? "it" : "them",
              "; compare with the images, and export anew or scale that axis if it is wrong")});
}

void find_copies(const Collection& collection, std::vector<Oddity>& oddities)
{
    for (const Copies& copies : congruent_meshes(collection.topology, collection.points))
        oddities.push_back({OddityKind::Copies,
                            {copies.meshes.begin() + 1, copies.meshes.end()},
                            describe(copies, collection.names)});
}

void find_coarse(const Collection& collection, std::vector<Oddity>& oddities)
{
    std::vector<std::optional<CoarseCoordinates>> all(collection.size());
    parallel_for(all.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            all[i] = coarse_coordinates(collection.topology.faces(), collection.points[i]);
    });
    std::vector<std::size_t> those;
    std::size_t worst = 0;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i]) {
            if (those.empty() || all[i]->share > all[worst]->share)
                worst = i;
            those.push_back(i);
        }
    if (!those.empty())
        oddities.push_back(
            {OddityKind::Coarse, those,
             join(list_names(collection.names, those),
                  those.size() == 1 ? ": coordinates are "
                                    : join(": coordinates are, in ", collection.names[worst], ", "),
                  describe(*all[worst]),
                  "; lengths, angles and all statistics hold that rounding")});
}

} // namespace

std::vector<Oddity> find_oddities(const Collection& collection)
{
    std::vector<Oddity> oddities;
    find_seams(collection, oddities);
    find_orientation(collection, oddities);
    find_sizes(collection, oddities);
    find_stretched(collection, oddities);
    find_copies(collection, oddities);
    find_coarse(collection, oddities);
    return oddities;
}

std::vector<std::size_t> odd_sizes(const std::vector<double>& sizes)
{
    std::vector<std::size_t> order(sizes.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return sizes[a] < sizes[b]; });
    std::vector<double> logarithms;
    for (const std::size_t i : order)
        logarithms.push_back(std::log(sizes[i]));
    // Of fewer than five, two strange sizes would decide what the spread is.
    const bool has_spread = sizes.size() >= 5;
    const double spread =
        has_spread ? spread_of(logarithms) : std::numeric_limits<double>::infinity();
    const SortedSizes parts(std::move(logarithms));
    // Units differ by 10 at least, but for inches and centimetres (2.54), and feet and metres (3.28); shapes of one
    // kind seldom by 5, or by 2 with nothing between where the others are much alike. Where many are strange the
    // spread of all is the gap, and the parts tell.
    const auto splits = [&](std::size_t end) {
        const double before = sizes[order[end - 1]];
        const double after = sizes[order[end]];
        return after >= 5.0 * before ||
               (after >= 2.0 * before && std::log(after / before) >= 10.0 * spread) ||
               (has_spread && parts.are_two_parts(end));
    };
    std::size_t best_begin = 0;
    std::size_t best_end = 0;
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
        end = begin + 1;
        while (end < order.size() && !splits(end))
            ++end;
        if (end - begin > best_end - best_begin) {
            best_begin = begin;
            best_end = end;
        }
    }
    std::vector<std::size_t> odd(order.begin(),
                                 order.begin() + static_cast<std::ptrdiff_t>(best_begin));
    odd.insert(odd.end(), order.begin() + static_cast<std::ptrdiff_t>(best_end), order.end());
    std::sort(odd.begin(), odd.end());
    return odd;
}

std::vector<std::vector<std::size_t>> parts_of_odd_sizes(const std::vector<double>& sizes,
                                                         const std::vector<std::size_t>& odd)
{
    constexpr double apart = 1.6; // sizes of one part seldom leave such a gap
    double usual = 0.0;           // any of the rest, which lie on one side of each part
    for (std::size_t i = 0; i < sizes.size() && usual == 0.0; ++i)
        if (!std::binary_search(odd.begin(), odd.end(), i))
            usual = sizes[i];
    std::vector<std::size_t> order = odd;
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return sizes[i]; });
    std::vector<std::vector<std::size_t>> parts;
    double before = 0.0;
    for (const std::size_t i : order) {
        if (sizes[i] >= apart * before || (before < usual) != (sizes[i] < usual))
            parts.emplace_back();
        parts.back().push_back(i);
        before = sizes[i];
    }
    for (std::vector<std::size_t>& part : parts)
        std::ranges::sort(part);
    return parts;
}

std::string describe_bent(std::size_t bent, std::size_t all)
{
    const bool is_one = bent == 1;
    return join(is_one ? "bends" : "bend", " the other way than ", the_others(all - bent), ", or ",
                is_one ? "is a mirror image" : "are mirror images", " of ",
                all - bent == 1 ? "it" : "them", ", which such sheets do not tell");
}

std::string list_names(const std::vector<std::string>& names,
                       const std::vector<std::size_t>& chosen)
{
    constexpr std::size_t most = 8; // a line or two of a terminal
    const std::size_t shown = chosen.size() <= most ? chosen.size() : most - 1;
    std::string text;
    for (std::size_t i = 0; i < shown; ++i)
        text += join(i == 0 ? "" : i + 1 < chosen.size() ? ", " : " and ", names.at(chosen[i]));
    if (shown < chosen.size())
        text += join(" and ", chosen.size() - shown, " more");
    return text;
}

std::string list_names(const std::vector<std::string>& names)
{
    std::vector<std::size_t> all(names.size());
    std::iota(all.begin(), all.end(), 0);
    return list_names(names, all);
}

} // namespace shape
