// SPDX-License-Identifier: MIT

#include <algorithm>
#include <vector>

#include "libshape/base/threads.h"

namespace shape {

double parallel_sum(std::size_t count, std::size_t grain,
                    const std::function<double(std::size_t, std::size_t)>& term)
{
    grain = std::max<std::size_t>(grain, 1);
    std::vector<double> parts((count + grain - 1) / grain, 0.0);
    parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
        parts[begin / grain] = term(begin, end);
    });
    double sum = 0.0;
    for (double part : parts)
        sum += part;
    return sum;
}

} // namespace shape
