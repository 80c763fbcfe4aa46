// SPDX-License-Identifier: MIT

#include "libshape/base/threads.h"

#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"

namespace shape {
using namespace internal;

int thread_count()
{
    return 1;
}

void set_thread_count(int count)
{
    if (count != 1)
        throw InvalidInput(join("thread count is ", count, ", there is 1"));
}

void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body)
{
    grain = std::max<std::size_t>(grain, 1);
    for (std::size_t begin = 0; begin < count; begin += grain) {
        throw_if_stop_requested();
        body(begin, std::min(count, begin + grain));
    }
}

} // namespace shape
