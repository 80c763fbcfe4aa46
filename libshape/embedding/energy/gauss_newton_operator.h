// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/linalg/lanes.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// The Gauss-Newton matrix J^T J of a LengthDihedralEnergy at a mesh, never formed, in single
/// precision: half of what the Hessian is where strains and bends are as wanted. Symmetric, positive
/// semidefinite. Vectors are in units of the mean wanted length.
///
/// Of a face with unit normal n, corners that move by v turn the normal about its edges by amounts
/// that depend on the three n . v alone: three numbers a face carry all bending.
///
/// Same bits for any number of threads.
class GaussNewtonOperator
{
public:
    explicit GaussNewtonOperator(const LengthDihedralEnergy& energy);

    /// Sets the mesh. A face without area bends nothing.
    /// @param points  Those of the last evaluate() of the energy, which keeps lengths and normals.
    /// @throws InvalidInput if there was none, or points has another size.
    /// Cost: O(#E).
    void linearise(const Eigen::VectorXd& points);

    /// product = J^T J v.
    /// @return v . product, not negative but for rounding.
    /// Cost: O(#E). Works in memory that is kept: not safe to call concurrently.
    double apply(const LaneVectors& v, LaneVectors& product);

    [[nodiscard]] double unit() const { return unit_; } ///< The mean wanted length [length].

private:
    const LengthDihedralEnergy& energy_;
    double unit_;
    LaneVectors normals_;    // of the faces, unit length
    LaneVectors directions_; // strain of an edge is directions_ . (v_b - v_a), weighted

    LaneVectors cotangents_; // of the faces' angles at their three corners
    LaneVectors stiffness_;  // of their edges: mu over the square of the length; 0 on the boundary
    LaneVectors bends_;      // of the faces at their edges, times the lengths
    LaneVectors lifts_;      // of the faces at their corners

    Eigen::VectorXf holds_; // of the vertices: hold_weights() of the energy, or empty

    std::vector<LengthDihedralEnergy::Collapse> collapses_;

    /// How a held sum changes as vertices move, terms of one sum, each of a corner of a hinge; or a gap that
    /// lacks something.
    struct SumSlopes
    {
        std::vector<int> vertices;
        std::vector<Eigen::Vector3f> slopes; // times the root of the stiffness
    };
    [[nodiscard]] SumSlopes slopes_of(const LengthDihedralEnergy::AngleSum& sum) const;
    std::vector<SumSlopes> sums_;
};

} // namespace shape::internal
