// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/topology.h"

namespace CLI {
class App;
}

namespace shape::tools {

struct TaggedPartArguments
{
    std::string vertices; ///< Files: indices or, with a label, values in a PLY file.
    std::string faces;
    std::string label;           ///< NAME or NAME=VALUE.
    std::int64_t border = 1;     ///< Rings over which the part fades out.
    std::vector<double> factors; ///< One a mesh.
};

/// Adds --scale-vertices, --scale-faces, --scale-label, --scale-border and --scale-factors.
void add_tagged_part_options(CLI::App& command, TaggedPartArguments& arguments);

/// A part of the mesh whose wanted lengths are multiplied (tagged_scaling.h).
struct TaggedPart
{
    Eigen::VectorXd shares;  ///< #E as tagged_shares() gives them; empty: there is no such part.
    Eigen::VectorXd factors; ///< One a mesh.

    /// The point with that part scaled by the blend of the factors.
    [[nodiscard]] ShapePoint scale(ShapePoint point, const Eigen::VectorXd& weights) const;
};

/// @throws UsageError for options that do not go together.
/// @throws FileError, InvalidInput if a file, its tags or the factors break a rule.
[[nodiscard]] TaggedPart read_tagged_part(const TaggedPartArguments& arguments,
                                          const Topology& topology, std::size_t meshes);

} // namespace shape::tools
