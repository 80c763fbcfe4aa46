// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

#include "libshape/io/table_file.h"
#include "libshape/mesh/labels.h"

namespace shape::tools {

/// A table with one row a mesh: the column `mesh` and the labels, to which further columns are added.
[[nodiscard]] Table mesh_table(const std::vector<std::string>& names, const Labels& labels);

/// Adds a column of numbers.
template <class Numbers>
void add_column(Table& table, const std::string& name, const Numbers& values)
{
    table.columns.push_back(name);
    auto row = table.rows.begin();
    for (const double value : values)
        (row++)->push_back(print_number(value));
}

/// @throws InvalidInput if two columns have one name: a label that is named as another column.
void check_columns(const Table& table);

} // namespace shape::tools
