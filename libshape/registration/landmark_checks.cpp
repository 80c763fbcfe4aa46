// SPDX-License-Identifier: MIT

#include "libshape/registration/landmark_checks.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/percent.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

using Eigen::Index;

/// About their mean, root of the sum of squares 1.
Eigen::MatrixXd normed(const Points& points)
{
    const Eigen::MatrixXd centred = points.rowwise() - points.colwise().mean();
    return centred / centred.norm();
}

/// What the best rotation of normed points a leaves of others, b: |a R - b|, where tr(R^T a^T b) is largest (Umeyama
/// 1991).
/// @param product  a^T b.
/// @param turn  1; -1: the best rotation and reflection.
double misfit(const Eigen::Matrix3d& product, double turn)
{
    const Eigen::Vector3d values = Eigen::JacobiSVD<Eigen::Matrix3d>(product).singularValues();
    const double last = product.determinant() * turn < 0.0 ? -values[2] : values[2];
    return std::sqrt(std::max(0.0, 2.0 - 2.0 * (values[0] + values[1] + last)));
}

/// "'a', 'b' and 'c'", all of them.
std::string listed(const std::vector<std::string>& names, const std::vector<Index>& chosen)
{
    std::string text;
    for (std::size_t i = 0; i < chosen.size(); ++i)
        text += join(i == 0                  ? ""
                     : i + 1 < chosen.size() ? ", "
                                             : " and ",
                     "'", names[to_size(chosen[i])], "'");
    return text;
}

/// Scan rows beside other landmarks than their own.
struct Exchanged
{
    double misfit; ///< What is left then.
    std::vector<Index> row_of;
    Eigen::Matrix3d product;
};

/// Of one exchange, two, ... after each other the ones that leave least, as far as a search that goes on from the best few of
/// each round finds them.
/// @param from, to  Normed.
std::vector<Exchanged> best_exchanges(const Eigen::MatrixXd& from, const Eigen::MatrixXd& to)
{
    constexpr Index rounds = 6;
    const Index count = from.rows();
    const std::size_t width = std::max<std::size_t>(2, 120 / to_size(count));
    const auto leaves_less = [](const Exchanged& a, const Exchanged& b) {
        return std::tie(a.misfit, a.row_of) < std::tie(b.misfit, b.row_of);
    };
    std::vector<Index> own(to_size(count));
    std::iota(own.begin(), own.end(), Index{0});
    std::set<std::vector<Index>> seen{own};
    std::vector<Exchanged> best;
    std::vector<Exchanged> last{{0.0, own, from.transpose() * to}};
    for (Index round = 0; round < (count > 4 ? std::min(rounds, count - 1) : 1); ++round) {
        std::vector<Exchanged> next;
        for (const Exchanged& before : last)
            for (Index i = 0; i < count; ++i)
                for (Index j = i + 1; j < count; ++j) {
                    Exchanged now = before;
                    std::swap(now.row_of[to_size(i)], now.row_of[to_size(j)]);
                    now.product -=
                        (from.row(i) - from.row(j)).transpose() *
                        (to.row(before.row_of[to_size(i)]) - to.row(before.row_of[to_size(j)]));
                    now.misfit = misfit(now.product, 1.0);
                    if (next.size() >= width && now.misfit >= next.back().misfit)
                        continue;
                    if (!seen.insert(now.row_of).second)
                        continue;
                    next.insert(std::upper_bound(next.begin(), next.end(), now, leaves_less), now);
                    if (next.size() > width)
                        next.pop_back();
                }
        if (next.empty())
            break;
        best.push_back(next.front());
        last = std::move(next);
    }
    return best;
}

/// "landmarks 'a' and 'b', 'c', 'd' and 'e' (...) look exchanged".
std::string describe(const std::vector<Index>& row_of, const std::vector<std::string>& names)
{
    std::string text = "landmarks ";
    std::vector<bool> is_named(row_of.size(), false);
    for (Index i = 0; i < std::ssize(row_of); ++i) {
        if (is_named[to_size(i)] || row_of[to_size(i)] == i)
            continue;
        std::vector<Index> circle; // each stands where the one before it should
        for (Index at = i; !is_named[to_size(at)]; at = row_of[to_size(at)]) {
            is_named[to_size(at)] = true;
            circle.push_back(at);
        }
        text += join(text.ends_with("landmarks ") ? "" : ", ", listed(names, circle));
        for (std::size_t k = 0; k < circle.size() && circle.size() > 2; ++k)
            text += join(k == 0 ? " (" : ", ", "'", names[to_size(circle[(k + 1) % circle.size()])],
                         k == 0 ? "' at the place of '" : "' at that of '",
                         names[to_size(circle[k])], k + 1 < circle.size() ? "'" : "')");
    }
    return text + " look exchanged";
}

/// Landmarks that are one point on one side alone.
std::optional<std::string> merged_landmarks(const std::vector<std::string>& names,
                                            const Points& on_template, const Points& on_scan)
{
    const auto groups_of = [](const Points& points, const Points& others) {
        std::map<std::array<double, 3>, std::vector<Index>> at;
        for (Index i = 0; i < points.rows(); ++i)
            at[{points(i, 0), points(i, 1), points(i, 2)}].push_back(i);
        std::vector<std::vector<Index>> groups;
        for (const auto& [place, group] : at) {
            const Index first = group.front();
            if (std::any_of(group.begin(), group.end(),
                            [&](Index i) { return others.row(i) != others.row(first); }))
                groups.push_back(group);
        }
        std::sort(groups.begin(), groups.end());
        return groups;
    };
    for (const bool is_scan : {true, false}) {
        const auto groups =
            is_scan ? groups_of(on_scan, on_template) : groups_of(on_template, on_scan);
        std::string text;
        for (const std::vector<Index>& group : groups)
            text += (text.empty() ? "" : ", ") + listed(names, group);
        if (!groups.empty())
            return join("landmarks ", text, " lie on one point", groups.size() > 1 ? " each" : "",
                        " of the ", is_scan ? "scan" : "template", ", but not of the ",
                        is_scan ? "template" : "scan");
    }
    return std::nullopt;
}

} // namespace

void check_not_far(const std::vector<std::string>& names, const Points& landmarks,
                   const Points& surface, const std::string& whose)
{
    constexpr double far = 20.0; // diagonals; set by hand
    const double diagonal = bounding_box_diagonal(surface);
    const Eigen::RowVector3d centre =
        0.5 * (surface.colwise().minCoeff() + surface.colwise().maxCoeff());
    std::string text;
    Index count = 0;
    for (Index i = 0; i < landmarks.rows(); ++i)
        if (const double away = (landmarks.row(i) - centre).norm() / diagonal; away > far)
            text += join(count++ == 0 ? "" : ", ", "'", names[to_size(i)], "' lies ",
                         std::round(away), " diagonals away");
    if (count > 0 && count < landmarks.rows())
        throw InvalidInput(join("landmarks of ", whose, ": ", text,
                                "; is that a code for a missing one? Leave its coordinates empty"));
}

void check_not_zero(const std::vector<std::string>& names, const Points& landmarks,
                    const Points& surface, const std::string& whose)
{
    constexpr double near = 0.05; // of the diagonal
    std::vector<Index> zeros;
    for (Index i = 0; i < landmarks.rows(); ++i)
        if ((landmarks.row(i).array() == 0.0).all())
            zeros.push_back(i);
    if (zeros.empty() ||
        (zeros.size() == 1 && surface.rows() > 0 &&
         surface.rowwise().norm().minCoeff() <= near * bounding_box_diagonal(surface)))
        return;
    throw InvalidInput(join(
        "landmarks of ", whose, ": ",
        std::ssize(zeros) == landmarks.rows() && zeros.size() > 1
            ? join("all ", zeros.size(), " are")
            : join(listed(names, zeros), zeros.size() == 1 ? " is" : " are"),
        " at 0, 0, 0, which several programs write for a missing one; leave coordinates of missing "
        "ones empty"));
}

bool is_on_line(const Points& landmarks)
{
    if (landmarks.rows() < 3)
        return true;
    const Points centred = landmarks.rowwise() - landmarks.colwise().mean();
    const Eigen::VectorXd spread = Eigen::JacobiSVD<Eigen::MatrixXd>(centred).singularValues();
    return !(spread[1] > 1e-3 * spread[0]); // else less than the error of picking them by hand
}

void check_not_on_line(const Points& landmarks, const Points& surface, const std::string& whose)
{
    if (landmarks.rows() < 3)
        return;
    constexpr double one_point = 1e-3; // of the diagonal
    const Points centred = landmarks.rowwise() - landmarks.colwise().mean();
    if (centred.rowwise().norm().maxCoeff() <= one_point * bounding_box_diagonal(surface))
        throw InvalidInput(join("landmarks of ", whose, ": all ", landmarks.rows(),
                                " lie in one point, which leaves every turn open"));
    if (is_on_line(landmarks))
        throw InvalidInput(join("landmarks of ", whose,
                                ": they lie on a line, which leaves a turn about it open"));
}

std::optional<std::string> mistaken_landmarks(const std::vector<std::string>& names,
                                              const Points& on_template, const Points& on_scan)
{
    constexpr double least_misfit = 0.05, explained = 1.0 / 3.0, halved = 0.5; // see the header
    if (auto merged = merged_landmarks(names, on_template, on_scan))
        return merged;
    if (on_scan.rows() < 4)
        return std::nullopt;
    const Eigen::MatrixXd from = normed(on_template), to = normed(on_scan);
    const Eigen::Matrix3d product = from.transpose() * to;
    const double as_given = misfit(product, 1.0);
    if (!(as_given >= least_misfit))
        return std::nullopt;
    double least = explained * as_given;
    std::optional<std::string> said;
    const auto than_as_given = [&](double left) {
        return join(percent(left), " of their spread from those of the template, as they are by ",
                    percent(as_given));
    };
    if (const double left = misfit(product, -1.0); left <= least) {
        least = left;
        said = join("the landmarks of the scan look like a mirror image: mirrored they differ by ",
                    than_as_given(left),
                    "; mirror the scan and its landmarks (one coordinate times -1), or exchange "
                    "left and right in their names if those are wrong");
    }
    bool is_first = true;
    for (const Exchanged& slips : best_exchanges(from, to)) {
        const bool is_better =
            is_first ? slips.misfit < least : slips.misfit <= (said ? halved * least : least);
        is_first = false;
        if (!is_better)
            continue;
        least = slips.misfit;
        said = join(describe(slips.row_of, names),
                    ": with their names exchanged the landmarks differ by ", than_as_given(least));
    }
    return said;
}

} // namespace shape::internal
