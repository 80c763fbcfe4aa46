// SPDX-License-Identifier: MIT

#pragma once

#include <array>
#include <vector>

#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/embedding/energy/region_mesh.h"
#include "libshape/linalg/eight_lanes.h"
#include "libshape/mesh/hinge.h"

namespace shape::internal {

/// A LengthDihedralEnergy for eight positions of a region at once, in single precision: the terms
/// that its moving vertices take part in, their gradient, and the Gauss-Newton matrix J^T J, never
/// formed (formulas as in gauss_newton_operator.h). Lengths are in units of unit().
class EightLaneEnergy
{
public:
    /// Keeps a reference to region.
    EightLaneEnergy(const LengthDihedralEnergy& energy, const RegionMesh& region);

    /// Sets eight positions, and gives their energies.
    /// @param points  All vertices of the region.
    std::array<float, EightLanes::lanes> linearise(const EightLanePoints& points);

    /// What every edge of the region adds to them.
    [[nodiscard]] const std::vector<EightLanes>& edge_energies() const { return energies_; }

    /// J^T r, half of the gradient; one per moving vertex.
    void gradient(EightLanePoints& forces);

    /// product = J^T J v.
    /// @param v  All vertices of the region; 0 for those that do not move.
    /// @param product  One per moving vertex.
    void apply(const EightLanePoints& v, EightLanePoints& product);

    [[nodiscard]] double unit() const { return unit_; } ///< Mean wanted length [length].

private:
    void transpose(const std::vector<EightLanes>& tensions, const std::vector<EightLanes>& moments,
                   EightLanePoints& forces);

    const RegionMesh& region_;
    double unit_;
    std::vector<float> inverse_lengths_; // of the target
    std::vector<float> sines_, cosines_; // of its dihedral angles
    std::vector<float> bend_weights_;    // mu of edges

    EightLanePoints normals_;                     // of faces, unit length
    std::vector<HingeSlopes<EightLanes>> hinges_; // three a moving face, see face_terms()
    EightLanePoints directions_;       // strain of an edge is directions . (v_b - v_a), weighted
    std::vector<EightLanes> strains_;  // residuals of edges, times the roots of their weights
    std::vector<EightLanes> bends_;    // theta - theta*, times mu
    std::vector<EightLanes> energies_; // of edges
    std::vector<EightLanes> tensions_, moments_; // J v
    std::vector<EightLanes> halfedge_terms_;     // what apply() works in: bends, then lifts
};

} // namespace shape::internal
