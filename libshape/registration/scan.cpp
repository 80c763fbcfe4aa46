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

void check_faces(const Points& points, const Faces& faces)
{
    if (faces.rows() == 0)
        throw InvalidInput("the scan has no face; a cloud of points needs a surface first");
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        if (faces.row(f).minCoeff() < 0 || faces.row(f).maxCoeff() >= points.rows())
            throw InvalidInput(
                join("face ", f, " names a vertex that is not among the ", points.rows()));
}

/// The vertices of a scan as they are given.
struct RawVertices
{
    Points points;          // 0 where not finite
    std::vector<char> bad;  // not finite
    std::vector<int> first; // at the same place
    std::size_t not_finite = 0;
};

RawVertices raw_vertices(const Points& points)
{
    RawVertices raw{points, std::vector<char>(to_size(points.rows()), 0), {}};
    for (Eigen::Index v = 0; v < points.rows(); ++v)
        if (!points.row(v).allFinite()) {
            raw.bad[to_size(v)] = 1;
            raw.points.row(v).setZero();
            ++raw.not_finite;
        }
    raw.first = first_at_place(raw.points);
    return raw;
}

/// By the rule of find_degenerate_geometry(): area > 1e-14 longest^2. The norm is twice the area.
bool has_area(const Points& points, const std::array<int, 3>& corners)
{
    const Eigen::Vector3d a = points.row(corners[0]), b = points.row(corners[1]),
                          c = points.row(corners[2]);
    const double longest =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    return (b - a).cross(c - a).norm() > 2e-14 * longest;
}

struct FaceCorners
{
    std::array<int, 3> sorted; // the first ones at their places
    int face;
};

struct KeptFaces
{
    std::vector<FaceCorners> faces; // ascending
    std::size_t without_area = 0;
    std::size_t twice = 0;
};

/// Faces with an area, each once, the first of equal ones.
KeptFaces kept_faces(const RawVertices& raw, const Faces& faces)
{
    KeptFaces result;
    std::vector<FaceCorners>& kept = result.faces;
    kept.reserve(to_size(faces.rows()));
    for (int f = 0; f < faces.rows(); ++f) {
        std::array<int, 3> c{faces(f, 0), faces(f, 1), faces(f, 2)};
        if (raw.bad[to_size(c[0])] + raw.bad[to_size(c[1])] + raw.bad[to_size(c[2])] > 0)
            continue;
        for (int& v : c)
            v = raw.first[to_size(v)];
        if (!has_area(raw.points, c)) {
            ++result.without_area;
            continue;
        }
        std::sort(c.begin(), c.end());
        kept.push_back({c, f});
    }
    std::sort(kept.begin(), kept.end(), [](const FaceCorners& a, const FaceCorners& b) {
        return a.sorted != b.sorted ? a.sorted < b.sorted : a.face < b.face;
    });
    const auto end = std::unique(
        kept.begin(), kept.end(),
        [](const FaceCorners& a, const FaceCorners& b) { return a.sorted == b.sorted; });
    result.twice = to_size(kept.end() - end);
    kept.erase(end, kept.end());
    std::sort(kept.begin(), kept.end(),
              [](const FaceCorners& a, const FaceCorners& b) { return a.face < b.face; });
    return result;
}

/// The kept faces and the vertices that they name, in the order given.
Scan compacted(const RawVertices& raw, const Faces& faces, const std::vector<FaceCorners>& kept)
{
    Scan scan;
    std::vector<int> numbers(raw.first.size(), -1);
    std::vector<int> vertices;
    for (const FaceCorners& face : kept)
        for (const int v : face.sorted)
            numbers[to_size(v)] = 0;
    for (int v = 0; v < raw.points.rows(); ++v)
        if (numbers[to_size(v)] == 0) {
            numbers[to_size(v)] = static_cast<int>(vertices.size());
            vertices.push_back(v);
        }
    scan.points = raw.points(vertices, Eigen::all);
    scan.faces.resize(std::ssize(kept), 3);
    for (std::size_t i = 0; i < kept.size(); ++i)
        for (int k = 0; k < 3; ++k)
            scan.faces(static_cast<Eigen::Index>(i), k) =
                numbers[to_size(raw.first[to_size(faces(kept[i].face, k))])];
    return scan;
}

/// What was left out, a sentence each.
std::vector<std::string> notes_on(const RawVertices& raw, const Faces& faces, const KeptFaces& kept)
{
    std::size_t isolated = 0, merged = 0;
    std::vector<char> named(raw.first.size(), 0);
    for (const int v : faces.reshaped())
        named[to_size(v)] = 1;
    for (std::size_t v = 0; v < named.size(); ++v) {
        isolated += named[v] == 0 && raw.bad[v] == 0 ? 1 : 0;
        merged += named[v] != 0 && raw.bad[v] == 0 && raw.first[v] != static_cast<int>(v) ? 1 : 0;
    }
    std::vector<std::string> notes;
    const auto note = [&](std::size_t count, const char* one, const char* more, const char* what) {
        if (count > 0)
            notes.push_back(join(counted(count, one, more), what));
    };
    note(raw.not_finite, "vertex", "vertices", " with a coordinate that is not finite");
    note(kept.without_area, "face", "faces", " without area");
    note(kept.twice, "face", "faces", " that occur twice");
    note(isolated, "vertex", "vertices", " without a face");
    note(merged, "vertex", "vertices", " at the place of another one (merged)");
    return notes;
}

} // namespace

Scan clean_scan(const Points& points, const Faces& faces)
{
    check_faces(points, faces);
    const RawVertices raw = raw_vertices(points);
    const KeptFaces kept = kept_faces(raw, faces);
    if (kept.faces.empty())
        throw InvalidInput("the scan has no face with an area");
    Scan scan = compacted(raw, faces, kept.faces);
    scan.ignored = notes_on(raw, faces, kept);
    return scan;
}

} // namespace shape
