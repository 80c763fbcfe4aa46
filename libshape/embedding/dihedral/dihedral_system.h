// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/base/pool.h"
#include "libshape/edge_space/patch_turns.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/start/edge_laplacian.h"
#include "libshape/embedding/start/linear_start.h"
#include "libshape/linalg/single_precision_solve.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/renumbering.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// What embeddings by lengths and dihedral angles keep of a topology and its references, all in an
/// order of vertices of its own.
struct DihedralSystem
{
    Renumbering renumbering;
    /// working_unit() of the first reference; a mesh in here is this times the mesh as it is.
    double unit;
    std::vector<Points> references; ///< Times `unit`.
    EdgeLaplacian laplacian;        ///< Of the references' mean lengths.
    ReferencePatches reference;     ///< Of turns.
    Pool<LinearStart> starts;

    /// @throws InvalidInput if there is no reference, or one has another size or edges of length 0.
    DihedralSystem(const Topology& of, const std::vector<Points>& meshes);

    /// With the factor of the Laplacian of another one of the same arguments.
    /// @throws InvalidInput as well if it is of another size.
    DihedralSystem(const Topology& of, const std::vector<Points>& meshes,
                   SinglePrecisionSolve factor);

    [[nodiscard]] const Topology& topology() const { return renumbering.topology; }

    /// A target in this order and unit, fit for the energy: lengths as in positive_lengths().
    /// @throws InvalidInput if it has other sizes, or turns or positions that are not finite.
    [[nodiscard]] ShapePoint target_of(const ShapePoint& point) const;

    /// A mesh, row by row in this order and unit, in its own, about its centroid.
    [[nodiscard]] Points result_of(const Eigen::VectorXd& points) const;

private:
    template <class... Factor>
    DihedralSystem(int, const Topology& of, const std::vector<Points>& meshes, Factor&&... factor);
};

} // namespace shape::internal
