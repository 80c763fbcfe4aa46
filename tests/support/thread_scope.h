// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/base/threads.h"

namespace shape::test {

/// Sets thread_count() for a scope.
class ThreadScope
{
public:
    explicit ThreadScope(int count) : before_(thread_count()) { set_thread_count(count); }
    ThreadScope(const ThreadScope&) = delete;
    ThreadScope& operator=(const ThreadScope&) = delete;
    ~ThreadScope() { set_thread_count(before_); }

private:
    int before_;
};

} // namespace shape::test
