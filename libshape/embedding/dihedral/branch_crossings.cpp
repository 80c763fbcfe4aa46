// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral/branch_crossings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "libshape/base/to_size.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/hinge.h"
#include "libshape/mesh/vertex_regions.h"

namespace shape::internal {
namespace {

using Eigen::VectorXd;

/// Edges that differ by more have another fold; smooth bends of two branches differ by less.
constexpr double folded = 0.3;
/// Edges of a fold that differ by less do not count for how far it has turned over.
constexpr double still = 0.1;

/// The largest difference of angles in the middle third of the places, #E; 0 on the boundary. Towards
/// the ends the branch from the other end may be anywhere.
VectorXd largest_differences(const Topology& topology, const std::vector<BranchPlace>& first,
                             const std::vector<BranchPlace>& second)
{
    VectorXd largest = VectorXd::Zero(topology.edge_count());
    const std::size_t last = first.size() - 1;
    for (std::size_t i = last / 3; i <= last - last / 3; ++i)
        for (int e = 0; e < topology.edge_count(); ++e)
            if (!topology.is_boundary_edge(e))
                largest[e] = std::max(
                    largest[e], std::abs(wrapped_angle(second[i].angles[e] - first[i].angles[e])));
    return largest;
}

double cheapest_centre(const std::vector<int>& edges, const std::vector<BranchPlace>& first,
                       const std::vector<BranchPlace>& second, int width)
{
    const auto sum = [&](const BranchPlace& place) {
        double energy = 0.0;
        for (const int e : edges)
            energy += place.energies[e];
        return energy;
    };
    const int places = static_cast<int>(first.size());
    const int begin = std::min(width / 2 + 1, places / 2);
    const int end = std::max(places - width / 2 - 1, begin + 1);
    double all = 0.0; // less what the second branch costs from the first place on
    double least = std::numeric_limits<double>::infinity();
    int best = begin;
    for (int k = 0; k < end; ++k) {
        if (k >= begin && all < least) {
            least = all;
            best = k;
        }
        all += sum(first[to_size(k)]) - sum(second[to_size(k)]);
    }
    return best - 0.5;
}

double ramp(double centre, int width, std::size_t place)
{
    return std::clamp((static_cast<double>(place) - centre) / width + 0.5, 0.0, 1.0);
}

} // namespace

double BranchCrossings::share(int edge, std::size_t place) const
{
    const int fold = fold_of_edge[to_size(edge)];
    return ramp(fold < 0 ? centre : folds[to_size(fold)].centre, width, place);
}

double BranchCrossings::share(std::size_t place) const
{
    return ramp(centre, width, place);
}

bool BranchCrossings::is_between(std::size_t place) const
{
    const double all = share(place);
    return (all > 0.0 && all < 1.0) ||
           std::any_of(folds.begin(), folds.end(), [&](const FoldCrossing& fold) {
               return ramp(fold.centre, width, place) != all;
           });
}

BranchCrossings branch_crossings(const Topology& topology, const std::vector<BranchPlace>& first,
                                 const std::vector<BranchPlace>& second, int width)
{
    const VectorXd largest = largest_differences(topology, first, second);
    std::vector<int> seeds;
    for (int e = 0; e < topology.edge_count(); ++e)
        if (largest[e] > folded)
            for (const int v : hinge_corners(topology, e))
                seeds.push_back(v);
    const std::vector<std::vector<int>> regions = regions_around(topology, seeds, 1);
    std::vector<int> region_of(to_size(topology.vertex_count()), -1);
    for (std::size_t r = 0; r < regions.size(); ++r)
        for (const int v : regions[r])
            region_of[to_size(v)] = static_cast<int>(r);

    BranchCrossings crossings;
    crossings.width = width;
    crossings.folds.resize(regions.size());
    crossings.fold_of_edge.resize(to_size(topology.edge_count()), -1);
    std::vector<std::vector<int>> edges(regions.size()); // with those that hardly move
    for (int e = 0; e < topology.edge_count(); ++e) {
        const int region = region_of[to_size(topology.edges()(e, 0))];
        if (region < 0 || region != region_of[to_size(topology.edges()(e, 1))])
            continue;
        crossings.fold_of_edge[to_size(e)] = region;
        edges[to_size(region)].push_back(e);
        if (largest[e] > still)
            crossings.folds[to_size(region)].edges.push_back(e);
    }
    double sum = 0.0;
    double weights = 0.0;
    for (std::size_t r = 0; r < regions.size(); ++r) {
        FoldCrossing& fold = crossings.folds[r];
        fold.centre = cheapest_centre(edges[r], first, second, width);
        const auto weight = static_cast<double>(fold.edges.size());
        sum += weight * fold.centre;
        weights += weight;
    }
    crossings.centre = weights > 0.0 ? sum / weights : 0.5 * static_cast<double>(first.size() - 1);
    return crossings;
}

} // namespace shape::internal
