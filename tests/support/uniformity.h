// SPDX-License-Identifier: MIT

#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace shape::test {

/// The largest distance between the distribution of values and the uniform one on [0, 1], times
/// sqrt(#values): beyond 1.63 in 1 % of all samples of a uniform distribution (Kolmogorov, Smirnov).
[[nodiscard]] inline double kolmogorov_smirnov(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    const auto count = static_cast<double>(values.size());
    double distance = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto below = static_cast<double>(i);
        distance =
            std::max({distance, values[i] - below / count, (below + 1.0) / count - values[i]});
    }
    return distance * std::sqrt(count);
}

} // namespace shape::test
