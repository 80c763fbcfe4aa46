// SPDX-License-Identifier: MIT

#include "tools/program/interrupt.h"

#include <csignal>

#include "libshape/base/error.h"

namespace shape::tools {
namespace {

volatile std::sig_atomic_t stop_requested = 0;

void request_stop(int)
{
    stop_requested = 1;
}

} // namespace

void catch_signals()
{
    struct sigaction action = {};
    action.sa_handler = request_stop;
    action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN); // a file beyond the limit of the shell is an error of writing
}

void throw_if_interrupted()
{
    if (stop_requested)
        throw Interrupted("interrupted; nothing half-done was kept");
}

} // namespace shape::tools
