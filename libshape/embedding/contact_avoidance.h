// SPDX-License-Identifier: MIT

#pragma once

#include <mutex>
#include <optional>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/crossing_count.h"
#include "libshape/embedding/start/edge_laplacian.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// EmbeddingOptions::avoid_contact: moves faces apart that cross, though they do in no reference.
class ContactAvoidance
{
public:
    /// Keeps references. What it needs is made when faces first cross.
    /// @param smoothness  mu of length_dihedral_energy.h, > 0.
    ContactAvoidance(const Topology& topology, const std::vector<Points>& references,
                     CrossingCount& crossings, double smoothness)
        : topology_(topology),
          references_(references),
          crossings_(crossings),
          smoothness_(smoothness)
    {
    }

    struct Result
    {
        Points points;
        int pairs_before; ///< That cross in no reference.
    };

    /// The mesh moved apart (separate_contacts()), without more inverted faces than it had; as it was where
    /// more than half of the pairs would stay.
    /// @param target  What it was made from.
    /// Safe to call concurrently.
    [[nodiscard]] Result apart(const Points& points, const ShapePoint& target);

private:
    const Topology& topology_;
    const std::vector<Points>& references_;
    CrossingCount& crossings_;
    double smoothness_;
    std::once_flag made_;
    std::optional<EdgeLaplacian> laplacian_;
};

} // namespace shape::internal
