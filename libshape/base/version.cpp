// SPDX-License-Identifier: MIT

#include "libshape/base/version.h"

#define SHAPE_PRINT(number) #number
#define SHAPE_JOIN(major, minor, patch) \
    SHAPE_PRINT(major) "." SHAPE_PRINT(minor) "." SHAPE_PRINT(patch)

namespace shape {

const char* version()
{
    return SHAPE_JOIN(SHAPE_VERSION_MAJOR, SHAPE_VERSION_MINOR, SHAPE_VERSION_PATCH);
}

} // namespace shape
