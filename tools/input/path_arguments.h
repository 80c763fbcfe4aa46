// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "tools/input/path_file.h"

namespace CLI {
class App;
}

namespace shape::tools {

struct PathArguments
{
    PathDescription options;
    std::string file;
    bool extrapolate = false; ///< Blends may leave the inputs,
    bool force_range = false; ///< and the safe range.
};

/// Adds --path, --weights, --frames, ..., --path-file, --extrapolate and --force-range.
void add_path_options(CLI::App& command, PathArguments& arguments);

/// The blends of a run.
struct Blends
{
    PathKind kind = PathKind::Line;
    std::vector<Eigen::VectorXd> weights; ///< One a blend, of as many entries as there are meshes.
    bool is_sequence = false;             ///< Frames along a path; else places of their own.

    /// Of frames of a line or spline; else empty:
    std::vector<double> places;                        ///< t of each,
    std::function<Eigen::VectorXd(double)> weights_at; ///< the weights at t,
    std::vector<double> stations; ///< and where the path passes through a mesh, and its ends.
};

/// @throws UsageError for options that do not go together or are missing.
/// @throws InvalidInput for a path file that breaks its rules, and for weights, places and polygons
///     that do not fit the meshes or each other.
[[nodiscard]] Blends blends_of(const PathArguments& arguments, int meshes);

} // namespace shape::tools
