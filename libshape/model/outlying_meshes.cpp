// SPDX-License-Identifier: MIT

#include "libshape/model/outlying_meshes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <set>

#include "libshape/base/format.h"
#include "libshape/base/order_statistics.h"
#include "libshape/base/rounded.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/dense.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/oddities.h"
#include "libshape/mesh/vertex_shifts.h"
#include "libshape/statistics/mean.h"

namespace shape {
using namespace internal;
namespace {

/// The median and the median deviation of five withstand two strange values, those of fewer only one.
constexpr std::size_t least_meshes = 5;

/// One figure of every mesh, and what it must exceed to be far from the others'.
struct Figure
{
    std::vector<double> values;
    double usual = 0.0;
    double limit = 0.0;
    std::set<std::size_t> sound = {}; ///< Beyond the limit, and yet not far.

    Figure(std::vector<double> figures, double least, double factor, double deviations)
        : values(std::move(figures)), usual(median(values))
    {
        std::vector<double> distances;
        for (const double value : values)
            distances.push_back(std::abs(value - usual));
        limit = std::max({least, factor * usual, usual + deviations * 1.4826 * median(distances)});
    }
    [[nodiscard]] bool is_far(std::size_t mesh) const
    {
        return values[mesh] > limit && !sound.contains(mesh);
    }
};

/// Unit-sum edge lengths, a row a mesh.
RowMatrix shape_vectors(const Collection& collection)
{
    RowMatrix rows(static_cast<Eigen::Index>(collection.size()), collection.topology.edge_count());
    parallel_for(collection.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Eigen::VectorXd lengths = edge_lengths(collection.topology, collection.points[i]);
            rows.row(static_cast<Eigen::Index>(i)) = lengths.transpose() / lengths.sum();
        }
    });
    return rows;
}

constexpr double none = std::numeric_limits<double>::infinity();

/// Squared distances between some rows and all of them, to the nearest that is no copy (a mirror image is one);
/// `none` if there are only copies.
struct NearestSquares
{
    Eigen::VectorXd of_some; ///< To the nearest of all.
    Eigen::VectorXd of_all;  ///< To the nearest of the some.
};

/// @param some  `rows` itself, or some of them.
/// @param rows  About their mean.
NearestSquares nearest_squares(const RowMatrix& some, const RowMatrix& rows)
{
    const bool are_all = &some == &rows; // then each pair is met once
    const Eigen::VectorXd some_norms = some.rowwise().squaredNorm();
    const Eigen::VectorXd norms = rows.rowwise().squaredNorm();
    const double copy = 1e-12 * norms.maxCoeff(); // squared; rounding is 1e-16
    NearestSquares nearest{Eigen::VectorXd::Constant(some.rows(), none),
                           Eigen::VectorXd::Constant(rows.rows(), none)};
    std::mutex alone; // a minimum is the same in any order
    parallel_for(to_size(rows.rows()), 64, [&](std::size_t begin, std::size_t end) {
        const auto first = static_cast<Eigen::Index>(begin);
        const auto count = static_cast<Eigen::Index>(end - begin);
        const Eigen::Index met = are_all ? first + count : some.rows();
        Eigen::MatrixXd squares =
            -2.0 * some.topRows(met) * rows.middleRows(first, count).transpose();
        squares.colwise() += some_norms.head(met);
        squares.rowwise() += norms.segment(first, count).transpose();
        squares.array() = (squares.array() > copy).select(squares.array(), none);
        nearest.of_all.segment(first, count) = squares.colwise().minCoeff().transpose();
        const std::lock_guard lock(alone);
        nearest.of_some.head(met) =
            nearest.of_some.head(met).cwiseMin(squares.rowwise().minCoeff());
    });
    if (are_all)
        nearest.of_some = nearest.of_all = nearest.of_some.cwiseMin(nearest.of_all).eval();
    return nearest;
}

/// 0 where there are only copies.
std::vector<double> roots_of(const Eigen::VectorXd& squares)
{
    std::vector<double> roots;
    for (const double square : squares)
        roots.push_back(square < none ? std::sqrt(square) : 0.0);
    return roots;
}

/// How the meshes that are near enough spread about their mean.
class Spread
{
public:
    /// @param rows  Some of them.
    explicit Spread(RowMatrix rows) : mean_(mean_of_rows(rows)), rows_(std::move(rows))
    {
        rows_.rowwise() -= mean_.transpose();
        const Eigen::MatrixXd products = rows_ * rows_.transpose();
        std::vector<double> norms;
        for (const double square : products.diagonal())
            norms.push_back(std::sqrt(square));
        usual_ = median(norms);
        const double squares = products.squaredNorm();
        if (!(squares > 0.0)) // copies
            return;
        const double dimensions = products.trace() * products.trace() / squares;
        const auto count = static_cast<double>(rows_.rows());
        apart_ = 4.0 + (4.0 + 50.0 / count) / (dimensions * dimensions);
        off_ = 2.0 + 12.0 / count;
        axes_.compute(products);
    }

    /// Whether a mesh is far for this spread, its nearest one being at a distance: along the directions that the others
    /// vary in, of which the last one is often far from the next if they are few, or off these.
    [[nodiscard]] bool is_far(const Eigen::VectorXd& row, double distance) const
    {
        return distance > apart_ * usual_ || distance_off(row - mean_) > off_ * usual_;
    }

private:
    /// Distance from the directions that the others vary in.
    [[nodiscard]] double distance_off(const Eigen::VectorXd& from_mean) const
    {
        constexpr double rounding = 1e-10; // of the largest square
        if (axes_.eigenvalues().size() == 0)
            return from_mean.norm();
        const Eigen::VectorXd along = axes_.eigenvectors().transpose() * (rows_ * from_mean);
        double square = from_mean.squaredNorm();
        for (Eigen::Index i = 0; i < along.size(); ++i)
            if (axes_.eigenvalues()[i] > rounding * axes_.eigenvalues().maxCoeff())
                square -= along[i] * along[i] / axes_.eigenvalues()[i];
        return std::sqrt(std::max(0.0, square));
    }

    Eigen::VectorXd mean_;
    RowMatrix rows_;
    double usual_ = 0.0; ///< Median distance from the mean.
    double apart_ = 0.0;
    double off_ = 0.0;
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes_;
};

/// Takes out those that are far for their neighbours alone.
Figure against_spread(Figure figure, const RowMatrix& rows)
{
    constexpr Eigen::Index most_compared = 1000;
    std::vector<Eigen::Index> all_near;
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
        if (!figure.is_far(to_size(i)))
            all_near.push_back(i);
    if (std::ssize(all_near) == rows.rows())
        return figure;
    std::vector<Eigen::Index> some;
    const Eigen::Index count = std::min<Eigen::Index>(std::ssize(all_near), most_compared);
    for (Eigen::Index k = 0; k < count; ++k)
        some.push_back(all_near[to_size(k * std::ssize(all_near) / count)]);
    const Spread spread(rows(some, Eigen::all));
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
        if (figure.is_far(to_size(i)) &&
            !spread.is_far(rows.row(i).transpose(), figure.values[to_size(i)]))
            figure.sound.insert(to_size(i));
    return figure;
}

/// Distance to the nearest of the others. Of many meshes some are compared with all, and say what is usual. How near
/// the rest are to these is enough to know that nearly all are near enough; the others are compared with all as well.
Figure nearest_distances(RowMatrix rows)
{
    constexpr Eigen::Index most_compared = 1000;
    rows.rowwise() -= mean_of_rows(rows).transpose();
    const auto figure_of = [](const Eigen::VectorXd& squares) {
        return Figure(roots_of(squares), 0.0, 3.0, 8.0);
    };
    if (rows.rows() <= most_compared)
        return against_spread(figure_of(nearest_squares(rows, rows).of_all), rows);
    std::vector<Eigen::Index> some;
    for (Eigen::Index k = 0; k < most_compared; ++k)
        some.push_back(k * rows.rows() / most_compared);
    const auto found = nearest_squares(rows(some, Eigen::all), rows);
    Figure figure = figure_of(found.of_some);
    Eigen::VectorXd squares = found.of_all;
    for (std::size_t k = 0; k < some.size(); ++k)
        squares[some[k]] = found.of_some[static_cast<Eigen::Index>(k)];
    std::vector<Eigen::Index> doubtful;
    const auto compare_with_all = [&] {
        const Eigen::VectorXd nearest = nearest_squares(rows(doubtful, Eigen::all), rows).of_some;
        for (std::size_t k = 0; k < doubtful.size(); ++k)
            squares[doubtful[k]] = nearest[static_cast<Eigen::Index>(k)];
        doubtful.clear();
    };
    for (Eigen::Index i = 0; i < squares.size(); ++i) {
        if (squares[i] > figure.limit * figure.limit)
            doubtful.push_back(i);
        if (std::ssize(doubtful) == most_compared)
            compare_with_all();
    }
    if (!doubtful.empty())
        compare_with_all();
    figure.values = roots_of(squares);
    return against_spread(std::move(figure), rows);
}

/// Distance of every value to the nearest one of its column.
RowMatrix column_gaps(RowMatrix values)
{
    const Eigen::Index count = values.rows();
    parallel_for(to_size(values.cols()), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<std::pair<double, Eigen::Index>> sorted(to_size(count));
        for (auto e = static_cast<Eigen::Index>(begin); e < static_cast<Eigen::Index>(end); ++e) {
            for (Eigen::Index i = 0; i < count; ++i)
                sorted[to_size(i)] = {values(i, e), i};
            std::sort(sorted.begin(), sorted.end());
            double before = none;
            for (std::size_t k = 0; k < sorted.size(); ++k) {
                const double after =
                    k + 1 < sorted.size() ? sorted[k + 1].first - sorted[k].first : none;
                values(sorted[k].second, e) = std::min(before, after);
                before = after;
            }
        }
    });
    return values;
}

/// The vertex of the largest figure, and that.
struct Place
{
    double value = -1.0;
    int vertex = -1;
};

/// By how much the gap of a vertex, the mean over its edges, exceeds what its neighbours have, or half of it if that is
/// more: at a joint that bends further than any other all around it change, at exchanged vertices two do.
std::vector<Place> largest_gaps(const Topology& topology, const RowMatrix& gaps)
{
    std::vector<Place> places(to_size(gaps.rows()));
    parallel_for(places.size(), 1, [&](std::size_t begin, std::size_t) {
        const auto row = gaps.row(static_cast<Eigen::Index>(begin));
        std::vector<double> means;
        for (int v = 0; v < topology.vertex_count(); ++v) {
            double sum = 0.0;
            for (const Topology::Spoke& spoke : topology.spokes(v))
                sum += row[spoke.edge];
            means.push_back(sum / static_cast<double>(topology.spokes(v).size()));
        }
        for (int v = 0; v < topology.vertex_count(); ++v) {
            const double gap = means[to_size(v)];
            if (gap <= places[begin].value)
                continue;
            std::vector<double> around;
            for (const Topology::Spoke& spoke : topology.spokes(v))
                around.push_back(means[to_size(spoke.vertex)]);
            const double value = std::max(0.5 * gap, gap - median(std::move(around)));
            if (value > places[begin].value)
                places[begin] = {value, v};
        }
    });
    return places;
}

/// How far a vertex stands out of its neighbours where its edges are unlike those of any other mesh: a joint that bends further
/// than any other lifts its neighbours too, and leaves lengths as they are.
std::vector<Place> largest_spikes(const Topology& topology, const VertexShifts& all,
                                  const RowMatrix& gaps)
{
    constexpr double varying = 3.0;
    Eigen::MatrixXd heights = Eigen::MatrixXd::Zero(topology.vertex_count(), gaps.rows());
    Eigen::VectorXd usual = Eigen::VectorXd::Zero(topology.vertex_count());
    for (std::size_t k = 0; k < all.vertices.size(); ++k) {
        const auto row = all.heights.row(static_cast<Eigen::Index>(k));
        heights.row(all.vertices[k]) = row;
        usual[all.vertices[k]] = median({row.begin(), row.end()});
    }
    std::vector<Place> places(to_size(gaps.rows()));
    parallel_for(places.size(), 1, [&](std::size_t begin, std::size_t) {
        const auto mesh = static_cast<Eigen::Index>(begin);
        std::vector<double> around;
        for (int v = 0; v < topology.vertex_count(); ++v) {
            const double beyond = heights(v, mesh) - varying * usual[v];
            if (beyond <= 0.0)
                continue;
            around.clear();
            double gap = 0.0;
            for (const Topology::Spoke& spoke : topology.spokes(v)) {
                around.push_back(heights(spoke.vertex, mesh));
                gap += gaps(mesh, spoke.edge);
            }
            gap /= static_cast<double>(around.size());
            const double square = (beyond - median(around)) * gap;
            if (const double value = std::sqrt(std::max(0.0, square)); value > places[begin].value)
                places[begin] = {value, v};
        }
    });
    for (Place& place : places)
        place.value = std::max(0.0, place.value); // no vertex is beyond what is usual
    return places;
}

/// Whether the edges at a vertex have other lengths in a mesh than in most.
/// @param logarithms  Of unit-sum lengths, a row a mesh.
bool has_other_lengths(const Topology& topology, const RowMatrix& logarithms, int vertex,
                       Eigen::Index mesh)
{
    constexpr double varying = 3.0;
    constexpr double least = 0.05;
    double sum = 0.0;
    for (const Topology::Spoke& spoke : topology.spokes(vertex)) {
        const auto column = logarithms.col(spoke.edge);
        const double usual = median({column.begin(), column.end()});
        std::vector<double> distances;
        for (const double value : column)
            distances.push_back(std::abs(value - usual));
        const double distance = distances[to_size(mesh)];
        sum += std::max(0.0, distance - varying * median(std::move(distances)));
    }
    return sum > least * static_cast<double>(topology.spokes(vertex).size());
}

/// A vertex, or what is around it, that lies elsewhere in a mesh than in most.
struct Shift : Place
{
    std::vector<std::size_t> alike; ///< Other meshes that have it there as far, ascending.
};

/// By how much the shift of a vertex exceeds three times the usual one there.
/// @param least  Smaller ones count as 0. @param counts  Asked whether the others do.
std::vector<Shift> largest_shifts(
    const VertexShifts& all, double least = -1.0,
    const std::function<bool(int vertex, Eigen::Index mesh)>& counts = {})
{
    constexpr double varying = 3.0;
    constexpr double alike = 0.5; // of the shift: where the same slip leads depends on the mesh
    std::vector<Shift> found(to_size(all.shifts.cols()));
    std::vector<Eigen::Index> rows(found.size(), -1);
    for (std::size_t k = 0; k < all.vertices.size(); ++k) {
        const auto row = all.shifts.row(static_cast<Eigen::Index>(k));
        const double usual = median({row.begin(), row.end()});
        for (std::size_t i = 0; i < found.size(); ++i)
            if (const double value = row[static_cast<Eigen::Index>(i)] - varying * usual;
                value > std::max(least, found[i].value) &&
                (!counts || counts(all.vertices[k], static_cast<Eigen::Index>(i)))) {
                found[i].value = value;
                found[i].vertex = all.vertices[k];
                rows[i] = static_cast<Eigen::Index>(k);
            }
    }
    for (std::size_t i = 0; i < found.size(); ++i)
        for (std::size_t j = 0; j < found.size() && rows[i] >= 0; ++j)
            if (j != i && all.shifts(rows[i], static_cast<Eigen::Index>(j)) >=
                              alike * all.shifts(rows[i], static_cast<Eigen::Index>(i)))
                found[i].alike.push_back(j);
    return found;
}

template <class PlaceOrShift>
std::vector<double> values_of(const std::vector<PlaceOrShift>& places)
{
    std::vector<double> values;
    for (const PlaceOrShift& place : places)
        values.push_back(place.value);
    return values;
}

} // namespace

std::vector<OutlyingMesh> find_outlying_meshes(const Collection& collection)
{
    if (collection.size() < least_meshes)
        return {};
    const Topology& topology = collection.topology;
    const RowMatrix lengths = shape_vectors(collection);
    const RowMatrix logarithms = lengths.array().log();
    // A vertex among its neighbours, and a region, that of a landmark, in what is around it.
    const VertexShifts shifts =
        vertex_shifts(topology, collection.points, 1, topology.vertex_count());
    Figure shift(values_of(largest_shifts(shifts)), 0.9, 2.0, 5.0);
    // Where neighbours lie close together, as lips do, vertices are often shifted and keep their lengths.
    const std::vector<Shift> shift_places =
        largest_shifts(shifts, shift.limit, [&](int vertex, Eigen::Index mesh) {
            return has_other_lengths(topology, logarithms, vertex, mesh);
        });
    shift.values = values_of(shift_places);
    const std::vector<Shift> region_places =
        largest_shifts(vertex_shifts(topology, collection.points, 6, 1500));
    const RowMatrix gaps = column_gaps(logarithms);
    const std::vector<Place> gap_places = largest_gaps(topology, gaps);
    const std::vector<Place> spike_places = largest_spikes(topology, shifts, gaps);
    const Figure distance = nearest_distances(lengths);
    const Figure length_gap(values_of(gap_places), 0.6, 2.5, 5.0);
    const Figure region_shift(values_of(region_places), 0.8, 4.0, 8.0);
    const Figure spike(values_of(spike_places), 0.5, 3.0, 8.0);
    std::vector<OutlyingMesh> found;
    for (std::size_t i = 0; i < collection.size(); ++i) {
        OutlyingMesh mesh{i,
                          distance.values[i],
                          length_gap.values[i],
                          std::max(0.0, shift.values[i]),
                          region_shift.values[i],
                          spike.values[i],
                          -1,
                          {}};
        std::string why;
        std::vector<std::size_t> alike;
        if (shift.is_far(i)) {
            mesh.vertex = shift_places[i].vertex;
            alike = shift_places[i].alike;
            why = join("vertex ", mesh.vertex, " lies ", rounded(mesh.shift),
                       " edges from where it lies among its neighbours in most meshes");
        } else if (region_shift.is_far(i)) {
            mesh.vertex = region_places[i].vertex;
            alike = region_places[i].alike;
            why = join("what lies around vertex ", mesh.vertex, " is moved by ",
                       rounded(100.0 * mesh.region_shift), " % of its size against most meshes");
        } else if (length_gap.is_far(i)) {
            mesh.vertex = gap_places[i].vertex;
            why = join("the edges at vertex ", mesh.vertex, " differ by a factor of ",
                       rounded(std::exp(mesh.length_gap)), " from those of every other mesh");
        } else if (spike.is_far(i)) {
            mesh.vertex = spike_places[i].vertex;
            why =
                join("vertex ", mesh.vertex,
                     " stands out of its neighbours, with edges unlike those of every other mesh");
        } else if (distance.is_far(i)) {
            why = join("the nearest one is ", rounded(mesh.distance / distance.usual),
                       " times as far as usual");
        } else {
            continue;
        }
        mesh.message =
            join(collection.names[i], " is far from all other meshes",
                 alike.empty() ? "" : join(" but ", list_names(collection.names, alike)), ": ", why,
                 alike.empty() ? "" : ", as there",
                 "; look at it (exchanged vertices or landmarks, a failed registration?)");
        found.push_back(std::move(mesh));
    }
    return found;
}

} // namespace shape
