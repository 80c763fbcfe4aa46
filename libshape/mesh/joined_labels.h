// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>

#include "libshape/mesh/labels.h"

namespace shape::internal {

/// Appends the labels of `count` meshes to those of the `before` meshes that stand already. Where one has a
/// label that the other lacks, its values are empty there.
void append_labels(Labels& all, std::size_t before, const Labels& added, std::size_t count);

} // namespace shape::internal
