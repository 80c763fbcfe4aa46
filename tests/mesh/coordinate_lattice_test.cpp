// SPDX-License-Identifier: MIT

#include "libshape/mesh/coordinate_lattice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "libshape/base/random.h"
#include "libshape/mesh/coordinate_spacing.h"
#include "libshape/mesh/polygon_cut.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

struct Mesh
{
    Points points;
    Faces faces;
};

Mesh scaled(Mesh mesh, double factor)
{
    mesh.points *= factor;
    return mesh;
}

Mesh in_single_precision(Mesh mesh)
{
    mesh.points = mesh.points.cast<float>().cast<double>().eval();
    return mesh;
}

bool is_coarse(const Mesh& mesh)
{
    return coarse_coordinates(mesh.faces, mesh.points).has_value();
}

/// Rows of `around` vertices, joined to the next row and, if closed, to themselves.
Mesh rows(int count, int around, bool is_closed,
          const std::function<Eigen::RowVector3d(int, int)>& place)
{
    Mesh mesh{Points(count * around, 3),
              Faces(2 * (count - 1) * (around - (is_closed ? 0 : 1)), 3)};
    Eigen::Index f = 0;
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < around; ++j) {
            mesh.points.row(i * around + j) = place(i, j);
            if (i + 1 == count || (j + 1 == around && !is_closed))
                continue;
            const int a = i * around + j;
            const int b = i * around + (j + 1) % around;
            mesh.faces.row(f++) << a, b, b + around;
            mesh.faces.row(f++) << a, b + around, a + around;
        }
    return mesh;
}

/// The surface of the voxels of a ball.
Mesh voxels(int size)
{
    std::map<std::array<int, 3>, int> numbers;
    std::vector<std::array<int, 4>> squares;
    const auto is_in = [&](std::array<int, 3> at) {
        double square = 0.0;
        for (const int x : at)
            square += (x + 0.5 - 0.5 * size) * (x + 0.5 - 0.5 * size);
        return square < 0.2 * size * size;
    };
    for (int x = 0; x < size; ++x)
        for (int y = 0; y < size; ++y)
            for (int z = 0; z < size; ++z)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    for (const int side : {0, 1}) {
                        std::array<int, 3> beside{x, y, z};
                        beside[axis] += side == 1 ? 1 : -1;
                        if (!is_in({x, y, z}) || is_in(beside))
                            continue;
                        std::array<int, 4> corners{};
                        for (std::size_t k = 0; k < 4; ++k) {
                            std::array<int, 3> at{x, y, z};
                            at[axis] += side;
                            at[(axis + 1) % 3] += k == 1 || k == 2 ? 1 : 0;
                            at[(axis + 2) % 3] += k >= 2 ? 1 : 0;
                            corners[side == 1 ? k : 3 - k] =
                                numbers.try_emplace(at, static_cast<int>(numbers.size()))
                                    .first->second;
                        }
                        squares.push_back(corners);
                    }
    Mesh mesh{Points(std::ssize(numbers), 3), Faces(2 * std::ssize(squares), 3)};
    for (const auto& [at, v] : numbers)
        mesh.points.row(v) << at[0], at[1], at[2];
    for (std::size_t k = 0; k < squares.size(); ++k) {
        const auto& [a, b, c, d] = squares[k];
        mesh.faces.row(2 * static_cast<Eigen::Index>(k)) << a, b, c;
        mesh.faces.row(2 * static_cast<Eigen::Index>(k) + 1) << a, c, d;
    }
    return mesh;
}

/// A smooth tube along z with rings at some heights.
Mesh tube(int count, int around, const std::function<double(int, int)>& height)
{
    return rows(count, around, true, [&](int i, int j) {
        const double angle = 2.0 * std::numbers::pi * j / around;
        const double z = height(i, j);
        const double radius = 15.0 * (1.0 + 0.3 * std::sin(z / 15.0) + 0.1 * std::cos(2.0 * angle));
        return Eigen::RowVector3d(radius * std::cos(angle), radius * std::sin(angle), z);
    });
}

/// Coordinates as so many bits tell them.
Mesh quantised(Mesh mesh, int bits)
{
    const Eigen::RowVector3d least = mesh.points.colwise().minCoeff();
    const double step = (mesh.points.colwise().maxCoeff() - least).maxCoeff() / ((1 << bits) - 1);
    for (auto point : mesh.points.rowwise())
        point = least + ((point - least) / step).array().round().matrix() * step;
    return mesh;
}

/// Coordinates of 11 significant bits.
Mesh in_half_precision(Mesh mesh)
{
    for (double& x : mesh.points.reshaped()) {
        int exponent = 0;
        (void)std::frexp(x, &exponent);
        const double step = std::ldexp(1.0, exponent - 11);
        x = std::round(x / step) * step;
    }
    return mesh;
}

Mesh ball(int levels)
{
    const test::TestMesh mesh = test::bumpy_sphere(levels, 0.1, 1);
    Points turned = test::moved(mesh.points, 3);
    turned.rowwise() -= turned.colwise().mean().eval();
    return {turned, mesh.topology.faces()};
}

TEST(CoordinateLattice, IsFoundInAnyUnit)
{
    Random random(2);
    for (const double unit : {1.0, 1.0 / 25.4, 3.3333, 1e-6, 1.0 / 3.0})
        for (const double start : {0.0, 17.0, -4000.0}) {
            Eigen::VectorXd exact(200);
            for (double& x : exact)
                x = start + 3.0 * std::round(400.0 * random.uniform());
            exact[5] = exact[4] + 3.0;
            Eigen::VectorXd x = unit * exact;
            x = x.cast<float>().cast<double>().eval();
            const auto found = find_lattice(x, 0.5 * unit);
            ASSERT_TRUE(found) << unit << " " << start;
            EXPECT_NEAR(found->step, 3.0 * unit, 1e-4 * unit);
            EXPECT_FALSE(found->is_far_half);
            EXPECT_EQ(found->levels.minCoeff(), 0);
            for (Eigen::Index v = 1; v < x.size(); ++v)
                EXPECT_EQ(found->levels[v] - found->levels[0], (exact[v] - exact[0]) / 3.0);
            EXPECT_FALSE(find_lattice(x, 3.5 * unit));
            Eigen::Index farthest = 0;
            (void)x.cwiseAbs().maxCoeff(&farthest);
            x[farthest] += 0.2 * unit;
            EXPECT_FALSE(find_lattice(x, 0.5 * unit));
        }
    EXPECT_FALSE(find_lattice(Eigen::VectorXd::Ones(30), 1e-3)); // one level
}

TEST(CoordinateLattice, OfHalfPrecisionIsThatOfTheFarHalf)
{
    const Mesh half = in_half_precision(ball(5));
    const auto found = find_lattice(half.points.col(0), 4e-4);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->is_far_half);
    EXPECT_EQ(found->step, std::ldexp(1.0, -11));
    EXPECT_EQ(found->levels.minCoeff(), -1);
}

TEST(CoordinateLattice, OfSlicesVoxelsAndRastersIsMeant)
{
    for (const double unit : {1.0, 0.3, 1.0 / 25.4}) {
        for (const int size : {16, 30})
            EXPECT_FALSE(is_coarse(in_single_precision(scaled(voxels(size), unit)))) << size;
        for (const int every : {1, 3, 5})
            EXPECT_FALSE(
                is_coarse(scaled(tube(20, 40, [&](int i, int) { return every * i; }), unit)));
        EXPECT_FALSE(is_coarse( // uneven slices
            scaled(tube(20, 40, [](int i, int) { return i * i / 2 + i; }), unit)));
        EXPECT_FALSE(is_coarse( // edges that skip slices on a smooth surface
            scaled(tube(40, 40, [](int i, int j) { return 2 * i + (7 * i + 3 * j) % 2; }), unit)));
        // Contours of pixels in slices, all whole numbers.
        EXPECT_FALSE(is_coarse(scaled(rows(30, 60, true,
                                           [](int i, int j) {
                                               const double angle = std::numbers::pi * j / 30.0;
                                               const double radius = 9.0 + std::cos(0.2 * i);
                                               return Eigen::RowVector3d(
                                                   std::round(radius * std::cos(angle)),
                                                   std::round(radius * std::sin(angle)), i);
                                           }),
                                      unit)));
        // Graded grids.
        EXPECT_FALSE(is_coarse(scaled(rows(20, 20, false,
                                           [](int i, int j) {
                                               return Eigen::RowVector3d(
                                                   i * (i + 1) / 2, j * j,
                                                   std::sin(0.3 * i) * std::cos(0.2 * j));
                                           }),
                                      unit)));
        EXPECT_FALSE(is_coarse(scaled(
            rows(12, 12, false,
                 [](int i, int j) { return Eigen::RowVector3d(1 << i, 1 << j, std::sqrt(i + j)); }),
            unit)));
    }
}

TEST(CoordinateLattice, OfPlatesIsMeant)
{
    // An I-beam in millimetres: no plate beside another, and edges that pass the web.
    std::vector<std::array<int, 2>> outline;
    const std::vector<std::array<int, 3>> corners{
        {0, 0, 5},     {100, 0, 1}, {100, 10, 3}, {55, 10, 9},  {55, 190, 3}, {100, 190, 1},
        {100, 200, 5}, {0, 200, 1}, {0, 190, 3},  {45, 190, 9}, {45, 10, 3},  {0, 10, 1}};
    for (std::size_t k = 0; k < corners.size(); ++k)
        for (int s = 0; s < corners[k][2]; ++s) {
            const auto& next = corners[(k + 1) % corners.size()];
            outline.push_back({corners[k][0] + (next[0] - corners[k][0]) * s / corners[k][2],
                               corners[k][1] + (next[1] - corners[k][1]) * s / corners[k][2]});
        }
    for (const int length : {20, 37, 50})
        for (const double unit : {1.0, 0.001, 1.0 / 25.4})
            EXPECT_FALSE(
                is_coarse(scaled(rows(30, static_cast<int>(outline.size()), true,
                                      [&](int i, int j) {
                                          const auto& at = outline[static_cast<std::size_t>(j)];
                                          return Eigen::RowVector3d(at[0], at[1], length * i);
                                      }),
                                 unit)))
                << length;
}

/// A comb in whole millimetres, `length` of its teeth; their ends are slanted by `slant`.
Mesh comb(int teeth, int width, int length, int slant)
{
    std::vector<std::array<int, 2>> outline{{0, 0}, {2 * width * teeth - width, 0}};
    for (int k = teeth - 1; k >= 0; --k) {
        const int left = 2 * width * k;
        const int end = 5 + length + k % 3;
        outline.insert(outline.end(),
                       {{left + width, 5}, {left + width, end - slant}, {left, end}, {left, 5}});
        if (k == 0)
            outline.pop_back();
    }
    const auto count = static_cast<int>(outline.size());
    Points cap(count, 3);
    for (int v = 0; v < count; ++v)
        cap.row(v) << outline[static_cast<std::size_t>(v)][0],
            outline[static_cast<std::size_t>(v)][1], 0;
    Mesh mesh{Points(2 * count, 3), Faces(4 * count - 4, 3)};
    mesh.points << cap, cap;
    mesh.points.bottomRows(count).col(2).setConstant(3.0);
    Eigen::Index f = 0;
    const auto cut = cut_polygon(cap);
    for (const auto& [a, b, c] : cut.value()) {
        mesh.faces.row(f++) << b, a, c;
        mesh.faces.row(f++) << a + count, b + count, c + count;
    }
    for (int v = 0; v < count; ++v) {
        const int next = (v + 1) % count;
        mesh.faces.row(f++) << v, next, next + count;
        mesh.faces.row(f++) << v, next + count, v + count;
    }
    return mesh;
}

TEST(CoordinateLattice, OfPartsMadeOfPlanesIsMeant)
{
    for (const double unit : {1.0, 0.001, 1.0 / 25.4})
        for (const int width : {1, 2, 5})
            for (const int length : {7, 20, 60})
                for (const int slant : {0, 1}) {
                    const Mesh made = scaled(comb(15, width, length, slant), unit);
                    if (slant == 0 || width < 3) { // else the ends are nearly flat: 11 degrees
                        EXPECT_FALSE(is_coarse(made)) << width << " " << length << " " << slant;
                        EXPECT_FALSE(is_coarse(in_single_precision(made)))
                            << width << " " << length;
                    }
                }
}

TEST(CoordinateLattice, OfStepsOfASmoothSurfaceIsNotMeant)
{
    for (const int axis : {0, 1, 2})
        for (const double edges : {0.05, 0.5, 1.2, 1.5, 2.0, 3.0}) {
            Mesh mesh = ball(4);
            const double step = 0.07 * edges;
            mesh.points.col(axis) = (mesh.points.col(axis) / step).array().round().matrix() * step;
            EXPECT_TRUE(is_coarse(mesh)) << axis << " " << edges;
        }
}

TEST(CoordinateLattice, OfUnevenHeightsIsMeantAndOfASmoothHillIsNot)
{
    for (const double range : {3.0, 6.0, 20.0, 100.0}) {
        Random random(3);
        EXPECT_FALSE(is_coarse(rows(25, 25, false, [&](int i, int j) {
            return Eigen::RowVector3d(30 * i, 30 * j,
                                      std::round(range * (2.0 * random.uniform() - 1.0)));
        }))) << range;
    }
    EXPECT_TRUE(is_coarse(rows(40, 40, false, [](int i, int j) {
        const double square = (i - 20) * (i - 20) + (j - 20) * (j - 20);
        return Eigen::RowVector3d(30 * i, 30 * j, std::round(40.0 * std::exp(-0.01 * square)));
    })));
}

TEST(CoordinateLattice, OfFewBitsIsNotMeantWhateverTheUnit)
{
    for (const double unit : {1.0, 25.4, 1.0 / 25.4, 3.3333}) {
        for (const int bits : {6, 7, 8})
            for (const int levels : {3, 4}) {
                EXPECT_TRUE(is_coarse(scaled(quantised(ball(levels), bits), unit))) << bits;
                EXPECT_TRUE(
                    is_coarse(in_single_precision(scaled(quantised(ball(levels), bits), unit))));
            }
        Mesh far = ball(4);
        far.points.array() += 3.0;
        EXPECT_TRUE(is_coarse(scaled(in_half_precision(far), unit)));
        const Mesh half = scaled(in_half_precision(ball(6)), unit);
        const auto found = coarse_coordinates(half.faces, half.points);
        ASSERT_TRUE(found);
        EXPECT_NEAR(found->step, unit * std::ldexp(1.0, -11), 1e-9 * unit);
        EXPECT_TRUE(found->is_far_half);
        EXPECT_NE(describe(*found).find("half precision, float16"), std::string::npos);
    }
}

} // namespace
} // namespace shape
