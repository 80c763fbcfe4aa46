// SPDX-License-Identifier: MIT

#pragma once

namespace shape::tools {

/// Gives the process its processors back, of which the libraries saw one while they started.
///
/// OpenBLAS starts a thread for every processor it sees, before main() does anything, and each asks
/// for 128 MiB: where threads cannot be created that ends the process by a signal, and under a limit of
/// the address space (`ulimit -v`) the threads ask for ever and the process never ends. Its threads
/// are not used (linalg/sparse_cholesky.h), so it sees one processor and starts none.
void use_all_processors();

} // namespace shape::tools
