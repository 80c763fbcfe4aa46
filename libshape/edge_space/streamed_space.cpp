// SPDX-License-Identifier: MIT

#include "libshape/edge_space/streamed_space.h"

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"

namespace shape::internal {

using Eigen::Index;

// The other functions stand beside those of collections, in shape_space.cpp, which the portable core has;
// streams it has not.
ShapeSpace make_space(const MeshStream& meshes, const SpaceOptions& options, Index block)
{
    check(options);
    if (meshes.size() == 0)
        throw InvalidInput("a space of shapes needs at least one mesh");
    if (options.kind == SpaceKind::Procrustes)
        throw InvalidInput("Procrustes space needs all meshes in memory");
    return make_edge_space(meshes.topology, to_size(meshes.size()), options,
                           [&](const auto& visit) {
                               for_each_block(meshes, 0, meshes.size(), block,
                                              [&](Index, const Collection& part) { visit(part); });
                           });
}

} // namespace shape::internal
