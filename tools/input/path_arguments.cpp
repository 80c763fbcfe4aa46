// SPDX-License-Identifier: MIT

#include "tools/input/path_arguments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/mean_value_coordinates.h"
#include "libshape/edge_space/paths.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;
namespace {

using Eigen::MatrixX2d;
using Eigen::Vector2d;
using Eigen::VectorXd;

Vector2d read_pair(const std::string& text, char separator, const std::string& option)
{
    const std::vector<std::string> pieces = split(text, separator);
    if (pieces.size() != 2)
        throw UsageError(
            join(option, ": '", text, "' is not two numbers joined by '", separator, "'"));
    return {read_number(pieces[0], option), read_number(pieces[1], option)};
}

/// "x,y:x,y:..."
MatrixX2d read_points(const std::string& text, const std::string& option)
{
    const std::vector<std::string> pieces = split(text, ':');
    MatrixX2d points(static_cast<Eigen::Index>(pieces.size()), 2);
    for (std::size_t i = 0; i < pieces.size(); ++i)
        points.row(static_cast<Eigen::Index>(i)) = read_pair(pieces[i], ',', option);
    return points;
}

void append_row(MatrixX2d& points, const Vector2d& point)
{
    points.conservativeResize(points.rows() + 1, 2);
    points.bottomRows<1>() = point.transpose();
}

/// An option that only some paths have.
void check_use(bool given, const std::string& name, bool has_meaning, const std::string& where)
{
    if (given && !has_meaning)
        throw UsageError(join("--", name, " has a meaning with ", where, " alone"));
}

void check_combination(const PathDescription& path, PathKind kind)
{
    const std::array<bool, 4> ways{!path.weights.empty(), path.frames.has_value(),
                                   path.at.rows() > 0, path.grid.has_value()};
    if (std::count(ways.begin(), ways.end(), true) != 1)
        throw UsageError(
            "give exactly one of --weights, --frames, --at and --grid, as an option or in the path "
            "file");
    const bool in_plane = kind == PathKind::Bilinear || kind == PathKind::Polygon;
    const bool curve = kind == PathKind::Line || kind == PathKind::Spline;
    check_use(!path.weights.empty(), "weights", kind == PathKind::Line, "--path line");
    check_use(path.at.rows() > 0, "at", in_plane, "--path bilinear and polygon");
    check_use(path.grid.has_value(), "grid", kind == PathKind::Bilinear, "--path bilinear");
    check_use(path.track.rows() > 0, "track", in_plane && path.frames,
              "--frames and --path bilinear or polygon");
    check_use(path.range.has_value(), "range", curve && path.frames,
              "--frames and --path line or spline");
    check_use(path.polygon.rows() > 0, "polygon", kind == PathKind::Polygon, "--path polygon");
    check_use(path.spline.has_value(), "spline", kind == PathKind::Spline, "--path spline");
}

/// The places of the blends on a patch or in a polygon.
MatrixX2d places(const PathDescription& path, const MatrixX2d& default_track)
{
    if (path.at.rows() > 0)
        return path.at;
    if (path.grid) {
        const auto columns = static_cast<Eigen::Index>((*path.grid)[0]);
        const auto rows = static_cast<Eigen::Index>((*path.grid)[1]);
        MatrixX2d result(columns * rows, 2);
        for (Eigen::Index i = 0; i < result.rows(); ++i) {
            const Eigen::Index row = i / columns;
            const Eigen::Index column = i - row * columns;
            result.row(i) << static_cast<double>(column) / static_cast<double>(columns - 1),
                static_cast<double>(row) / static_cast<double>(rows - 1);
        }
        return result;
    }
    const MatrixX2d& track = path.track.rows() > 0 ? path.track : default_track;
    const auto last = static_cast<double>(*path.frames - 1);
    MatrixX2d result(*path.frames, 2);
    for (Eigen::Index i = 0; i < result.rows(); ++i)
        result.row(i) = point_on_track(track, static_cast<double>(i) / last).transpose();
    return result;
}

std::vector<VectorXd> on_patch(const PathDescription& path, int meshes)
{
    if (meshes != 4)
        throw InvalidInput(join("--path bilinear: a patch has 4 corners, not ", meshes, " meshes"));
    MatrixX2d diagonal(2, 2);
    diagonal << 0.0, 0.0, 1.0, 1.0;
    std::vector<VectorXd> weights;
    const MatrixX2d chosen = places(path, diagonal);
    for (const auto& place : chosen.rowwise())
        weights.emplace_back(bilinear_weights(place[0], place[1]));
    return weights;
}

std::vector<VectorXd> in_polygon(const PathDescription& path, int meshes)
{
    if (meshes < 3)
        throw InvalidInput(
            join("--path polygon: a polygon has 3 corners or more, not ", meshes, " meshes"));
    const Polygon polygon = path.polygon.rows() > 0 ? path.polygon : regular_polygon(meshes);
    if (polygon.rows() != meshes)
        throw InvalidInput(
            join("--polygon: ", counted(polygon.rows(), "corner"), " for ", meshes, " meshes"));
    check_simple_polygon(polygon);
    MatrixX2d round_trip = polygon;
    append_row(round_trip, polygon.row(0).transpose());
    std::vector<VectorXd> weights;
    const MatrixX2d chosen = places(path, round_trip);
    for (const auto& place : chosen.rowwise())
        weights.push_back(mean_value_coordinates(polygon, place.transpose()));
    return weights;
}

VectorXd on_spline(SplineKind kind, int meshes, double t)
{
    if (kind == SplineKind::BSpline)
        return b_spline_weights(meshes, t);
    return catmull_rom_weights(VectorXd::LinSpaced(meshes, 0.0, 1.0), t);
}

void add_curve(const PathDescription& path, int meshes, Blends& blends)
{
    const SplineKind spline = path.spline.value_or(SplineKind::CatmullRom);
    const bool is_line = blends.kind == PathKind::Line;
    blends.weights_at = [=](double t) {
        return is_line ? line_weights(meshes, t) : on_spline(spline, meshes, t);
    };
    const bool passes_all = is_line || spline == SplineKind::CatmullRom;
    const int parts = passes_all ? meshes - 1 : 1;
    for (int i = 0; i <= parts; ++i)
        blends.stations.push_back(static_cast<double>(i) / parts);
    const Vector2d range = path.range.value_or(Vector2d(0.0, 1.0));
    const auto last = static_cast<double>(*path.frames - 1);
    for (std::int64_t i = 0; i < *path.frames; ++i) {
        const double share = static_cast<double>(i) / last;
        blends.places.push_back((1.0 - share) * range[0] + share * range[1]);
        blends.weights.push_back(blends.weights_at(blends.places.back()));
    }
}

std::string print(const VectorXd& weights)
{
    std::string text;
    for (const double weight : weights)
        text += join(text.empty() ? "" : ",", weight);
    return text;
}

std::vector<VectorXd> given_weights(const PathDescription& path, int meshes)
{
    std::vector<VectorXd> result;
    for (const std::vector<double>& numbers : path.weights) {
        const VectorXd weights =
            Eigen::Map<const VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
        const std::string place = join("--weights ", print(weights), ": ");
        if (weights.size() != meshes)
            throw InvalidInput(
                join(place, counted(weights.size(), "weight"), " for ", meshes, " meshes"));
        if (std::abs(weights.sum() - 1.0) > 1e-9)
            throw InvalidInput(join(place, "the weights sum to ", weights.sum(), ", not to 1"));
        result.push_back(weights);
    }
    return result;
}

/// Splines and polygons have negative weights of their own; elsewhere they are extrapolation.
void refuse_extrapolation(const Blends& blends)
{
    if (blends.kind == PathKind::Spline || blends.kind == PathKind::Polygon)
        return;
    for (std::size_t i = 0; i < blends.weights.size(); ++i)
        for (Eigen::Index k = 0; k < blends.weights[i].size(); ++k)
            if (const double weight = blends.weights[i][k]; weight < 0.0 || weight > 1.0)
                throw InvalidInput(join("blend ", i + 1, " of ", blends.weights.size(),
                                        ", weights ", print(blends.weights[i]), ": weight ", k + 1,
                                        " is ", weight,
                                        ", outside [0, 1]; --extrapolate allows it"));
}

constexpr const char* paths_group = "Paths"; // of the help

/// An option that is read from a text.
CLI::Option* add_text(CLI::App& to, const std::string& name, const std::string& text,
                      const std::string& description,
                      const std::function<void(const std::string&)>& read)
{
    return to.add_option_function<std::string>(name, read, description)->option_text(text);
}

/// Which blends: --weights, --frames, --at or --grid.
void add_blends(CLI::App& command, PathDescription& path)
{
    CLI::Option_group* blends = command.add_option_group("Blends", "exactly one of");
    blends
        ->add_option_function<std::vector<std::string>>(
            "--weights",
            [&path](const std::vector<std::string>& texts) {
                for (const std::string& text : texts)
                    path.weights.push_back(read_numbers(text, "--weights"));
            },
            "One weight a mesh; they sum to 1 (within 1e-9) and lie in [0, 1]. Repeat\n"
            "the option for several blends")
        ->allow_extra_args(false)
        ->option_text("w1,w2,...");
    add_text(
        *blends, "--frames", "INTEGER",
        join("N blends along the path, equally spaced, both ends included, [2, ", most_frames, "]"),
        [&path](const std::string& text) {
            path.frames = read_integer(text, "--frames", 2, most_frames);
        });
    blends
        ->add_option_function<std::vector<std::string>>(
            "--at",
            [&path](const std::vector<std::string>& texts) {
                for (const std::string& text : texts)
                    append_row(path.at, read_pair(text, ',', "--at"));
            },
            "A blend at a place of the patch or polygon. Repeat the option for several")
        ->allow_extra_args(false)
        ->option_text("x,y");
    add_text(
        *blends, "--grid", "COLUMNS,ROWS",
        join("Blends all over the patch, row by row from (0, 0); each in [2, ", most_rows, "]"),
        [&path](const std::string& text) {
            const std::vector<std::string> sides = split(text, ',');
            if (sides.size() != 2)
                throw UsageError(join("--grid: '", text, "' is not COLUMNS,ROWS"));
            path.grid = Vector2d(read_integer(sides[0], "--grid", 2, most_rows),
                                 read_integer(sides[1], "--grid", 2, most_rows));
        });
    blends->require_option(0, 1);
}

/// Which path, and what of it.
void add_shape_of_path(CLI::App& command, PathDescription& path)
{
    add_choice(command, "--path", path.kind,
               "line: from mesh to mesh in order, each part as long as the others (default).\n"
               "bilinear: 4 meshes at the places (0,0), (1,0), (0,1), (1,1) of a patch.\n"
               "polygon: 3 meshes or more at the corners of a polygon; mean value coordinates of\n"
               "a point in it. spline: a smooth curve through all meshes, see --spline",
               path_kinds())
        ->group(paths_group);
    add_text(command, "--range", "A:B",
             "The part of a line or spline that the frames cover: 0 is the first mesh, 1 the last\n"
             "(default: 0:1). Lines go on beyond with --extrapolate",
             [&path](const std::string& text) { path.range = read_pair(text, ':', "--range"); })
        ->group(paths_group);
    add_text(command, "--track", "x,y:x,y:...",
             "What the frames move along, at constant speed: a polyline in the patch (default:\n"
             "0,0:1,1) or polygon (default: from corner to corner and back to the first)",
             [&path](const std::string& text) { path.track = read_points(text, "--track"); })
        ->group(paths_group);
    add_text(
        command, "--polygon", "x,y:x,y:...",
        "Corners of the polygon, one a mesh, in order; it must be simple (default: regular, on\n"
        "the unit circle, counter-clockwise from 1,0)",
        [&path](const std::string& text) { path.polygon = read_points(text, "--polygon"); })
        ->group(paths_group);
    add_choice(command, "--spline", path.spline,
               "catmull-rom: through every mesh (default); b-spline: cubic, through the first and\n"
               "the last mesh and near the others, smoother",
               spline_kinds())
        ->group(paths_group);
}

/// The path file, and how far blends may leave the inputs.
void add_file_and_ranges(CLI::App& command, PathArguments& arguments)
{
    command
        .add_option("--path-file", arguments.file,
                    "JSON file that says the same: an object with any of the keys path, weights,\n"
                    "frames, at, grid, range, track, polygon, spline. Points are [x, y], a range\n"
                    "[a, b], a grid [columns, rows], weights a list of lists; e.g.\n"
                    "{\"path\": \"polygon\", \"frames\": 50, \"track\": [[0, 0], [0.5, 0.2]]}")
        ->option_text("FILE")
        ->group(paths_group);
    CLI::Option* extrapolate =
        command
            .add_flag("--extrapolate", arguments.extrapolate,
                      "Allow weights outside [0, 1] of lines and patches. Prints the safe range:\n"
                      "how far no triangle inequality breaks. What leaves it is refused")
            ->group(paths_group);
    command
        .add_flag("--force-range", arguments.force_range,
                  "Go beyond the safe range; no mesh has the lengths there, the nearest is written")
        ->needs(extrapolate)
        ->group(paths_group);
}

} // namespace

void add_path_options(CLI::App& command, PathArguments& arguments)
{
    add_blends(command, arguments.options);
    add_shape_of_path(command, arguments.options);
    add_file_and_ranges(command, arguments);
}

Blends blends_of(const PathArguments& arguments, int meshes)
{
    PathDescription path = arguments.options;
    if (!arguments.file.empty())
        read_path_file(arguments.file, path);
    Blends blends;
    blends.kind = path.kind.value_or(PathKind::Line);
    blends.is_sequence = path.frames.has_value();
    check_combination(path, blends.kind);
    if (!path.weights.empty())
        blends.weights = given_weights(path, meshes);
    else if (blends.kind == PathKind::Bilinear)
        blends.weights = on_patch(path, meshes);
    else if (blends.kind == PathKind::Polygon)
        blends.weights = in_polygon(path, meshes);
    else
        add_curve(path, meshes, blends);
    if (!arguments.extrapolate)
        refuse_extrapolation(blends);
    return blends;
}

} // namespace shape::tools
