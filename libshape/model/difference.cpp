// SPDX-License-Identifier: MIT

#include "libshape/model/difference.h"

#include <cmath>
#include <map>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/statistics/mean.h"

namespace shape {
using namespace internal;
namespace {

/// Members of one group: value of the pairing label -> index of the mesh.
using Group = std::map<std::string, std::size_t>;

Group find_group(const Collection& collection, const LabelColumn& pair_by, const std::string& label,
                 const std::string& value)
{
    const LabelColumn& column = find_label(collection.labels, label);
    Group group;
    for (std::size_t i = 0; i < collection.size(); ++i) {
        if (column.values[i] != value || pair_by.values[i].empty()) // no value, no partner
            continue;
        const auto [member, is_new] = group.try_emplace(pair_by.values[i], i);
        if (!is_new)
            throw InvalidInput(join("difference: ", pair_by.name, " '", pair_by.values[i],
                                    "' occurs twice among ", label, " = '", value,
                                    "': ", collection.names[member->second], " and ",
                                    collection.names[i]));
    }
    if (group.empty())
        throw InvalidInput(join("difference: no mesh has ", label, " = '", value,
                                "' and a value of ", pair_by.name));
    return group;
}

/// The `from` members of all pairs, then the `to` members in the same order.
Collection pair_up(const Collection& collection, const Group& from, const Group& to,
                   std::vector<std::string>& pairs)
{
    Collection paired{collection.topology, {}, {}, {}};
    const auto append = [&](std::size_t mesh) {
        paired.names.push_back(collection.names[mesh]);
        paired.points.push_back(collection.points[mesh]);
    };
    for (const auto& [value, mesh] : from)
        if (to.contains(value)) {
            pairs.push_back(value);
            append(mesh);
        }
    for (const std::string& value : pairs)
        append(to.at(value));
    return paired;
}

/// The pairs of a collection: the `from` members, then the `to` members in the same order.
struct Pairs
{
    Collection members;
    std::vector<std::string> values; ///< Their values of the pairing label.
};

Pairs find_pairs(const Collection& collection, const DifferenceOptions& options)
{
    check(options);
    const LabelColumn& pair_by = find_label(collection.labels, options.pair_by);
    const Group from = find_group(collection, pair_by, options.from_label, options.from_value);
    const Group to = find_group(collection, pair_by, options.to_label, options.to_value);
    std::vector<std::string> pairs;
    const Collection paired = pair_up(collection, from, to, pairs);
    if (pairs.empty())
        throw InvalidInput(join("difference: no ", options.pair_by, " has both ",
                                options.from_label, " = '", options.from_value, "' and ",
                                options.to_label, " = '", options.to_value, "'"));
    return {paired, std::move(pairs)};
}

} // namespace

void check(const DifferenceOptions& options)
{
    require(!options.pair_by.empty(), "DifferenceOptions.pair_by", "empty", "a label");
    require(!options.from_label.empty(), "DifferenceOptions.from_label", "empty", "a label");
    require(!options.to_label.empty(), "DifferenceOptions.to_label", "empty", "a label");
}

DifferenceVector mean_difference(const Collection& collection, const DifferenceOptions& options)
{
    auto [paired, pairs] = find_pairs(collection, options);
    const ShapeVectors vectors = shape_vectors(paired, options.scale);
    const auto count = static_cast<Eigen::Index>(pairs.size());
    const auto mean_change = [&](const RowMatrix& rows) {
        return mean_of_rows(rows.bottomRows(count) - rows.topRows(count));
    };
    return {.topology = paired.topology,
            .reference_points = paired.points.front(),
            .scale = options.scale,
            .mean_edge_lengths = mean_of_rows(vectors.edge_lengths.topRows(count)),
            .mean_dihedral_angles = mean_of_rows(vectors.dihedral_angles.topRows(count)),
            .edge_lengths = mean_change(vectors.edge_lengths),
            .dihedral_angles = mean_change(vectors.dihedral_angles),
            .from_size = vectors.sizes.head(count).mean(),
            .to_size = vectors.sizes.tail(count).mean(),
            .pairs = std::move(pairs)};
}

ColumnEffects difference_effects(const Collection& collection, const DifferenceOptions& options)
{
    const Pairs pairs = find_pairs(collection, options);
    const ShapeVectors vectors = shape_vectors(pairs.members, options.scale);
    const auto count = static_cast<Eigen::Index>(pairs.values.size());
    return paired_effects(vectors.edge_lengths.topRows(count),
                          vectors.edge_lengths.bottomRows(count));
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
