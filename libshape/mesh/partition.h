// SPDX-License-Identifier: MIT

#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "libshape/base/to_size.h"

namespace shape::internal {

/// Items 0 ... count - 1 in classes that only grow together (union by path halving).
class Partition
{
public:
    explicit Partition(std::size_t count) : parent_(count)
    {
        std::iota(parent_.begin(), parent_.end(), 0);
    }
    /// The lowest item of the class.
    int root(int i)
    {
        while (at(i) != i)
            i = at(i) = at(at(i));
        return i;
    }
    void unite(int a, int b) { at(std::max(root(a), root(b))) = std::min(root(a), root(b)); }

private:
    int& at(int i) { return parent_[to_size(i)]; }
    std::vector<int> parent_;
};

} // namespace shape::internal
