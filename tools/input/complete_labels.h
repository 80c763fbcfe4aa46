// SPDX-License-Identifier: MIT

#pragma once

#include <string>

#include "tools/input/label_input.h"

namespace shape::tools {

/// group_by_label() for hosts that have no options.
/// @param remedy  How meshes without a value are left out, for the message.
[[nodiscard]] Grouping group_by_label(const MeshLabels& meshes, const std::string& label,
                                      const std::string& remedy);

} // namespace shape::tools
