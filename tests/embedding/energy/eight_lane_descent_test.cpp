// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/eight_lane_descent.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/energy/gauss_newton_operator.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

constexpr int lanes = EightLanes::lanes;

std::array<float*, 3> numbers(EightLanePoint& p, int k)
{
    return {&p.x.of[k], &p.y.of[k], &p.z.of[k]};
}

/// Seeded vectors, 0 from vertex `end` on.
EightLanePoints random_points(std::size_t size, int end, Random& random)
{
    EightLanePoints points(size);
    for (std::size_t v = 0; v < to_size(end); ++v)
        for (int k = 0; k < lanes; ++k)
            for (float* const number : numbers(points[v], k))
                *number = static_cast<float>(random.uniform(-1.0, 1.0));
    return points;
}

/// A mesh of which a disc of vertices moves, a target near it, and eight seeded positions near it.
struct Setting
{
    test::TestMesh mesh;
    ShapePoint target;
    LengthDihedralEnergy energy;
    RegionMesh region;
    EightLaneEnergy eight;
    EightLanePoints points;

    Setting(const test::TestMesh& of, double noise, unsigned seed)
        : mesh(of),
          target(target_of(mesh, noise, seed)),
          energy(mesh.topology, target, 5e-3),
          region(mesh.topology, disc(mesh.topology)),
          eight(energy, region),
          points(region.vertices.size())
    {
        Random random(seed);
        const EightLanePoints perturbation =
            random_points(points.size(), region.moving_vertices, random);
        for (std::size_t v = 0; v < points.size(); ++v)
            for (int k = 0; k < lanes; ++k)
                for (std::size_t c = 0; c < 3; ++c) {
                    EightLanePoint perturbed = perturbation[v];
                    *numbers(points[v], k)[c] =
                        static_cast<float>(mesh.points(region.vertices[v], static_cast<int>(c)) /
                                           eight.unit()) +
                        0.1F * *numbers(perturbed, k)[c];
                }
    }

    static ShapePoint target_of(const test::TestMesh& mesh, double noise, unsigned seed)
    {
        Random random(seed + 100);
        ShapePoint target{edge_lengths(mesh.topology, mesh.points),
                          dihedral_angles(mesh.topology, mesh.points)};
        for (int e = 0; e < mesh.topology.edge_count(); ++e) {
            target.edge_lengths[e] *= 1.0 + noise * random.uniform(-1.0, 1.0);
            target.dihedral_angles[e] += noise * random.uniform(-1.0, 1.0);
        }
        return target;
    }

    /// The first vertex and two rings around it, but not the whole mesh.
    static std::vector<int> disc(const Topology& topology)
    {
        std::vector<int> vertices{0};
        for (int ring = 0; ring < 2; ++ring)
            for (const int v : std::vector<int>(vertices))
                for (const int h : topology.outgoing(v))
                    for (const int other :
                         {topology.target(h), topology.source(Topology::previous(h))})
                        if (std::find(vertices.begin(), vertices.end(), other) == vertices.end())
                            vertices.push_back(other);
        vertices.resize(std::min(vertices.size(), to_size(topology.vertex_count()) - 1));
        return vertices;
    }

    /// The whole mesh with one of the eight in it, row by row.
    VectorXd whole(const EightLanePoints& positions, int k)
    {
        VectorXd rows = mesh.points.reshaped<Eigen::RowMajor>();
        for (int v = 0; v < region.moving_vertices; ++v)
            for (std::size_t c = 0; c < 3; ++c) {
                EightLanePoint point = positions[to_size(v)];
                rows[3 * region.vertices[to_size(v)] + static_cast<int>(c)] =
                    eight.unit() * static_cast<double>(*numbers(point, k)[c]);
            }
        return rows;
    }
};

TEST(EightLaneEnergy, DiffersBetweenPositionsAsTheEnergyOfTheWholeMesh)
{
    for (const test::TestMesh& mesh : test::sample_meshes())
        for (unsigned seed = 1; seed <= 3; ++seed) {
            SCOPED_TRACE(mesh.name);
            Setting s(mesh, 0.1, seed);
            const auto energies = s.eight.linearise(s.points);
            VectorXd gradient;
            const double first = s.energy.evaluate(s.whole(s.points, 0), gradient);
            for (int k = 1; k < lanes; ++k) {
                const double wanted = s.energy.evaluate(s.whole(s.points, k), gradient) - first;
                const auto at = to_size(k);
                EXPECT_NEAR(static_cast<double>(energies[at] - energies[0]), wanted,
                            1e-5 * static_cast<double>(energies[at] + energies[0]));
            }
            EightLanes sum{};
            for (const EightLanes& of_edge : s.eight.edge_energies())
                sum = sum + of_edge;
            EXPECT_NEAR(sum.of[3], energies[3], 1e-5F * energies[3]);
        }
}

TEST(EightLaneEnergy, HasTheGradientOfTheEnergy)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        Setting s(mesh, 0.1, 1);
        (void)s.eight.linearise(s.points);
        EightLanePoints half;
        s.eight.gradient(half);
        ASSERT_EQ(half.size(), to_size(s.region.moving_vertices));
        for (int k = 0; k < lanes; ++k) {
            VectorXd gradient;
            (void)s.energy.evaluate(s.whole(s.points, k), gradient);
            const double scale = gradient.cwiseAbs().maxCoeff() * s.eight.unit();
            for (std::size_t v = 0; v < half.size(); ++v)
                for (std::size_t c = 0; c < 3; ++c)
                    EXPECT_NEAR(
                        2.0 * static_cast<double>(*numbers(half[v], k)[c]),
                        gradient[3 * s.region.vertices[v] + static_cast<int>(c)] * s.eight.unit(),
                        2e-5 * scale);
        }
    }
}

TEST(EightLaneEnergy, AppliesTheGaussNewtonMatrixOfTheMesh)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        Setting s(mesh, 0.1, 2);
        (void)s.eight.linearise(s.points);
        Random random(5);
        EightLanePoints v = random_points(s.points.size(), s.region.moving_vertices, random);
        EightLanePoints product;
        s.eight.apply(v, product);
        for (int k = 0; k < lanes; ++k) {
            const Eigen::VectorXd whole = s.whole(s.points, k);
            Eigen::VectorXd gradient;
            (void)s.energy.evaluate(whole, gradient);
            GaussNewtonOperator matrix(s.energy);
            matrix.linearise(whole);
            LaneVectors motion = LaneVectors::Zero(4, mesh.points.rows());
            for (std::size_t i = 0; i < product.size(); ++i)
                for (std::size_t c = 0; c < 3; ++c)
                    motion(static_cast<int>(c), s.region.vertices[i]) = *numbers(v[i], k)[c];
            LaneVectors wanted;
            matrix.apply(motion, wanted);
            wanted *= static_cast<float>(s.eight.unit() * s.eight.unit() /
                                         (matrix.unit() * matrix.unit()));
            const float scale = wanted.cwiseAbs().maxCoeff();
            for (std::size_t i = 0; i < product.size(); ++i)
                for (std::size_t c = 0; c < 3; ++c)
                    EXPECT_NEAR(*numbers(product[i], k)[c],
                                wanted(static_cast<int>(c), s.region.vertices[i]), 2e-5F * scale);
        }
    }
}

/// Of the moving vertices, weighted by 1 / l^2.
EightLaneSolve laplacian_of(const Setting& s)
{
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t e = 0; e < s.region.edges.size(); ++e) {
        const double length = s.target.edge_lengths[s.region.edges[e]] / s.eight.unit();
        for (const auto& [a, b] : {std::pair(s.region.ends[2 * e], s.region.ends[2 * e + 1]),
                                   std::pair(s.region.ends[2 * e + 1], s.region.ends[2 * e])}) {
            if (a >= s.region.moving_vertices)
                continue;
            entries.emplace_back(a, a, 1.0 / (length * length));
            if (b < s.region.moving_vertices)
                entries.emplace_back(a, b, -1.0 / (length * length));
        }
    }
    SparseMatrix matrix(s.region.moving_vertices, s.region.moving_vertices);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return EightLaneSolve(matrix);
}

TEST(EightLaneDescent, FindsTheMeshThatHasTheTargetFromEightSides)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        Setting s(mesh, 0.0, 3);
        const auto energies = descend(s.eight, laplacian_of(s), s.points, {.newton_steps = 15});
        for (int k = 0; k < lanes; ++k) {
            EXPECT_LT(energies[to_size(k)], 1e-6F);
            if (s.region.vertex_count() < s.region.moving_vertices + 3)
                continue; // what is held leaves it free to turn
            const VectorXd found = s.whole(s.points, k);
            EXPECT_LT((found - mesh.points.reshaped<Eigen::RowMajor>()).cwiseAbs().maxCoeff(),
                      2e-3 * s.eight.unit());
        }
    }
}

TEST(EightLaneDescent, NeverRaisesAnEnergy)
{
    for (unsigned seed = 1; seed <= 5; ++seed) {
        Setting s(test::bumpy_sphere(3, 0.2, seed), 0.5, seed);
        const EightLaneSolve preconditioner = laplacian_of(s);
        auto last = s.eight.linearise(s.points);
        for (int step = 0; step < 6; ++step) {
            const auto energies = descend(s.eight, preconditioner, s.points, {.newton_steps = 1});
            const auto there = s.eight.linearise(s.points);
            for (std::size_t k = 0; k < lanes; ++k) {
                EXPECT_LE(energies[k], last[k]);
                EXPECT_NEAR(there[k], energies[k], 1e-6F * energies[k]);
            }
            last = energies;
        }
    }
}

void expect_equal(EightLanePoints& a, EightLanePoints& b)
{
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t v = 0; v < a.size(); ++v)
        for (int k = 0; k < lanes; ++k)
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_EQ(*numbers(a[v], k)[c], *numbers(b[v], k)[c]);
}

TEST(EightLaneDescent, GoesWhereItsStepsLeadOneByOne)
{
    // One by one, no call knows which positions have come to rest.
    constexpr int steps = 40;
    Setting s(test::bumpy_sphere(3, 0.2, 1), 0.1, 1);
    const EightLaneSolve preconditioner = laplacian_of(s);
    EightLanePoints at_once = s.points;
    (void)descend(s.eight, preconditioner, at_once, {.newton_steps = steps});
    for (int step = 0; step < steps; ++step)
        (void)descend(s.eight, preconditioner, s.points, {.newton_steps = 1});
    expect_equal(at_once, s.points);
}

TEST(EightLaneDescent, EndsOnceAllPositionsAreAtRest)
{
    Setting s(test::bumpy_sphere(3, 0.2, 2), 0.1, 2);
    const EightLaneSolve preconditioner = laplacian_of(s);
    (void)descend(s.eight, preconditioner, s.points, {.newton_steps = 1'000'000'000});
    EightLanePoints there = s.points;
    (void)descend(s.eight, preconditioner, s.points, {.newton_steps = 1});
    expect_equal(there, s.points);
}

} // namespace
} // namespace shape
