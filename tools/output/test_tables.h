// SPDX-License-Identifier: MIT

#pragma once

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

/// The fields df, residual_df, sum_of_squares, residual_sum_of_squares, r_squared, f (null if
/// infinite), p_value and permutations.
[[nodiscard]] Json test_figures(const LinearModelTest& test);

/// The same as columns of a table.
[[nodiscard]] std::vector<std::string> test_columns();
[[nodiscard]] std::vector<std::string> test_cells(const LinearModelTest& test);

/// "F(2, 398) = 74.1, R^2 = 0.12, p = 0.001".
[[nodiscard]] std::string describe(const LinearModelTest& test);

} // namespace shape::tools
