// SPDX-License-Identifier: MIT

#include "libshape/base/version.h"

namespace shape {

const char* version() { return SHAPE_VERSION; }

} // namespace shape
