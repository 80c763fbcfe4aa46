// SPDX-License-Identifier: MIT

#include "libshape/embedding/continuation.h"

#include <Eigen/Geometry>
#include <map>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/embedding/face_layout.h"
#include "libshape/embedding/gauss_newton.h"
#include "libshape/embedding/graded_unknowns.h"
#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/embedding/face_fit.h"
#include "libshape/linalg/sparse_cholesky.h"
#include "libshape/mesh/alignment.h"

namespace shape {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Frames of the faces as face_layout.h wants them: x along the first half-edge, z the normal.
std::vector<Matrix3d> face_frames(const Topology& topology, const Points& points)
{
    std::vector<Matrix3d> frames(static_cast<std::size_t>(topology.face_count()));
    for (int f = 0; f < topology.face_count(); ++f) {
        const auto side = [&](int corner) -> Vector3d {
            return (points.row(topology.faces()(f, corner)) - points.row(topology.faces()(f, 0)))
                .normalized();
        };
        const Vector3d normal = side(1).cross(side(2)).normalized();
        frames[static_cast<std::size_t>(f)] << side(1), normal.cross(side(1)), normal;
    }
    return frames;
}

/// Positions whose edges are nearest, relative to their lengths, to what the faces want.
class GradedLaplacian
{
public:
    GradedLaplacian(const Topology& topology, const VectorXd& lengths)
        : topology_(topology),
          unknowns_(graded_unknowns(topology, lengths)),
          parts_(static_cast<std::size_t>(topology.edge_count())),
          weights_(lengths.array().square().inverse()),
          factor_(matrix())
    {
    }

    [[nodiscard]] const VectorXd& weights() const { return weights_; }

    /// @param halfedges  As seen from the frames of their faces.
    [[nodiscard]] Points positions(const std::vector<Matrix3d>& frames,
                                   const Points& halfedges) const
    {
        Eigen::MatrixXd rhs =
            Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(unknowns_.vertices.size()), 3);
        for (int f = 0; f < topology_.face_count(); ++f)
            for (int h = 3 * f; h < 3 * f + 3; ++h) {
                const int e = topology_.edge(h);
                const double forward = topology_.source(h) == topology_.edges()(e, 0) ? 1.0 : -1.0;
                const Vector3d pull =
                    forward * weights_[e] *
                    (frames[static_cast<std::size_t>(f)] * halfedges.row(h).transpose());
                for (const auto& [row, sign] : parts_[static_cast<std::size_t>(e)])
                    rhs.row(row) += sign * pull.transpose();
            }
        const Eigen::MatrixXd solution = factor_.solve(rhs);
        Points points = Points::Zero(topology_.vertex_count(), 3);
        for (std::size_t v = 0; v < unknowns_.rows.size(); ++v)
            for (const int row : unknowns_.rows[v])
                points.row(static_cast<Eigen::Index>(v)) += solution.row(row);
        return points;
    }

private:
    SparseMatrix matrix()
    {
        std::vector<Eigen::Triplet<double, int>> entries;
        for (int e = 0; e < topology_.edge_count(); ++e) {
            std::map<int, int> signs; // an unknown that moves both ends changes nothing
            for (const int end : {0, 1})
                for (const int row :
                     unknowns_.rows[static_cast<std::size_t>(topology_.edges()(e, end))])
                    signs[row] += end == 0 ? -1 : 1;
            std::erase_if(signs, [](const auto& part) { return part.second == 0; });
            const double weight = (topology_.is_boundary_edge(e) ? 1.0 : 2.0) * weights_[e];
            for (const auto& [i, a] : signs)
                for (const auto& [j, b] : signs)
                    if (i >= j)
                        entries.emplace_back(i, j, a * b * weight);
            parts_[static_cast<std::size_t>(e)].assign(signs.begin(), signs.end());
        }
        const auto size = static_cast<Eigen::Index>(unknowns_.vertices.size());
        SparseMatrix result(size, size);
        result.setFromTriplets(entries.begin(), entries.end());
        return result;
    }

    const Topology& topology_;
    GradedUnknowns unknowns_;
    std::vector<std::vector<std::pair<int, int>>> parts_; // of an edge: unknowns and their signs
    VectorXd weights_;
    SparseCholesky factor_;
};

/// The mesh with the target's lengths and bending as far as one Laplace solve a step can have them.
Points linear_start(const Topology& topology, const Points& from, const ShapePoint& target)
{
    constexpr int face_steps = 3;
    const VectorXd& lengths = target.edge_lengths;
    const GradedLaplacian laplacian(topology, lengths);
    const FaceLayout layout = lay_out_faces(topology, lengths, target.dihedral_angles);
    std::vector<Matrix3d> frames = face_frames(topology, from);
    Points points = laplacian.positions(frames, layout.halfedges);
    for (int step = 0; step < face_steps; ++step) {
        frames = fit_faces(topology, layout, laplacian.weights(), points, std::move(frames));
        points = laplacian.positions(frames, layout.halfedges);
    }
    return points;
}

} // namespace

ContinuedMesh continue_to(const Topology& topology, const Points& from, const ShapePoint& target,
                          const ContinuationOptions& options)
{
    if (from.rows() != topology.vertex_count())
        throw InvalidInput(join("from has ", from.rows(), " rows, the topology ",
                                topology.vertex_count(), " vertices"));
    const LengthDihedralEnergy energy(topology, target, options.smoothness);
    const GaussNewton solver(topology, target.edge_lengths);
    const Points start = linear_start(topology, from, target);
    const GaussNewtonResult found =
        solver.minimize(energy, start.reshaped<Eigen::RowMajor>(),
                        {.max_iterations = options.max_iterations,
                         .decrease_tolerance = options.decrease_tolerance,
                         .damping = 1e-10,
                         .least_damping = 1e-13,
                         .halvings = 3});
    const Points points = Eigen::Map<const Points>(found.points.data(), topology.vertex_count(), 3);
    return {best_rigid_motion(points, from)(points), found.value, found.iterations,
            found.converged};
}

} // namespace shape
