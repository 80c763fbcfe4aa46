// SPDX-License-Identifier: MIT

#pragma once

#include <mutex>
#include <optional>
#include <vector>

#include "libshape/embedding/embedder.h"
#include "libshape/mesh/face_crossings.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Counts the pairs of faces that cross in a mesh, and those that cross in no reference.
class CrossingCount
{
public:
    /// Keeps references; the tree of faces is made when it is first needed.
    CrossingCount(const Topology& topology, const std::vector<Points>& references)
        : topology_(topology), references_(references)
    {
    }

    /// Sets self_intersections and new_self_intersections of its report. Safe to call concurrently.
    void add_to(Embedding& embedding);

private:
    const Topology& topology_;
    const std::vector<Points>& references_;
    std::once_flag made_;
    std::optional<FaceTree> faces_;
    std::vector<FacePair> known_; // of any reference, sorted
};

} // namespace shape::internal
