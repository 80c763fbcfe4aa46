// SPDX-License-Identifier: MIT

#pragma once

namespace shape::tools {

/// From now on arrays of 4 MiB and more go back to the system when they are freed. The C library
/// would keep the room of most of them, and a run would hold what it no longer needs.
void return_large_arrays();

/// Gives back what was freed in small pieces, such as a collection. Before a step that needs much.
void return_freed_memory();

} // namespace shape::tools
