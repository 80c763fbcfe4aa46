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

    struct Count
    {
        int all;
        int in_no_reference;
    };
    [[nodiscard]] Count count(const Points& points);

    /// Sets self_intersections and new_self_intersections of its report.
    void add_to(Embedding& embedding);

    [[nodiscard]] const FaceTree& faces();
    /// Pairs that cross in any reference, sorted.
    [[nodiscard]] const std::vector<FacePair>& known();

    // All of these are safe to call concurrently.

private:
    void make();

    const Topology& topology_;
    const std::vector<Points>& references_;
    std::once_flag made_;
    std::optional<FaceTree> faces_;
    std::vector<FacePair> known_;
};

} // namespace shape::internal
