// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/linalg/lanes.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// The Gauss-Newton matrix J^T J of a LengthDihedralEnergy at a mesh, never formed, in single
/// precision: half of what the Hessian is where strains and bends are as wanted. Symmetric, positive
/// semidefinite. Vectors are in units of the mean wanted length.
///
/// Of a face with unit normal n, corners that move by v turn the normal about its edges by a 3 by 3
/// matrix times the n . v: three numbers a face carry all bending.
///
/// Same bits for any number of threads.
class GaussNewtonOperator
{
public:
    explicit GaussNewtonOperator(const LengthDihedralEnergy& energy);

    /// Sets the mesh. A face without area bends nothing.
    /// @param points  #V by 3, row by row in one vector [length].
    /// Cost: O(#E).
    void linearise(const Eigen::VectorXd& points);

    /// product = J^T J v.
    /// Cost: O(#E). Works in memory that is kept: not safe to call concurrently.
    void apply(const LaneVectors& v, LaneVectors& product);

    [[nodiscard]] double unit() const { return unit_; } ///< The mean wanted length [length].

private:
    const LengthDihedralEnergy& energy_;
    double unit_;
    LaneVectors normals_;    // of the faces, unit length
    LaneVectors directions_; // strain of an edge is directions_ . (v_b - v_a), weighted

    /// Of every face, column j: how it bends at its three edges as corner j rises by one unit, times
    /// the root of mu.
    std::vector<std::array<Eigen::Vector4f, 3>> hinges_;

    LaneVectors bends_;       // of every face at its three edges; then moments of its corners
    Eigen::VectorXf moments_; // of the edges
    Eigen::VectorXf tensions_;
};

} // namespace shape
