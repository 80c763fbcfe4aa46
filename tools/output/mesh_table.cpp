// SPDX-License-Identifier: MIT

#include "tools/output/mesh_table.h"

#include <set>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape::tools {
using namespace internal;

Table mesh_table(const std::vector<std::string>& names, const Labels& labels)
{
    Table table{{"mesh"}, {}};
    for (const LabelColumn& label : labels)
        table.columns.push_back(label.name);
    for (std::size_t i = 0; i < names.size(); ++i) {
        std::vector<std::string>& row = table.rows.emplace_back();
        row.push_back(names[i]);
        for (const LabelColumn& label : labels)
            row.push_back(label.values[i]);
    }
    return table;
}

void check_columns(const Table& table)
{
    std::set<std::string> seen;
    for (const std::string& column : table.columns)
        if (!seen.insert(column).second)
            throw InvalidInput(join("the label '", column,
                                    "' has the name of another column of the table; rename it"));
}

} // namespace shape::tools
