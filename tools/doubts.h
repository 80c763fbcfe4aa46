// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "libshape/mesh/collection.h"
#include "libshape/model/difference.h"
#include "libshape/statistics/grouping.h"
#include "tools/input/repeated_rows.h"

// What commands say of data whose figures may mislead, for the Python package too, which does the work by itself.

namespace shape::tools {

/// Whether a block has members of both groups of a pair, which are compared within such blocks then.
[[nodiscard]] bool is_within_blocks(const Grouping& groups, const Grouping& blocks, int first,
                                    int second);

/// Of one slip in a table that makes a design of repeated scans a crossed one: if more than half of the meshes are left
/// out, as blocks of one group say nothing then.
/// @param by, within  The labels of groups and blocks.
[[nodiscard]] std::optional<std::string> doubt_about_lost_meshes(const Grouping& groups,
                                                                 const Grouping& blocks,
                                                                 const std::string& by,
                                                                 const std::string& within);

/// What a comparison of groups asks about rows.
[[nodiscard]] RepetitionQuestion rows_of_comparison(const Grouping& groups, const std::string& by);

/// How many pairs have several meshes on a side, whose mean counts; "" if none has.
[[nodiscard]] std::string describe_repeated_pairs(const DifferenceOptions& options,
                                                  const Collection& collection,
                                                  const std::vector<std::string>& pairs);

/// Of the meshes of two groups without pairs.
/// @param is_tested  Effects are; else the means alone count, in which whoever has more meshes weighs more.
[[nodiscard]] std::optional<std::string> doubt_about_members(const DifferenceOptions& options,
                                                             const Collection& collection,
                                                             bool is_tested);

} // namespace shape::tools
