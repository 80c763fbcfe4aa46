// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "libshape/base/bytes.h"
#include "libshape/edge_space/shape_space.h"
#include "libshape/linalg/dense.h"
#include "libshape/linalg/single_precision_solve.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"
#include "libshape/model/shape_model.h"

namespace shape::internal {

/// Something that is added to a decoded point of edge space, such as a difference vector: so much per
/// unit of its amount.
struct AddedDirections
{
    RowMatrix edge_lengths;    ///< M by #E [length].
    RowMatrix dihedral_angles; ///< M by #E [rad].
};

/// A model as it travels to where its points are decoded: what a decoder needs and no more, and the
/// factor of the Laplacian, so that nothing is factorised there. Modes stay in double precision: a descent
/// that is cut off before it converges ends elsewhere, by a hundredth in its worst edge, if its target differs in
/// the digits of a float.
struct ModelBlock
{
    Topology topology;
    Points reference_points; ///< #V by 3 [length].
    ShapeSpace space;        ///< As decode() needs it.
    Eigen::VectorXd mean;
    Eigen::VectorXd mean_dihedral_angles;
    RowMatrix modes;                          ///< K by D.
    RowMatrix mode_dihedral_angles;           ///< K by #E, or K by 0.
    AddedDirections directions;               ///< None in Procrustes space.
    double smoothness = 5e-3;                 ///< Angles weigh this much (dihedral_embedding.h).
    std::vector<SinglePrecisionSolve> factor; ///< One; none in Procrustes space.
};

/// @param modes  How many of the model's, from the first on; at most K.
/// @throws InvalidInput if there are directions in Procrustes space, or of another size.
/// Cost: that of a DihedralEmbedder.
[[nodiscard]] ModelBlock make_block(const ShapeModel& model, int modes,
                                    AddedDirections directions = {}, double smoothness = 5e-3);

/// The layout is told in docs/formats.md.
[[nodiscard]] std::vector<unsigned char> write_block(const ModelBlock& block);

/// @throws InvalidInput if the bytes are none of write_block().
[[nodiscard]] ModelBlock read_block(std::span<const unsigned char> bytes);

} // namespace shape::internal
