// SPDX-License-Identifier: MIT

#pragma once

#include <cmath>
#include <string_view>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape::internal {

// What every check() of an options struct is made of: its fields are named as "Struct.field".

/// @throws InvalidInput "`field` is `value`, must be `rule`" unless the rule holds.
template <class Value>
void require(bool holds, std::string_view field, const Value& value, std::string_view rule)
{
    if (!holds)
        throw InvalidInput(join(field, " is ", value, ", must be ", rule));
}

inline void require_positive(double value, std::string_view field)
{
    require(value > 0.0 && std::isfinite(value), field, value, "> 0 and finite");
}

inline void require_not_negative(double value, std::string_view field)
{
    require(value >= 0.0 && std::isfinite(value), field, value, ">= 0 and finite");
}

inline void require_at_least(int least, int value, std::string_view field)
{
    require(value >= least, field, value, join(">= ", least));
}

} // namespace shape::internal
