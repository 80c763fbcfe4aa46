// SPDX-License-Identifier: MIT

#include "libshape/edge_space/shape_space.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/edge_space/procrustes.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/collections.h"
#include "tests/support/matrices.h"
#include "tests/support/meshes.h"
#include "tests/support/spaces.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(ShapeSpace, OfPlainLengthsIsThatOfShapeVectors)
{
    const Collection collection = test::bumpy_spheres(6, 1);
    for (const Scale scale : {Scale::Unit, Scale::None}) {
        const ShapeVectors vectors = shape_vectors(collection, scale);
        const ShapeSpace space = make_space(collection, {.scale = scale});
        EXPECT_TRUE(is_plain(space));
        EXPECT_EQ(scale_of(space), scale);
        EXPECT_EQ(encode(space, collection), vectors.edge_lengths);
        EXPECT_EQ(companions(space, collection), vectors.dihedral_angles);
        EXPECT_EQ(sizes(space, collection), vectors.sizes);
    }
}

TEST(ShapeSpace, DecodesWhatItEncoded)
{
    const Collection collection = test::bumpy_spheres(5, 2);
    for (const SpaceOptions& options : test::sample_spaces()) {
        const ShapeSpace space = make_space(collection, options);
        const RowMatrix coordinates = encode(space, collection);
        const RowMatrix companion = companions(space, collection);
        const Eigen::VectorXd size = sizes(space, collection);
        for (Index i = 0; i < 5; ++i) {
            const Points& points = collection.points[to_size(i)];
            const Eigen::VectorXd lengths = edge_lengths(collection.topology, points);
            const DecodedShape shape = decode(space, coordinates.row(i).transpose(),
                                              companion.row(i).transpose(), size[i]);
            const Points* decoded = std::get_if<Points>(&shape);
            EXPECT_EQ(decoded != nullptr, options.kind == SpaceKind::Procrustes);
            const ShapePoint point =
                decoded ? ShapePoint{edge_lengths(collection.topology, *decoded),
                                     dihedral_angles(collection.topology, *decoded)}
                        : std::get<ShapePoint>(shape);
            EXPECT_LE((point.edge_lengths - lengths).cwiseQuotient(lengths).cwiseAbs().maxCoeff(),
                      1e-12);
            EXPECT_LE((point.dihedral_angles - dihedral_angles(collection.topology, points))
                          .cwiseAbs()
                          .maxCoeff(),
                      1e-11);
            ASSERT_EQ(point.positions.rows(), options.position_weight > 0.0 ? points.rows() : 0);
            if (point.positions.rows() > 0) {
                EXPECT_LE((best_rigid_motion(point.positions, points)(point.positions) - points)
                              .cwiseAbs()
                              .maxCoeff(),
                          1e-11);
            }
        }
    }
}

TEST(ShapeSpace, KnowsNoPose)
{
    const Collection collection = test::bumpy_spheres(5, 3);
    for (const SpaceOptions& options : test::sample_spaces()) {
        const ShapeSpace space = make_space(collection, options);
        const RowMatrix here = encode(space, collection);
        EXPECT_LE((encode(space, test::moved(collection, 40)) - here).norm(), 1e-11 * here.norm());
    }
}

TEST(ShapeSpace, OfUnitScaleKnowsNoSize)
{
    const Collection collection = test::bumpy_spheres(5, 4);
    Collection larger = collection;
    for (Points& points : larger.points)
        points *= 3.0;
    for (const SpaceOptions& options : test::sample_spaces()) {
        const ShapeSpace space = make_space(collection, options);
        const RowMatrix here = encode(space, collection);
        const double change = (encode(space, larger) - here).norm();
        if (options.scale == Scale::Unit)
            EXPECT_LE(change, 1e-12 * here.norm());
        else
            EXPECT_GT(change, 0.1 * here.norm());
        EXPECT_LE((sizes(space, larger) - 3.0 * sizes(space, collection)).norm(), 1e-11);
    }
}

TEST(ShapeSpace, EncodesAMeshTheSameInAnyCompany)
{
    const Collection collection = test::bumpy_spheres(5, 5);
    const Collection alone{collection.topology, {"one"}, {collection.points[3]}, {}};
    for (const SpaceOptions& options : test::sample_spaces()) {
        const ShapeSpace space = make_space(collection, options);
        EXPECT_EQ(encode(space, alone).row(0), encode(space, collection).row(3));
    }
}

TEST(ShapeSpace, HasTheMetricThatItsHeaderStates)
{
    // Two meshes half a small step away from their mean on either side.
    const test::TestMesh mesh = test::bumpy_sphere(1, 0.3, 6);
    constexpr double h = 1e-5;
    const Points step =
        h * test::random_matrix(mesh.points.rows(), 3, 7); // moves lengths and angles
    const Collection pair{
        mesh.topology, {"a", "b"}, {mesh.points - 0.5 * step, mesh.points + 0.5 * step}, {}};
    const Eigen::VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
    const Eigen::VectorXd relative =
        (edge_lengths(mesh.topology, pair.points[1]) - edge_lengths(mesh.topology, pair.points[0]))
            .cwiseQuotient(lengths);
    const Eigen::VectorXd turn = dihedral_angles(mesh.topology, pair.points[1]) -
                                 dihedral_angles(mesh.topology, pair.points[0]);
    Eigen::VectorXd area = Eigen::VectorXd::Zero(lengths.size());
    Eigen::VectorXd vertex_area = Eigen::VectorXd::Zero(mesh.points.rows());
    const Points aligned[2] = {aligned_with(mesh.points, pair.points[0], Scale::None),
                               aligned_with(mesh.points, pair.points[1], Scale::None)};
    const Eigen::VectorXd moved = (aligned[1] - aligned[0]).rowwise().norm();
    for (int f = 0; f < mesh.topology.face_count(); ++f) {
        const auto corner = mesh.topology.faces().row(f);
        const Eigen::RowVector3d u = mesh.points.row(corner[1]) - mesh.points.row(corner[0]);
        const Eigen::RowVector3d v = mesh.points.row(corner[2]) - mesh.points.row(corner[0]);
        for (const int e : mesh.topology.face_edges().row(f))
            area[e] += 0.5 * u.cross(v).norm() / 3.0;
        for (const int corner_of_face : corner)
            vertex_area[corner_of_face] += 0.5 * u.cross(v).norm() / 3.0;
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> principal(
        mesh.points.rowwise() - mesh.points.colwise().mean().eval(), Eigen::ComputeThinV);
    const double diagonal = bounding_box_diagonal(mesh.points * principal.matrixV());
    for (const SpaceOptions& options : test::sample_spaces()) {
        if (options.kind != SpaceKind::Edge || options.scale != Scale::None)
            continue;
        const Eigen::VectorXd gains = options.weighting == EdgeWeighting::Area
                                          ? Eigen::VectorXd((area / area.sum()).cwiseSqrt())
                                          : relative_slopes(options.coordinates, lengths);
        const Eigen::VectorXd shares =
            options.weighting == EdgeWeighting::Area
                ? Eigen::VectorXd(vertex_area / vertex_area.sum())
                : Eigen::VectorXd::Constant(vertex_area.size(), 1.0 / mesh.topology.vertex_count());
        const double expected =
            gains.cwiseProduct(relative).squaredNorm() +
            std::pow(options.dihedral_weight, 2) * gains.cwiseProduct(turn).squaredNorm() +
            std::pow(options.position_weight / diagonal, 2) * gains.squaredNorm() *
                shares.dot(moved.cwiseAbs2());
        const RowMatrix coordinates = encode(make_space(pair, options), pair);
        EXPECT_NEAR((coordinates.row(1) - coordinates.row(0)).squaredNorm(), expected,
                    1e-6 * expected);
    }
}

/// A flat square of 2 n^2 triangles, and the same stretched by 2 % along x.
Collection stretched_square(int n)
{
    const Topology topology = test::open_patch(n, 1).topology;
    Points square(topology.vertex_count(), 3);
    for (int r = 0; r <= n; ++r)
        for (int c = 0; c <= n; ++c)
            square.row(r * (n + 1) + c) << static_cast<double>(c) / n, static_cast<double>(r) / n,
                0.0;
    Points stretched = square;
    stretched.col(0) *= 1.02;
    return {topology, {"square", "stretched"}, {square, stretched}, {}};
}

TEST(ShapeSpace, WeightedByAreaDoesNotSeeHowFineAMeshIs)
{
    const auto distance = [](int n, LengthCoordinates coordinates, EdgeWeighting weighting) {
        const Collection pair = stretched_square(n);
        const RowMatrix rows = encode(
            make_space(pair,
                       {.scale = Scale::None, .coordinates = coordinates, .weighting = weighting}),
            pair);
        return (rows.row(1) - rows.row(0)).norm();
    };
    for (const LengthCoordinates coordinates :
         {LengthCoordinates::Plain, LengthCoordinates::Squared, LengthCoordinates::Log}) {
        const double coarse = distance(4, coordinates, EdgeWeighting::Area);
        EXPECT_NEAR(distance(16, coordinates, EdgeWeighting::Area), coarse, 1e-12 * coarse);
    }
    // Logarithms alone: 16 times as many faces, about four times the distance.
    EXPECT_NEAR(distance(16, LengthCoordinates::Log, EdgeWeighting::Uniform) /
                    distance(4, LengthCoordinates::Log, EdgeWeighting::Uniform),
                4.0, 0.5);
}

TEST(ShapeSpace, MeasuresAnglesNearTheFoldOnOneBranch)
{
    // Two triangles hinged at an edge, folded nearly flat onto each other from either side.
    Faces faces(2, 3);
    faces << 0, 1, 2, 1, 0, 3;
    const Topology topology(faces, 4);
    const auto hinge = [](double angle) {
        Points points(4, 3);
        points << 0, 0, 0, 1, 0, 0, 0.5, 1, 0, 0.5, -std::cos(angle), -std::sin(angle);
        return points;
    };
    const double fold = 3.1;
    const Collection pair{topology, {"over", "under"}, {hinge(fold), hinge(-fold)}, {}};
    const ShapeSpace space = make_space(pair, {.scale = Scale::None, .dihedral_weight = 1.0});
    const RowMatrix rows = encode(space, pair);
    const double length = 1.0; // of the hinge: a turn counts as much as it times the angle
    EXPECT_NEAR((rows.row(1) - rows.row(0)).norm(), length * (2.0 * M_PI - 2.0 * fold), 1e-12);
}

TEST(ShapeSpace, ProcrustesHasPositionsAlignedWithTheMean)
{
    const Collection collection = test::bumpy_spheres(4, 8);
    const ShapeSpace space = make_space(collection, {.kind = SpaceKind::Procrustes});
    const Points& mean = std::get<ProcrustesSpace>(space).mean;
    EXPECT_EQ(mean, procrustes_mean(collection.points).points);
    const RowMatrix rows = encode(space, collection);
    ASSERT_EQ(rows.cols(), 3 * mean.rows());
    const Points second = aligned_with(mean, collection.points[1], Scale::Unit);
    for (Index v = 0; v < mean.rows(); ++v)
        EXPECT_EQ(Eigen::RowVector3d(rows.row(1).segment(3 * v, 3)), second.row(v));
    EXPECT_EQ(companions(space, collection).cols(), 0);
    EXPECT_NEAR(sizes(space, collection)[2], centroid_size(collection.points[2]), 1e-12);
}

TEST(ShapeSpace, AlignsPositionsWithTheirMean)
{
    // The mean of the aligned meshes is what they are aligned with: the residual of Gower's equation.
    const Collection collection = test::moved(test::bumpy_spheres(6, 12), 13);
    for (const Scale scale : {Scale::Unit, Scale::None}) {
        const ShapeSpace space = make_space(collection, {.scale = scale, .position_weight = 2.0});
        const Points& mean = std::get<EdgeSpace>(space).mean_positions;
        Points sum = Points::Zero(mean.rows(), 3);
        for (const Points& points : collection.points) {
            const double size = edge_lengths(collection.topology, points).sum();
            sum += aligned_with(mean, scale == Scale::Unit ? Points(points / size) : points,
                                Scale::None);
        }
        EXPECT_LE((sum / 6.0 - mean).norm(), 1e-11 * mean.norm());
        EXPECT_LE(mean.colwise().mean().norm(), 1e-12 * mean.norm());
    }
}

TEST(ShapeSpace, DistancesDoNotDependOnHowMeshesStand)
{
    Collection collection = test::bumpy_spheres(5, 3);
    for (Points& points : collection.points) // a box along x, y and z shrinks when they turn
        points *= Eigen::Vector3d(4.0, 1.0, 0.3).asDiagonal();
    const auto products = [](const Collection& meshes, const SpaceOptions& options) {
        const RowMatrix rows = encode(make_space(meshes, options), meshes);
        const RowMatrix centred = rows.rowwise() - rows.colwise().mean().eval();
        return Eigen::MatrixXd(centred * centred.transpose());
    };
    for (const SpaceOptions& options : test::sample_spaces()) {
        const Eigen::MatrixXd here = products(collection, options);
        for (const unsigned seed : {1u, 2u, 3u})
            EXPECT_LE((products(test::moved(collection, seed), options) - here).norm(),
                      1e-5 * here.norm());
    }
}

TEST(FeasibleStepOfASpace, EndsWhereTheFirstTriangleBreaks)
{
    const Collection collection = test::bumpy_spheres(4, 9);
    for (const SpaceOptions& options : test::sample_spaces()) {
        const ShapeSpace space = make_space(collection, options);
        const RowMatrix rows = encode(space, collection);
        const RowMatrix angles = companions(space, collection);
        const Eigen::VectorXd mean = rows.row(0);
        const Eigen::VectorXd direction = rows.row(1) - rows.row(0);
        const double step = feasible_step(space, collection.topology, mean, direction, 50.0);
        if (options.kind == SpaceKind::Procrustes) {
            EXPECT_EQ(step, 50.0);
            continue;
        }
        const auto breaks = [&](double t) {
            const DecodedShape shape =
                decode(space, mean + t * direction, angles.row(0).transpose(), 1.0);
            return !check_admissibility(collection.topology,
                                        std::get<ShapePoint>(shape).edge_lengths)
                        .triangles.empty();
        };
        EXPECT_GT(step, 1.0 - 1e-9); // the other end is a mesh
        EXPECT_LT(step, 50.0);
        EXPECT_FALSE(breaks(step * (1.0 - 1e-9)));
        EXPECT_TRUE(breaks(step * (1.0 + 1e-9)));
    }
}

TEST(ShapeSpace, RefusesWhatBreaksARule)
{
    const Collection collection = test::bumpy_spheres(3, 10);
    EXPECT_THROW((void)make_space({collection.topology, {}, {}, {}}, {}), InvalidInput);
    for (const double weight : {-1.0, nan, std::numeric_limits<double>::infinity()})
        EXPECT_THROW((void)make_space(collection, {.dihedral_weight = weight}), InvalidInput);
    EXPECT_THROW(
        (void)make_space(collection, {.kind = SpaceKind::Procrustes, .dihedral_weight = 1.0}),
        InvalidInput);
    EXPECT_THROW((void)make_space(collection, {.position_weight = -1.0}), InvalidInput);
    EXPECT_THROW(
        (void)make_space(collection, {.kind = SpaceKind::Procrustes, .position_weight = 1.0}),
        InvalidInput);
    EXPECT_THROW((void)make_space(collection, {.kind = SpaceKind::Procrustes,
                                               .coordinates = LengthCoordinates::Log}),
                 InvalidInput);
    EXPECT_THROW((void)make_space(
                     collection, {.kind = SpaceKind::Procrustes, .weighting = EdgeWeighting::Area}),
                 InvalidInput);
}

TEST(ShapeSpace, RefusesMeshesAndPointsThatAreNotOfIt)
{
    const Collection collection = test::bumpy_spheres(3, 11);
    const test::TestMesh torus = test::torus(5, 7);
    const Collection others{torus.topology, {"torus"}, {torus.points}, {}};
    for (const SpaceOptions& options : test::sample_spaces()) {
        const ShapeSpace space = make_space(collection, options);
        const bool knows_meshes = options.kind == SpaceKind::Procrustes ||
                                  options.weighting == EdgeWeighting::Area ||
                                  options.dihedral_weight > 0.0 || options.position_weight > 0.0;
        if (knows_meshes) {
            EXPECT_THROW((void)encode(space, others), InvalidInput);
        }
        const Eigen::VectorXd row = encode(space, collection).row(0);
        const Eigen::VectorXd angles = companions(space, collection).row(0);
        EXPECT_THROW((void)decode(space, row.head(row.size() - 1), angles, 1.0), InvalidInput);
        if (angles.size() > 0) {
            EXPECT_THROW((void)decode(space, row, angles.head(5), 1.0), InvalidInput);
        }
        for (const double size : {0.0, -1.0, nan})
            if (options.scale == Scale::Unit) {
                EXPECT_THROW((void)decode(space, row, angles, size), InvalidInput);
            }
    }
}

} // namespace
} // namespace shape
