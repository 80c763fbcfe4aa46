// SPDX-License-Identifier: MIT

#include "tools/output/test_tables.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libshape/base/format.h"
#include "libshape/io/table_file.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;

void add_permutations(CLI::App& command, std::int64_t& permutations)
{
    add_integer(command, "--permutations", permutations,
                join("Random permutations of a test (see --seed), [0, 10000000] (default: ",
                     permutations, ");\nthe smallest p-value is 1 / (permutations + 1)"),
                0, 10'000'000);
}

void add_covariates(CLI::App& command, const std::string& option, std::vector<std::string>& columns,
                    const std::string& description)
{
    command.add_option(option, columns, description)
        ->option_text("LABEL|size")
        ->allow_extra_args(false);
}

Json test_figures(const LinearModelTest& test)
{
    return {{"df", test.degrees_of_freedom},
            {"residual_df", test.residual_degrees_of_freedom},
            {"sum_of_squares", test.sum_of_squares},
            {"residual_sum_of_squares", test.residual_sum_of_squares},
            {"r_squared", test.r_squared},
            {"f", std::isfinite(test.f) ? Json(test.f) : Json()},
            {"p_value", test.permutations > 0 ? Json(test.p_value) : Json()},
            {"permutations", test.permutations}};
}

std::vector<std::string> test_columns()
{
    const Json figures = test_figures({});
    std::vector<std::string> columns;
    for (const auto& field : figures.items())
        columns.push_back(field.key());
    return columns;
}

std::vector<std::string> test_cells(const LinearModelTest& test)
{
    std::vector<std::string> cells;
    const Json figures = test_figures(test);
    for (const auto& [key, field] : figures.items())
        cells.push_back(field.is_null() ? (key == "f" && std::isinf(test.f) ? "inf" : "")
                        : field.is_number_integer() ? std::to_string(field.get<int>())
                                                    : print_number(field.get<double>()));
    return cells;
}

std::string describe(const LinearModelTest& test)
{
    if (test.residual_degrees_of_freedom == 0)
        return "too few meshes for a test";
    char text[160];
    std::snprintf(text, sizeof text, "F(%d, %d) = %.4g, R^2 = %.4g", test.degrees_of_freedom,
                  test.residual_degrees_of_freedom, test.f, test.r_squared);
    if (test.permutations == 0)
        return join(text, ", not tested");
    char p[40];
    std::snprintf(p, sizeof p, ", p = %.4g", test.p_value);
    return join(text, p);
}

} // namespace shape::tools
