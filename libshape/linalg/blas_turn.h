// SPDX-License-Identifier: MIT

#pragma once

#include <mutex>

namespace shape::internal {

/// What a thread holds while it works inside OpenBLAS.
///
/// OpenBLAS keeps a buffer for every thread that is inside it at once, and where the system refuses
/// one it asks again, for ever. So under a limit of the address space (`ulimit -v`) threads take
/// turns: one buffer then serves all, and the first turn looks whether there is room for it.
class BlasTurn
{
public:
    /// @throws std::bad_alloc if there is no room for the buffer.
    BlasTurn();

private:
    std::unique_lock<std::mutex> lock_; ///< Held only under a limit.
};

} // namespace shape::internal
