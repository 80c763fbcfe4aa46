// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/statistics/pass_state.h"

namespace shape::internal {

/// Takes a state apart again, in the same order.
class PassStateReader
{
public:
    explicit PassStateReader(PassState state) : state_(std::move(state)) {}

    [[nodiscard]] std::int64_t number() { return state_.numbers.at(numbers_++); }

    /// @throws InvalidInput if the array has another size.
    [[nodiscard]] RowMatrix array(Eigen::Index rows, Eigen::Index columns)
    {
        RowMatrix array = std::move(state_.arrays.at(arrays_++));
        if (array.rows() != rows || array.cols() != columns)
            throw InvalidInput("the state of an interrupted run is that of other data");
        return array;
    }
    [[nodiscard]] Eigen::VectorXd vector(Eigen::Index size)
    {
        return array(1, size).row(0).transpose();
    }

private:
    PassState state_;
    std::size_t numbers_ = 0;
    std::size_t arrays_ = 0;
};

} // namespace shape::internal
