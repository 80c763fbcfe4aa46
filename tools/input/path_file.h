// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace shape::tools {

/// How the inputs are joined.
enum class PathKind
{
    Line,     ///< Straight from mesh to mesh.
    Bilinear, ///< Four meshes at the corners of a patch.
    Polygon,  ///< Meshes at the corners of a polygon, mean value coordinates of a point in it.
    Spline,   ///< A smooth curve through the meshes or near them.
};

enum class SplineKind
{
    CatmullRom,
    BSpline,
};

/// Names of the choices, in options and files.
[[nodiscard]] const std::vector<std::pair<std::string, PathKind>>& path_kinds();
[[nodiscard]] const std::vector<std::pair<std::string, SplineKind>>& spline_kinds();

constexpr std::int64_t most_frames = 1'000'000;
constexpr std::int64_t most_rows = 1000; ///< A grid has at most this many.

/// Which blends are wanted, as options or a path file say; what neither says is empty.
struct PathDescription
{
    std::optional<PathKind> kind;
    std::optional<SplineKind> spline;
    std::optional<std::int64_t> frames;   ///< In [2, most_frames].
    std::optional<Eigen::Vector2d> range; ///< The parameter runs over this along lines and splines.
    std::optional<Eigen::Vector2d> grid;  ///< Columns and rows of a patch, in [2, most_rows].
    std::vector<std::vector<double>> weights;
    Eigen::MatrixX2d at;      ///< Places of single blends, in a patch or polygon.
    Eigen::MatrixX2d track;   ///< Polyline that the frames move along, there.
    Eigen::MatrixX2d polygon; ///< Corners.
};

/// Adds what a path file says: a JSON object with the fields of PathDescription as keys (`path` for
/// the kind), points as [x, y]; docs/interpolation.md has examples.
/// @throws InvalidInput naming file and key for what is not JSON, an unknown key, one that occurs
///     twice, or a value of the wrong kind.
/// @throws UsageError if the description has that field already.
/// @throws FileError if the file cannot be read.
void read_path_file(const std::string& file, PathDescription& description);

} // namespace shape::tools
