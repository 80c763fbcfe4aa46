// SPDX-License-Identifier: MIT

#pragma once

#include <atomic>

#include "libshape/base/error.h"

namespace shape::internal {

/// What may ask the work of this thread to stop, set by another thread or a handler of signals; null: nothing.
/// parallel_for passes it on to the threads that help.
inline constinit thread_local const std::atomic<bool>* stop_request = nullptr;

/// While it lives, the work of this thread looks at `requested`.
class StopScope
{
public:
    explicit StopScope(const std::atomic<bool>* requested) : before_(stop_request)
    {
        stop_request = requested;
    }
    StopScope(const StopScope&) = delete;
    StopScope& operator=(const StopScope&) = delete;
    ~StopScope() { stop_request = before_; }

private:
    const std::atomic<bool>* before_;
};

[[nodiscard]] inline bool is_stop_requested()
{
    return stop_request != nullptr && stop_request->load(std::memory_order_relaxed);
}

[[noreturn]] inline void throw_interrupted()
{
    throw Interrupted("interrupted; nothing half-done was kept");
}

/// For loops that take long without parallel_for, which looks before each chunk.
inline void throw_if_stop_requested()
{
    if (is_stop_requested())
        throw_interrupted();
}

} // namespace shape::internal
