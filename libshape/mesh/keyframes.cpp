// SPDX-License-Identifier: MIT

#include "libshape/mesh/keyframes.h"

#include <algorithm>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
using namespace internal;
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

using Coordinates = Eigen::Array<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

void check(const std::vector<Points>& frames, double tolerance)
{
    if (frames.empty())
        throw InvalidInput("frames is empty, a sequence needs at least one");
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (frames[i].rows() != frames.front().rows())
            throw InvalidInput(join("frames[", i, "] has ", frames[i].rows(), " points, frames[0] ",
                                    frames.front().rows()));
        if (!frames[i].allFinite())
            throw InvalidInput(join("frames[", i, "] has a coordinate that is not finite"));
    }
    if (!(tolerance >= 0.0))
        throw InvalidInput(join("tolerance is ", tolerance, ", must be >= 0"));
}

Coordinates slope(const std::vector<Points>& frames, std::size_t from, std::size_t to)
{
    return (frames[to] - frames[from]).array() / static_cast<double>(to - from);
}

/// The keyframe before each frame on a path of fewest keyframes.
std::vector<std::size_t> shortest_paths(const std::vector<Points>& frames, double tolerance)
{
    const std::size_t count = frames.size();
    std::vector<std::size_t> before(count, 0);
    std::vector<std::size_t> length(count, std::numeric_limits<std::size_t>::max());
    length[0] = 0;
    const Coordinates anything = Coordinates::Constant(frames.front().rows(), 3, infinity);
    for (std::size_t i = 0; i + 1 < count; ++i) {
        Coordinates low = -anything;
        Coordinates high = anything;
        for (std::size_t j = i + 1; j < count && (low <= high).all(); ++j) {
            const Coordinates own = slope(frames, i, j);
            if (length[i] + 1 < length[j] && (low <= own).all() && (own <= high).all()) {
                length[j] = length[i] + 1;
                before[j] = i;
            }
            const double room = tolerance / static_cast<double>(j - i);
            low = low.max(own - room);
            high = high.min(own + room);
        }
    }
    return before;
}

double interpolation_error(const std::vector<Points>& frames, std::size_t from, std::size_t to)
{
    const Coordinates step = slope(frames, from, to);
    double error = 0.0;
    for (std::size_t k = from + 1; k < to; ++k) {
        const Coordinates made = frames[from].array() + static_cast<double>(k - from) * step;
        error = std::max(error, (frames[k].array() - made).abs().maxCoeff());
    }
    return error;
}

} // namespace

Keyframes choose_keyframes(const std::vector<Points>& frames, double tolerance)
{
    check(frames, tolerance);
    const std::vector<std::size_t> before = shortest_paths(frames, tolerance);
    Keyframes keyframes{{frames.size() - 1}};
    while (keyframes.frames.back() > 0) {
        const std::size_t to = keyframes.frames.back();
        keyframes.frames.push_back(before[to]);
        keyframes.error = std::max(keyframes.error, interpolation_error(frames, before[to], to));
    }
    std::reverse(keyframes.frames.begin(), keyframes.frames.end());
    return keyframes;
}

} // namespace shape
