// SPDX-License-Identifier: MIT

#include "libshape/model/unlike_meshes.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libshape/base/order_statistics.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/handedness.h"

namespace shape::internal {
namespace {

constexpr double far = 5.0; ///< Times: sizes of one kind seldom differ so, as odd_sizes() has it.

/// How far beyond known sizes a further one is odd, as a factor.
double odd_factor(const std::vector<double>& sizes)
{
    if (sizes.size() < 5) // two strange ones would decide what the spread is
        return far;
    std::vector<double> logarithms;
    for (const double size : sizes)
        logarithms.push_back(std::log(size));
    const double centre = median(logarithms);
    for (double& value : logarithms)
        value = std::abs(value - centre);
    return std::clamp(std::exp(10.0 * 1.4826 * median(logarithms)), 2.0, far);
}

void set_sizes(KnownMeshes& known, const std::vector<double>& sizes)
{
    const auto [least, largest] = std::minmax_element(sizes.begin(), sizes.end());
    const double factor = odd_factor(sizes);
    known.usual_size = median(sizes);
    known.least_size = *least / factor;
    known.largest_size = *largest * factor;
}

} // namespace

KnownMeshes known_meshes(const ShapeModel& model)
{
    KnownMeshes known{model.topology, model.reference_points, model.mean_dihedral_angles};
    set_sizes(known, {model.sizes.begin(), model.sizes.end()});
    return known;
}

KnownMeshes known_meshes(const DifferenceVector& difference)
{
    KnownMeshes known{difference.topology, difference.reference_points,
                      difference.mean_dihedral_angles};
    set_sizes(known, {difference.from_size, difference.to_size});
    return known;
}

KnownMeshes known_meshes(const Collection& collection)
{
    KnownMeshes known{collection.topology, collection.points.front(), {}};
    std::vector<double> sizes;
    for (const Points& points : collection.points)
        sizes.push_back(edge_lengths(collection.topology, points).sum());
    set_sizes(known, sizes);
    return known;
}

double odd_size(const KnownMeshes& known, double size)
{
    return size < known.least_size || size > known.largest_size ? size / known.usual_size : 0.0;
}

RowMatrix unlike_meshes(const KnownMeshes& known, const Collection& meshes,
                        const Eigen::VectorXd& sizes)
{
    RowMatrix marks = RowMatrix::Zero(sizes.size(), 2);
    for (Eigen::Index i = 0; i < sizes.size(); ++i) {
        const bool is_mirrored = is_mirror_image(known.topology, meshes.points[to_size(i)],
                                                 known.reference_points, known.dihedral_angles);
        const bool is_guess =
            is_mirrored && may_be_bent(known.topology, meshes.points[to_size(i)],
                                       known.reference_points, known.dihedral_angles);
        marks.row(i) << (is_guess ? 2.0 : is_mirrored ? 1.0 : 0.0), odd_size(known, sizes[i]);
    }
    return marks;
}

Eigen::VectorXd far_meshes(const ShapeModel& model, const Projection& projection)
{
    constexpr double far_from_mean = 4.0; // set by hand, see there
    const Eigen::Index count = model.scores.rows();
    Eigen::VectorXd times = Eigen::VectorXd::Zero(projection.residuals.size());
    if (count < 5) // they show little of how far meshes are
        return times;
    const double left = std::max(0.0, model.total_variance - model.variances.sum()) *
                        static_cast<double>(count - 1) / static_cast<double>(count);
    const double farthest = std::sqrt(model.scores.rowwise().squaredNorm().maxCoeff() + left);
    for (Eigen::Index i = 0; i < times.size(); ++i) {
        const double distance =
            std::hypot(projection.scores.row(i).norm(), projection.residuals[i]);
        if (distance > far_from_mean * farthest)
            times[i] = distance / farthest;
    }
    return times;
}

} // namespace shape::internal
