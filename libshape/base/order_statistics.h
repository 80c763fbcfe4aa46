// SPDX-License-Identifier: MIT

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
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

/// The smallest values that at least share * #values are not above, for each share; 0 of none.
/// @param shares  In [0, 1], ascending. Cost: about that of the first.
inline std::vector<double> quantiles_of(std::vector<double> values,
                                        std::initializer_list<double> shares)
{
    if (values.empty())
        return std::vector<double>(shares.size(), 0.0);
    std::vector<double> quantiles;
    auto first = values.begin(); // what is before it is no larger than the rest
    for (const double share : shares) {
        const auto rank =
            static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size()))) - 1;
        const auto nth = std::max(first, values.begin() + std::max<std::ptrdiff_t>(rank, 0));
        std::nth_element(first, nth, values.end());
        quantiles.push_back(*nth);
        first = nth;
    }
    return quantiles;
}

inline double quantile_of(std::vector<double> values, double share)
{
    return quantiles_of(std::move(values), {share}).front();
}

} // namespace shape::internal
