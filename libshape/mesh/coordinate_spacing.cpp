// SPDX-License-Identifier: MIT

#include "libshape/mesh/coordinate_spacing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "libshape/base/format.h"
#include "libshape/base/order_statistics.h"
#include "libshape/base/rounded.h"

namespace shape::internal {
namespace {

template <class Coordinates>
bool are_single_precision(const Coordinates& coordinates)
{
    return std::all_of(coordinates.begin(), coordinates.end(),
                       [](double x) { return static_cast<double>(static_cast<float>(x)) == x; });
}

/// The exponent of ten.
double decade_of(double x)
{
    return std::floor(std::log10(x));
}

/// Whether a number is one of so many significant digits, up to the rounding of its format.
/// @param x  > 0. @param rounding  Of the format, relative.
bool has_digits(double x, int digits, double rounding)
{
    const double scaled = x * std::pow(10.0, digits - 1 - decade_of(x));
    return std::abs(scaled - std::round(scaled)) <= rounding * scaled;
}

/// A step is coarse that is larger than this part of the median edge.
constexpr double coarse_share = 0.01;

/// Median of the sides of faces [length], those without length left out; 0 if there are none.
double median_side(const Faces& faces, const Points& points)
{
    std::vector<double> sides;
    sides.reserve(static_cast<std::size_t>(faces.size()));
    for (const auto& face : faces.rowwise())
        for (int c = 0; c < 3; ++c)
            if (const double side = (points.row(face[c]) - points.row(face[(c + 1) % 3])).norm();
                side > 0.0)
                sides.push_back(side);
    return sides.empty() ? 0.0 : median(std::move(sides));
}

/// The largest number of which all values are multiples, from the first one on; 0 if it is not above `least`, or if all
/// are equal.
/// @param of  The value of a vertex; whole numbers, or whole multiples of a power of two.
template <class Of>
double common_step(Eigen::Index count, double least, const Of& of)
{
    double step = 0.0;
    for (Eigen::Index v = 1; v < count; ++v) {
        double rest = std::abs(of(v) - of(0));
        while (rest > 0.0) { // Euclid; the remainders are exact
            const double next = std::fmod(step, rest);
            step = rest;
            rest = next;
        }
        if (step > 0.0 && step <= least)
            return 0.0;
    }
    return step;
}

/// The step of an axis, if it is above `least`; else 0.
double step_of(const Eigen::VectorXd& coordinates, bool is_single, double least)
{
    const Eigen::Index count = coordinates.size();
    int exponent = 0;
    (void)std::frexp(least, &exponent);
    const double binary = std::ldexp(1.0, exponent - 1); // <= least
    const auto all_of = [&](const auto& holds) {
        return std::all_of(coordinates.begin(), coordinates.end(), holds);
    };
    if (all_of([&](double x) { return std::fmod(x, binary) == 0.0; }))
        return common_step(count, least, [&](Eigen::Index v) { return coordinates[v]; });
    const double decimal = std::pow(10.0, std::floor(std::log10(least)));
    const double rounding =
        is_single ? std::ldexp(1.0, -24) : std::numeric_limits<double>::epsilon();
    constexpr double most = 0.02; // of a step: beyond it chance is not excluded
    const auto is_multiple = [&](double x) {
        const double steps = x / decimal;
        const double tolerance = 2.0 * rounding * std::abs(steps);
        return tolerance <= most && std::abs(steps - std::round(steps)) <= tolerance;
    };
    if (!all_of(is_multiple))
        return 0.0;
    return decimal * common_step(count, least / decimal, [&](Eigen::Index v) {
               return std::round(coordinates[v] / decimal);
           });
}

/// By how many steps nearly all edges run along an axis at most: 1, 2, or 0 for more.
int raster_steps(const Faces& faces, const Eigen::VectorXd& coordinates, double step)
{
    constexpr double share = 0.99;
    std::array<Eigen::Index, 2> within{};
    for (const auto& face : faces.rowwise())
        for (int c = 0; c < 3; ++c) {
            const double run =
                std::abs(coordinates[face[c]] - coordinates[face[(c + 1) % 3]]) / step;
            within[0] += run < 1.01 ? 1 : 0;
            within[1] += run < 2.01 ? 1 : 0;
        }
    for (const int steps : {1, 2})
        if (static_cast<double>(within[static_cast<std::size_t>(steps - 1)]) >=
            share * static_cast<double>(faces.size()))
            return steps;
    return 0;
}

/// The distance of neighbouring numbers of a size.
double distance_of_numbers(double size, bool is_single)
{
    int exponent = 0;
    (void)std::frexp(size, &exponent);
    return std::ldexp(1.0, exponent - (is_single ? 24 : 53));
}

} // namespace

std::optional<CoarseCoordinates> coarse_coordinates(const Faces& faces, const Points& points,
                                                    bool exempt_rasters)
{
    constexpr Eigen::Index least_vertices = 20;
    if (points.rows() < least_vertices)
        return std::nullopt;
    const double edge = median_side(faces, points);
    const double least = coarse_share * edge;
    if (!(least > std::numeric_limits<double>::min()))
        return std::nullopt;
    std::vector<CoarseCoordinates> found;
    std::vector<int> rasters; // steps that edges run by, of each of those
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const Eigen::VectorXd coordinates = points.col(axis);
        const bool is_single = are_single_precision(coordinates);
        const double step = step_of(coordinates, is_single, least);
        if (step <= least)
            continue;
        const double largest = coordinates.cwiseAbs().maxCoeff();
        const bool is_far = step <= 2.0 * distance_of_numbers(largest, is_single);
        found.push_back({step, step / edge, largest, is_single, is_far});
        rasters.push_back(is_far ? 0 : raster_steps(faces, coordinates, step));
    }
    const bool are_several =
        std::count_if(rasters.begin(), rasters.end(), [](int steps) { return steps > 0; }) > 1;
    std::optional<CoarseCoordinates> coarsest;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const bool is_exempt =
            exempt_rasters && (rasters[i] == 1 || (rasters[i] == 2 && are_several));
        if (!is_exempt && (!coarsest || found[i].step > coarsest->step))
            coarsest = found[i];
    }
    return coarsest;
}

std::string describe(const CoarseCoordinates& coarse)
{
    const char* const precision = coarse.is_single ? "single precision" : "double precision";
    return join("multiples of ", rounded(coarse.step), ", ", rounded(100.0 * coarse.share),
                " % of the median edge: ",
                coarse.is_far
                    ? join(precision, " has no finer numbers ", rounded(coarse.largest),
                           " from the origin. Export relative to a local origin",
                           coarse.is_single ? ", or in double precision" : "")
                    : "digits were cut off, unless the mesh was made of round numbers (by "
                      "hand, of slices). Export with more digits, or relative to a "
                      "local origin");
}

double coordinate_spacing(const Points& points)
{
    const double largest = points.rows() == 0 ? 0.0 : points.cwiseAbs().maxCoeff();
    if (!(largest > 0.0))
        return 0.0;
    const bool is_single = are_single_precision(points.reshaped());
    int exponent = 0;
    (void)std::frexp(largest, &exponent);
    const double binary = std::ldexp(1.0, exponent - (is_single ? 24 : 53));

    // Of more digits than `most`, single precision holds nearly all numbers and double precision so many that they
    // matter to nobody.
    const int most = is_single ? 6 : 9;
    const double rounding = is_single ? 6e-8 : 1e-15;
    int digits = 4; // of fewer, as small integers have, nobody writes coordinates
    for (const double coordinate : points.reshaped()) {
        const double x = std::abs(coordinate);
        if (x < 1e-9 * largest)
            continue;
        while (!has_digits(x, digits, rounding))
            if (++digits > most)
                return binary;
    }
    return std::max(binary, std::pow(10.0, decade_of(largest) + 1 - digits));
}

} // namespace shape::internal
