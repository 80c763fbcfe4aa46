// SPDX-License-Identifier: MIT

#include "tools/output/model_tables.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

namespace shape::tools {

Json mode_figures(const ShapeModel& model)
{
    Json modes = Json::array();
    double cumulative = 0.0;
    for (int k = 0; k < model.mode_count(); ++k) {
        cumulative += model.variances[k];
        const FeasibleRange range = feasible_range(model, k, feasible_reach);
        modes.push_back({{"mode", k + 1},
                         {"variance", model.variances[k]},
                         {"share", model.variances[k] / model.total_variance},
                         {"cumulative", cumulative / model.total_variance},
                         {"feasible_low", range.low},
                         {"feasible_high", range.high}});
    }
    return modes;
}

std::string mode_table(const Json& figures)
{
    std::string table = "mode      variance     share  cumulative  feasible range [std. dev.]\n";
    for (const Json& mode : figures) {
        char row[128];
        std::snprintf(row, sizeof row, "%4d  %12.6g  %7.3f%%  %9.3f%%  %6.2f to %.2f\n",
                      mode["mode"].get<int>(), mode["variance"].get<double>(),
                      100.0 * mode["share"].get<double>(), 100.0 * mode["cumulative"].get<double>(),
                      mode["feasible_low"].get<double>(), mode["feasible_high"].get<double>());
        table += row;
    }
    return table;
}

Json label_figures(const Labels& labels)
{
    Json figures = Json::object();
    for (const LabelColumn& column : labels) {
        std::set<std::string_view> values(column.values.begin(), column.values.end());
        values.erase(""); // missing
        figures[column.name] = values.size();
    }
    return figures;
}

} // namespace shape::tools
