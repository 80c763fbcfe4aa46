// SPDX-License-Identifier: MIT

#include "libshape/edge_space/shape_space.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/edge_space/procrustes.h"
#include "libshape/edge_space/streamed_space.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/points.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

Eigen::VectorXd scaled_lengths(const Topology& topology, const Points& points, Scale scale)
{
    Eigen::VectorXd lengths = edge_lengths(topology, points);
    return scale == Scale::Unit ? Eigen::VectorXd(lengths / lengths.sum()) : lengths;
}

/// Sums over the collection, mesh by mesh in order: no more than one mesh is encoded at a time.
struct EdgeSums
{
    Eigen::VectorXd lengths;
    Eigen::VectorXd cosines;
    Eigen::VectorXd sines;
};

EdgeSums no_sums(const Topology& topology)
{
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(topology.edge_count());
    return {zero, zero, zero};
}

void add_to_sums(const Collection& collection, Scale scale, EdgeSums& sums)
{
    for (const Points& points : collection.points) {
        const Eigen::VectorXd angles = dihedral_angles(collection.topology, points);
        sums.lengths += scaled_lengths(collection.topology, points, scale);
        sums.cosines.array() += angles.array().cos();
        sums.sines.array() += angles.array().sin();
    }
}

/// A third of the areas of the faces at each edge, over the whole area [1].
Eigen::VectorXd area_shares(const Topology& topology, const Eigen::VectorXd& lengths)
{
    const Points angles = corner_angles(topology, lengths);
    Eigen::VectorXd shares = Eigen::VectorXd::Zero(topology.edge_count());
    double whole = 0.0;
    for (int f = 0; f < topology.face_count(); ++f) {
        const auto edges = topology.face_edges().row(f);
        const double area = 0.5 * lengths[edges[2]] * lengths[edges[0]] * std::sin(angles(f, 0));
        shares(edges).array() += area / 3.0;
        whole += area;
    }
    return shares / whole;
}

/// A mesh in the unit of the space.
Points scaled(const EdgeSpace& space, const Points& points, double size)
{
    return space.scale == Scale::Unit ? Points(points / size) : points;
}

/// Of an area of 1, what belongs to each vertex: of each face a third of it, as to its edges.
Eigen::VectorXd vertex_shares(const Topology& topology, const Eigen::VectorXd& of_edges)
{
    // A corner of a face ends two of its edges, which have a third of the face each.
    Eigen::VectorXd shares = Eigen::VectorXd::Zero(topology.vertex_count());
    for (int e = 0; e < topology.edge_count(); ++e)
        for (const int v : topology.edges().row(e))
            shares[v] += 0.5 * of_edges[e];
    return shares;
}

/// The diagonal of the bounding box whose sides run along the principal axes of the points, which does not
/// depend on how they stand, as that of a box along x, y and z does [length].
double principal_diagonal(const Points& points)
{
    const Points centred = points.rowwise() - points.colwise().mean().eval();
    const Eigen::Matrix3d axes =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(centred.transpose() * centred)
            .eigenvectors();
    return bounding_box_diagonal(centred * axes);
}

/// Generalised Procrustes alignment of meshes that come in parts: each is turned towards the mean of the
/// round before, the first of them at first.
Points mean_positions(const EdgeSpace& space, const EachPart& each_part)
{
    const ProcrustesOptions rule; // ends as procrustes_mean() does
    constexpr std::size_t at_a_time = 32;
    Points mean;
    for (int round = 0; round < rule.max_iterations; ++round) {
        Points sum;
        double count = 0.0;
        each_part([&](const Collection& part) {
            for (std::size_t first = 0; first < part.size(); first += at_a_time) {
                std::vector<Points> aligned(std::min(at_a_time, part.size() - first));
                const auto align = [&](std::size_t i) {
                    const Points& points = part.points[first + i];
                    const double size = edge_lengths(part.topology, points).sum();
                    aligned[i] = scaled(space, points, size);
                    if (mean.size() == 0 && first + i == 0 && count == 0.0)
                        mean = aligned[i].rowwise() - aligned[i].colwise().mean().eval();
                    aligned[i] = aligned_with(mean, aligned[i], Scale::None);
                };
                align(0); // the first of all is what the others are turned to
                parallel_for(aligned.size() - 1, 1,
                             [&](std::size_t i, std::size_t) { align(i + 1); });
                if (sum.size() == 0)
                    sum = Points::Zero(aligned.front().rows(), 3);
                for (const Points& points : aligned)
                    sum += points;
                count += static_cast<double>(aligned.size());
            }
        });
        sum /= count;
        const double change = (sum - mean).norm();
        mean = std::move(sum);
        if (change <= rule.tolerance * mean.norm())
            break;
    }
    return mean;
}

ProcrustesSpace make_procrustes_space(const Collection& collection, Scale scale)
{
    ProcrustesMean mean = procrustes_mean(collection.points, {.scale = scale});
    return {scale, std::move(mean.points), mean.iterations, mean.converged};
}

Index dimension(const EdgeSpace& space, const Topology& topology)
{
    return topology.edge_count() * (space.dihedral_factors.size() > 0 ? 2 : 1) +
           3 * space.position_factors.size();
}

Index dimension(const ProcrustesSpace& space, const Topology&)
{
    return 3 * space.mean.rows();
}

/// @param size  Gets the sum of the lengths.
/// @param coordinates  Gets them: of large meshes it costs more to copy numbers than to find them.
void encode_mesh(const EdgeSpace& space, const Topology& topology, const Points& points,
                 double& size, Eigen::Ref<Eigen::VectorXd> coordinates)
{
    const Index edges = topology.edge_count();
    Eigen::VectorXd lengths = edge_lengths(topology, points);
    size = lengths.sum();
    const double unit = space.scale == Scale::Unit ? size : 1.0;
    if (space.coordinates == LengthCoordinates::Plain)
        coordinates.head(edges) = lengths / unit;
    else
        coordinates.head(edges) = to_coordinates(space.coordinates, lengths / unit);
    if (space.length_factors.size() > 0)
        coordinates.head(edges).array() *= space.length_factors.array();
    if (space.dihedral_factors.size() > 0)
        coordinates.segment(edges, edges) = dihedral_angles(topology, points)
                                                .binaryExpr(space.branch_angles, &on_branch)
                                                .cwiseProduct(space.dihedral_factors);
    if (space.position_factors.size() > 0) {
        const Points aligned =
            aligned_with(space.mean_positions, scaled(space, points, size), Scale::None);
        coordinates.tail(aligned.size()) =
            Points(space.position_factors.asDiagonal() * aligned).reshaped<Eigen::RowMajor>();
    }
}

void encode_mesh(const ProcrustesSpace& space, const Topology&, const Points& points, double& size,
                 Eigen::Ref<Eigen::VectorXd> coordinates)
{
    size = centroid_size(points);
    coordinates = aligned_with(space.mean, points, space.scale).reshaped<Eigen::RowMajor>();
}

double size_of(const EdgeSpace&, const Topology& topology, const Points& points)
{
    return edge_lengths(topology, points).sum();
}

double size_of(const ProcrustesSpace&, const Topology&, const Points& points)
{
    return centroid_size(points);
}

void check_fit(const EdgeSpace& space, const Collection& collection)
{
    for (const Eigen::VectorXd* factors : {&space.length_factors, &space.dihedral_factors})
        if (factors->size() > 0 && factors->size() != collection.topology.edge_count())
            throw InvalidInput(join("space: it is of ", factors->size(), " edges, the meshes have ",
                                    collection.topology.edge_count()));
    const Index vertices = space.position_factors.size();
    if (vertices > 0 && vertices != collection.topology.vertex_count())
        throw InvalidInput(join("space: it is of ", vertices, " vertices, the meshes have ",
                                collection.topology.vertex_count()));
}

void check_fit(const ProcrustesSpace& space, const Collection& collection)
{
    if (space.mean.rows() != collection.topology.vertex_count())
        throw InvalidInput(join("space: it is of ", space.mean.rows(),
                                " vertices, the meshes have ", collection.topology.vertex_count()));
}

DecodedShape decode_point(const EdgeSpace& space, const Eigen::VectorXd& coordinates,
                          const Eigen::VectorXd& companion, double size)
{
    const bool with_angles = space.dihedral_factors.size() > 0;
    const Index of_positions = 3 * space.position_factors.size();
    const Index edges =
        with_angles ? space.dihedral_factors.size() : coordinates.size() - of_positions;
    if (coordinates.size() != edges * (with_angles ? 2 : 1) + of_positions ||
        (space.length_factors.size() > 0 && space.length_factors.size() != edges) ||
        (!with_angles && companion.size() != edges))
        throw InvalidInput(join("a point of edge space has ", coordinates.size(),
                                " coordinates and ", companion.size(),
                                " companion angles, which is not what the space has"));
    Eigen::VectorXd values = coordinates.head(edges);
    if (space.length_factors.size() > 0)
        values.array() /= space.length_factors.array();
    ShapePoint point{
        to_lengths(space.coordinates, values),
        with_angles ? coordinates.segment(edges, edges).cwiseQuotient(space.dihedral_factors).eval()
                    : companion};
    if (of_positions > 0)
        point.positions = space.position_factors.cwiseInverse().asDiagonal() *
                          coordinates.tail(of_positions)
                              .reshaped<Eigen::RowMajor>(space.position_factors.size(), 3);
    if (space.scale == Scale::Unit) {
        // The sum of combined plain lengths is 1 already; that of others is not.
        const bool is_linear = space.coordinates == LengthCoordinates::Plain;
        const double factor = is_linear ? size : size / point.edge_lengths.sum();
        point.edge_lengths *= factor;
        point.positions *= factor;
    }
    return point;
}

DecodedShape decode_point(const ProcrustesSpace& space, const Eigen::VectorXd& coordinates,
                          const Eigen::VectorXd&, double size)
{
    if (coordinates.size() != 3 * space.mean.rows())
        throw InvalidInput(join("a point of Procrustes space has ", coordinates.size(),
                                " coordinates, the space ", 3 * space.mean.rows()));
    const Points points = coordinates.reshaped<Eigen::RowMajor>(space.mean.rows(), 3);
    return Points(space.scale == Scale::Unit ? size * points : points);
}

} // namespace

void check(const SpaceOptions& options)
{
    // Beyond it the lengths' part of an inner product is lost to rounding.
    constexpr double most = 1e6;
    const auto require_weight = [](double weight, std::string_view field) {
        require(weight >= 0.0 && weight <= most, field, weight, "in [0, 1e6]");
    };
    require_weight(options.dihedral_weight, "SpaceOptions.dihedral_weight");
    require_weight(options.position_weight, "SpaceOptions.position_weight");
    const auto of_edge_space = [&](const char* field, bool is_set) {
        if (is_set && options.kind != SpaceKind::Edge)
            throw InvalidInput(
                join("SpaceOptions.", field,
                     " is set, but belongs to edge space, which is not the chosen one"));
    };
    of_edge_space("coordinates", options.coordinates != LengthCoordinates::Plain);
    of_edge_space("weighting", options.weighting != EdgeWeighting::Uniform);
    of_edge_space("dihedral_weight", options.dihedral_weight != 0.0);
    of_edge_space("position_weight", options.position_weight != 0.0);
}

ShapeSpace make_space(const Collection& collection, const SpaceOptions& options)
{
    check(options);
    if (collection.size() == 0)
        throw InvalidInput("a space of shapes needs at least one mesh");
    if (options.kind == SpaceKind::Procrustes)
        return make_procrustes_space(collection, options.scale);
    return make_edge_space(collection.topology, collection.size(), options,
                           [&](const auto& visit) { visit(collection); });
}

namespace internal {

EdgeSpace make_edge_space(const Topology& topology, std::size_t meshes, const SpaceOptions& options,
                          const EachPart& each_part)
{
    EdgeSpace space{options.scale, options.coordinates, {}, {}, {}, {}, {}};
    const bool by_area = options.weighting == EdgeWeighting::Area;
    const bool with_angles = options.dihedral_weight > 0.0;
    const bool with_positions = options.position_weight > 0.0;
    if (!by_area && !with_angles && !with_positions)
        return space;
    const auto count = static_cast<double>(meshes);
    EdgeSums sums = no_sums(topology);
    each_part([&](const Collection& part) { add_to_sums(part, options.scale, sums); });
    const Eigen::VectorXd mean = sums.lengths / count;
    const Eigen::VectorXd slopes = relative_slopes(options.coordinates, mean);
    const Eigen::VectorXd gains = // g_e
        by_area ? Eigen::VectorXd(area_shares(topology, mean).cwiseSqrt()) : slopes;
    if (by_area)
        space.length_factors = gains.cwiseQuotient(slopes);
    if (with_angles) {
        space.dihedral_factors = options.dihedral_weight * gains;
        space.branch_angles = sums.cosines.binaryExpr(
            sums.sines, [&](double x, double y) { return circular_mean(x, y, count); });
    }
    if (with_positions) {
        space.mean_positions = mean_positions(space, each_part);
        const Eigen::VectorXd shares =
            by_area
                ? vertex_shares(topology, area_shares(topology, mean))
                : Eigen::VectorXd::Constant(topology.vertex_count(), 1.0 / topology.vertex_count());
        space.position_factors = options.position_weight * gains.norm() /
                                 principal_diagonal(space.mean_positions) * shares.cwiseSqrt();
    }
    return space;
}

void encode(const ShapeSpace& space, const Collection& block, RowMatrix& coordinates,
            Eigen::VectorXd& sizes)
{
    std::visit(
        [&](const auto& s) {
            check_fit(s, block);
            const auto count = static_cast<Index>(block.size());
            coordinates.resize(count, dimension(s, block.topology));
            sizes.resize(count);
            parallel_for(block.size(), 1, [&](std::size_t mesh, std::size_t) {
                const auto row = static_cast<Index>(mesh);
                encode_mesh(s, block.topology, block.points[mesh], sizes[row],
                            coordinates.row(row).transpose());
            });
        },
        space);
}

Index dimension(const ShapeSpace& space, const Topology& topology)
{
    return std::visit([&](const auto& s) { return shape::dimension(s, topology); }, space);
}

bool has_companions(const ShapeSpace& space)
{
    const EdgeSpace* edge = std::get_if<EdgeSpace>(&space);
    return edge != nullptr && edge->dihedral_factors.size() == 0;
}

} // namespace internal

Scale scale_of(const ShapeSpace& space)
{
    return std::visit([](const auto& s) { return s.scale; }, space);
}

bool is_plain(const ShapeSpace& space)
{
    const EdgeSpace* edge = std::get_if<EdgeSpace>(&space);
    return edge != nullptr && edge->coordinates == LengthCoordinates::Plain &&
           edge->length_factors.size() == 0 && edge->dihedral_factors.size() == 0 &&
           edge->position_factors.size() == 0;
}

RowMatrix encode(const ShapeSpace& space, const Collection& collection)
{
    return std::visit(
        [&](const auto& s) {
            check_fit(s, collection);
            RowMatrix coordinates(static_cast<Index>(collection.size()),
                                  dimension(s, collection.topology));
            parallel_for(collection.size(), 1, [&](std::size_t mesh, std::size_t) {
                double size = 0.0;
                encode_mesh(s, collection.topology, collection.points[mesh], size,
                            coordinates.row(static_cast<Index>(mesh)).transpose());
            });
            return coordinates;
        },
        space);
}

Eigen::VectorXd sizes(const ShapeSpace& space, const Collection& collection)
{
    return std::visit(
        [&](const auto& s) {
            Eigen::VectorXd result(static_cast<Index>(collection.size()));
            for (std::size_t i = 0; i < collection.size(); ++i)
                result[static_cast<Index>(i)] =
                    size_of(s, collection.topology, collection.points[i]);
            return result;
        },
        space);
}

RowMatrix companions(const ShapeSpace& space, const Collection& collection)
{
    if (!has_companions(space))
        return RowMatrix(static_cast<Index>(collection.size()), 0);
    return companion_angles(collection);
}

DecodedShape decode(const ShapeSpace& space, const Eigen::VectorXd& coordinates,
                    const Eigen::VectorXd& companion, double size)
{
    if (scale_of(space) == Scale::Unit && !(size > 0.0 && std::isfinite(size)))
        throw InvalidInput(join("a shape's size is ", size, ", must be > 0 and finite"));
    return std::visit([&](const auto& s) { return decode_point(s, coordinates, companion, size); },
                      space);
}

double feasible_step(const ShapeSpace& space, const Topology& topology, const Eigen::VectorXd& mean,
                     const Eigen::VectorXd& direction, double limit)
{
    const EdgeSpace* edge = std::get_if<EdgeSpace>(&space);
    if (edge == nullptr)
        return limit;
    const auto values = [&](const Eigen::VectorXd& coordinates) -> Eigen::VectorXd {
        const auto lengths = coordinates.head(topology.edge_count());
        if (edge->length_factors.size() == 0)
            return lengths;
        return lengths.cwiseQuotient(edge->length_factors);
    };
    return feasible_step(topology, values(mean), values(direction), limit, edge->coordinates);
}

} // namespace shape
