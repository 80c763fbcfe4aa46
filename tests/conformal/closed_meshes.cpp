// SPDX-License-Identifier: MIT

#include "tests/conformal/closed_meshes.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "libshape/base/random.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape::test {
using namespace internal;
namespace {

using std::numbers::pi;

Eigen::RowVector3d normal_vector(Random& random)
{
    const double x = random.normal();
    const double y = random.normal();
    return {x, y, random.normal()};
}

TestMesh build(const char* name, const std::vector<Eigen::Vector3i>& list, const Points& points)
{
    Faces faces(static_cast<Eigen::Index>(list.size()), 3);
    for (std::size_t f = 0; f < list.size(); ++f)
        faces.row(static_cast<Eigen::Index>(f)) = list[f].transpose();
    return {name, Topology(faces, static_cast<int>(points.rows())), points};
}

} // namespace

TestMesh random_inscribed(int count, unsigned seed)
{
    Random random(seed);
    Points points(count, 3);
    for (int v = 0; v < count; ++v)
        points.row(v) = normal_vector(random).normalized();
    // A tetrahedron, then point by point: the faces that see it give way to a cone over their rim.
    const auto sees = [&](const Eigen::Vector3i& f, int v) {
        const Eigen::RowVector3d a = points.row(f[0]);
        const Eigen::RowVector3d b = points.row(f[1]) - a;
        const Eigen::RowVector3d c = points.row(f[2]) - a;
        return b.cross(c).dot(points.row(v) - a) > 0.0;
    };
    std::vector<Eigen::Vector3i> faces{{0, 1, 2}};
    if (sees(faces[0], 3))
        std::swap(faces[0][1], faces[0][2]);
    const Eigen::Vector3i base = faces[0];
    for (int k = 0; k < 3; ++k)
        faces.emplace_back(base[(k + 1) % 3], base[k], 3);
    for (int v = 4; v < count; ++v) {
        std::vector<Eigen::Vector3i> kept;
        std::set<std::pair<int, int>> rim;
        for (const Eigen::Vector3i& f : faces) {
            if (!sees(f, v)) {
                kept.push_back(f);
                continue;
            }
            for (int k = 0; k < 3; ++k)
                if (rim.erase({f[(k + 1) % 3], f[k]}) == 0)
                    rim.insert({f[k], f[(k + 1) % 3]});
        }
        for (const auto& [a, b] : rim)
            kept.emplace_back(a, b, v);
        faces = std::move(kept);
    }
    return build("random inscribed polyhedron", faces, points);
}

TestMesh stretched(TestMesh mesh, const Eigen::Vector3d& axes)
{
    mesh.name = "stretched " + mesh.name;
    mesh.points = mesh.points * axes.asDiagonal();
    return mesh;
}

TestMesh jittered(TestMesh mesh, double amount, unsigned seed)
{
    Random random(seed);
    const double step = amount * edge_lengths(mesh.topology, mesh.points).mean();
    for (Eigen::Index v = 0; v < mesh.points.rows(); ++v)
        mesh.points.row(v) += step * normal_vector(random);
    mesh.name = "jittered " + mesh.name;
    return mesh;
}

TestMesh with_slivers(const TestMesh& mesh, double share, double degrees, unsigned seed)
{
    Random random(seed);
    std::vector<Eigen::Vector3i> faces;
    std::vector<Eigen::RowVector3d> added;
    const int old_count = mesh.topology.vertex_count();
    for (int f = 0; f < mesh.topology.face_count(); ++f) {
        const Eigen::Vector3i v = mesh.topology.faces().row(f).transpose();
        if (random.uniform() >= share) {
            faces.push_back(v);
            continue;
        }
        const auto k = static_cast<int>(random.index(3));
        const int a = v[k];
        const int b = v[(k + 1) % 3];
        const int c = v[(k + 2) % 3];
        const Eigen::RowVector3d side = mesh.points.row(b) - mesh.points.row(a);
        const Eigen::RowVector3d middle = mesh.points.row(a) + 0.5 * side;
        Eigen::RowVector3d inwards = mesh.points.row(c) - middle;
        inwards -= inwards.dot(side) / side.squaredNorm() * side;
        added.push_back(middle +
                        0.5 * side.norm() * std::tan(degrees * pi / 180.0) * inwards.normalized());
        const int p = old_count + static_cast<int>(added.size()) - 1;
        faces.insert(faces.end(), {{a, b, p}, {b, c, p}, {c, a, p}});
    }
    Points points(old_count + static_cast<Eigen::Index>(added.size()), 3);
    points.topRows(old_count) = mesh.points;
    for (std::size_t i = 0; i < added.size(); ++i)
        points.row(old_count + static_cast<Eigen::Index>(i)) = added[i];
    TestMesh result = build("", faces, points);
    result.name = mesh.name + " with slivers";
    return result;
}

TestMesh globe(int meridians, int parallels)
{
    Points points(meridians * parallels + 2, 3);
    const auto vertex = [&](int i, int j) { return i * meridians + j % meridians; };
    for (int i = 0; i < parallels; ++i)
        for (int j = 0; j < meridians; ++j) {
            const double latitude = pi * (i + 1.0) / (parallels + 1.0) - 0.5 * pi;
            const double longitude = 2.0 * pi * (j + 0.1 * i) / meridians;
            points.row(vertex(i, j)) << std::cos(latitude) * std::cos(longitude),
                std::cos(latitude) * std::sin(longitude), std::sin(latitude);
        }
    const int south = meridians * parallels;
    points.row(south) << 0.0, 0.0, -1.0;
    points.row(south + 1) << 0.0, 0.0, 1.0;
    std::vector<Eigen::Vector3i> faces;
    for (int j = 0; j < meridians; ++j) {
        faces.emplace_back(vertex(0, j + 1), vertex(0, j), south);
        faces.emplace_back(vertex(parallels - 1, j), vertex(parallels - 1, j + 1), south + 1);
        for (int i = 0; i + 1 < parallels; ++i) {
            faces.emplace_back(vertex(i, j), vertex(i, j + 1), vertex(i + 1, j));
            faces.emplace_back(vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j));
        }
    }
    return build("globe", faces, points);
}

TestMesh tentacled(int levels, int count, double length, unsigned seed)
{
    TestMesh mesh = icosphere(levels);
    Random random(seed);
    Eigen::VectorXd radius = Eigen::VectorXd::Ones(mesh.points.rows());
    for (int i = 0; i < count; ++i) {
        const Eigen::Vector3d axis = normal_vector(random).normalized().transpose();
        radius.array() += length * (60.0 * ((mesh.points * axis).array() - 1.0)).exp();
    }
    mesh.points = radius.asDiagonal() * mesh.points;
    mesh.name = "tentacled sphere";
    return mesh;
}

} // namespace shape::test
