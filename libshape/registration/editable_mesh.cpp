// SPDX-License-Identifier: MIT

#include "libshape/registration/editable_mesh.h"

namespace shape::internal {

EditableMesh editable_mesh(const Topology& topology, const Points& points)
{
    EditableMesh mesh;
    mesh.request_vertex_status();
    mesh.request_edge_status();
    mesh.request_halfedge_status();
    mesh.request_face_status();
    mesh.request_face_normals();
    for (const auto& p : points.rowwise())
        mesh.add_vertex({p[0], p[1], p[2]});
    for (const auto& face : topology.faces().rowwise())
        mesh.add_face(EditableMesh::VertexHandle(face[0]), EditableMesh::VertexHandle(face[1]),
                      EditableMesh::VertexHandle(face[2]));
    return mesh;
}

} // namespace shape::internal
