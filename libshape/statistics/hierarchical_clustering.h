// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

namespace shape {

/// Two clusters that become one. Clusters 0 to N - 1 are the observations, N + k is that of merge k.
struct Merge
{
    int first = -1;  ///< The one with the lowest observation of both ...
    int second = -1; ///< ... and the other.
    double height = 0.0;
    int count = 0; ///< Observations in the new cluster.
};

/// A binary tree over N observations.
struct Clustering
{
    std::vector<Merge> merges; ///< N - 1, heights ascending.
    std::vector<int> order;    ///< The observations as a drawing of the tree has them, first before
                               ///< second: clusters are runs of it.
};

/// Average linkage (UPGMA; Sokal and Michener 1958): the two clusters merge whose observations are
/// nearest on average, at that distance as height, until one is left. Among equal distances the
/// observations with lower indices decide. Single linkage, at one height, is in close_rows.h.
///
/// @param distances  N by N, see check_distances().
/// @throws InvalidInput if that rule is broken.
/// Cost: O(N^2), by chains of nearest neighbours (Murtagh 1983).
[[nodiscard]] Clustering cluster_by_average_linkage(Eigen::MatrixXd distances);

/// For each position of the order after the first, the height at which the observation there and
/// the one before it are in one cluster; N entries, the first 0.
[[nodiscard]] std::vector<double> joining_heights(const Clustering& clustering);

} // namespace shape
