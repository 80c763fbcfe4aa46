// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/base/to_size.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// A triangulation with a length on every edge whose edges can be flipped: the decorated surface
/// of discrete conformal equivalence. Lengths are Penner coordinates. They need not keep any
/// triangle inequality: a flip follows Ptolemy's rule, which commutes with conformal scaling.
///
/// Starts as a mesh with the same numbers of half-edges, edges and faces (see Topology); a flip
/// keeps the number of its edge. Flips may lead to several edges between two vertices and to loops.
class IntrinsicTriangulation
{
public:
    /// @param lengths  #E [length], > 0, finite.
    /// @throws InvalidInput naming the first entry that breaks a rule.
    IntrinsicTriangulation(const Topology& topology, const Eigen::VectorXd& lengths);

    [[nodiscard]] int vertex_count() const { return vertex_count_; }
    [[nodiscard]] int edge_count() const { return static_cast<int>(halfedge_.size()); }
    [[nodiscard]] int face_count() const { return static_cast<int>(faces_.rows()); }

    [[nodiscard]] int source(int halfedge) const { return faces_(halfedge / 3, halfedge % 3); }
    [[nodiscard]] int target(int halfedge) const { return source(Topology::next(halfedge)); }
    [[nodiscard]] int edge(int halfedge) const { return edges_(halfedge / 3, halfedge % 3); }
    [[nodiscard]] int opposite(int halfedge) const ///< -1 on the boundary.
    {
        return opposite_[to_size(halfedge)];
    }
    /// One half-edge of an edge.
    [[nodiscard]] int halfedge(int edge) const { return halfedge_[to_size(edge)]; }

    /// Half-edges that leave a vertex, counter-clockwise; at a boundary vertex the first runs along
    /// the boundary. `start` leaves the vertex. Cost: the degree.
    [[nodiscard]] std::vector<int> ring(int start) const;

    /// Some half-edge that leaves each vertex, #V. Cost: O(#F).
    [[nodiscard]] std::vector<int> first_halfedges() const;

    /// Natural logarithms of the lengths, #E [log length].
    [[nodiscard]] const Eigen::VectorXd& log_lengths() const { return log_lengths_; }

    /// log length after scaling by the factors u: log a_ij + (u_i + u_j) / 2 (Rojas 2014, eq. 13).
    [[nodiscard]] double scaled_log_length(int edge, const Eigen::VectorXd& u) const
    {
        const int h = halfedge(edge);
        return log_lengths_[edge] + 0.5 * (u[source(h)] + u[target(h)]);
    }

    /// Whether the edge has two distinct faces.
    [[nodiscard]] bool is_flippable(int edge) const;

    /// Log length that the edge would have after a flip, by Ptolemy's rule; is_flippable(edge).
    [[nodiscard]] double flipped_log_length(int edge) const;

    /// Turns the edge into the other diagonal of its quadrilateral; is_flippable(edge).
    void flip(int edge);

private:
    void set_halfedge(int halfedge, int source, int edge, int opposite);

    int vertex_count_ = 0;
    Faces faces_;
    Faces edges_;
    std::vector<int> opposite_; // per half-edge
    std::vector<int> halfedge_; // per edge
    Eigen::VectorXd log_lengths_;
};

} // namespace shape::internal
