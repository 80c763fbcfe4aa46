// SPDX-License-Identifier: MIT

#include "libshape/registration/coarse_mesh.h"

#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModAspectRatioT.hh>
#include <OpenMesh/Tools/Decimater/ModEdgeLengthT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <cstdint>

#include "libshape/base/to_size.h"
#include "libshape/registration/editable_mesh.h"

namespace shape::internal {

CoarseMesh coarsened(const Topology& topology, const Points& points, int vertex_count)
{
    EditableMesh mesh = editable_mesh(topology, points);
    mesh.update_face_normals();

    OpenMesh::Decimater::DecimaterT<EditableMesh> decimater(mesh);
    OpenMesh::Decimater::ModEdgeLengthT<EditableMesh>::Handle by_length;
    OpenMesh::Decimater::ModNormalFlippingT<EditableMesh>::Handle no_flips;
    OpenMesh::Decimater::ModAspectRatioT<EditableMesh>::Handle no_slivers;
    decimater.add(by_length);
    decimater.add(no_flips);
    decimater.add(no_slivers);
    decimater.module(by_length).set_edge_length(std::numeric_limits<float>::max());
    decimater.module(by_length).set_binary(false);
    // Folds must not appear, nor faces whose angles say nothing; both bounds leave enough to collapse.
    decimater.module(no_flips).set_max_normal_deviation(45.0F);
    decimater.module(no_slivers).set_aspect_ratio(5.0F);
    decimater.module(no_slivers).set_binary(true);
    decimater.initialize();
    decimater.decimate_to(to_size(vertex_count));

    std::vector<int> vertices;
    std::vector<int> numbers(to_size(topology.vertex_count()), -1);
    for (const auto v : mesh.vertices())
        if (!mesh.status(v).deleted() && !mesh.is_isolated(v)) {
            numbers[to_size(v.idx())] = static_cast<int>(vertices.size());
            vertices.push_back(v.idx());
        }
    std::vector<std::array<int, 3>> corners;
    for (const auto f : mesh.faces()) {
        if (mesh.status(f).deleted())
            continue;
        std::array<int, 3> face{};
        int k = 0;
        for (const auto v : mesh.fv_range(f))
            face[to_size(k++)] = numbers[to_size(v.idx())];
        corners.push_back(face);
    }
    Faces faces(static_cast<Eigen::Index>(corners.size()), 3);
    for (std::size_t f = 0; f < corners.size(); ++f)
        for (int k = 0; k < 3; ++k)
            faces(static_cast<Eigen::Index>(f), k) = corners[f][to_size(k)];
    Points kept(static_cast<Eigen::Index>(vertices.size()), 3);
    for (std::size_t v = 0; v < vertices.size(); ++v)
        kept.row(static_cast<Eigen::Index>(v)) = points.row(vertices[v]);
    return {Topology(faces, static_cast<int>(vertices.size())), std::move(vertices),
            std::move(kept)};
}

} // namespace shape::internal
