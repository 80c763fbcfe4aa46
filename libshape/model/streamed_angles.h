// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "libshape/linalg/block_products.h"
#include "libshape/mesh/collection.h"
#include "libshape/statistics/pass_state_reader.h"

namespace shape::internal {

/// Dihedral angles of the meshes of a block, a row each [rad].
/// @param angles  #meshes by #E, filled.
void measure_angles(const Collection& block, Block angles);

/// Finds, from meshes that come by once, the branch that each edge's angles lie on (unify_branches()).
class BranchSums
{
public:
    explicit BranchSums(Eigen::Index edges);

    /// Takes the next meshes. Cost: cosine and sine are measured without the angle.
    void add(const Collection& block);

    /// Around which angles near the fold are measured [rad]; 0, where on_branch() changes nothing, of
    /// edges whose angles keep away from it.
    /// @param count  Of all meshes.
    [[nodiscard]] Eigen::VectorXd means(Eigen::Index count) const;

    /// What add() sums, and what it finds of which all is the largest; 0 before it.
    [[nodiscard]] std::vector<std::span<double>> sums();
    [[nodiscard]] std::span<double> largest();

    void save(PassState& state) const;
    void restore(PassStateReader& state);

private:
    Eigen::VectorXd sharp_; ///< 1 where an angle came near the fold, else 0.
    Eigen::VectorXd cosines_;
    Eigen::VectorXd sines_;
};

/// Brings the angles of all rows onto the branches around these means.
void unify_branches(Block angles, const Eigen::VectorXd& means);

} // namespace shape::internal
