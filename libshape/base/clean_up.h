// SPDX-License-Identifier: MIT

#pragma once

#include <new>

namespace shape::internal {

/// For destructors: runs work() that may find no memory, once more if it does, as memory may lack for a moment;
/// then what it was to remove stays.
template <class Work>
void clean_up(const Work& work) noexcept
{
    for (int attempt = 0; attempt < 2; ++attempt)
        try {
            return work();
        } catch (const std::bad_alloc&) {
        }
}

} // namespace shape::internal
