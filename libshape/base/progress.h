// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <functional>
#include <string_view>

namespace shape {

/// Called by long work after each unit: what is being done, units done, units in all.
/// May throw Interrupted to stop the work; nothing half-done is kept then. An empty function is
/// never called. Calls come from one thread at a time.
using Progress = std::function<void(std::string_view stage, std::size_t done, std::size_t total)>;

} // namespace shape
