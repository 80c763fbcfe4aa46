// SPDX-License-Identifier: MIT

#include "tools/explore/page_frame.h"

#include "libshape/base/to_size.h"

// The assembler takes the file in as it is.
#ifdef SHAPE_PAGE_FILE
asm(".section .rodata\n"
    "shape_page_begin: .incbin \"" SHAPE_PAGE_FILE
    "\"\n"
    "shape_page_end: .byte 0\n"
    ".previous\n");
extern "C" const char shape_page_begin[], shape_page_end[];
#endif

namespace shape::tools {
using namespace internal;

std::string_view page_frame()
{
#ifdef SHAPE_PAGE_FILE
    return {shape_page_begin, to_size(shape_page_end - shape_page_begin)};
#else
    return {};
#endif
}

} // namespace shape::tools
