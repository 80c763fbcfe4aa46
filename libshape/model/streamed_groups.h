// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <optional>

#include "libshape/base/progress.h"
#include "libshape/mesh/mesh_stream.h"
#include "libshape/model/group_means.h"
#include "libshape/statistics/group_comparison.h"
#include "libshape/statistics/group_spread.h"

namespace shape {

/// What is asked of groups of meshes that come by in passes.
struct StreamedGroupsOptions
{
    /// In which space meshes are compared.
    SpaceOptions space = {};
    /// How many permutations the tests draw, and how.
    PermutationOptions permutations = {};
    /// How many replicates the intervals of the spread draw, and how.
    BootstrapOptions bootstrap = {};
    /// Of the tests, and what means and spread are adjusted for.
    CovariatesOfSizes covariates = {};
    /// Whether the sums come from all inner products, or from passes; not given: what costs less.
    std::optional<bool> by_inner_products = {};
    bool with_companions = false; ///< Whether the dihedral angles of the means are wanted.
    /// At most this much memory is used [byte]; 0: a quarter of the machine's.
    std::uint64_t memory = 0;
    Progress progress = {}; ///< Called with kilobytes read, of the pass that its stage names.
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const StreamedGroupsOptions& options);

struct StreamedGroups
{
    GroupedShapes shapes; ///< `products` stay empty.
    GroupComparison comparison;
    GroupSpread spread;
    LinearModelTest spread_test;
    Points reference_points; ///< The first mesh.
    int passes = 0;
    bool by_inner_products = false; ///< How the sums were found: by all of them, or by passes.
};

/// compare_groups(), group_spread(), test_spread() and group_shapes() of the meshes of a collection that need not
/// fit into memory, each as exact as in memory: permutations and replicates are the same, and what they need of
/// the meshes are weighted sums. Those come from the N by N inner products where these are few, else from
/// passes that take as many sums as the memory holds.
///
/// @throws as those, and as group_shapes(); LimitExceeded if the memory does not hold the means; what
///     reading throws. Procrustes space is refused.
/// Cost: N^2 E multiplications, or 2 N E for each of about permutations (G - 1) + replicates sums, and
///     for G > 2 groups as many again for the pairs. One pass more with covariates or blocks of several meshes.
[[nodiscard]] StreamedGroups compare_groups(const MeshStream& meshes, const Grouping& groups,
                                            const Grouping& blocks,
                                            const StreamedGroupsOptions& options);

} // namespace shape
