// SPDX-License-Identifier: MIT

#include "libshape/model/difference.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <type_traits>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/statistics/grouping.h"
#include "libshape/statistics/mean.h"

namespace shape {
using namespace internal;
namespace {

/// Members of one group: value of the pairing label -> indices of the meshes.
using Group = std::map<std::string, std::vector<std::size_t>>;

Group find_group(const Collection& collection, const LabelColumn& pair_by, const std::string& label,
                 const std::string& value)
{
    const LabelColumn& column = find_label(collection.labels, label);
    Group group;
    for (std::size_t i = 0; i < collection.size(); ++i) {
        if (column.values[i] != value || pair_by.values[i].empty()) // no value, no partner
            continue;
        group[pair_by.values[i]].push_back(i);
    }
    if (group.empty())
        throw InvalidInput(join("difference: no mesh has ", label, " = '", value,
                                "' and a value of ", pair_by.name));
    return group;
}

/// What is compared: the `from` members, then the `to` members, paired in the same order.
struct Compared
{
    Collection members;
    Eigen::Index from_count = 0;    ///< Rows.
    std::vector<std::string> pairs; ///< Values of the pairing label; none: two groups.
    Grouping rows;                  ///< Of the members: those that count once, by their mean.
};

Compared find_pairs(const Collection& collection, const DifferenceOptions& options)
{
    const LabelColumn& pair_by = find_label(collection.labels, options.pair_by);
    const Group from = find_group(collection, pair_by, options.from_label, options.from_value);
    const Group to = find_group(collection, pair_by, options.to_label, options.to_value);
    Compared compared{{collection.topology, {}, {}, {}}, 0, {}, {}};
    for (const auto& [value, meshes] : from)
        if (to.contains(value))
            compared.pairs.push_back(value);
    if (compared.pairs.empty())
        throw InvalidInput(join("difference: no ", options.pair_by, " has both ",
                                options.from_label, " = '", options.from_value, "' and ",
                                options.to_label, " = '", options.to_value, "'"));
    for (const Group* side : {&from, &to})
        for (const std::string& value : compared.pairs) {
            for (const std::size_t mesh : side->at(value)) {
                compared.members.names.push_back(collection.names[mesh]);
                compared.members.points.push_back(collection.points[mesh]);
                compared.rows.group_of.push_back(compared.rows.group_count());
            }
            compared.rows.names.push_back(value);
        }
    compared.from_count = static_cast<Eigen::Index>(compared.pairs.size());
    return compared;
}

std::vector<std::size_t> meshes_with(const Collection& collection, const std::string& label,
                                     const std::string& value)
{
    const LabelColumn& column = find_label(collection.labels, label);
    std::vector<std::size_t> meshes;
    for (std::size_t i = 0; i < collection.size(); ++i)
        if (column.values[i] == value)
            meshes.push_back(i);
    if (meshes.empty())
        throw InvalidInput(join("difference: no mesh has ", label, " = '", value, "'"));
    return meshes;
}

Compared find_groups(const Collection& collection, const DifferenceOptions& options)
{
    std::vector<std::size_t> meshes =
        meshes_with(collection, options.from_label, options.from_value);
    const auto count = static_cast<Eigen::Index>(meshes.size());
    for (const std::size_t i : meshes_with(collection, options.to_label, options.to_value)) {
        if (std::find(meshes.begin(), meshes.begin() + count, i) != meshes.begin() + count)
            throw InvalidInput(join("difference: ", collection.names[i], " has both ",
                                    options.from_label, " = '", options.from_value, "' and ",
                                    options.to_label, " = '", options.to_value, "'"));
        meshes.push_back(i);
    }
    return {subset(collection, meshes),
            count,
            {},
            groups_of_one(static_cast<Eigen::Index>(meshes.size()))};
}

Compared find_compared(const Collection& collection, const DifferenceOptions& options)
{
    check(options);
    return options.pair_by.empty() ? find_groups(collection, options)
                                   : find_pairs(collection, options);
}

/// What is compared, each row once.
ShapeVectors vectors_of(const Compared& compared, Scale scale)
{
    ShapeVectors vectors = shape_vectors(compared.members, scale);
    if (compared.rows.group_count() == compared.rows.size())
        return vectors;
    const std::vector<std::vector<int>> rows = members(compared.rows);
    const auto average = [&](auto& all) {
        std::decay_t<decltype(all)> means(std::ssize(rows), all.cols());
        for (std::size_t row = 0; row < rows.size(); ++row)
            means.row(static_cast<Eigen::Index>(row)) = all(rows[row], Eigen::all).colwise().mean();
        all = std::move(means);
    };
    average(vectors.edge_lengths);
    average(vectors.dihedral_angles);
    Eigen::VectorXd sizes(std::ssize(rows));
    for (std::size_t row = 0; row < rows.size(); ++row)
        sizes[static_cast<Eigen::Index>(row)] = vectors.sizes(rows[row]).mean();
    vectors.sizes = std::move(sizes);
    return vectors;
}

} // namespace

void check(const DifferenceOptions& options)
{
    require(!options.from_label.empty(), "DifferenceOptions.from_label", "empty", "a label");
    require(!options.to_label.empty(), "DifferenceOptions.to_label", "empty", "a label");
    require(options.from_label != options.to_label || options.from_value != options.to_value,
            "DifferenceOptions.to_value", options.to_value, "another group than that of the start");
}

DifferenceVector mean_difference(const Collection& collection, const DifferenceOptions& options)
{
    Compared compared = find_compared(collection, options);
    const ShapeVectors vectors = vectors_of(compared, options.scale);
    const Eigen::Index from = compared.from_count;
    const Eigen::Index to = vectors.sizes.size() - from;
    const auto mean_change = [&](const RowMatrix& rows) -> Eigen::VectorXd {
        if (!compared.pairs.empty())
            return mean_of_rows(rows.bottomRows(to) - rows.topRows(from));
        return mean_of_rows(rows.bottomRows(to)) - mean_of_rows(rows.topRows(from));
    };
    return {.topology = compared.members.topology,
            .reference_points = compared.members.points.front(),
            .scale = options.scale,
            .mean_edge_lengths = mean_of_rows(vectors.edge_lengths.topRows(from)),
            .mean_dihedral_angles = mean_of_rows(vectors.dihedral_angles.topRows(from)),
            .edge_lengths = mean_change(vectors.edge_lengths),
            .dihedral_angles = mean_change(vectors.dihedral_angles),
            .from_size = vectors.sizes.head(from).mean(),
            .to_size = vectors.sizes.tail(to).mean(),
            .pairs = std::move(compared.pairs)};
}

ColumnEffects difference_effects(const Collection& collection, const DifferenceOptions& options)
{
    const Compared compared = find_compared(collection, options);
    const ShapeVectors vectors = vectors_of(compared, options.scale);
    const Eigen::Index from = compared.from_count;
    const auto check_count = [](const std::string& label, const std::string& value,
                                Eigen::Index count) {
        if (count < 2)
            throw InvalidInput(join("effects need two or more meshes, or pairs of them; of ", label,
                                    " = '", value, "' there is ", count));
    };
    check_count(options.from_label, options.from_value, from);
    check_count(options.to_label, options.to_value, vectors.sizes.size() - from);
    const RowMatrix first = vectors.edge_lengths.topRows(from);
    const RowMatrix second = vectors.edge_lengths.bottomRows(vectors.sizes.size() - from);
    return compared.pairs.empty() ? independent_effects(first, second)
                                  : paired_effects(first, second);
}

ShapePoint start_of(const DifferenceVector& difference, double size)
{
    if (difference.scale == Scale::None)
        return {difference.mean_edge_lengths, difference.mean_dihedral_angles};
    if (!(size > 0.0 && std::isfinite(size)))
        throw InvalidInput(join("difference: size is ", size, ", must be > 0 and finite"));
    return {size * difference.mean_edge_lengths, difference.mean_dihedral_angles};
}

ShapePoint apply_differences(const ShapePoint& start,
                             const std::vector<DifferenceVector>& differences,
                             const std::vector<double>& amounts)
{
    if (amounts.size() != differences.size())
        throw InvalidInput(join("difference: ", amounts.size(), " amounts for ", differences.size(),
                                " differences"));
    const double size = start.edge_lengths.sum();
    ShapePoint point = start;
    for (std::size_t k = 0; k < differences.size(); ++k) {
        const DifferenceVector& difference = differences[k];
        if (!std::isfinite(amounts[k]))
            throw InvalidInput(
                join("difference: amount ", k, " is ", amounts[k], ", must be finite"));
        if (difference.edge_lengths.size() != start.edge_lengths.size() ||
            !(difference.topology == differences.front().topology))
            throw InvalidInput(join("difference: difference ", k, " has another triangulation (",
                                    difference.edge_lengths.size(), " edges) than the shape (",
                                    start.edge_lengths.size(), " edges) or the first one"));
        if (difference.scale != differences.front().scale)
            throw InvalidInput(
                join("difference: difference ", k, " has another scale than the first one"));
        const double factor = difference.scale == Scale::Unit ? size : 1.0;
        point.edge_lengths += amounts[k] * factor * difference.edge_lengths;
        point.dihedral_angles += amounts[k] * difference.dihedral_angles;
    }
    return point;
}

} // namespace shape
