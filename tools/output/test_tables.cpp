// SPDX-License-Identifier: MIT

#include "tools/output/test_tables.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libshape/base/format.h"
#include "libshape/io/table_file.h"
#include "libshape/statistics/bootstrap.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;

void add_permutations(CLI::App& command, std::int64_t& permutations)
{
    add_integer(
        command, "--permutations", permutations,
        join("Random permutations of a test (see --seed), [0, 10000000] (default: ", permutations,
             ");\nthe smallest p-value is 1 / (permutations + 1), or 1 over the number of\n"
             "different ones if these are few: 0.1 of three meshes against three"),
        0, 10'000'000);
}

void add_covariates(CLI::App& command, const std::string& option, std::vector<std::string>& columns,
                    const std::string& description)
{
    command.add_option(option, columns, description)
        ->option_text("LABEL|size")
        ->allow_extra_args(false);
}

namespace {

/// null of what is NaN or infinite.
Json finite_or_null(double number)
{
    return std::isfinite(number) ? Json(number) : Json();
}

/// The figures that tables have too.
Json table_figures(const LinearModelTest& test)
{
    return {{"df", test.degrees_of_freedom},
            {"residual_df", test.residual_degrees_of_freedom},
            {"sum_of_squares", finite_or_null(test.sum_of_squares)},
            {"residual_sum_of_squares", finite_or_null(test.residual_sum_of_squares)},
            {"r_squared", finite_or_null(test.r_squared)},
            {"f", finite_or_null(test.f)},
            {"p_value", finite_or_null(test.p_value)},
            {"permutations", test.permutations}};
}

} // namespace

double smallest_p(const LinearModelTest& test)
{
    return std::max(test.smallest_p, 1.0 / (1.0 + test.permutations));
}

Json test_figures(const LinearModelTest& test)
{
    Json figures = table_figures(test);
    figures["smallest_p"] = test.permutations > 0 ? Json(smallest_p(test)) : Json();
    return figures;
}

std::vector<std::string> test_columns()
{
    const Json figures = table_figures({});
    std::vector<std::string> columns;
    for (const auto& field : figures.items())
        columns.push_back(field.key());
    return columns;
}

std::vector<std::string> test_cells(const LinearModelTest& test)
{
    std::vector<std::string> cells;
    const Json figures = table_figures(test);
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
    if (test.smallest_p * (1.0 + test.permutations) <= 1.0 + 1e-9)
        return join(text, p);
    char least[80];
    std::snprintf(least, sizeof least, " (so few meshes or blocks allow none below %.4g)",
                  test.smallest_p);
    return join(text, p, least);
}

std::optional<std::string> doubt_of_replicates(std::int64_t replicates)
{
    const int least = least_replicates(BootstrapOptions{}.confidence);
    if (replicates >= least)
        return std::nullopt;
    return join("a 95 % interval takes ", least, " replicates, here ",
                replicates == 1 ? "is " : "are ", replicates,
                ": of fewer even the smallest and the largest span less; none is given");
}

} // namespace shape::tools
