// SPDX-License-Identifier: MIT

#include "tools/program/memory.h"

#include <cstdlib> // defines __GLIBC__

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace shape::tools {

void return_large_arrays()
{
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 4 << 20);
    mallopt(M_TRIM_THRESHOLD, 8 << 20);
#endif
}

void return_freed_memory()
{
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

} // namespace shape::tools
