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
    int count = 0;          ///< See SyntheticDataset::count_meaning; 0: the default of the dataset.
    int vertices = 0;       ///< Wanted #V of each mesh; 0: the default of the dataset.
    std::uint64_t seed = 1; ///< Of all that is random in the dataset.
};

/// All datasets, sorted by name; datasets/README.md describes them.
[[nodiscard]] const std::vector<SyntheticDataset>& synthetic_datasets();

/// Makes a dataset: one connected oriented manifold, no degenerate triangle.
/// The first meshes do not depend on `count` where count is a number of random individuals.
/// @throws InvalidInput if there is no such dataset, or count or vertices are out of its range.
/// Determinism: the same name, count, vertices and seed give the same bits.
[[nodiscard]] Collection make_synthetic(std::string_view name,
                                        const SyntheticOptions& options = {});

} // namespace shape
