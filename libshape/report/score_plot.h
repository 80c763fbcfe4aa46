// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libshape/linalg/dense.h"
#include "libshape/report/plot.h"

namespace shape {

/// What is drawn around the points of one label value.
enum class GroupOutline
{
    None,
    Hull,    ///< Their convex hull; of three points and more.
    Ellipse, ///< Where 95 % of a normal distribution with their mean and covariance lie; as Hull.
};

struct ScorePlotOptions
{
    /// This score goes to the right, an index in [0, K).
    int mode_x = 0;
    /// This one goes up.
    int mode_y = 1;
    /// A unit is as long in x as in y.
    bool equal_axes = false;
    /// Names stand beside their points, as far as they do not cover one another.
    bool names = false;
    /// This is drawn around the points of each of several label values, numbers on a scale apart.
    GroupOutline outline = GroupOutline::None;
    /// Beside a scale of colours the label values have this name.
    std::string label_name = {};
};

/// More label values than this are folded: the largest ones, less one, keep a colour and a mark of
/// their own, the rest share a grey one. It is as many as colours and marks tell apart.
inline constexpr std::size_t most_plot_groups = 12;

/// The scores of meshes along two modes. Label values make one series each in the order of their
/// first appearance, folded as above; or, if all that there are spell finite numbers and more than six
/// different ones, one series on a scale of colours. Meshes without a value are grey.
///
/// @param scores  N by K.
/// @param label_values  N, or empty: one series.
/// @param explained  Shares of the variance in [0, 1] for the axes, at most K; may be empty.
/// @throws InvalidInput if a size or an index does not fit.
[[nodiscard]] Plot score_plot(const RowMatrix& scores, const std::vector<std::string>& names,
                              const std::vector<std::string>& label_values,
                              const Eigen::VectorXd& explained,
                              const ScorePlotOptions& options = {});

} // namespace shape
