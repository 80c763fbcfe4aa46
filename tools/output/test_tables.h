// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libshape/statistics/linear_model.h"
#include "tools/program/session.h"

namespace CLI {
class App;
}

namespace shape::tools {

/// Adds --permutations.
void add_permutations(CLI::App& command, std::int64_t& permutations);

/// Adds an option that takes the name of a label of numbers, or `size`, and may be repeated.
void add_covariates(CLI::App& command, const std::string& option, std::vector<std::string>& columns,
                    const std::string& description);

/// That of the design, or of the number of permutations if that is larger.
[[nodiscard]] double smallest_p(const LinearModelTest& test);

/// The fields df, residual_df, sum_of_squares, residual_sum_of_squares, r_squared, f (null if
/// infinite), p_value, permutations and smallest_p; null of what was not tested.
[[nodiscard]] Json test_figures(const LinearModelTest& test);

/// The same as columns of a table, but for smallest_p.
[[nodiscard]] std::vector<std::string> test_columns();
[[nodiscard]] std::vector<std::string> test_cells(const LinearModelTest& test);

/// "F(2, 398) = 74.1, R^2 = 0.12, p = 0.001"; with the smallest p-value of the design where more permutations would
/// give no smaller one.
[[nodiscard]] std::string describe(const LinearModelTest& test);

/// Why a bootstrap of so many replicates has no intervals, if it has none.
[[nodiscard]] std::optional<std::string> doubt_of_replicates(std::int64_t replicates);

} // namespace shape::tools
