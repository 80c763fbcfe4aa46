// SPDX-License-Identifier: MIT

#include "libshape/mesh/defects.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "libshape/base/counted.h"
#include "libshape/base/format.h"
#include "libshape/base/gathered_vectors.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector3.h"
#include "libshape/base/vectorised.h"
#include "libshape/mesh/coordinate_spacing.h"
#include "libshape/mesh/partition.h"
#include "libshape/mesh/triangle_area.h"

namespace shape {
using namespace internal;
namespace {

/// Keeps at most `limit` defects of each kind.
class DefectList
{
public:
    explicit DefectList(int limit) : limit_(limit) {}

    void add(DefectKind kind, int face, int vertex, std::string message)
    {
        if (count_[kind]++ < limit_)
            defects_.push_back({kind, face, vertex, std::move(message)});
    }
    [[nodiscard]] bool empty() const { return defects_.empty(); }
    [[nodiscard]] std::vector<Defect> take() { return std::move(defects_); }

private:
    int limit_;
    std::map<DefectKind, int> count_;
    std::vector<Defect> defects_;
};

/// One side of a face: the edge low-high, and whether the face runs from low to high.
struct Side
{
    int low;
    int high;
    int face;
    bool forward;
};

std::vector<Side> sorted_sides(const Faces& faces)
{
    std::vector<Side> sides;
    sides.reserve(to_size(3 * faces.rows()));
    for (int f = 0; f < faces.rows(); ++f)
        for (int c = 0; c < 3; ++c) {
            const int a = faces(f, c);
            const int b = faces(f, (c + 1) % 3);
            sides.push_back({std::min(a, b), std::max(a, b), f, a < b});
        }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face);
    });
    return sides;
}

void find_duplicate_faces(const Faces& faces, DefectList& list)
{
    std::vector<std::array<int, 4>> keys;
    keys.reserve(to_size(faces.rows()));
    for (int f = 0; f < faces.rows(); ++f) {
        std::array<int, 4> key{faces(f, 0), faces(f, 1), faces(f, 2), f};
        std::sort(key.begin(), key.begin() + 3);
        keys.push_back(key);
    }
    std::sort(keys.begin(), keys.end());
    for (std::size_t i = 1; i < keys.size(); ++i)
        if (std::equal(keys[i].begin(), keys[i].begin() + 3, keys[i - 1].begin()))
            list.add(
                DefectKind::DuplicateFace, keys[i][3], keys[i][0],
                join("face ", keys[i][3], " repeats face ", keys[i - 1][3], " (vertices ",
                     keys[i][0], ", ", keys[i][1], ", ", keys[i][2], "); remove one of the two"));
}

void find_edge_defects(const std::vector<Side>& sides, DefectList& list)
{
    for (std::size_t i = 0; i < sides.size();) {
        std::size_t end = i + 1;
        while (end < sides.size() && sides[end].low == sides[i].low &&
               sides[end].high == sides[i].high)
            ++end;
        const Side& s = sides[i];
        if (end - i > 2)
            list.add(DefectKind::NonManifoldEdge, sides[i + 2].face, s.low,
                     join("edge ", s.low, "-", s.high, " has ", end - i, " faces (", s.face, ", ",
                          sides[i + 1].face, ", ", sides[i + 2].face,
                          ", ...); an edge may have at most 2, take the others away"));
        else if (end - i == 2 && s.forward == sides[i + 1].forward)
            list.add(DefectKind::FlippedFace, sides[i + 1].face, s.low,
                     join("faces ", s.face, " and ", sides[i + 1].face, " both run ",
                          s.forward ? s.low : s.high, " -> ", s.forward ? s.high : s.low,
                          "; flip one, neighbours must run through an edge in opposite "
                          "directions"));
        i = end;
    }
}

/// Corners around a vertex are united across the edges they share; more than one class is a
/// bow-tie. Faces united the same way give the components.
void find_fans_and_components(const Faces& faces, int vertex_count, const std::vector<Side>& sides,
                              DefectList& list)
{
    Partition corners(to_size(3 * faces.rows()));
    Partition components(to_size(faces.rows()));
    const auto corner = [&](int face, int vertex) {
        const int c = faces(face, 0) == vertex ? 0 : faces(face, 1) == vertex ? 1 : 2;
        return 3 * face + c;
    };
    for (std::size_t i = 1; i < sides.size(); ++i) {
        const Side& a = sides[i - 1];
        const Side& b = sides[i];
        if (a.low != b.low || a.high != b.high)
            continue;
        corners.unite(corner(a.face, a.low), corner(b.face, a.low));
        corners.unite(corner(a.face, a.high), corner(b.face, a.high));
        components.unite(a.face, b.face);
    }
    std::vector<int> fan(to_size(vertex_count), -1);
    std::vector<char> reported(to_size(vertex_count), 0);
    for (int h = 0; h < 3 * faces.rows(); ++h) {
        const auto v = to_size(faces(h / 3, h % 3));
        const int root = corners.root(h);
        if (fan[v] < 0)
            fan[v] = root;
        else if (fan[v] != root && !reported[v]) {
            reported[v] = 1;
            list.add(DefectKind::BowTie, h / 3, static_cast<int>(v),
                     join("vertex ", v, " joins separate fans of faces (faces ", fan[v] / 3,
                          " and ", h / 3, "); split it into one vertex a fan"));
        }
    }
    for (int v = 0; v < vertex_count; ++v)
        if (fan[to_size(v)] < 0)
            list.add(DefectKind::IsolatedVertex, -1, v,
                     join("vertex ", v, " belongs to no face; remove it"));

    // A bow-tie joins components through a vertex only: those are counted apart as well.
    std::vector<int> size(to_size(faces.rows()), 0);
    for (int f = 0; f < faces.rows(); ++f)
        ++size[to_size(components.root(f))];
    const auto count = std::count_if(size.begin(), size.end(), [](int s) { return s > 0; });
    if (count > 1) {
        int first_outside = 0;
        while (components.root(first_outside) == 0)
            ++first_outside;
        list.add(DefectKind::SeveralComponents, first_outside, faces(first_outside, 0),
                 join("the surface has ", count, " components (face ", first_outside,
                      " is not connected with face 0); keep one, or treat each as a mesh of its "
                      "own"));
    }
}

/// Sets 1 where a triangle of sides b - a and c - a may be without area, else 0: where
///
///     |(b - a) x (c - a)|^2 > 5e-28 longest^4    and    longest^2 > 1e-60
///
/// it has one, by the rule of find_degenerate_geometry() squared (4e-28) and a quarter more for rounding; below
/// 1e-60 the squares would underflow. In memory a coordinate of 128 faces is a row; the plain way takes three roots a face.
SHAPE_VECTORISED void find_suspects(int count, const VectorRows& along, const VectorRows& back,
                                    double* __restrict suspects)
{
    for (int i = 0; i < count; ++i) {
        const Vector3<double> u = along[i];
        const Vector3<double> v = back[i];
        const Vector3<double> w = v - u;
        const Vector3<double> normal = cross(u, v);
        const double uu = dot(u, u);
        const double vv = dot(v, v);
        const double ww = dot(w, w);
        const double larger = uu > vv ? uu : vv;
        const double square = larger > ww ? larger : ww;
        const bool has_area = dot(normal, normal) > 5e-28 * square * square && square > 1e-60;
        suspects[i] = has_area ? 0.0 : 1.0;
    }
}

/// Faces, ascending, that are to be looked at: few.
std::vector<int> suspects(const Faces& faces, const Points& points)
{
    std::vector<int> found;
    const int total = static_cast<int>(faces.rows());
    for (int first = 0; first < total; first += block_size) {
        const int count = std::min(block_size, total - first);
        VectorRows along, back;
        Row is_suspect;
        const int* const corners = faces.data() + 3 * first;
        gather_differences(count, points.data(), {corners + 1, 3}, {corners, 3}, along);
        gather_differences(count, points.data(), {corners + 2, 3}, {corners, 3}, back);
        find_suspects(count, along, back, is_suspect);
        for (int i = 0; i < count; ++i)
            if (is_suspect[i] > 0.0)
                found.push_back(first + i);
    }
    return found;
}

/// Whether the longest edge is in its range, or all edges have the length 0, which their faces say.
bool has_usual_size(const Faces& faces, const Points& points, DefectList& list)
{
    constexpr double most = 1e60;
    // Sides of the bounding box tell of nearly every mesh: no edge is longer than three of them, and in a surface
    // of at most 1e10 edges, which hang together, one is at least the 1e10th part of the largest.
    const double side = (points.colwise().maxCoeff() - points.colwise().minCoeff()).maxCoeff();
    if (side <= 1e-1 * most && side >= 1e10 / most)
        return true;
    double longest = 0.0;
    int face = 0;
    int corner = 0;
    for (int f = 0; f < faces.rows(); ++f)
        for (int c = 0; c < 3; ++c) {
            const Eigen::RowVector3d edge =
                points.row(faces(f, (c + 1) % 3)) - points.row(faces(f, c));
            const double length = std::hypot(edge[0], edge[1], edge[2]);
            if (length > longest) {
                longest = length;
                face = f;
                corner = c;
            }
        }
    if (longest == 0.0 || (longest >= 1.0 / most && longest <= most))
        return true;
    list.add(DefectKind::SizeOutOfRange, face, faces(face, corner),
             join("the longest edge, ", faces(face, corner), "-", faces(face, (corner + 1) % 3),
                  ", has the length ", longest, ", must be in [", 1.0 / most, ", ", most,
                  "], as powers of lengths are taken; choose another unit, or repair the "
                  "coordinates"));
    return false;
}

/// That coordinates are too coarse, if they are.
std::string cause_of_collapse(const Faces& faces, const Points& points)
{
    const auto coarse = coarse_coordinates(faces, points, false);
    return coarse ? join("; coordinates are ", describe(*coarse)) : "";
}

} // namespace

std::vector<Defect> find_defects(const Faces& faces, int vertex_count, int limit)
{
    DefectList list(limit);
    if (vertex_count == 0 || faces.rows() == 0) {
        list.add(DefectKind::Empty, -1, -1,
                 join("the mesh has ", counted(vertex_count, "vertex", "vertices"), " and ",
                      counted(faces.rows(), "face"), "; it needs at least one face"));
        return list.take();
    }
    for (int f = 0; f < faces.rows(); ++f) {
        for (int c = 0; c < 3; ++c)
            if (faces(f, c) < 0 || faces(f, c) >= vertex_count)
                list.add(DefectKind::IndexOutOfRange, f, faces(f, c),
                         join("face ", f, " names vertex ", faces(f, c), ", the mesh has ",
                              vertex_count, " (0 to ", vertex_count - 1, ")"));
        if (faces(f, 0) == faces(f, 1) || faces(f, 1) == faces(f, 2) || faces(f, 2) == faces(f, 0))
            list.add(DefectKind::DegenerateFace, f, faces(f, 0),
                     join("face ", f, " (", faces(f, 0), ", ", faces(f, 1), ", ", faces(f, 2),
                          ") names a vertex twice; remove it"));
    }
    if (!list.empty())
        return list.take();
    const std::vector<Side> sides = sorted_sides(faces);
    find_duplicate_faces(faces, list);
    find_edge_defects(sides, list);
    find_fans_and_components(faces, vertex_count, sides, list);
    return list.take();
}

std::vector<Defect> find_degenerate_geometry(const Faces& faces, const Points& points, int limit)
{
    DefectList list(limit);
    for (int v = 0; v < points.rows(); ++v)
        if (!points.row(v).allFinite())
            list.add(DefectKind::NotFinite, -1, v,
                     join("vertex ", v, " has a coordinate that is not finite (", points(v, 0),
                          ", ", points(v, 1), ", ", points(v, 2), ")"));
    const bool is_finite = list.empty();
    if (is_finite && faces.rows() > 0 && !has_usual_size(faces, points, list))
        return list.take();
    bool is_first = true;
    for (const int f : suspects(faces, points)) {
        const Eigen::RowVector3d a = points.row(faces(f, 0));
        const Eigen::RowVector3d b = points.row(faces(f, 1));
        const Eigen::RowVector3d c = points.row(faces(f, 2));
        const double area = triangle_area(a, b, c);
        const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
        if (area > 1e-14 * longest * longest)
            continue;
        const std::string cause = is_finite && is_first ? cause_of_collapse(faces, points) : "";
        is_first = false;
        list.add(DefectKind::DegenerateTriangle, f, faces(f, 0),
                 join("face ", f, " (", faces(f, 0), ", ", faces(f, 1), ", ", faces(f, 2),
                      ") has no area; move one of its vertices, the triangle inequality "
                      "must be strict",
                      cause));
    }
    return list.take();
}

} // namespace shape
