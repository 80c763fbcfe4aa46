// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace shape {

/// One labelled column of a collection: values[i] belongs to mesh i.
struct LabelColumn
{
    std::string name;
    std::vector<std::string> values;
};

/// Labels of the meshes of a collection, in the order of the columns of their file.
using Labels = std::vector<LabelColumn>;

/// The column with that name.
/// @throws InvalidInput if there is none; the message lists those that exist.
[[nodiscard]] const LabelColumn& find_label(const Labels& labels, std::string_view name);

} // namespace shape
