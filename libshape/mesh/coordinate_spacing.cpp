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
#include "libshape/mesh/coordinate_lattice.h"

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
    std::array<std::optional<Lattice>, 3> lattices;
    bool has_some = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        lattices[axis] = find_lattice(points.col(static_cast<Eigen::Index>(axis)), least);
        has_some = has_some || lattices[axis];
    }
    if (!has_some)
        return std::nullopt;
    const std::array<bool, 3> meant =
        exempt_rasters ? are_meant(faces, points, lattices) : std::array<bool, 3>{};
    std::optional<CoarseCoordinates> coarsest;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!lattices[axis])
            continue;
        const Eigen::VectorXd coordinates = points.col(static_cast<Eigen::Index>(axis));
        const bool is_single = are_single_precision(coordinates);
        const double step = lattices[axis]->step;
        const double largest = coordinates.cwiseAbs().maxCoeff();
        const bool is_far = step <= 2.0 * distance_of_numbers(largest, is_single);
        const bool is_told = is_far || !meant[axis];
        if (is_told && (!coarsest || step > coarsest->step))
            coarsest = {step, step / edge, largest, is_single, is_far, lattices[axis]->is_far_half};
    }
    return coarsest;
}

std::string describe(const CoarseCoordinates& coarse)
{
    const char* const precision = coarse.is_single ? "single precision" : "double precision";
    return join("multiples of ", rounded(coarse.step), ", ", rounded(100.0 * coarse.share),
                " % of the median edge: ",
                coarse.is_far ? join(precision, " has no finer numbers ", rounded(coarse.largest),
                                     " from the origin. Export relative to a local origin",
                                     coarse.is_single ? ", or in double precision" : "")
                : coarse.is_far_half
                    ? "far from the origin, and less near it: numbers of few bits (half precision, "
                      "float16). "
                      "Export in single precision or with more digits"
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
