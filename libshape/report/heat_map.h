// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libshape/statistics/hierarchical_clustering.h"

namespace shape {

/// Distances between N things, with the tree that orders them.
struct HeatMap
{
    std::string title; ///< May be empty.
    std::vector<std::string> names;
    std::vector<std::string> label_values; ///< N, or empty: no strip of colours.
    Eigen::MatrixXd distances;             ///< N by N.
    Clustering clustering;
};

/// Draws the distances in the order of the tree: dark where things are near. The tree stands on top,
/// the labels in a strip of category colours with a legend, names where cells are large enough.
/// @throws InvalidInput if the sizes disagree.
[[nodiscard]] std::string heat_map_svg(const HeatMap& map);

} // namespace shape
