// SPDX-License-Identifier: MIT

#pragma once

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// A mesh whose edges OpenMesh splits, collapses and flips.
using EditableMesh = OpenMesh::TriMesh_ArrayKernelT<OpenMesh::DefaultTraitsDouble>;

/// The mesh with room for what editing needs: the status of all elements and normals of faces, which are
/// not computed yet. Vertices and faces keep their numbers.
[[nodiscard]] EditableMesh editable_mesh(const Topology& topology, const Points& points);

} // namespace shape::internal
