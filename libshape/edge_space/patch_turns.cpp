// SPDX-License-Identifier: MIT

#include "libshape/edge_space/patch_turns.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/triangle_area.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Smaller patches follow creases better; but in a fist neighbours of 16 faces turn by up to 180 degrees
/// against each other, where a rotation vector is not unique (16, 32 and 64 are compared in
/// docs/experiments/embedding.md).
constexpr int faces_per_patch = 32;

VectorXd face_areas(const Topology& topology, const Points& points)
{
    VectorXd areas(topology.face_count());
    for (int f = 0; f < topology.face_count(); ++f) {
        const auto corner = [&](int c) -> Vector3d { return points.row(topology.faces()(f, c)); };
        areas[f] = triangle_area(corner(0), corner(1), corner(2));
    }
    return areas;
}

} // namespace

ReferencePatches::ReferencePatches(const Topology& topology, const Points& reference)
    : patches(topology, faces_per_patch),
      frames(face_frames(topology, reference)),
      areas(face_areas(topology, reference))
{
}

Quaterniond ReferencePatches::rotation(int patch, const Rotations& others) const
{
    Matrix3d sum = Matrix3d::Zero();
    for (int i = patches.begin(patch); i < patches.begin(patch + 1); ++i) {
        const int face = patches.faces[to_size(i)];
        const auto f = to_size(face);
        sum += areas[face] * (others[f] * frames[f].conjugate()).toRotationMatrix();
    }
    return Quaterniond(nearest_rotation(sum));
}

VectorXd ReferencePatches::turns(const Topology& topology, const Points& mesh) const
{
    const Rotations others = face_frames(topology, mesh);
    Rotations rotations(to_size(patches.count()));
    parallel_for(rotations.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p)
            rotations[p] = rotation(static_cast<int>(p), others);
    });
    VectorXd turns(3 * static_cast<Index>(patches.pairs.size()));
    for (Index k = 0; k < turns.size() / 3; ++k) {
        const FacePatches::Pair& pair = patches.pairs[to_size(k)];
        turns.segment<3>(3 * k) = rotation_vector(rotations[to_size(pair.lower)].conjugate() *
                                                  rotations[to_size(pair.higher)]);
    }
    return turns;
}

PatchTurns::PatchTurns(const Topology& topology, const Points& reference)
    : renumbering_(renumber_for_locality(topology)),
      reference_(renumbering_.topology, renumbered(renumbering_, reference))
{
}

Index PatchTurns::size() const
{
    return 3 * static_cast<Index>(reference_.patches.pairs.size());
}

VectorXd PatchTurns::of(const Points& mesh) const
{
    const Topology& topology = renumbering_.topology;
    if (mesh.rows() != topology.vertex_count())
        throw InvalidInput(join("turns: the mesh has ", mesh.rows(), " vertices, the reference ",
                                topology.vertex_count()));
    return reference_.turns(topology, renumbered(renumbering_, mesh));
}

RowMatrix PatchTurns::of(const std::vector<Points>& meshes) const
{
    RowMatrix turns(static_cast<Index>(meshes.size()), size());
    parallel_for(meshes.size(), 1, [&](std::size_t mesh, std::size_t) {
        turns.row(static_cast<Index>(mesh)) = of(meshes[mesh]).transpose();
    });
    return turns;
}

} // namespace shape::internal
