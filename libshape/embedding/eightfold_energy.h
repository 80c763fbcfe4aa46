// SPDX-License-Identifier: MIT

#pragma once

#include <array>
#include <vector>

#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/embedding/region_mesh.h"
#include "libshape/linalg/eightfold.h"

namespace shape {

/// A LengthDihedralEnergy for eight positions of a region at once, in single precision: the terms
/// that its moving vertices take part in, their gradient, and the Gauss-Newton matrix J^T J, never
/// formed (formulas as in gauss_newton_operator.h). Lengths are in units of unit().
class EightfoldEnergy
{
public:
    /// Keeps a reference to region.
    EightfoldEnergy(const LengthDihedralEnergy& energy, const RegionMesh& region);

    /// Sets eight positions, and gives their energies.
    /// @param points  All vertices of the region.
    std::array<float, Eightfold::lanes> linearise(const EightfoldPoints& points);

    /// What every edge of the region adds to them.
    [[nodiscard]] const std::vector<Eightfold>& edge_energies() const { return energies_; }

    /// J^T r, half of the gradient; one per moving vertex.
    void gradient(EightfoldPoints& forces);

    /// product = J^T J v.
    /// @param v  All vertices of the region; 0 for those that do not move.
    /// @param product  One per moving vertex.
    void apply(const EightfoldPoints& v, EightfoldPoints& product);

    [[nodiscard]] double unit() const { return unit_; } ///< Mean wanted length [length].

private:
    void transpose(const std::vector<Eightfold>& tensions, const std::vector<Eightfold>& moments,
                   EightfoldPoints& forces);

    const RegionMesh& region_;
    double unit_;
    std::vector<float> inverse_lengths_; // of the target
    std::vector<float> sines_, cosines_; // of its dihedral angles
    std::vector<float> bend_weights_;    // mu of edges

    EightfoldPoints normals_;         // of faces, unit length
    std::vector<Eightfold> hinges_;   // six a moving face, see face_terms()
    EightfoldPoints directions_;      // strain of an edge is directions . (v_b - v_a), weighted
    std::vector<Eightfold> strains_;  // residuals of edges, times the roots of their weights
    std::vector<Eightfold> bends_;    // theta - theta*, times mu
    std::vector<Eightfold> energies_; // of edges
    std::vector<Eightfold> tensions_, moments_; // J v
    std::vector<Eightfold> halfedge_terms_;     // what apply() works in: bends, then lifts
};

} // namespace shape
