// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <variant>

#include "libshape/edge_space/length_coordinates.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/linalg/dense.h"
#include "libshape/mesh/collection.h"

namespace shape {

/// Edge lengths as coordinates: c_e = a_e f(l_e); behind them, if dihedral angles are coordinates too,
/// d_e = b_e theta_e; behind these, if vertex positions are, p_v x_v, x y z of one vertex after the other,
/// of the mesh aligned with a mean. Pose-invariant.
struct EdgeSpace
{
    Scale scale = Scale::Unit;                                ///< Unit: l is divided by its sum.
    LengthCoordinates coordinates = LengthCoordinates::Plain; ///< f.
    Eigen::VectorXd length_factors = {};                      ///< a: #E, > 0; empty: all 1.
    Eigen::VectorXd dihedral_factors = {}; ///< b: #E, > 0; empty: angles are not coordinates.
    Eigen::VectorXd branch_angles = {}; ///< #E [rad], as dihedral_factors: angles near the fold are
                                        ///< measured on the branch around it (unify_branches).
    Eigen::VectorXd position_factors = {}; ///< p: #V, > 0; empty: positions are not coordinates.
    Points mean_positions =
        {}; ///< #V by 3, as position_factors, centroid at 0: what meshes, of unit sum
            ///< of lengths or as they are, are aligned with.
};

/// Vertex positions as coordinates, x y z of one vertex after the other, aligned with a mean.
struct ProcrustesSpace
{
    Scale scale = Scale::Unit; ///< Unit: centroid size 1.
    Points mean = {};          ///< #V by 3, centroid at 0: what meshes are aligned with.
    int iterations = 0;        ///< The alignment that found the mean took these; not kept in files.
    bool converged = true;     ///< So did it; not kept in files.
};

/// A Euclidean space of shapes: how a mesh becomes a vector of D coordinates, and back.
using ShapeSpace = std::variant<EdgeSpace, ProcrustesSpace>;

enum class SpaceKind
{
    Edge,       ///< EdgeSpace.
    Procrustes, ///< ProcrustesSpace.
};

/// How edges are weighted against each other.
enum class EdgeWeighting
{
    Uniform, ///< Every edge counts as it is.
    Area,    ///< By its share of the surface: see make_space().
};

/// What follows scale belongs to edge space and may be set there alone.
struct SpaceOptions
{
    /// Shapes are points of this space.
    SpaceKind kind = SpaceKind::Edge;
    /// Unit: every mesh is brought to one size first. None: size is a part of shape.
    Scale scale = Scale::Unit;
    /// Lengths are taken as they are, or by another function of them.
    LengthCoordinates coordinates = LengthCoordinates::Plain;
    /// Edges count alike, or by the area around them.
    EdgeWeighting weighting = EdgeWeighting::Uniform;
    /// Where > 0, dihedral angles are coordinates too: 1 rad counts as much as a relative change of
    /// length by this; in [0, 1e6].
    double dihedral_weight = 0.0;
    /// Where > 0, vertex positions are coordinates too, and say where meshes are in the large: a
    /// displacement of all vertices by the diagonal counts as much as a relative change of all lengths by
    /// this; in [0, 1e6].
    double position_weight = 0.0;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const SpaceOptions& options);

/// The space of a collection.
///
/// To first order around the mean lengths m (arithmetic, after scaling) its squared distance is
///
///     sum_e g_e^2 ( (dl_e / m_e)^2 + W^2 dtheta_e^2 + P^2 sum_v s_v |dx_v|^2 / D^2 ),
///
/// with g_e = m_e f'(m_e) for uniform weights, and g_e^2 = A_e / A for area weights, whatever f: A_e is a
/// third of the areas of the faces at e and A the whole area, of the mean. So an area counts by its size
/// however finely it is meshed. W = dihedral_weight, P = position_weight; s_v is 1 / #V for uniform weights and a
/// third of the areas of the faces at v over A for area weights; x are aligned positions (generalised
/// Procrustes alignment of the meshes as scaled), D the diagonal of the box along the principal axes of
/// their mean.
///
/// @throws InvalidInput if the collection is empty, or check(options)
///     refuses an option.
[[nodiscard]] ShapeSpace make_space(const Collection& collection, const SpaceOptions& options);

[[nodiscard]] Scale scale_of(const ShapeSpace& space); ///< What the space does about size.

/// Whether the coordinates are edge lengths and nothing else.
[[nodiscard]] bool is_plain(const ShapeSpace& space);

/// The meshes as points of the space, N by D; each depends on itself and the space alone.
/// @throws InvalidInput if the space holds something per vertex or edge, and of another number.
[[nodiscard]] RowMatrix encode(const ShapeSpace& space, const Collection& collection);

/// Sizes of meshes, N [length]: sums of edge lengths, centroid sizes in Procrustes space.
[[nodiscard]] Eigen::VectorXd sizes(const ShapeSpace& space, const Collection& collection);

/// What must be combined by the same weights as the coordinates so that the result can be embedded:
/// N by #E dihedral angles [rad], each edge on one branch; N by 0 where coordinates say all.
[[nodiscard]] RowMatrix companions(const ShapeSpace& space, const Collection& collection);

/// A point of a space as a shape: lengths and angles that an embedding makes a mesh of, or a mesh.
using DecodedShape = std::variant<ShapePoint, Points>;

/// The inverse of encode().
/// @param companion  #E, or empty: a combination of the rows of companions().
/// @param size  For Scale::Unit, > 0 [length]: the sum of the edge lengths of the result; what
///     positions are multiplied with. Ignored for Scale::None.
/// @throws InvalidInput if a shape or the size breaks a rule.
[[nodiscard]] DecodedShape decode(const ShapeSpace& space, const Eigen::VectorXd& coordinates,
                                  const Eigen::VectorXd& companion, double size);

/// The largest step t in [0, limit] such that the points from mean towards mean + t * direction keep
/// every triangle inequality; limit where points are meshes already. Exact to rounding.
/// @param mean, direction  D; the companion angles do not matter.
[[nodiscard]] double feasible_step(const ShapeSpace& space, const Topology& topology,
                                   const Eigen::VectorXd& mean, const Eigen::VectorXd& direction,
                                   double limit);

} // namespace shape
