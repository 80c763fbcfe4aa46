// SPDX-License-Identifier: MIT

#include "tests/support/meshes.h"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>

#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape::test {
using namespace internal;
namespace {

using std::numbers::pi;

struct Soup
{
    std::vector<Eigen::Vector3d> points;
    std::vector<Eigen::Vector3i> faces;
};

TestMesh build(std::string name, const Soup& soup)
{
    Points points(static_cast<Eigen::Index>(soup.points.size()), 3);
    for (Eigen::Index v = 0; v < points.rows(); ++v)
        points.row(v) = soup.points[to_size(v)].transpose();
    Faces faces(static_cast<Eigen::Index>(soup.faces.size()), 3);
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        faces.row(f) = soup.faces[to_size(f)].transpose();
    return {std::move(name), Topology(faces, static_cast<int>(points.rows())), points};
}

Soup icosahedron()
{
    const double g = (1.0 + std::sqrt(5.0)) / 2.0;
    Soup soup;
    soup.points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    for (Eigen::Vector3d& p : soup.points)
        p.normalize();
    // The faces are the triples of mutually nearest vertices, turned outwards.
    for (int a = 0; a < 12; ++a)
        for (int b = a + 1; b < 12; ++b)
            for (int c = b + 1; c < 12; ++c) {
                const auto& p = soup.points;
                const auto [i, j, k] = std::tuple(to_size(a), to_size(b), to_size(c));
                const double reach = 1.1;
                if ((p[i] - p[j]).norm() > reach || (p[j] - p[k]).norm() > reach ||
                    (p[k] - p[i]).norm() > reach)
                    continue;
                const bool outwards = p[i].cross(p[j]).dot(p[k]) > 0.0;
                soup.faces.push_back(outwards ? Eigen::Vector3i(a, b, c)
                                              : Eigen::Vector3i(a, c, b));
            }
    return soup;
}

Soup split(const Soup& soup)
{
    Soup fine;
    fine.points = soup.points;
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
        const auto [entry, is_new] =
            middles.try_emplace(std::minmax(a, b), static_cast<int>(fine.points.size()));
        if (is_new)
            fine.points.push_back((soup.points[to_size(a)] + soup.points[to_size(b)]).normalized());
        return entry->second;
    };
    for (const Eigen::Vector3i& f : soup.faces) {
        const int a = middle(f[0], f[1]);
        const int b = middle(f[1], f[2]);
        const int c = middle(f[2], f[0]);
        fine.faces.insert(fine.faces.end(), {{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}});
    }
    return fine;
}

/// Quads of a grid that may close up in either direction, split along alternating diagonals.
Soup grid(int rows, int columns, bool close_rows, bool close_columns)
{
    Soup soup;
    const auto vertex = [&](int r, int c) { return (r % rows) * columns + c % columns; };
    for (int r = 0; r < (close_rows ? rows : rows - 1); ++r)
        for (int c = 0; c < (close_columns ? columns : columns - 1); ++c) {
            const int p = vertex(r, c);
            const int q = vertex(r, c + 1);
            const int s = vertex(r + 1, c + 1);
            const int t = vertex(r + 1, c);
            if ((r + c) % 2 == 0)
                soup.faces.insert(soup.faces.end(), {{p, q, s}, {p, s, t}});
            else
                soup.faces.insert(soup.faces.end(), {{p, q, t}, {q, s, t}});
        }
    soup.points.resize(to_size(rows * columns));
    return soup;
}

} // namespace

TestMesh tetrahedron()
{
    Soup soup;
    soup.points = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
    soup.faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    return build("tetrahedron", soup);
}

TestMesh icosphere(int levels)
{
    Soup soup = icosahedron();
    for (int level = 0; level < levels; ++level)
        soup = split(soup);
    return build("icosphere", soup);
}

TestMesh bumpy_sphere(int levels, double amplitude, unsigned seed)
{
    TestMesh mesh = icosphere(levels);
    mesh.name = "bumpy sphere";
    Random random(seed);
    Eigen::VectorXd radius = Eigen::VectorXd::Ones(mesh.points.rows());
    for (int bump = 0; bump < 12; ++bump) {
        const Eigen::Vector3d centre =
            Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
        const double height = amplitude * random.uniform(-1.0, 1.0);
        radius.array() += height * (12.0 * ((mesh.points * centre).array() - 1.0)).exp();
    }
    mesh.points = radius.asDiagonal() * mesh.points;
    return mesh;
}

TestMesh torus(int around, int along)
{
    Soup soup = grid(along, around, true, true);
    for (int i = 0; i < along; ++i)
        for (int j = 0; j < around; ++j) {
            const double u = 2.0 * pi * i / along;
            const double v = 2.0 * pi * j / around;
            const double r = 3.0 + std::cos(v);
            soup.points[to_size(i * around + j)] = {r * std::cos(u), -r * std::sin(u),
                                                    std::sin(v) * (1.0 + 0.1 * std::cos(3.0 * u))};
        }
    return build("torus", soup);
}

TestMesh open_patch(int n, unsigned seed)
{
    Soup soup = grid(n + 1, n + 1, false, false);
    Random random(seed);
    for (int r = 0; r <= n; ++r)
        for (int c = 0; c <= n; ++c) {
            const double x = (2.0 * c + random.uniform(-0.2, 0.2)) / n - 1.0;
            const double y = (2.0 * r + random.uniform(-0.2, 0.2)) / n - 1.0;
            soup.points[to_size(r * (n + 1) + c)] = {x, y, 0.5 * std::sin(2.0 * x) + 0.3 * y * y};
        }
    return build("open patch", soup);
}

FoldedPatch folded_patch()
{
    TestMesh mesh = open_patch(48, 4);
    Points folded = mesh.points;
    for (int row = 8; row <= 40; row += 16)
        for (int column = 8; column <= 40; column += 16) {
            const int v = 49 * row + column;
            folded.row(v) += 2.2 * (mesh.points.row(v + 1) - mesh.points.row(v));
        }
    return {std::move(mesh), std::move(folded)};
}

TestMesh open_cylinder(int around, int along)
{
    Soup soup = grid(along, around, false, true);
    for (int i = 0; i < along; ++i)
        for (int j = 0; j < around; ++j) {
            const double v = 2.0 * pi * j / around;
            soup.points[to_size(i * around + j)] = {std::cos(v), std::sin(v),
                                                    4.0 * i / (along - 1) + 0.1 * std::sin(v)};
        }
    return build("open cylinder", soup);
}

std::vector<TestMesh> sample_meshes()
{
    return {tetrahedron(), bumpy_sphere(2, 0.3, 1), torus(9, 16), open_patch(10, 2),
            open_cylinder(10, 8)};
}

ShapePoint shape_of(const Topology& topology, const Points& points)
{
    return {edge_lengths(topology, points), dihedral_angles(topology, points)};
}

Points moved(const Points& points, unsigned seed)
{
    Random random(seed);
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
            .normalized();
    const Eigen::RowVector3d shift(random.normal(), random.normal(), random.normal());
    return (points * turn.toRotationMatrix().transpose()).rowwise() + shift;
}

} // namespace shape::test
