// SPDX-License-Identifier: MIT

#include "tools/input/label_input.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/label_doubts.h"
#include "libshape/io/label_file.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/oddities.h"
#include "tools/input/complete_labels.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

/// The column of which every mesh has a value.
const LabelColumn& complete_label(const MeshLabels& meshes, const std::string& label,
                                  const std::string& remedy)
{
    const LabelColumn& column = find_label(meshes.labels, label);
    const auto missing = std::find(column.values.begin(), column.values.end(), "");
    if (missing != column.values.end()) {
        const auto mesh = to_size(missing - column.values.begin());
        const auto count = std::count(missing, column.values.end(), "");
        const char* const those = count > 1 ? "them" : "it";
        throw InvalidInput(
            join("mesh ", meshes.names[mesh],
                 count > 1 ? join(" and ", counted(count - 1, "other"), " have") : " has",
                 " no value of label '", label, "' (", count, " of ",
                 counted(meshes.size(), "mesh", "meshes"), "); leave ", those, " out (", remedy,
                 ") or label ", those));
    }
    return column;
}

/// Which of the wanted values of labels no mesh has, and which there are; empty if all occur.
std::string values_that_do_not_occur(const std::map<std::string, std::set<std::string>>& wanted,
                                     const Labels& labels)
{
    for (const auto& [label, values] : wanted) {
        std::set<std::string> there;
        for (const std::string& value : find_label(labels, label).values)
            if (!value.empty())
                there.insert(value);
        for (const std::string& value : values)
            if (!there.contains(value)) {
                const std::vector<std::string> list(there.begin(), there.end());
                return join("; no mesh has ", label, " = '", value, "', there are ",
                            list_names(list));
            }
    }
    return {};
}

std::string only(const std::string& label)
{
    return "--only " + label;
}

/// Sums of squares are what covariates go into.
void check_magnitude(const std::string& label, const Eigen::VectorXd& values)
{
    const double largest = values.cwiseAbs().maxCoeff();
    const double squares = values.squaredNorm();
    const bool overflows = !std::isfinite(squares);
    if (overflows || (largest > 0.0 && squares < std::numeric_limits<double>::min()))
        throw InvalidInput(join("label '", label, "': the squares of numbers as ",
                                overflows ? "large" : "small", " as ", largest,
                                overflows ? " overflow" : " underflow",
                                " double precision; give them in another unit"));
}

} // namespace

void add_labelled_input(CLI::App& command, LabelledInput& input)
{
    add_mesh_input(command, input.meshes);
    command
        .add_option("--labels", input.meshes.labels,
                    "CSV file of labels: first column `mesh` (file stem), further columns are\n"
                    "labels (default: the labels of the collection files)")
        ->option_text("FILE");
    command
        .add_option(
            "--only", input.only,
            "Use only meshes whose label has this value, or any value (LABEL alone); may be\n"
            "repeated: values of the same label are alternatives, conditions on other labels\n"
            "must hold as well")
        ->option_text("LABEL[=VALUE]")
        ->allow_extra_args(false);
}

CLI::Option* add_label(CLI::App& command, const std::string& option, std::string& label,
                       const std::string& description)
{
    return command.add_option(option, label, description)->option_text("LABEL");
}

std::vector<std::size_t> chosen_meshes(const std::vector<std::string>& only, const Labels& labels,
                                       std::size_t count)
{
    std::map<std::string, std::set<std::string>> wanted; // no value: any
    std::set<std::string> labelled;
    for (const std::string& text : only) {
        if (text.find('=') == std::string::npos) {
            labelled.insert(label_name(text));
            continue;
        }
        const auto [label, value] = label_and_value("--only", text);
        wanted[label].insert(value);
    }
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < count; ++i)
        if (std::all_of(wanted.begin(), wanted.end(),
                        [&](const auto& rule) {
                            return rule.second.contains(find_label(labels, rule.first).values[i]);
                        }) &&
            std::all_of(labelled.begin(), labelled.end(), [&](const std::string& label) {
                return !find_label(labels, label).values[i].empty();
            }))
            kept.push_back(i);
    if (kept.empty())
        throw InvalidInput(join("--only leaves no mesh", values_that_do_not_occur(wanted, labels)));
    return kept;
}

Collection read_labelled(const Session& session, const LabelledInput& input)
{
    for (const std::string& text : input.only)
        if (text.find('=') != std::string::npos)
            (void)label_and_value("--only", text); // refused before anything is read
    Collection collection = read_meshes(session, input.meshes);
    if (input.only.empty())
        return collection;
    return subset(collection, chosen_meshes(input.only, collection.labels, collection.size()));
}

std::pair<std::string, std::string> label_and_value(const std::string& option,
                                                    const std::string& text)
{
    const std::size_t sign = text.find('=');
    if (sign == std::string::npos || sign == 0)
        throw UsageError(join(option, ": '", text, "' must be LABEL=VALUE"));
    const std::string label = label_name(text.substr(0, sign));
    const std::string value = label_value(text.substr(sign + 1));
    if (value.empty())
        throw UsageError(join(option, ": '", text,
                              "' names no value (empty, NA, NaN, NULL and so on "
                              "mean that a mesh has none); `--only ",
                              label, "` takes the meshes that have one"));
    return {label, value};
}

Grouping group_by_label(const MeshLabels& meshes, const std::string& label)
{
    return group_by_label(meshes, label, only(label));
}

Grouping group_by_label(const MeshLabels& meshes, const std::string& label,
                        const std::string& remedy)
{
    return group_by(complete_label(meshes, label, remedy).values);
}

Grouping group_by_label_or_all(const MeshLabels& meshes, const std::string& label)
{
    return label.empty() ? one_group(static_cast<Eigen::Index>(meshes.size()))
                         : group_by_label(meshes, label);
}

Grouping group_by_label_or_each(const MeshLabels& meshes, const std::string& label)
{
    return label.empty() ? group_by(meshes.names) : group_by_label(meshes, label);
}

double number_of_label(const LabelColumn& label, std::size_t mesh,
                       const std::vector<std::string>& names, const std::string& place,
                       const std::string& remedy)
{
    try {
        return parse_number(label.values[mesh], join(place, place.empty() ? "" : ": ", "label '",
                                                     label.name, "' of mesh ", names[mesh]));
    } catch (const InvalidInput& error) {
        throw InvalidInput(join(error.what(), remedy));
    }
}

Eigen::MatrixXd covariates_of(const MeshLabels& meshes, const Eigen::VectorXd& sizes,
                              const std::vector<std::string>& columns, const std::string& table)
{
    Eigen::MatrixXd result(sizes.size(), static_cast<Eigen::Index>(columns.size()));
    for (std::size_t c = 0; c < columns.size(); ++c) {
        const auto column = static_cast<Eigen::Index>(c);
        if (columns[c] == "size") {
            if (std::ranges::any_of(meshes.labels,
                                    [](const LabelColumn& l) { return l.name == "size"; }))
                throw InvalidInput(
                    "'size' is the size of a mesh here, and a label is called so too: rename the "
                    "label");
            result.col(column) = sizes;
            continue;
        }
        const LabelColumn& label = complete_label(meshes, columns[c], only(columns[c]));
        for (std::size_t i = 0; i < meshes.size(); ++i)
            result(static_cast<Eigen::Index>(i), column) =
                number_of_label(label, i, meshes.names, table,
                                join("; correct it, or leave the cell empty and the mesh out (",
                                     only(label.name), ")"));
        check_magnitude(columns[c], result.col(column));
    }
    return result;
}

void warn_of_missing_codes(const Session& session, const LabelledInput& input, const Labels& labels,
                           const std::vector<std::string>& columns)
{
    if (!input.meshes.labels.empty())
        return; // said when that was read
    for (const LabelColumn& label : labels)
        if (std::find(columns.begin(), columns.end(), label.name) != columns.end())
            if (const auto doubt = doubt_about_numbers(label))
                session.warn(*doubt);
}

Eigen::MatrixXd codes(const Grouping& groups)
{
    Eigen::MatrixXd column(groups.size(), 1);
    for (Eigen::Index i = 0; i < groups.size(); ++i)
        column(i, 0) = groups.group_of[to_size(i)];
    return column;
}

} // namespace shape::tools
