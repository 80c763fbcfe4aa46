// SPDX-License-Identifier: MIT

#include "libshape/mesh/joined_labels.h"

#include <algorithm>

namespace shape::internal {

void append_labels(Labels& all, std::size_t before, const Labels& added, std::size_t count)
{
    const auto column_of = [&](const std::string& name) -> LabelColumn& {
        const auto found = std::find_if(all.begin(), all.end(),
                                        [&](const LabelColumn& c) { return c.name == name; });
        if (found != all.end())
            return *found;
        return all.emplace_back(LabelColumn{name, std::vector<std::string>(before)});
    };
    for (const LabelColumn& column : added) {
        std::vector<std::string>& values = column_of(column.name).values;
        values.insert(values.end(), column.values.begin(), column.values.end());
    }
    for (LabelColumn& column : all)
        column.values.resize(before + count);
}

} // namespace shape::internal
