// SPDX-License-Identifier: MIT

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

namespace shape::internal {

/// The median; of an even number of values the mean of the two in the middle.
/// @param values  At least one.
inline double median(std::vector<double> values)
{
    const auto middle = values.begin() + std::ssize(values) / 2;
    std::nth_element(values.begin(), middle, values.end());
    const double upper = *middle;
    return values.size() % 2 == 1 ? upper
                                  : 0.5 * (*std::max_element(values.begin(), middle) + upper);
}

/// The smallest value that at least share * #values are not above; 0 of none.
/// @param share  In [0, 1].
inline double quantile_of(std::vector<double> values, double share)
{
    if (values.empty())
        return 0.0;
    const auto rank =
        static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size()))) - 1;
    const auto nth = values.begin() + std::max<std::ptrdiff_t>(rank, 0);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

} // namespace shape::internal
