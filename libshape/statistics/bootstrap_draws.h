// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/base/random.h"
#include "libshape/statistics/bootstrap.h"

namespace shape::internal {

/// Which observations each replicate of a bootstrap draws.
class BootstrapDraws
{
public:
    /// @throws InvalidInput as bootstrap().
    BootstrapDraws(const Resampling& resampling, const BootstrapOptions& options);

    /// How often a replicate draws each of the N observations. Cost: N.
    [[nodiscard]] Eigen::VectorXd times(int replicate) const;

private:
    std::vector<std::vector<int>> blocks_;
    std::vector<std::vector<int>> strata_; ///< Blocks.
    std::vector<Random> random_;           ///< Where each replicate begins.
    Eigen::Index count_;
};

} // namespace shape::internal
