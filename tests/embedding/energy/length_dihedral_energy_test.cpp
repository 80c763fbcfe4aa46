// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/length_dihedral_energy.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/energy/gauss_newton.h"
#include "libshape/embedding/energy/stretch_term.h"
#include "libshape/linalg/eight_lanes.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

VectorXd flat(const Points& points)
{
    return points.reshaped<Eigen::RowMajor>();
}

/// Every coordinate moved by up to `amount` of the mean edge length.
Points perturbed(const test::TestMesh& mesh, double amount, unsigned seed)
{
    Random random(seed);
    const double reach = amount * edge_lengths(mesh.topology, mesh.points).mean();
    return mesh.points + Points::NullaryExpr(mesh.points.rows(), 3,
                                             [&] { return random.uniform(-reach, reach); });
}

/// mu_e from where the vertices of the wanted triangles are.
VectorXd trusted_bends(const test::TestMesh& mesh, double mu)
{
    const Topology& t = mesh.topology;
    VectorXd weights(t.edge_count());
    for (int e = 0; e < t.edge_count(); ++e) {
        double weight = mu;
        for (const int h : t.edge_halfedges().row(e)) {
            if (h < 0) {
                weight = 0.0;
                continue;
            }
            const Eigen::RowVector3d a = mesh.points.row(t.source(h));
            const Eigen::RowVector3d b = mesh.points.row(t.target(h));
            const Eigen::RowVector3d c = mesh.points.row(t.source(Topology::previous(h)));
            const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
            const double height = (b - a).cross(c - a).norm() / longest;
            const double shape = height / longest / sliver_shape;
            weight = std::min(weight, mu * std::clamp(shape * shape, 0.01, 1.0));
        }
        weights[e] = weight;
    }
    return weights;
}

/// The sample meshes, each with a few vertices next to an edge opposite.
std::vector<test::TestMesh> meshes_with_slivers()
{
    std::vector<test::TestMesh> meshes = test::sample_meshes();
    Random random(8);
    for (test::TestMesh& mesh : meshes)
        for (int f = 0; f < mesh.topology.face_count(); f += 7) {
            const auto face = mesh.topology.faces().row(f);
            const double height = random.uniform(0.001, 0.3);
            mesh.points.row(face[0]) =
                height * mesh.points.row(face[0]) +
                (1.0 - height) * 0.5 * (mesh.points.row(face[1]) + mesh.points.row(face[2]));
        }
    return meshes;
}

TEST(StretchTerm, IsTheSquareOfSmallStrainsAndItsWeightTheSlope)
{
    EXPECT_NEAR(stretch_term(1e-4).value, 1e-8, 1e-13);
    EXPECT_NEAR(stretch_term(stretch_onset).value,
                stretch_onset * stretch_onset * (1.0 + 1.0 / 1.125), 1e-16);
    EXPECT_NEAR(stretch_term(1e3).value / 1e6, 9.0, 1e-3);
    for (const double s : {-0.5, -0.03, 0.001, 0.02, 0.1, 2.0}) {
        const double h = 1e-6 * std::abs(s);
        const double slope = (stretch_term(s + h).value - stretch_term(s - h).value) / (2.0 * h);
        EXPECT_NEAR(stretch_term(s).weight, slope / (2.0 * s), 1e-7 * slope / s);
    }
}

TEST(StretchTerm, StiffensFromSixPerCentOn)
{
    // s = s0 = 0.06: phi = s0^2 (1 + 8 / 9), and its weight is 1 + 136 / 81.
    for (const double s : {-0.06, 0.06}) {
        EXPECT_NEAR(stretch_term(s).value, 0.0068, 1e-16);
        EXPECT_NEAR(stretch_term(s).weight, 217.0 / 81.0, 1e-14);
    }
}

/// By central differences, of every `stride`-th coordinate.
void expect_gradient(LengthDihedralEnergy& energy, VectorXd x, const VectorXd& gradient,
                     Eigen::Index stride)
{
    VectorXd unused;
    for (Eigen::Index i = 0; i < x.size(); i += stride) {
        const double here = std::exchange(x[i], x[i] + 1e-6);
        const double above = energy.evaluate(x, unused);
        x[i] = here - 1e-6;
        const double below = energy.evaluate(x, unused);
        x[i] = here;
        EXPECT_NEAR((above - below) / 2e-6, gradient[i], 1e-7 * gradient.norm());
    }
}

TEST(LengthDihedralEnergy, TrustsTheBendsOfSliversByTheSquareOfTheirHeights)
{
    // Two triangles on an edge of length 1, the longest of both; their heights are those given.
    const Topology hinge(Faces{{0, 1, 2}, {1, 0, 3}}, 4);
    const auto weight = [&](double left, double right) {
        const Points points{{0, 0, 0}, {1, 0, 0}, {0.5, left, 0}, {0.5, 0, -right}};
        const LengthDihedralEnergy energy(hinge, test::shape_of(hinge, points), 0.4);
        return energy.bend_weights().maxCoeff(); // that of the edge inside; 0 on the boundary
    };
    EXPECT_NEAR(weight(0.8, 0.5), 0.4, 1e-15);
    EXPECT_NEAR(weight(0.21, 0.3), 0.4, 1e-15);
    EXPECT_NEAR(weight(0.1, 0.3), 0.1, 1e-12); // half of a fifth, squared
    EXPECT_NEAR(weight(0.3, 0.1), 0.1, 1e-12);
    EXPECT_NEAR(weight(0.1, 0.04), 0.4 / 25.0, 1e-12); // the flatter of the two
    EXPECT_NEAR(weight(0.001, 0.3), 0.004, 1e-12);     // not below a hundredth
}

TEST(StretchTerm, IsTheSameInFloatAndInEightLanesButForRounding)
{
    for (const double s : {-0.9, -0.05, 0.0, 1e-4, 0.06, 3.0}) {
        const auto [value, weight] = stretch_term(s);
        const StretchTerm<float> single = stretch_term(static_cast<float>(s));
        EXPECT_NEAR(single.value, value, 1e-6 * value);
        EXPECT_NEAR(single.weight, weight, 1e-6 * weight);
        EightLanes strain = EightLanes::all(0.5F);
        strain.of[3] = static_cast<float>(s);
        const StretchTerm<EightLanes> eight = stretch_term(strain);
        EXPECT_EQ(eight.value.of[3], single.value);
        EXPECT_EQ(eight.weight.of[3], single.weight);
        EXPECT_EQ(eight.value.of[4], stretch_term(0.5F).value);
    }
}

TEST(LengthDihedralEnergy, VanishesAtTheMeshItself)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
        VectorXd gradient;
        EXPECT_LT(energy.evaluate(flat(test::moved(mesh.points, 3)), gradient), 1e-24);
        EXPECT_LT(gradient.norm(), 1e-11);
    }
}

TEST(LengthDihedralEnergy, IsTheSumOfItsDefinition)
{
    constexpr double mu = 0.03;
    std::vector<test::TestMesh> meshes = test::sample_meshes();
    for (test::TestMesh& mesh : meshes_with_slivers())
        meshes.push_back(std::move(mesh));
    for (const test::TestMesh& mesh : meshes) {
        SCOPED_TRACE(mesh.name);
        const ShapePoint target = test::shape_of(mesh.topology, mesh.points);
        const Points points = perturbed(mesh, 0.2, 5);
        const ShapePoint found = test::shape_of(mesh.topology, points);
        LengthDihedralEnergy energy(mesh.topology, target, mu);
        VectorXd gradient;
        const double value = energy.evaluate(flat(points), gradient);
        const VectorXd bend_weights = trusted_bends(mesh, mu);
        double sum = 0.0;
        for (int e = 0; e < mesh.topology.edge_count(); ++e) {
            const double strain = found.edge_lengths[e] / target.edge_lengths[e] - 1.0;
            const double bend = wrapped_angle(found.dihedral_angles[e] - target.dihedral_angles[e]);
            const double of_edge = stretch_term(strain).value + bend_weights[e] * bend * bend;
            EXPECT_NEAR(energy.edge_energies()[e], of_edge, 1e-12 * value);
            sum += of_edge;
        }
        EXPECT_NEAR(value, sum, 1e-12 * sum);
    }
}

TEST(LengthDihedralEnergy, HoldsVerticesByTheirSharesOfTheArea)
{
    // A box's surface is not a box full of points; a sphere of radius 1 has sum a |y - centre|^2 = 1.
    const test::TestMesh mesh = test::icosphere(3);
    LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
    const Points held = test::moved(mesh.points, 3);
    EXPECT_EQ(energy.hold_energy(flat(held)), 0.0);
    energy.hold_near(flat(held), 0.5);
    VectorXd gradient;
    EXPECT_LT(energy.evaluate(flat(held), gradient), 1e-20);
    EXPECT_LT(gradient.norm(), 1e-9);
    // Moved as a whole by d: weight #E d^2 / D^2, D^2 = 12.
    const Points away = held.rowwise() + Eigen::RowVector3d(0.3, -0.1, 0.2);
    EXPECT_NEAR(energy.evaluate(flat(away), gradient),
                0.5 * mesh.topology.edge_count() * 0.14 / 12.0, 1e-10);
    EXPECT_NEAR(energy.hold_weights().sum(), 0.5 * mesh.topology.edge_count() / 12.0, 1e-10);
    EXPECT_NEAR(energy.hold_energy(flat(away)), 0.5 * mesh.topology.edge_count() * 0.14 / 12.0,
                1e-10);

    VectorXd x = flat(away);
    (void)energy.evaluate(x, gradient);
    expect_gradient(energy, x, gradient, 97);
}

TEST(LengthDihedralEnergy, HoldsSumsOfAngles)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.2, 3);
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    const VectorXd angles = target.dihedral_angles;
    target.dihedral_angles.array() += 0.3;
    target.edge_lengths *= 1.05;
    LengthDihedralEnergy energy(mesh.topology, target, 0.1);
    VectorXd x = flat(mesh.points);
    VectorXd gradient;
    const double before = energy.evaluate(x, gradient);
    // One aim differs by a whole turn, which changes nothing; two sums share an edge.
    const double turn = 2.0 * std::numbers::pi;
    energy.hold_sums({{{3, 7}, {2.0, -1.0}, {angles[3] - 0.1, angles[7] + turn}, 0.5},
                      {{7, 11}, {1.0, 1.0}, {angles[7] + 0.2, angles[11]}, 2.0}});
    EXPECT_NEAR(energy.evaluate(x, gradient) - before, 0.5 * 0.04 + 2.0 * 0.04, 1e-12);
    expect_gradient(energy, x, gradient, 1);
}

TEST(LengthDihedralEnergy, KeepsPlacesApartThatAreTooNear)
{
    const test::TestMesh mesh = test::icosphere(1);
    LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
    VectorXd x = flat(mesh.points);
    const Eigen::Vector3d direction = Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0;
    const double between = direction.dot(Eigen::Vector3d(
        mesh.points.row(3) - 0.25 * mesh.points.row(7) - 0.75 * mesh.points.row(8)));
    const auto gap = [&](double least) {
        return LengthDihedralEnergy::Gap{{3, 7, 8}, {1.0, -0.25, -0.75}, direction, least, 5.0};
    };
    VectorXd gradient;
    energy.keep_apart({gap(between - 0.1)});
    EXPECT_LT(energy.evaluate(x, gradient), 1e-20);
    energy.keep_apart({gap(between + 0.2), gap(between + 0.1)});
    EXPECT_NEAR(energy.evaluate(x, gradient), 5.0 * (0.04 + 0.01), 1e-12);
    expect_gradient(energy, x, gradient, 1);
    energy.keep_apart({});
    EXPECT_LT(energy.evaluate(x, gradient), 1e-20);
    EXPECT_THROW(energy.keep_apart({{{1, 2}, {1.0}, direction, 0.0, 1.0}}), InvalidInput);
}

TEST(LengthDihedralEnergy, RefusesSumsThatDoNotFit)
{
    const test::TestMesh mesh = test::open_patch(3, 1);
    LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
    int boundary = 0;
    while (!mesh.topology.is_boundary_edge(boundary))
        ++boundary;
    EXPECT_THROW(energy.hold_sums({{{boundary}, {1.0}, {0.0}, 1.0}}), InvalidInput);
    EXPECT_THROW(energy.hold_sums({{{0}, {1.0, 2.0}, {0.0}, 1.0}}), InvalidInput);
    EXPECT_THROW(energy.hold_sums({{{0}, {1.0}, {}, 1.0}}), InvalidInput);
}

TEST(LengthDihedralEnergy, HasTheGradientOfCentralDifferences)
{
    std::vector<test::TestMesh> meshes = test::sample_meshes();
    for (test::TestMesh& mesh : meshes_with_slivers())
        meshes.push_back(std::move(mesh));
    for (const test::TestMesh& mesh : meshes) {
        SCOPED_TRACE(mesh.name);
        LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.7);
        VectorXd x = flat(perturbed(mesh, 0.1, 7));
        VectorXd gradient;
        VectorXd unused;
        (void)energy.evaluate(x, gradient);
        Random random(9);
        const double step = 1e-6;
        for (int sample = 0; sample < 30; ++sample) {
            const auto i =
                static_cast<Eigen::Index>(random.index(static_cast<std::uint64_t>(x.size())));
            const double here = x[i];
            x[i] = here + step;
            const double above = energy.evaluate(x, unused);
            x[i] = here - step;
            const double below = energy.evaluate(x, unused);
            x[i] = here;
            EXPECT_NEAR((above - below) / (2.0 * step), gradient[i], 1e-7 * gradient.norm());
        }
    }
}

TEST(LengthDihedralEnergy, TrustsBendsBesideWellShapedTriangles)
{
    constexpr double mu = 0.2;
    for (const test::TestMesh& mesh : {test::tetrahedron(), test::icosphere(3)}) {
        const LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points),
                                          mu);
        EXPECT_EQ(energy.bend_weights(), VectorXd::Constant(mesh.topology.edge_count(), mu));
    }
}

TEST(LengthDihedralEnergy, TrustsBendsBesideSliversByTheSquareOfTheirFlatness)
{
    constexpr double mu = 0.2;
    const Topology two((Faces(2, 3) << 0, 1, 2, 1, 0, 3).finished(), 4);
    const int shared = two.find_edge(0, 1);
    // Isosceles triangles over a shared base of length 3; the second one is well shaped.
    const auto weights = [&](double side, double other_side) {
        ShapePoint target{VectorXd::Constant(5, side), VectorXd::Zero(5)};
        target.edge_lengths[shared] = 3.0;
        target.edge_lengths[two.find_edge(0, 3)] = other_side;
        target.edge_lengths[two.find_edge(1, 3)] = other_side;
        return LengthDihedralEnergy(two, target, mu).bend_weights();
    };
    const auto side_of = [](double height) { return std::hypot(1.5, height); };
    for (const double flatness : {0.021, 0.05, 0.1, 0.15, 0.199})
        for (const bool first : {true, false}) {
            const double side = side_of(3.0 * flatness);
            const double wanted = mu * flatness * flatness / (sliver_shape * sliver_shape);
            EXPECT_NEAR((first ? weights(side, 3.0) : weights(3.0, side))[shared], wanted,
                        1e-12 * mu);
        }
    EXPECT_NEAR(weights(side_of(0.3), side_of(0.15))[shared], 0.0625 * mu, 1e-12 * mu);
    for (const double flatness : {0.201, 0.3, 2.0}) // a side is the longest, in the end
        EXPECT_EQ(weights(side_of(3.0 * flatness), 3.0)[shared], mu);
    EXPECT_EQ(weights(side_of(0.001), 3.0)[shared], 0.01 * mu);
    EXPECT_EQ(weights(1.4, 3.0)[shared], 0.01 * mu); // no triangle has such sides
    // Needles: the base is short, a side the longest; height over the side 3 sin(apex angle).
    const double side = 30.0;
    const double sine = std::sin(2.0 * std::asin(1.5 / side));
    EXPECT_NEAR(weights(side, 3.0)[shared], mu * sine * sine / (sliver_shape * sliver_shape),
                1e-12 * mu);
    const VectorXd all = weights(3.0, 3.0);
    for (int e = 0; e < 5; ++e)
        EXPECT_EQ(all[e], e == shared ? mu : 0.0);
}

TEST(LengthDihedralEnergy, TrustsBendsOfMeshesByTheFlatterOfTwoTriangles)
{
    constexpr double mu = 0.2;
    int slivers = 0;
    for (const test::TestMesh& mesh : meshes_with_slivers()) {
        SCOPED_TRACE(mesh.name);
        const VectorXd weights =
            LengthDihedralEnergy(mesh.topology, test::shape_of(mesh.topology, mesh.points), mu)
                .bend_weights();
        const VectorXd wanted = trusted_bends(mesh, mu);
        EXPECT_LT((weights - wanted).cwiseAbs().maxCoeff(), 1e-12 * mu);
        for (const double weight : wanted)
            slivers += weight > 0.01 * mu && weight < mu ? 1 : 0;
    }
    EXPECT_GT(slivers, 100);
}

/// Areas of the faces.
VectorXd areas(const Topology& topology, const Points& points)
{
    VectorXd areas(topology.face_count());
    for (int f = 0; f < topology.face_count(); ++f) {
        const auto face = topology.faces().row(f);
        const Eigen::RowVector3d p = points.row(face[0]);
        areas[f] = 0.5 * (points.row(face[1]) - p).cross(points.row(face[2]) - p).norm();
    }
    return areas;
}

/// Meshes displaced at random, of which some faces have a twentieth to a half of their heights.
std::vector<std::pair<test::TestMesh, Points>> meshes_with_collapses()
{
    std::vector<std::pair<test::TestMesh, Points>> all;
    Random random(8);
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        Points points = perturbed(mesh, 0.05, 3);
        for (int f = 0; f < mesh.topology.face_count(); f += 7) {
            const auto face = mesh.topology.faces().row(f);
            const double height = random.uniform(0.05, 0.5);
            points.row(face[0]) =
                height * points.row(face[0]) +
                (1.0 - height) * 0.5 * (points.row(face[1]) + points.row(face[2]));
        }
        all.emplace_back(mesh, points);
    }
    return all;
}

TEST(LengthDihedralEnergy, GrowsByLogarithmsOfAreasBelowHalfOfTheWantedOnesIfTheseAreKept)
{
    constexpr double beta = 0.01;
    for (const auto& [mesh, points] : meshes_with_collapses()) {
        SCOPED_TRACE(mesh.name);
        LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
        VectorXd gradient;
        const double without = energy.evaluate(flat(points), gradient);
        EXPECT_TRUE(energy.collapses().empty());
        energy.keep_areas();
        const double with = energy.evaluate(flat(points), gradient);
        const VectorXd shares =
            areas(mesh.topology, points).cwiseQuotient(areas(mesh.topology, mesh.points));
        double sum = 0.0;
        auto collapse = energy.collapses().begin();
        for (int f = 0; f < mesh.topology.face_count(); ++f)
            if (shares[f] < 0.5) {
                ASSERT_NE(collapse, energy.collapses().end());
                EXPECT_EQ(collapse->face, f);
                EXPECT_NEAR(collapse->residual, -std::sqrt(beta) * std::log(2.0 * shares[f]),
                            1e-12);
                sum += collapse->residual * collapse->residual;
                ++collapse;
            }
        EXPECT_EQ(collapse, energy.collapses().end());
        EXPECT_GT(sum, 0.0);
        EXPECT_NEAR(with, without + sum, 1e-13 * with);
        EXPECT_NEAR(energy.edge_energies().sum(), with, 1e-13 * with);
    }
}

TEST(LengthDihedralEnergy, StaysAsItIsWhereNoAreaIsMissing)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
        const VectorXd points = flat(perturbed(mesh, 0.05, 3));
        VectorXd without;
        VectorXd with;
        const double value = energy.evaluate(points, without);
        energy.keep_areas();
        EXPECT_EQ(energy.evaluate(points, with), value);
        EXPECT_EQ(with, without);
    }
}

TEST(LengthDihedralEnergy, HasTheGradientOfCentralDifferencesWithAreasKept)
{
    for (const auto& [mesh, points] : meshes_with_collapses()) {
        SCOPED_TRACE(mesh.name);
        LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
        energy.keep_areas();
        VectorXd x = flat(points);
        VectorXd gradient;
        VectorXd unused;
        (void)energy.evaluate(x, gradient);
        const std::vector<LengthDihedralEnergy::Collapse> collapses = energy.collapses();
        ASSERT_FALSE(collapses.empty());
        constexpr double step = 1e-6;
        for (std::size_t k = 0; k < collapses.size(); k += 5)
            for (int corner = 0; corner < 3; ++corner)
                for (int axis = 0; axis < 3; ++axis) {
                    const int i = 3 * mesh.topology.faces()(collapses[k].face, corner) + axis;
                    const double here = x[i];
                    x[i] = here + step;
                    const double above = energy.evaluate(x, unused);
                    ASSERT_EQ(energy.collapses().size(), collapses.size());
                    const double residual_above = energy.collapses()[k].residual;
                    x[i] = here - step;
                    const double below = energy.evaluate(x, unused);
                    ASSERT_EQ(energy.collapses().size(), collapses.size());
                    const double residual_below = energy.collapses()[k].residual;
                    x[i] = here;
                    EXPECT_NEAR((above - below) / (2.0 * step), gradient[i],
                                1e-7 * gradient.norm());
                    const auto& by_corners = collapses[k].gradients;
                    EXPECT_NEAR((residual_above - residual_below) / (2.0 * step),
                                by_corners[to_size(corner)][axis],
                                1e-6 * (by_corners[0].norm() + by_corners[1].norm()));
                }
    }
}

TEST(LengthDihedralEnergy, IsFiniteWhereAFaceHasNoArea)
{
    const test::TestMesh mesh = test::open_patch(10, 2);
    LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
    energy.keep_areas();
    for (const double height : {0.0, 1e-140, 1e-80, 1e-9}) {
        Points points = Points::Zero(mesh.points.rows(), 3);
        points.col(0) = mesh.points.col(0);
        points.col(1) = height * mesh.points.col(1);
        VectorXd gradient;
        EXPECT_TRUE(std::isfinite(energy.evaluate(flat(points), gradient))) << height;
        EXPECT_TRUE(gradient.allFinite()) << height;
    }
}

TEST(LengthDihedralEnergy, HasTheSameBitsForAnyThreadCount)
{
    const test::TestMesh mesh = test::bumpy_sphere(4, 0.3, 1);
    LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
    const VectorXd x = flat(perturbed(mesh, 0.1, 2));
    const int threads = thread_count();
    VectorXd one;
    VectorXd three;
    set_thread_count(1);
    const double value_one = energy.evaluate(x, one);
    set_thread_count(3);
    const double value_three = energy.evaluate(x, three);
    set_thread_count(threads);
    EXPECT_EQ(value_one, value_three);
    EXPECT_TRUE(one == three);
}

TEST(LengthDihedralEnergy, RefusesBadTargets)
{
    const test::TestMesh mesh = test::tetrahedron();
    const ShapePoint good = test::shape_of(mesh.topology, mesh.points);
    ShapePoint bad = good;
    bad.edge_lengths[2] = 0.0;
    EXPECT_THROW(LengthDihedralEnergy(mesh.topology, bad, 1.0), InvalidInput);
    bad = good;
    bad.dihedral_angles[1] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(LengthDihedralEnergy(mesh.topology, bad, 1.0), InvalidInput);
    bad = good;
    bad.edge_lengths.conservativeResize(5);
    EXPECT_THROW(LengthDihedralEnergy(mesh.topology, bad, 1.0), InvalidInput);
    EXPECT_THROW(LengthDihedralEnergy(mesh.topology, good, 0.0), InvalidInput);
}

TEST(GaussNewton, FindsAShakenMeshAgain)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        LengthDihedralEnergy energy(mesh.topology, test::shape_of(mesh.topology, mesh.points), 0.1);
        const GaussNewtonResult result =
            GaussNewton(mesh.topology, graded_unknowns(mesh.topology, energy.target().edge_lengths))
                .minimize(energy, flat(perturbed(mesh, 0.05, 4)), {.max_iterations = 60});
        EXPECT_LT(result.value, 1e-18);
        VectorXd gradient;
        EXPECT_NEAR(energy.evaluate(result.points, gradient), result.value, 1e-18);
    }
}

TEST(GaussNewton, MovesTheNamedVerticesOnlyAndEndsWhereTheirGradientVanishes)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 1);
    ShapePoint target = test::shape_of(mesh.topology, mesh.points);
    Random random(3);
    for (double& length : target.edge_lengths)
        length *= random.uniform(0.97, 1.03);
    LengthDihedralEnergy energy(mesh.topology, target, 0.1);
    const std::vector<int> some{3, 17, 40, 41, 200};
    const VectorXd start = flat(mesh.points);
    GradedUnknowns unknowns{some,
                            std::vector<std::vector<int>>(to_size(mesh.topology.vertex_count()))};
    for (std::size_t i = 0; i < some.size(); ++i)
        unknowns.rows[to_size(some[i])] = {static_cast<int>(i)};
    const GaussNewtonResult result =
        GaussNewton(mesh.topology, unknowns)
            .minimize(energy, start, {.max_iterations = 200, .decrease_tolerance = 0.0});
    VectorXd before;
    VectorXd after;
    (void)energy.evaluate(start, before);
    (void)energy.evaluate(result.points, after);
    for (int v = 0; v < mesh.topology.vertex_count(); ++v) {
        if (std::find(some.begin(), some.end(), v) != some.end())
            EXPECT_LT(after.segment<3>(3 * v).norm(), 1e-6 * before.norm());
        else
            EXPECT_EQ(result.points.segment<3>(3 * v), start.segment<3>(3 * v));
    }
}

} // namespace
} // namespace shape
