// SPDX-License-Identifier: MIT

#pragma once

#include <string>

#include "libshape/model/shape_model.h"
#include "tools/program/session.h"

namespace shape::tools {

/// How far from the mean feasible ranges are looked for [standard deviations].
inline constexpr double feasible_reach = 10.0;

/// The modes of a model, one object each: mode, variance, share, cumulative (of the total
/// variance), feasible_low, feasible_high [standard deviations].
[[nodiscard]] Json mode_figures(const ShapeModel& model);

/// Those figures as lines of text, with a head.
[[nodiscard]] std::string mode_table(const Json& figures);

/// Names of the labels and how many different values each has.
[[nodiscard]] Json label_figures(const Labels& labels);

} // namespace shape::tools
