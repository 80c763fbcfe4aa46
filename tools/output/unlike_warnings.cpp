// SPDX-License-Identifier: MIT

#include "tools/output/unlike_warnings.h"

#include <algorithm>
#include <optional>

#include "libshape/base/format.h"
#include "libshape/base/order_statistics.h"
#include "libshape/base/rounded.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/oddities.h"
#include "libshape/mesh/unit_ratio.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

std::string warning_of_mirror_images(const std::vector<std::string>& names,
                                     const std::vector<std::size_t>& mirrored,
                                     const UnlikeWords& words)
{
    const bool is_one = mirrored.size() == 1;
    const char* const them = is_one ? "it" : "them";
    const char* const are_images = words.are_differences
                                       ? (is_one ? " is of mirror images" : " are of mirror images")
                                       : (is_one ? " is a mirror image" : " are mirror images");
    const std::string back = "(one coordinate times -1, faces as they are)";
    return join(words.option, list_names(names, mirrored), are_images, " of ", words.others, "; ",
                words.mirrored, ": ",
                words.are_differences ? join("make ", them, " anew of meshes mirrored back ", back)
                                      : join("mirror ", them, " back ", back));
}

/// Of sheets nobody can tell.
std::string warning_of_bent(const std::vector<std::string>& names,
                            const std::vector<std::size_t>& bent, const UnlikeWords& words)
{
    const bool is_one = bent.size() == 1;
    return join(
        words.option, list_names(names, bent),
        words.are_differences ? (is_one ? " is of meshes that bend" : " are of meshes that bend")
        : is_one              ? " bends"
                              : " bend",
        " the other way than ", words.others, ", or ",
        words.are_differences || !is_one ? "are mirror images" : "is a mirror image",
        " of them, which such sheets do not tell; mirror back (one coordinate times -1, faces as "
        "they are) only if you know that");
}

/// @param ratios  Of the odd ones, all above 1 or all below.
std::string warning_of_sizes(const std::vector<std::string>& names,
                             const std::vector<std::size_t>& odd, const std::vector<double>& ratios,
                             const UnlikeWords& words)
{
    const double usual = median(ratios);
    std::vector<double> times;
    for (const double ratio : ratios)
        times.push_back(std::max(ratio, 1.0 / ratio));
    const auto [least, most] = std::minmax_element(times.begin(), times.end());
    const std::string range = rounded(*least) == rounded(*most)
                                  ? rounded(*least)
                                  : join(rounded(*least), " to ", rounded(*most));
    const std::optional<UnitRatio> known = unit_ratio_near(usual);
    return join(
        words.option, list_names(names, odd), odd.size() == 1 ? " is " : " are ",
        words.are_differences ? "of meshes " : "", range, " times ",
        usual > 1.0 ? "larger" : "smaller", " than ", words.others,
        known ? join("; are they in ", known->units, "? ") : std::string("; are all in one unit? "),
        words.size.empty() ? "Export all in one unit" : words.size);
}

} // namespace

std::string effect_of_mirroring(const ShapeSpace& space)
{
    const auto* const edge = std::get_if<EdgeSpace>(&space);
    const bool is_seen =
        edge == nullptr || edge->dihedral_factors.size() > 0 || edge->position_factors.size() > 0;
    return is_seen ? "the space takes that for a difference of shape"
                   : "edge lengths do not see that";
}

RowMatrix marks_in_transfer(const DifferenceVector& difference, const Collection& meshes,
                            const Eigen::VectorXd& sizes)
{
    RowMatrix marks = unlike_meshes(known_meshes(difference), meshes, sizes);
    if (difference.scale == Scale::Unit)
        marks.col(1).setZero();
    return marks;
}

UnlikeWords words_of_transfer(const std::string& option, const std::string& others)
{
    return {.option = option,
            .others = others,
            .mirrored = "angles change the wrong way",
            .size = "Lengths are added as they are (--scale none): bring all to one unit first"};
}

std::vector<std::string> unlike_warnings(const std::vector<std::string>& names,
                                         const RowMatrix& marks, const UnlikeWords& words)
{
    std::vector<std::string> warnings;
    const auto marked = [&](double mark) {
        std::vector<std::size_t> those;
        for (Eigen::Index i = 0; i < marks.rows(); ++i)
            if (marks(i, 0) == mark)
                those.push_back(to_size(i));
        return those;
    };
    if (const std::vector<std::size_t> mirrored = marked(1.0); !mirrored.empty())
        warnings.push_back(warning_of_mirror_images(names, mirrored, words));
    if (const std::vector<std::size_t> bent = marked(2.0); !bent.empty())
        warnings.push_back(warning_of_bent(names, bent, words));
    for (const bool larger : {true, false}) {
        std::vector<std::size_t> odd;
        std::vector<double> ratios;
        for (Eigen::Index i = 0; i < marks.rows(); ++i)
            if (const double ratio = marks(i, 1); ratio > 0.0 && (ratio > 1.0) == larger) {
                odd.push_back(to_size(i));
                ratios.push_back(ratio);
            }
        if (!odd.empty())
            warnings.push_back(warning_of_sizes(names, odd, ratios, words));
    }
    return warnings;
}

void warn_of_unlike(const Session& session, const std::vector<std::string>& names,
                    const RowMatrix& marks, const UnlikeWords& words)
{
    for (const std::string& warning : unlike_warnings(names, marks, words))
        session.warn(warning);
}

std::vector<std::string> far_warnings(const std::vector<std::string>& names,
                                      const Eigen::VectorXd& times, const std::string& others)
{
    std::vector<std::size_t> far;
    double least = 0.0;
    double most = 0.0;
    for (Eigen::Index i = 0; i < times.size(); ++i)
        if (times[i] > 0.0) {
            least = far.empty() ? times[i] : std::min(least, times[i]);
            most = std::max(most, times[i]);
            far.push_back(to_size(i));
        }
    if (far.empty())
        return {};
    const std::string range = rounded(least) == rounded(most)
                                  ? rounded(least)
                                  : join(rounded(least), " to ", rounded(most));
    return {
        join(list_names(names, far), far.size() == 1 ? " is " : " are ", range,
             " times as far from the mean as the farthest of ", others,
             " (exchanged vertices or landmarks, a failed registration, another kind?); look at ",
             far.size() == 1 ? "it" : "them")};
}

void warn_of_far(const Session& session, const std::vector<std::string>& names,
                 const Eigen::VectorXd& times, const std::string& others)
{
    for (const std::string& warning : far_warnings(names, times, others))
        session.warn(warning);
}

} // namespace shape::tools
