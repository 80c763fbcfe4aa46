// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral/dihedral_system.h"

#include <memory>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/face_patches.h"
#include "libshape/mesh/working_unit.h"

namespace shape::internal {
namespace {

using Eigen::VectorXd;

const std::vector<Points>& checked(const Topology& topology, const std::vector<Points>& references)
{
    if (references.empty())
        throw InvalidInput("the embedding needs at least one reference mesh");
    for (const Points& reference : references)
        if (!(edge_lengths(topology, reference).minCoeff() > 0.0))
            throw InvalidInput("a reference mesh has an edge of length 0");
    return references;
}

VectorXd mean_lengths(const Topology& topology, const std::vector<Points>& meshes)
{
    VectorXd sum = VectorXd::Zero(topology.edge_count());
    for (const Points& mesh : meshes)
        sum += edge_lengths(topology, mesh);
    return sum / static_cast<double>(meshes.size());
}

std::vector<Points> in_order(const Renumbering& renumbering, double unit,
                             const std::vector<Points>& meshes)
{
    std::vector<Points> ordered;
    ordered.reserve(meshes.size());
    for (const Points& mesh : meshes)
        ordered.emplace_back(unit * renumbered(renumbering, mesh));
    return ordered;
}

} // namespace

template <class... Factor>
DihedralSystem::DihedralSystem(int, const Topology& of, const std::vector<Points>& meshes,
                               Factor&&... factor)
    : renumbering(renumber_for_locality(of)),
      unit(working_unit(of, checked(of, meshes).front())),
      references(in_order(renumbering, unit, meshes)),
      laplacian(renumbering.topology, mean_lengths(renumbering.topology, references),
                std::forward<Factor>(factor)...),
      reference(renumbering.topology, references.front()),
      starts([this, patches = std::make_shared<FacePatches>(renumbering.topology, 64)] {
          return std::make_unique<LinearStart>(renumbering.topology, patches, reference, laplacian,
                                               laplacian.single_precision());
      })
{
}

DihedralSystem::DihedralSystem(const Topology& of, const std::vector<Points>& meshes)
    : DihedralSystem(0, of, meshes)
{
}

DihedralSystem::DihedralSystem(const Topology& of, const std::vector<Points>& meshes,
                               SinglePrecisionSolve factor)
    : DihedralSystem(0, of, meshes, std::move(factor))
{
}

ShapePoint DihedralSystem::target_of(const ShapePoint& point) const
{
    const int edges = topology().edge_count();
    if (point.edge_lengths.size() != edges || point.dihedral_angles.size() != edges)
        throw InvalidInput(join("target has ", point.edge_lengths.size(), " lengths and ",
                                point.dihedral_angles.size(), " dihedral angles, the topology ",
                                edges, " edges"));
    const auto pairs = static_cast<Eigen::Index>(reference.patches.pairs.size());
    if (point.patch_turns.size() > 0 &&
        (point.patch_turns.size() != 3 * pairs || !point.patch_turns.allFinite()))
        throw InvalidInput(join("target has ", point.patch_turns.size(),
                                " numbers of turns, must be 3 for each of ", pairs,
                                " pairs of patches, all finite"));
    Points positions;
    if (point.positions.size() > 0) {
        if (point.positions.rows() != topology().vertex_count() || !point.positions.allFinite())
            throw InvalidInput(join("target has ", point.positions.rows(),
                                    " positions, the topology ", topology().vertex_count(),
                                    " vertices; all must be finite"));
        positions = unit * renumbered(renumbering, point.positions);
    }
    return {positive_lengths(unit * renumbered(renumbering, point.edge_lengths)),
            renumbered(renumbering, point.dihedral_angles), point.patch_turns, positions};
}

Points DihedralSystem::result_of(const VectorXd& points) const
{
    Points result = restored(renumbering,
                             Eigen::Map<const Points>(points.data(), topology().vertex_count(), 3));
    result.rowwise() -= centroid(result);
    return result / unit;
}

} // namespace shape::internal
