// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// How far the ladybug's walks around the interior vertices are from closing (Rojas 2014, eq. 1-3):
///
///     E = sum of E_v,    E_v = |R_v - I|^2,    R_v = Z_0 X_0 ... Z_k X_k,
///
/// where Z_i turns by a corner angle and X_i by minus a bending angle. A function of the dihedral
/// angles; topology and corner angles are fixed.
///
/// The derivative by a bending angle takes no product of matrices but those of the walk itself:
/// with a_i the direction of edge i on the walk (the x axis after Z_i) and s the axial vector of
/// (R_v - R_v^T) / 2,
///
///     dE_v / dd_i = -4 a_i . s,
///
/// which is eq. 8, since a turn X_i by dd_i turns all of R_v about a_i.
///
/// Vertices are walked in blocks of equal degree, side by side, which the compiler vectorises; the layout
/// stands in closure.cpp.
/// Same bits for any number of threads.
class ClosureEnergy
{
public:
    /// @param corner_angles  #F by 3 [rad].
    /// @throws InvalidInput if corner_angles has another size.
    ClosureEnergy(const Topology& topology, const Points& corner_angles);

    /// E and its gradient. Keeps scratch space: one call at a time.
    /// @param dihedral_angles  #E [rad]; boundary edges are ignored.
    /// @param gradient  #E [1/rad], overwritten; 0 at edges without an interior end.
    /// @throws InvalidInput if a size is wrong.
    /// Cost: O(#E).
    double evaluate(const Eigen::Ref<const Eigen::VectorXd>& dihedral_angles,
                    Eigen::Ref<Eigen::VectorXd> gradient);

    [[nodiscard]] Eigen::Index edge_count() const { return edge_slots_.rows(); }

private:
    static constexpr int lanes =
        2; // vertices walked side by side: as many as fit the registers of SSE2

    struct Block
    {
        std::size_t first; // row of its first step
        std::size_t steps; // degree; lanes of lower degree are filled up with turns by 0
    };
    using Row = Eigen::Array<double, lanes, 1>;
    using Rows = std::vector<Row>; // one row per step
    std::vector<Block> blocks_;
    Rows corner_cosine_, corner_sine_;
    std::vector<Eigen::Array<int, lanes, 1>> step_edge_; // #E where a lane is filled up
    Edges edge_slots_;                    // of the edge's steps at its ends; the last slot if none
    std::vector<double> cosine_, sine_;   // scratch, per edge and one more for turns by 0
    std::vector<double> slot_derivative_; // scratch, per slot (row * lanes + lane) and one more

    [[nodiscard]] double walk(const Block& block, Rows& scratch);
};

/// E alone, without a gradient: of lengths and dihedral angles as they are, laid out face by face
/// (face_layout.h). By E_v = 4 (1 - cos a), where R_v turns by a: the same as ClosureEnergy but for
/// rounding, and cheaper once, for no corner angle is computed.
/// @param lengths  #E [length], > 0; faces that they do not close are laid out flat.
/// @param dihedral_angles  #E [rad].
/// @throws InvalidInput if a size is wrong.
[[nodiscard]] double closure_energy(const Topology& topology, const Eigen::VectorXd& lengths,
                                    const Eigen::VectorXd& dihedral_angles);

} // namespace shape::internal
