// SPDX-License-Identifier: MIT

#include "tests/support/data.h"

#include <cstdlib>

namespace shape::test {

std::filesystem::path data_dir()
{
    const char* chosen = std::getenv("SHAPE_DATA_DIR");
    return chosen != nullptr ? chosen : SHAPE_DEFAULT_DATA_DIR;
}

} // namespace shape::test
