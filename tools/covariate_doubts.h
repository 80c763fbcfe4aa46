// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "libshape/statistics/grouping.h"

// What commands say of slopes that hang on few meshes or blocks, and of numbers that are taken for groups.

namespace shape::tools {

/// The same in all members of a block but for a few blocks, which after a slip in a table make a test within blocks of
/// one between them. Of blocks of several meshes, those in which the covariate varies must have half of the meshes.
/// @param option  "--on age".
/// @param within  The label of the blocks.
[[nodiscard]] std::optional<std::string> doubt_about_varying_blocks(
    const Eigen::VectorXd& covariate, const Grouping& blocks, const std::string& option,
    const std::string& within);

/// How much of a slope each of some things determines, of sum 1.
/// @param weights  N: of the meshes in the slope.
/// @param rows  Of the meshes: those that count together.
/// @param carriers  Of the meshes: the things, each of some of these rows.
[[nodiscard]] Eigen::VectorXd slope_shares(const Eigen::VectorXd& weights, const Grouping& rows,
                                           const Grouping& carriers);

/// The same where each is a row and has a mean in common with others, which is what these make it: 1 of one value far away, not
/// 1 - 1 / n. Of fewer than eight rows as they are: of few, one is easily farther than the others.
/// @param means  Of the rows: those that have a mean in common.
[[nodiscard]] Eigen::VectorXd shares_beyond_means(Eigen::VectorXd shares, const Grouping& rows,
                                                  const Grouping& means);

/// Where one of them alone determines a slope: more than determining_share of it (group_fit.h).
/// @param carriers  Of the values of the covariate.
/// @param shares  Of the carriers.
/// @param within  The label of carriers that are blocks; empty if they are meshes.
[[nodiscard]] std::optional<std::string> doubt_about_slope(const Eigen::VectorXd& covariate,
                                                           const Grouping& carriers,
                                                           const Eigen::VectorXd& shares,
                                                           const std::string& option,
                                                           const std::string& within);

/// Groups that are numbers, nearly all different: at least ten, and fewer than two meshes a group.
[[nodiscard]] std::optional<std::string> doubt_about_numeric_groups(const Grouping& groups,
                                                                    const std::string& by);

} // namespace shape::tools
