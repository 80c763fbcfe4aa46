// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/linalg/dense.h"
#include "libshape/mesh/collection.h"

namespace shape {

/// A point of the space together with its companions: what an embedding starts from.
struct ShapePoint
{
    Eigen::VectorXd edge_lengths;    ///< #E [length].
    Eigen::VectorXd dihedral_angles; ///< #E [rad], 0 on the boundary; may leave (-pi, pi].
    Eigen::VectorXd patch_turns =
        {}; ///< [rad] of patches of faces against each other since a reference; or empty.
    Points positions =
        {}; ///< #V by 3 [length]: where vertices are in the large, in any pose; or empty.
};

/// What is done about size.
enum class Scale
{
    Unit, ///< Lengths are divided by their sum (Rojas 2014, eq. 12).
    None, ///< Lengths stay as they are.
};

/// N meshes as points of edge-length space. Row i belongs to mesh i, column e to edge e.
struct ShapeVectors
{
    RowMatrix edge_lengths;     ///< N by #E; unit sum, or [length] for Scale::None.
    RowMatrix dihedral_angles;  ///< N by #E [rad], on one branch per edge (unify_branches).
    Eigen::VectorXd sizes;      ///< N sums of edge lengths [length].
    RowMatrix patch_turns = {}; ///< N rows [rad], as in ShapePoint, since the first mesh.
};

/// Encodes the meshes of a collection.
/// Cost: O(N #E).
[[nodiscard]] ShapeVectors shape_vectors(const Collection& collection, Scale scale);

/// Their dihedral angles alone, N by #E [rad], as shape_vectors() gives them.
[[nodiscard]] RowMatrix companion_angles(const Collection& collection);

/// Puts the angles of every column on one branch, so that combining rows makes sense.
///
/// An angle is measured in (-pi, pi], which cuts the circle at the fold. Rule, per edge: if the
/// circular mean of the column lies within pi/3 of the fold, every angle within pi/3 of the fold
/// moves by a multiple of 2 pi to within pi of that mean; all other angles, and all columns whose
/// mean is elsewhere, stay as measured. Thus 170 and -170 degrees blend to 180, while 100 and -100
/// blend through flat: a surface bends through flat, it does not pass through itself.
/// A column without a mean (its unit vectors cancel) stays as measured.
/// @param angles  N by #E [rad] in (-pi, pi].
[[nodiscard]] RowMatrix unify_branches(RowMatrix angles);

/// The parts of that rule: first, the mean angle in (-pi, pi] [rad] of `count` unit vectors from the sums
/// of their cosines and sines, 0 if they cancel.
[[nodiscard]] double circular_mean(double cosines, double sines, double count);
[[nodiscard]] double on_branch(double angle, double mean); ///< On the branch around `mean`.

/// How lengths are combined.
enum class LengthBlend
{
    Plain,   ///< sum_i w_i l_i.
    Squared, ///< sqrt(sum_i w_i l_i^2) (Rojas 2014, section 6); negative sums become 0.
};

/// The combination of the rows with these weights; dihedral angles and turns are combined plainly.
/// @param weights  N, finite; their sum is within 1e-9 of 1.
/// @throws InvalidInput if a rule is broken.
[[nodiscard]] ShapePoint blend(const ShapeVectors& vectors, const Eigen::VectorXd& weights,
                               LengthBlend lengths = LengthBlend::Plain);

} // namespace shape
