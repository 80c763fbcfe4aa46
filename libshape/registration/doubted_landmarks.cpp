// SPDX-License-Identifier: MIT

#include "libshape/registration/doubted_landmarks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <utility>

#include "libshape/base/format.h"
#include "libshape/base/percent.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/points.h"
#include "libshape/registration/closest_points.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr std::size_t least_count = 3; // that must be left to start from
/// The neighbourhood of a landmark: standard deviation, over the template's diagonal.
constexpr double around = 0.05;
/// CoarseTrial::bent of an edge, mean of a neighbourhood. Around landmarks that were put 10 % of the diagonal away and more it is 0.011
/// and more, around those that are right up to 0.05 (smiles), and less than this around most.
constexpr double much_bent = 0.01;
constexpr std::ptrdiff_t most_suspects =
    2; // of those the worst; the wrong one was always among them
/// Without a landmark that was put 10 % of the diagonal away and more the score is 0.81 times what it was and less.
constexpr double clearly_better = 0.9;
/// What a fit without the doubted ones scores at most: else they are not what is wrong with it. Right fits of the
/// collections have 0.007 to 0.06.
constexpr double sound_score = 0.1;
/// Few landmarks stand beside wrong names if the score falls below the first of these times what it was by exchanging names, and to
/// what a sound fit has or below the second: bent poses with few landmarks are no sound fits either way.
constexpr double far_better = 0.5, by_far_better = 0.1;
/// As much_bent, for few landmarks, whose exchange bends more.
constexpr double bent_by_exchange = 0.02;

/// The mean of `bent` around each landmark.
std::vector<double> bent_around(const TemplateLevel& level, const Points& landmarks,
                                const Eigen::VectorXd& bent)
{
    const Topology& topology = level.topology;
    const double deviation = around * bounding_box_diagonal(level.rest);
    std::vector<double> means;
    for (const auto& landmark : landmarks.rowwise()) {
        double sum = 0.0, weights = 0.0;
        for (int e = 0; e < topology.edge_count(); ++e) {
            const Eigen::RowVector3d middle = 0.5 * (level.rest.row(topology.edges()(e, 0)) +
                                                     level.rest.row(topology.edges()(e, 1)));
            const double apart = (middle - landmark).norm() / deviation;
            const double weight = std::exp(-0.5 * apart * apart);
            sum += weight * bent[e];
            weights += weight;
        }
        means.push_back(weights > 0.0 ? sum / weights : 0.0);
    }
    return means;
}

/// Where a mesh of a level has a landmark, and how far that is from where the scan has it.
double off_by(const TemplateLevel& level, const SurfacePoint& mark, const Points& points,
              const Eigen::RowVector3d& on_scan)
{
    Eigen::RowVector3d place = Eigen::RowVector3d::Zero();
    for (int k = 0; k < 3; ++k)
        place += mark.barycentric[k] * points.row(level.topology.faces()(mark.face, k));
    return (place - on_scan).norm();
}

LandmarkPairs only(const LandmarkPairs& landmarks, const std::vector<std::size_t>& chosen)
{
    LandmarkPairs some;
    some.on_template = landmarks.on_template(chosen, Eigen::all);
    some.on_scan = landmarks.on_scan(chosen, Eigen::all);
    for (const std::size_t i : chosen)
        some.names.push_back(landmarks.names[i]);
    return some;
}

} // namespace

std::vector<DoubtedLandmark> doubted_landmarks(const TemplateLevel& level,
                                               const LandmarkPairs& landmarks,
                                               const Eigen::VectorXd& bent, double near,
                                               const LandmarkTrial& try_with)
{
    const std::size_t count = landmarks.names.size();
    if (count <= least_count)
        return {};
    const ClosestPoints tree(level.rest, level.topology.faces());
    std::vector<SurfacePoint> marks;
    for (const auto& landmark : landmarks.on_template.rowwise())
        marks.push_back(tree.nearest(landmark));
    const auto off = [&](std::size_t i, const CoarseTrial& trial) {
        return off_by(level, marks[i], trial.mesh.points,
                      landmarks.on_scan.row(static_cast<Index>(i)));
    };

    std::vector<std::size_t> left(count), doubted;
    std::iota(left.begin(), left.end(), std::size_t{0});
    std::optional<CoarseTrial> with; // those that are left
    while (left.size() > least_count) {
        const std::vector<double> means =
            bent_around(level, landmarks.on_template, with ? with->bent : bent);
        std::vector<std::size_t> suspects;
        std::copy_if(left.begin(), left.end(), std::back_inserter(suspects),
                     [&](std::size_t i) { return means[i] > much_bent; });
        std::stable_sort(suspects.begin(), suspects.end(),
                         [&](std::size_t i, std::size_t j) { return means[i] > means[j]; });
        if (std::ssize(suspects) > most_suspects)
            suspects.erase(suspects.begin() + most_suspects, suspects.end());
        if (suspects.empty())
            break;
        if (!with)
            with = try_with(landmarks);
        std::optional<std::size_t> wrong;
        double least = clearly_better * with->score;
        std::optional<CoarseTrial> without;
        for (const std::size_t suspect : suspects) {
            std::vector<std::size_t> others;
            std::copy_if(left.begin(), left.end(), std::back_inserter(others),
                         [&](std::size_t i) { return i != suspect; });
            CoarseTrial trial = try_with(only(landmarks, others));
            if (trial.score < least && off(suspect, trial) > near) {
                least = trial.score;
                wrong = suspect;
                without = std::move(trial);
            }
        }
        if (!wrong)
            break;
        doubted.push_back(*wrong);
        left.erase(std::find(left.begin(), left.end(), *wrong));
        with = std::move(without);
    }
    if (doubted.empty() || 2 * doubted.size() > count || with->score > sound_score)
        return {};
    std::vector<DoubtedLandmark> said;
    for (const std::size_t i : doubted)
        said.push_back({landmarks.names[i], off(i, *with)});
    return said;
}

std::vector<std::string> exchanged_landmarks(const TemplateLevel& level,
                                             const LandmarkPairs& landmarks,
                                             const CoarseTrial& as_given,
                                             const LandmarkTrial& try_with)
{
    using Order = std::vector<std::size_t>;
    const std::size_t count = landmarks.names.size();
    const std::vector<Order> orders =
        count == 2   ? std::vector<Order>{{1, 0}}
        : count == 3 ? std::vector<Order>{{1, 0, 2}, {0, 2, 1}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}}
                     : std::vector<Order>{};
    if (orders.empty())
        return {};
    const std::vector<double> means = bent_around(level, landmarks.on_template, as_given.bent);
    if (as_given.score <= sound_score &&
        *std::max_element(means.begin(), means.end()) <= bent_by_exchange)
        return {};
    double least = std::min(far_better * as_given.score,
                            std::max(sound_score, by_far_better * as_given.score));
    const Order* best = nullptr;
    for (const Order& order : orders) {
        LandmarkPairs exchanged = landmarks;
        exchanged.on_scan = landmarks.on_scan(order, Eigen::all);
        if (const double score = try_with(exchanged).score; score < least) {
            least = score;
            best = &order;
        }
    }
    std::vector<std::string> names;
    for (std::size_t i = 0; best != nullptr && i < count; ++i)
        if ((*best)[i] != i)
            names.push_back(landmarks.names[i]);
    return names;
}

} // namespace shape::internal
