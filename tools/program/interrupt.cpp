// SPDX-License-Identifier: MIT

#include "tools/program/interrupt.h"

#include <atomic>
#include <csignal>

#include "libshape/base/stop.h"

namespace shape::tools {
namespace {

std::atomic<bool> stop_requested = false;
static_assert(std::atomic<bool>::is_always_lock_free); // a handler of signals sets it

void request_stop(int)
{
    stop_requested = true;
}

} // namespace

void catch_signals()
{
    static const internal::StopScope heed(&stop_requested);
    struct sigaction action = {};
    action.sa_handler = request_stop;
    action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN); // a file beyond the limit of the shell is an error of writing
}

} // namespace shape::tools
