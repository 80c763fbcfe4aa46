// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/collection.h"
#include "libshape/statistics/column_effects.h"

namespace shape {

/// The mean difference between two groups of a collection, of pairs (Rojas 2014, Fig. 10) or of the
/// means of groups without pairs, with the mean of the group it starts from.
struct DifferenceVector
{
    Topology topology;
    Points reference_points; ///< #V by 3 [length].
    Scale scale = Scale::Unit;
    Eigen::VectorXd mean_edge_lengths;    ///< #E; mean of the `from` members (of the pairs).
    Eigen::VectorXd mean_dihedral_angles; ///< #E [rad].
    Eigen::VectorXd edge_lengths;         ///< #E; mean of `to` - mean of `from`.
    Eigen::VectorXd dihedral_angles;      ///< #E [rad].
    double from_size = 0.0;               ///< Mean size of the `from` members [length].
    double to_size = 0.0;                 ///< Mean size of the `to` members [length].
    std::vector<std::string> pairs;       ///< Values of the pairing label, one a pair, sorted;
                                          ///< none if the groups are not paired.
};

struct DifferenceOptions
{
    /// Two meshes with the same value of this label are a pair, those without a value are not; several of one group, such as
    /// repeated scans, count once, by their mean, as in compare_groups() within blocks. Empty:
    /// the groups are not paired, all meshes of both count.
    std::string pair_by = {};
    /// The label that chooses the meshes of the start; not empty.
    std::string from_label = {};
    /// The start is the mean of the meshes with this value of from_label.
    std::string from_value = {};
    /// The label that chooses the meshes of the end; not empty.
    std::string to_label = {};
    /// The end is the mean of the meshes with this value of to_label.
    std::string to_value = {};
    /// Unit: every mesh is brought to one size first. None: size is a part of shape.
    Scale scale = Scale::Unit;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const DifferenceOptions& options);

/// @throws InvalidInput if a label is missing, a group is empty, no value occurs in both, or a mesh is in both groups and they are not paired. Members
///     without a partner are left out.
[[nodiscard]] DifferenceVector mean_difference(const Collection& collection,
                                               const DifferenceOptions& options);

/// Where the two groups differ: the effects of every entry of the shape vectors, #E; paired_effects()
/// of pairs, independent_effects() of groups without.
/// @throws InvalidInput as mean_difference() and those; so for a single pair.
[[nodiscard]] ColumnEffects difference_effects(const Collection& collection,
                                               const DifferenceOptions& options);

/// The mean of the `from` members, in units of length.
/// @param size  Sum of its edge lengths [length]; ignored for Scale::None.
/// @throws InvalidInput if size is not > 0.
[[nodiscard]] ShapePoint start_of(const DifferenceVector& difference, double size);

/// A shape with differences added, such as expressions of others: start + sum_k a_k difference_k.
/// Unit-sum differences are multiplied with the size of the start, which the result keeps; those of
/// Scale::None are added as they are.
/// @param start  The point of a mesh, or start_of(); any size.
/// @param differences  All of one triangulation and one scale.
/// @param amounts  As many, finite.
/// @throws InvalidInput if a rule is broken.
[[nodiscard]] ShapePoint apply_differences(const ShapePoint& start,
                                           const std::vector<DifferenceVector>& differences,
                                           const std::vector<double>& amounts);

} // namespace shape
