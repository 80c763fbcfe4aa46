// SPDX-License-Identifier: MIT

#include "libshape/embedding/path/continuation.h"

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/energy/gauss_newton.h"
#include "libshape/embedding/energy/graded_unknowns.h"
#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/embedding/start/face_fit.h"
#include "libshape/embedding/start/face_layout.h"
#include "libshape/linalg/sparse_cholesky.h"
#include "libshape/mesh/alignment.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Positions whose edges are nearest, relative to their lengths, to what the faces want.
class GradedLaplacian
{
public:
    GradedLaplacian(const Topology& topology, GradedUnknowns unknowns)
        : topology_(topology), unknowns_(std::move(unknowns))
    {
        for (int e = 0; e < topology_.edge_count(); ++e) {
            std::map<int, int> signs; // an unknown that moves both ends changes nothing
            for (const int end : {0, 1})
                for (const int row : unknowns_.rows[to_size(topology_.edges()(e, end))])
                    signs[row] += end == 0 ? -1 : 1;
            std::erase_if(signs, [](const auto& part) { return part.second == 0; });
            parts_.emplace_back(signs.begin(), signs.end());
        }
    }

    void set_lengths(const VectorXd& lengths)
    {
        weights_ = lengths.array().square().inverse();
        std::vector<Eigen::Triplet<double, int>> entries;
        for (int e = 0; e < topology_.edge_count(); ++e) {
            const double weight = (topology_.is_boundary_edge(e) ? 1.0 : 2.0) * weights_[e];
            for (const auto& [i, a] : parts_[to_size(e)])
                for (const auto& [j, b] : parts_[to_size(e)])
                    if (i >= j)
                        entries.emplace_back(i, j, a * b * weight);
        }
        const auto size = static_cast<Eigen::Index>(unknowns_.vertices.size());
        SparseMatrix matrix(size, size);
        matrix.setFromTriplets(entries.begin(), entries.end());
        if (factor_)
            factor_->refactor(matrix);
        else
            factor_.emplace(matrix);
    }

    /// Of set_lengths(): the weight of every edge.
    [[nodiscard]] const VectorXd& weights() const { return weights_; }

    [[nodiscard]] Points positions(const FaceLayout& layout, const Rotations& frames) const
    {
        Eigen::MatrixXd rhs =
            Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(unknowns_.vertices.size()), 3);
        for (int f = 0; f < topology_.face_count(); ++f) {
            const Matrix3d frame = frames[to_size(f)].toRotationMatrix();
            for (int h = 3 * f; h < 3 * f + 3; ++h) {
                const int e = topology_.edge(h);
                const double forward = topology_.source(h) == topology_.edges()(e, 0) ? 1.0 : -1.0;
                const Vector3d pull =
                    forward * weights_[e] * (frame.leftCols<2>() * layout.halfedge(h));
                for (const auto& [row, sign] : parts_[to_size(e)])
                    rhs.row(row) += sign * pull.transpose();
            }
        }
        const Eigen::MatrixXd solution = factor_->solve(rhs);
        Points points = Points::Zero(topology_.vertex_count(), 3);
        for (std::size_t v = 0; v < unknowns_.rows.size(); ++v)
            for (const int row : unknowns_.rows[v])
                points.row(static_cast<Eigen::Index>(v)) += solution.row(row);
        return points;
    }

private:
    Topology topology_;
    GradedUnknowns unknowns_;
    std::vector<std::vector<std::pair<int, int>>> parts_; // of an edge: unknowns and their signs
    VectorXd weights_;
    std::optional<SparseCholesky> factor_;
};

/// @throws InvalidInput if there is not a positive length for every edge.
void check_lengths(const Topology& topology, const VectorXd& lengths)
{
    if (lengths.size() != topology.edge_count() || !(lengths.array() > 0.0).all() ||
        !lengths.allFinite())
        throw InvalidInput(join("lengths: ", lengths.size(), " values for ", topology.edge_count(),
                                " edges, must be one each, > 0 and finite"));
}

} // namespace

void check(const ContinuationOptions& options)
{
    require_positive(options.smoothness, "ContinuationOptions.smoothness");
    require_positive(options.stiffness, "ContinuationOptions.stiffness");
    require_not_negative(options.decrease_tolerance, "ContinuationOptions.decrease_tolerance");
    require_at_least(0, options.max_iterations, "ContinuationOptions.max_iterations");
}

struct Continuation::State
{
    State(const Topology& of, const GradedUnknowns& unknowns)
        : topology(of), laplacian(of, unknowns), solver(of, unknowns)
    {
    }

    /// The mesh with the target's lengths and bending as far as Laplace solves can have them.
    Points linear_start(const Points& from, const ShapePoint& target)
    {
        constexpr int face_steps = 3; // as DihedralEmbeddingOptions.local_global_steps
        laplacian.set_lengths(target.edge_lengths);
        const FaceLayout layout =
            lay_out_faces(topology, target.edge_lengths, target.dihedral_angles);
        Rotations frames = face_frames(topology, from);
        Points points = laplacian.positions(layout, frames);
        for (int step = 0; step < face_steps; ++step) {
            frames = fit_faces(topology, layout, laplacian.weights(), points, std::move(frames));
            points = laplacian.positions(layout, frames);
        }
        return points;
    }

    /// Gauss-Newton steps from start, the result in the pose of another mesh.
    ContinuedMesh descend(const LengthDihedralEnergy& energy, const Points& start,
                          const Points& pose, const ContinuationOptions& options)
    {
        const GaussNewtonResult found =
            solver.minimize(energy, start.reshaped<Eigen::RowMajor>(),
                            {.max_iterations = options.max_iterations,
                             .decrease_tolerance = options.decrease_tolerance,
                             .stiffness = options.stiffness},
                            &factor);
        const Points points =
            Eigen::Map<const Points>(found.points.data(), topology.vertex_count(), 3);
        return {best_rigid_motion(points, pose)(points), found.value, found.iterations,
                found.converged};
    }

    void check_mesh(const Points& from) const
    {
        if (from.rows() != topology.vertex_count())
            throw InvalidInput(join("from has ", from.rows(), " rows, the topology ",
                                    topology.vertex_count(), " vertices"));
    }

    Topology topology;
    GradedLaplacian laplacian;
    GaussNewton solver;
    std::optional<SparseCholesky> factor; ///< The solver keeps it from one mesh to the next.
};

Continuation::Continuation(const Topology& topology, const VectorXd& lengths)
{
    check_lengths(topology, lengths);
    state_ = std::make_unique<State>(topology, graded_unknowns(topology, lengths));
}

Continuation::~Continuation() = default;
Continuation::Continuation(Continuation&&) noexcept = default;
Continuation& Continuation::operator=(Continuation&&) noexcept = default;

ContinuedMesh Continuation::move(const Points& from, const ShapePoint& target,
                                 const ContinuationOptions& options)
{
    check(options);
    state_->check_mesh(from);
    const LengthDihedralEnergy energy(state_->topology, target, options.smoothness);
    return state_->descend(energy, state_->linear_start(from, target), from, options);
}

ContinuedMesh Continuation::adjust(const Points& from, const ShapePoint& target,
                                   const ContinuationOptions& options)
{
    check(options);
    state_->check_mesh(from);
    const LengthDihedralEnergy energy(state_->topology, target, options.smoothness);
    return state_->descend(energy, from, from, options);
}

} // namespace shape
