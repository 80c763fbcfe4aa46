// SPDX-License-Identifier: MIT

#pragma once

#include <type_traits>

namespace shape::internal {

/// s0 of phi. Blends of real poses strain most edges by well below a per cent; what exceeds 6 % is one
/// of the few that pay for the others.
inline constexpr double stretch_onset = 0.06;

/// phi(s) = s^2 + s^4 / (s0^2 + s^2 / 8): the square of a relative edge error s, stiffer by up to 9
/// times beyond a few per cent, so that no edge pays for all others.
template <class Number>
struct StretchTerm
{
    Number value;  ///< phi(s).
    Number weight; ///< phi'(s) / (2 s): Gauss-Newton takes s for a residual of this weight.
};

/// Written once for all kernels. In float and in EightLanes (linalg/eight_lanes.h) the constants are
/// rounded to float first.
template <class Number>
[[nodiscard, gnu::always_inline]] constexpr StretchTerm<Number> stretch_term(const Number& strain)
{
    using Scalar = typename decltype([] {
        if constexpr (std::is_floating_point_v<Number>)
            return std::type_identity<Number>();
        else
            return std::type_identity<typename Number::Scalar>();
    }())::type;
    constexpr auto onset = static_cast<Scalar>(stretch_onset * stretch_onset);
    constexpr auto eighth = static_cast<Scalar>(0.125);
    const Number square = strain * strain;
    const Number scale = onset + eighth * square;
    return {square + square * square / scale,
            Scalar{1} + square * (Scalar{2} * onset + eighth * square) / (scale * scale)};
}

} // namespace shape::internal
