// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <complex>

#include "libshape/mesh/points.h"

namespace shape {

/// Positions in the complex plane, each the unevaluated sum position + remainder: conformal maps
/// shrink limbs to clusters far smaller than the spacing of doubles around them.
struct PlanarLayout
{
    Eigen::VectorXcd positions;  ///< #V [length].
    Eigen::VectorXcd remainders; ///< #V [length]; below the rounding of positions.

    [[nodiscard]] std::complex<double> difference(int from, int to) const
    {
        return (positions[to] - positions[from]) + (remainders[to] - remainders[from]);
    }
};

/// Points on the unit sphere, each the unevaluated sum point + remainder (see PlanarLayout).
struct SpherePoints
{
    Points points;
    Points remainders;

    [[nodiscard]] Eigen::RowVector3d difference(int from, int to) const
    {
        return (points.row(to) - points.row(from)) + (remainders.row(to) - remainders.row(from));
    }
};

} // namespace shape
