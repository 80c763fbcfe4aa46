// SPDX-License-Identifier: MIT

#pragma once

namespace shape::tools {

/// From now on SIGINT and SIGTERM ask the work of this thread to stop, the library's too (base/stop.h; a second
/// one ends the process at once), and a closed pipe is an error of writing instead of the end of the process.
void catch_signals();

} // namespace shape::tools
