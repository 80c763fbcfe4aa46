// SPDX-License-Identifier: MIT

#include "tools/program/spelling.h"

#include <algorithm>

#include "libshape/base/format.h"

namespace shape::tools {
using namespace internal;
namespace {

/// How many letters must be put in, taken out, changed or swapped to make one word of the other.
std::size_t edit_distance(const std::string& a, const std::string& b)
{
    std::vector<std::vector<std::size_t>> cost(a.size() + 1,
                                               std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i)
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                cost[i][j] = i + j;
                continue;
            }
            cost[i][j] = std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1,
                                   cost[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
        }
    return cost[a.size()][b.size()];
}

/// The known word that is spelled most like this one; empty if none is near.
std::string nearest(const std::string& word, const std::vector<std::string>& known)
{
    constexpr std::size_t longest = 40;
    std::string best;
    if (word.size() > longest)
        return best;
    std::size_t least = 1 + std::max<std::size_t>(2, word.size() / 3);
    for (const std::string& candidate : known)
        if (const std::size_t distance = edit_distance(word, candidate); distance < least) {
            least = distance;
            best = candidate;
        }
    return best;
}

} // namespace

std::string did_you_mean(const std::string& word, const std::vector<std::string>& known)
{
    const std::string best = nearest(word, known);
    return best.empty() ? std::string() : join("; did you mean '", best, "'?");
}

} // namespace shape::tools
