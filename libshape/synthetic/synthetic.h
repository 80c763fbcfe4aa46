// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "libshape/mesh/collection.h"

namespace shape {

/// An option of a synthetic dataset: its default and the values it may have.
struct SyntheticRange
{
    int standard = 0;
    int low = 0;
    int high = 0;
};

/// A collection that can be made from nothing but a seed.
struct SyntheticDataset
{
    std::string name;
    std::string description;
    std::string count_meaning; ///< What `count` counts.
    SyntheticRange count;
    SyntheticRange vertices; ///< Per mesh; what comes out is as near as the construction allows.
};

struct SyntheticOptions
{
    /// The dataset has this many of what SyntheticDataset::count_meaning says, in its range; 0: its
    /// default.
    int count = 0;
    /// Each mesh has about this many vertices, in the range of the dataset; 0: its default.
    int vertices = 0;
    /// All that is random in the dataset depends on this.
    std::uint64_t seed = 1;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const SyntheticOptions& options);

/// All datasets, sorted by name; datasets/README.md describes them.
[[nodiscard]] const std::vector<SyntheticDataset>& synthetic_datasets();

/// Makes a dataset: one connected oriented manifold, no degenerate triangle.
/// The first meshes do not depend on `count` where count is a number of random individuals.
/// @throws InvalidInput if there is no such dataset, or count or vertices are out of its range.
/// Determinism: the same name, count, vertices and seed give the same bits.
[[nodiscard]] Collection make_synthetic(std::string_view name,
                                        const SyntheticOptions& options = {});

} // namespace shape
