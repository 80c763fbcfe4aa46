// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/base/ranks.h"

namespace shape::tools {

/// The processes that `mpirun` has started with this one; a single one without it.
[[nodiscard]] const Ranks& ranks();

/// Joins them, if the program was started by mpirun.
/// @throws UsageError if the program was built without MPI, or their number is not a power of two.
void join_ranks();

/// Leaves them: all end well together, or, where one has failed, all with its exit code at once.
/// @return The exit code.
int leave_ranks(int exit_code);

/// Whether this process is to say why it fails. Where all have failed alike the first one does, and ends the
/// others meanwhile; so they wait a little.
/// @param is_interrupted  Told to stop: so are the others, by mpirun if not before. The first one speaks or, should
///     it have been killed, the second.
[[nodiscard]] bool is_to_speak(bool is_interrupted);

/// Waits for all of them to come here.
void wait_for_ranks();

} // namespace shape::tools
