// SPDX-License-Identifier: MIT

#include "libshape/statistics/hierarchical_clustering.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "libshape/base/to_size.h"
#include "libshape/statistics/distance_matrix.h"

namespace shape {
using namespace internal;
namespace {

/// A merge of the clusters that two observations are in.
struct Join
{
    int a = -1;
    int b = -1;
    double height = 0.0;
};

/// The joins in the order in which chains of nearest neighbours find them. A cluster stands in the
/// row of its lowest observation.
std::vector<Join> join_all(Eigen::MatrixXd& distances)
{
    const auto count = static_cast<int>(distances.rows());
    std::vector<int> active(to_size(count));
    std::iota(active.begin(), active.end(), 0);
    Eigen::VectorXd sizes = Eigen::VectorXd::Ones(count);
    std::vector<int> chain;
    std::vector<Join> joins;
    while (active.size() > 1) {
        if (chain.empty())
            chain.push_back(active.front());
        const int last = chain.back();
        const int before = chain.size() > 1 ? chain[chain.size() - 2] : -1;
        // The one before stays the nearest among equals: a chain must not run in circles.
        int nearest = before;
        double least =
            before < 0 ? std::numeric_limits<double>::infinity() : distances(last, before);
        for (const int other : active)
            if (other != last && distances(last, other) < least) {
                nearest = other;
                least = distances(last, other);
            }
        if (nearest != before) {
            chain.push_back(nearest);
            continue;
        }
        const int kept = std::min(last, before);
        const int gone = std::max(last, before);
        joins.push_back({kept, gone, least});
        chain.resize(chain.size() - 2);
        active.erase(std::find(active.begin(), active.end(), gone));
        const double share = sizes[kept] / (sizes[kept] + sizes[gone]);
        for (const int other : active)
            distances(kept, other) = distances(other, kept) =
                share * distances(kept, other) + (1.0 - share) * distances(gone, other);
        distances(kept, kept) = 0.0;
        sizes[kept] += sizes[gone];
    }
    return joins;
}

int root(std::vector<int>& parent, int node)
{
    while (parent[to_size(node)] != node)
        node = parent[to_size(node)] = parent[to_size(parent[to_size(node)])];
    return node;
}

/// Sorts the joins by height and names the clusters they join.
std::vector<Merge> sorted_merges(std::vector<Join> joins)
{
    std::stable_sort(joins.begin(), joins.end(),
                     [](const Join& x, const Join& y) { return x.height < y.height; });
    const int count = static_cast<int>(joins.size()) + 1;
    std::vector<int> parent(to_size(count)); // to the lowest observation
    std::iota(parent.begin(), parent.end(), 0);
    std::vector<int> cluster = parent; // at roots
    std::vector<int> sizes(parent.size(), 1);
    std::vector<Merge> merges;
    for (const Join& join : joins) {
        const int a = root(parent, join.a);
        const int b = root(parent, join.b);
        const auto kept = to_size(std::min(a, b));
        const auto gone = to_size(std::max(a, b));
        parent[gone] = std::min(a, b);
        sizes[kept] += sizes[gone];
        merges.push_back({cluster[kept], cluster[gone], join.height, sizes[kept]});
        cluster[kept] = count + static_cast<int>(merges.size()) - 1;
    }
    return merges;
}

} // namespace

Clustering cluster_by_average_linkage(Eigen::MatrixXd distances)
{
    check_distances(distances);
    Clustering clustering;
    clustering.merges = sorted_merges(join_all(distances));
    const auto count = static_cast<int>(distances.rows());
    std::vector<int> stack{2 * count - 2};
    while (!stack.empty()) {
        const int cluster = stack.back();
        stack.pop_back();
        if (cluster < count) {
            clustering.order.push_back(cluster);
            continue;
        }
        const Merge& merge = clustering.merges[to_size(cluster - count)];
        stack.push_back(merge.second);
        stack.push_back(merge.first);
    }
    return clustering;
}

std::vector<double> joining_heights(const Clustering& clustering)
{
    const std::size_t count = clustering.order.size();
    std::vector<double> heights(count, 0.0);
    // The first position of every cluster: that of the second of a merge is where it joins.
    std::vector<std::size_t> first(2 * count - 1);
    for (std::size_t position = 0; position < count; ++position)
        first[to_size(clustering.order[position])] = position;
    for (std::size_t k = 0; k < clustering.merges.size(); ++k) {
        const Merge& merge = clustering.merges[k];
        first[count + k] = first[to_size(merge.first)];
        heights[first[to_size(merge.second)]] = merge.height;
    }
    return heights;
}

} // namespace shape
