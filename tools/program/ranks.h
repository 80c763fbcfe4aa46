// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/base/ranks.h"

namespace shape::tools {

/// The processes that `mpirun` has started with this one; a single one without it.
[[nodiscard]] const Ranks& ranks();

/// Joins them, if the program was started by mpirun.
/// @throws UsageError if the program was built without MPI, or their number is no power of two.
void join_ranks();

/// Leaves them: all end well together, or, where one has failed, all with its exit code at once.
/// @return The exit code.
int leave_ranks(int exit_code);

/// Lets the first process speak where all have failed alike: it ends the others meanwhile. Should it have been
/// killed, the second one speaks.
/// @param is_interrupted  They have been told to stop, and mpirun kills those that are there a second later.
void let_first_rank_speak(bool is_interrupted);

/// Waits for all of them to come here.
void wait_for_ranks();

} // namespace shape::tools
