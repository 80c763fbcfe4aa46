// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "libshape/mesh/labels.h"

namespace shape::internal {

/// Appends the labels of `count` meshes to those of the `before` meshes that stand already. Where one has a
/// label that the other lacks, its values are empty there.
void append_labels(Labels& all, std::size_t before, const Labels& added, std::size_t count);

/// A value of a label that gave way to another.
struct ReplacedLabel
{
    std::string label;
    std::string mesh;
    std::string before;
    std::string now;
};

/// Takes over the labels that meshes have elsewhere, by their names. A value that is empty there says nothing.
/// @return  What was another before.
std::vector<ReplacedLabel> take_labels(Labels& labels, const std::vector<std::string>& names,
                                       const Labels& from,
                                       const std::vector<std::string>& names_there);

} // namespace shape::internal
