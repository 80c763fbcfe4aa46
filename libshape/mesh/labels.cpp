// SPDX-License-Identifier: MIT

#include "libshape/mesh/labels.h"

#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
using namespace internal;

const LabelColumn& find_label(const Labels& labels, std::string_view name)
{
    const auto found =
        std::find_if(labels.begin(), labels.end(), [&](const auto& c) { return c.name == name; });
    if (found != labels.end())
        return *found;
    std::string known;
    for (const LabelColumn& column : labels)
        known += (known.empty() ? "" : ", ") + column.name;
    throw InvalidInput(join("no label column '", name, "'; the collection has ",
                            known.empty() ? "no labels" : known));
}

} // namespace shape
