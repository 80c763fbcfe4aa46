// SPDX-License-Identifier: MIT

#include "libshape/mesh/vertex_shifts.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "libshape/base/order_statistics.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

/// Vertices so many edges away, and the sides of their polygon as indices into them.
struct Shell
{
    std::vector<int> vertices;
    std::vector<std::pair<int, int>> sides;
};

/// Finds shells with one mark a vertex, which is used again.
class ShellFinder
{
public:
    ShellFinder(const Topology& topology, int rings)
        : topology_(topology),
          rings_(rings),
          far_(to_size(topology.vertex_count()), -1),
          place_(far_)
    {
    }

    [[nodiscard]] Shell around(int vertex)
    {
        met_.assign(1, vertex);
        far_[to_size(vertex)] = 0;
        for (std::size_t k = 0; k < met_.size(); ++k)
            if (const int distance = far_[to_size(met_[k])]; distance < rings_)
                for (const Topology::Spoke& spoke : topology_.spokes(met_[k]))
                    if (int& other = far_[to_size(spoke.vertex)]; other < 0) {
                        other = distance + 1;
                        met_.push_back(spoke.vertex);
                    }
        Shell shell;
        for (const int v : met_)
            if (far_[to_size(v)] == rings_) {
                place_[to_size(v)] = static_cast<int>(shell.vertices.size());
                shell.vertices.push_back(v);
            }
        for (const int v : met_) // faces with one vertex within have a side opposite to it
            if (far_[to_size(v)] == rings_ - 1)
                for (const int h : topology_.outgoing(v)) {
                    const int a = place_[to_size(topology_.target(h))];
                    const int b = place_[to_size(topology_.target(Topology::next(h)))];
                    if (a >= 0 && b >= 0)
                        shell.sides.emplace_back(a, b);
                }
        for (const int v : met_)
            far_[to_size(v)] = place_[to_size(v)] = -1;
        return shell;
    }

private:
    const Topology& topology_;
    int rings_;
    std::vector<int> far_; ///< Edges from the vertex, or -1.
    std::vector<int> place_;
    std::vector<int> met_;
};

/// A vertex and its shell, seen along the normal of the polygon and about the centroid.
struct FlatShell
{
    Eigen::MatrixX2d shell;
    Eigen::RowVector2d vertex;
    double height = 0.0; ///< Of the vertex.
    double radius = 0.0; ///< Mean distance of the shell from the centroid, in space.
};

FlatShell flat_shell(const Shell& shell, int vertex, const Points& points)
{
    Points around = points(shell.vertices, Eigen::all);
    const Eigen::RowVector3d centre = around.colwise().mean();
    around.rowwise() -= centre;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (const auto& [a, b] : shell.sides)
        normal += around.row(a).transpose().cross(around.row(b).transpose());
    if (!(normal.norm() > 0.0))
        normal = Eigen::Vector3d::UnitZ();
    normal.normalize();
    Eigen::Matrix<double, 3, 2> axes;
    axes.col(0) = normal.unitOrthogonal();
    axes.col(1) = normal.cross(axes.col(0));
    const Eigen::RowVector3d from_centre = points.row(vertex) - centre;
    return {around * axes, from_centre * axes, from_centre.dot(normal),
            around.rowwise().norm().mean()};
}

/// The weights with which the shell gives the vertex, and which sum to one.
Eigen::VectorXd weights(const FlatShell& flat)
{
    constexpr double line = 1e-3; // of the trace: a shell near a line says nothing across it
    const Eigen::Index count = flat.shell.rows();
    Eigen::Matrix2d squares = flat.shell.transpose() * flat.shell;
    Eigen::VectorXd mean = Eigen::VectorXd::Constant(count, 1.0 / static_cast<double>(count));
    const double trace = squares.trace();
    if (!(trace > 0.0))
        return mean;
    squares.diagonal().array() += line * trace;
    return mean + flat.shell * squares.ldlt().solve(flat.vertex.transpose());
}

/// Change of the height of a vertex in every mesh.
Eigen::RowVectorXd heights_of(const std::vector<FlatShell>& all)
{
    Eigen::RowVectorXd heights(std::ssize(all));
    for (std::size_t i = 0; i < all.size(); ++i)
        heights[static_cast<Eigen::Index>(i)] =
            all[i].radius > 0.0 ? all[i].height / all[i].radius : 0.0;
    const double usual = median({heights.begin(), heights.end()});
    return (heights.array() - usual).abs();
}

/// The shift of a vertex in every mesh.
/// @param all  Gets its shell in each.
Eigen::RowVectorXd shifts_of(const Shell& shell, int vertex, std::span<const Points> meshes,
                             std::vector<FlatShell>& all)
{
    all.clear();
    Eigen::MatrixXd weight(std::ssize(meshes), std::ssize(shell.vertices));
    for (const Points& points : meshes) {
        all.push_back(flat_shell(shell, vertex, points));
        weight.row(std::ssize(all) - 1) = weights(all.back()).transpose();
    }
    Eigen::RowVectorXd usual(weight.cols());
    for (Eigen::Index k = 0; k < weight.cols(); ++k)
        usual[k] = median({weight.col(k).begin(), weight.col(k).end()});
    Eigen::RowVectorXd shifts = Eigen::RowVectorXd::Zero(std::ssize(meshes));
    const double sum = usual.sum(); // medians of weights that sum to one need not
    if (!(std::abs(sum) > 0.1))     // they agree in nothing
        return shifts;
    usual /= sum;
    for (std::size_t i = 0; i < meshes.size(); ++i)
        if (all[i].radius > 0.0)
            shifts[static_cast<Eigen::Index>(i)] =
                (all[i].vertex - usual * all[i].shell).norm() / all[i].radius;
    return shifts;
}

} // namespace

VertexShifts vertex_shifts(const Topology& topology, std::span<const Points> meshes, int rings,
                           int most)
{
    const int all = topology.vertex_count();
    const int count = std::min(all, most);
    std::vector<int> asked;
    for (int k = 0; k < count; ++k)
        asked.push_back(static_cast<int>(static_cast<std::int64_t>(k) * all / count));
    std::vector<char> is_known(asked.size(), 0);
    Eigen::MatrixXd shifts(count, std::ssize(meshes));
    Eigen::MatrixXd heights(count, std::ssize(meshes));
    parallel_for(asked.size(), 64, [&](std::size_t begin, std::size_t end) {
        ShellFinder finder(topology, rings);
        std::vector<FlatShell> flat;
        for (std::size_t k = begin; k < end; ++k) {
            const Shell shell = finder.around(asked[k]);
            if (shell.vertices.size() < 3)
                continue;
            shifts.row(static_cast<Eigen::Index>(k)) = shifts_of(shell, asked[k], meshes, flat);
            heights.row(static_cast<Eigen::Index>(k)) = heights_of(flat);
            is_known[k] = 1;
        }
    });
    VertexShifts result;
    std::vector<Eigen::Index> known;
    for (std::size_t k = 0; k < asked.size(); ++k)
        if (is_known[k] != 0) {
            result.vertices.push_back(asked[k]);
            known.push_back(static_cast<Eigen::Index>(k));
        }
    result.shifts = shifts(known, Eigen::all);
    result.heights = heights(known, Eigen::all);
    return result;
}

} // namespace shape::internal
