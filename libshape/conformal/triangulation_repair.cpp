// SPDX-License-Identifier: MIT

#include "libshape/conformal/triangulation_repair.h"

#include "libshape/base/require.h"

namespace shape {
using namespace internal;

void check(const TriangulationRepairOptions& options)
{
    require_at_least(0, options.local_rounds, "TriangulationRepairOptions.local_rounds");
    require_at_least(0, options.max_rounds, "TriangulationRepairOptions.max_rounds");
}

} // namespace shape
