// SPDX-License-Identifier: MIT

#include "libshape/registration/scan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;
namespace {

/// For every vertex the first one at the same place.
std::vector<int> first_at_place(const Points& points)
{
    std::vector<int> order(to_size(points.rows()));
    std::iota(order.begin(), order.end(), 0);
    const auto place = [&](int v) { return std::array{points(v, 0), points(v, 1), points(v, 2)}; };
    std::sort(order.begin(), order.end(), [&](int a, int b) {
        const auto at_a = place(a), at_b = place(b);
        return at_a != at_b ? at_a < at_b : a < b;
    });
    std::vector<int> first(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool again = i > 0 && place(order[i]) == place(order[i - 1]);
        first[to_size(order[i])] = again ? first[to_size(order[i - 1])] : order[i];
    }
    return first;
}

} // namespace

Scan clean_scan(const Points& points, const Faces& faces)
{
    if (faces.rows() == 0)
        throw InvalidInput("the scan has no face; a cloud of points needs a surface first");
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        if (faces.row(f).minCoeff() < 0 || faces.row(f).maxCoeff() >= points.rows())
            throw InvalidInput(
                join("face ", f, " names a vertex that is not among the ", points.rows()));
    Points finite = points;
    std::vector<char> bad(to_size(points.rows()), 0);
    std::size_t not_finite = 0;
    for (Eigen::Index v = 0; v < points.rows(); ++v)
        if (!points.row(v).allFinite()) {
            bad[to_size(v)] = 1;
            finite.row(v).setZero();
            ++not_finite;
        }
    const std::vector<int> first = first_at_place(finite);

    struct Corners
    {
        std::array<int, 3> sorted;
        int face;
    };
    std::vector<Corners> kept;
    kept.reserve(to_size(faces.rows()));
    std::size_t without_area = 0;
    for (int f = 0; f < faces.rows(); ++f) {
        std::array<int, 3> c{faces(f, 0), faces(f, 1), faces(f, 2)};
        if (bad[to_size(c[0])] + bad[to_size(c[1])] + bad[to_size(c[2])] > 0)
            continue;
        for (int& v : c)
            v = first[to_size(v)];
        const Eigen::Vector3d a = finite.row(c[0]), b = finite.row(c[1]), d = finite.row(c[2]);
        const double longest =
            std::max({(b - a).squaredNorm(), (d - b).squaredNorm(), (a - d).squaredNorm()});
        if (!((b - a).cross(d - a).norm() > 1e-14 * longest)) {
            ++without_area;
            continue;
        }
        std::sort(c.begin(), c.end());
        kept.push_back({c, f});
    }
    std::sort(kept.begin(), kept.end(), [](const Corners& a, const Corners& b) {
        return a.sorted != b.sorted ? a.sorted < b.sorted : a.face < b.face;
    });
    const auto end = std::unique(kept.begin(), kept.end(), [](const Corners& a, const Corners& b) {
        return a.sorted == b.sorted;
    });
    const std::size_t twice = to_size(kept.end() - end);
    kept.erase(end, kept.end());
    std::sort(kept.begin(), kept.end(),
              [](const Corners& a, const Corners& b) { return a.face < b.face; });
    if (kept.empty())
        throw InvalidInput("the scan has no face with an area");

    Scan scan;
    std::vector<int> numbers(to_size(points.rows()), -1);
    std::vector<int> vertices;
    for (const Corners& face : kept)
        for (const int v : face.sorted)
            numbers[to_size(v)] = 0;
    for (int v = 0; v < points.rows(); ++v)
        if (numbers[to_size(v)] == 0) {
            numbers[to_size(v)] = static_cast<int>(vertices.size());
            vertices.push_back(v);
        }
    scan.points = finite(vertices, Eigen::all);
    scan.faces.resize(std::ssize(kept), 3);
    for (std::size_t i = 0; i < kept.size(); ++i)
        for (int k = 0; k < 3; ++k)
            scan.faces(static_cast<Eigen::Index>(i), k) =
                numbers[to_size(first[to_size(faces(kept[i].face, k))])];

    std::size_t isolated = 0, merged = 0;
    std::vector<char> named(to_size(points.rows()), 0);
    for (const int v : faces.reshaped())
        named[to_size(v)] = 1;
    for (std::size_t v = 0; v < named.size(); ++v) {
        isolated += named[v] == 0 && bad[v] == 0 ? 1 : 0;
        merged += named[v] != 0 && bad[v] == 0 && first[v] != static_cast<int>(v) ? 1 : 0;
    }
    const auto note = [&](std::size_t count, const char* one, const char* more, const char* what) {
        if (count > 0)
            scan.ignored.push_back(join(counted(count, one, more), what));
    };
    note(not_finite, "vertex", "vertices", " with a coordinate that is not finite");
    note(without_area, "face", "faces", " without area");
    note(twice, "face", "faces", " that occur twice");
    note(isolated, "vertex", "vertices", " without a face");
    note(merged, "vertex", "vertices", " at the place of another one (merged)");
    return scan;
}

} // namespace shape
