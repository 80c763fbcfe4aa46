// SPDX-License-Identifier: MIT

#include "libshape/mesh/joined_labels.h"

#include <algorithm>
#include <map>

namespace shape::internal {
namespace {

/// The column of that name, which is made if there is none.
LabelColumn& column_of(Labels& labels, const std::string& name, std::size_t meshes)
{
    const auto found = std::ranges::find(labels, name, &LabelColumn::name);
    if (found != labels.end())
        return *found;
    return labels.emplace_back(LabelColumn{name, std::vector<std::string>(meshes)});
}

} // namespace

void append_labels(Labels& all, std::size_t before, const Labels& added, std::size_t count)
{
    for (const LabelColumn& column : added) {
        std::vector<std::string>& values = column_of(all, column.name, before).values;
        values.insert(values.end(), column.values.begin(), column.values.end());
    }
    for (LabelColumn& column : all)
        column.values.resize(before + count);
}

std::vector<ReplacedLabel> take_labels(Labels& labels, const std::vector<std::string>& names,
                                       const Labels& from,
                                       const std::vector<std::string>& names_there)
{
    std::map<std::string, std::size_t> place;
    for (std::size_t i = 0; i < names_there.size(); ++i)
        place[names_there[i]] = i;
    std::vector<ReplacedLabel> replaced;
    for (const LabelColumn& column : from) {
        std::vector<std::string>& values = column_of(labels, column.name, names.size()).values;
        for (std::size_t i = 0; i < names.size(); ++i) {
            const auto there = place.find(names[i]);
            if (there == place.end() || column.values[there->second].empty())
                continue;
            const std::string& now = column.values[there->second];
            if (!values[i].empty() && values[i] != now)
                replaced.push_back({column.name, names[i], values[i], now});
            values[i] = now;
        }
    }
    return replaced;
}

} // namespace shape::internal
