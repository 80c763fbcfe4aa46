// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "libshape/base/bytes.h"
#include "libshape/edge_space/shape_space.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"
#include "libshape/linalg/dense.h"
#include "libshape/linalg/single_precision_solve.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Something that is added to a decoded point of edge space, such as a difference vector: so much per
/// unit of its amount.
struct AddedDirections
{
    RowMatrix edge_lengths;    ///< M by #E [length].
    RowMatrix dihedral_angles; ///< M by #E [rad].
};

/// Row-major in single precision: a row is a mesh, x y z of one vertex after the other.
using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Where vertices are to first order, from which drafts start: no digits are asked of it.
struct LinearVertices
{
    Points mean;          ///< #V by 3 [length]: the mean at the mean size.
    FloatRows modes;      ///< Change per unit of the score, of the first min(K, most_linear_modes).
    FloatRows directions; ///< M by 3 #V; the same per unit of the amount.
    double size = 1.0;    ///< The mean size; 1 where sizes are not free.
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
    double smoothness = usual_smoothness;     ///< Angles weigh this much (dihedral_embedding.h).
    std::vector<SinglePrecisionSolve> factor; ///< One; none in Procrustes space, as the next.
    LinearVertices linear;
};

/// The layout is told in docs/formats.md.
[[nodiscard]] std::vector<unsigned char> write_block(const ModelBlock& block);

/// @throws InvalidInput if the bytes are not those of write_block().
[[nodiscard]] ModelBlock read_block(std::span<const unsigned char> bytes);

} // namespace shape::internal
