// SPDX-License-Identifier: MIT

#include "libshape/edge_space/procrustes.h"

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/rotation_fit.h"

namespace shape {
using namespace internal;
namespace {

/// x -> (x - centre) * factor, rows of points.
struct Placement
{
    Eigen::RowVector3d centre;
    double factor = 1.0;
};

Placement place(const Points& points, Scale scale)
{
    Placement placement{points.colwise().mean(), 1.0};
    if (scale == Scale::Unit) {
        const double size = centroid_size(points);
        if (!(size > 0.0))
            throw InvalidInput("Procrustes alignment: all vertices of a mesh coincide");
        placement.factor = 1.0 / size;
    }
    return placement;
}

/// The rotation of the placed points towards a centred reference.
Eigen::Matrix3d turn_towards(const Points& reference, const Points& points,
                             const Placement& placement, const Eigen::Matrix3d& guess)
{
    // The rows of the reference sum to 0, so the centre of the points drops out up to rounding; it
    // is taken away all the same, for meshes far from the origin.
    const Eigen::Matrix3d covariance =
        reference.transpose() * (points.rowwise() - placement.centre);
    return nearest_rotation_from(placement.factor * covariance, guess);
}

void check_meshes(const std::vector<Points>& meshes)
{
    if (meshes.empty())
        throw InvalidInput("Procrustes alignment of no mesh");
    for (std::size_t i = 0; i < meshes.size(); ++i)
        if (meshes[i].rows() != meshes.front().rows() || meshes[i].rows() == 0)
            throw InvalidInput(join("Procrustes alignment: mesh ", i, " has ", meshes[i].rows(),
                                    " vertices, the first ", meshes.front().rows(),
                                    "; the counts must be equal and not 0"));
}

} // namespace

double centroid_size(const Points& points)
{
    return (points.rowwise() - points.colwise().mean()).norm();
}

Points aligned_with(const Points& reference, const Points& points, Scale scale)
{
    if (points.rows() != reference.rows() || points.rows() == 0)
        throw InvalidInput(join("alignment of ", points.rows(), " points with ", reference.rows(),
                                ": the counts must be equal and not 0"));
    const Placement placement = place(points, scale);
    const Eigen::Matrix3d rotation =
        turn_towards(reference, points, placement, Eigen::Matrix3d::Identity());
    return (points.rowwise() - placement.centre) * (placement.factor * rotation.transpose());
}

void check(const ProcrustesOptions& options)
{
    require_at_least(1, options.max_iterations, "ProcrustesOptions.max_iterations");
    require_positive(options.tolerance, "ProcrustesOptions.tolerance");
}

ProcrustesMean procrustes_mean(const std::vector<Points>& meshes, const ProcrustesOptions& options)
{
    check(options);
    check_meshes(meshes);
    const std::size_t count = meshes.size();
    std::vector<Placement> placements;
    placements.reserve(count);
    for (const Points& mesh : meshes)
        placements.push_back(place(mesh, options.scale));
    std::vector<Eigen::Matrix3d> rotations(count, Eigen::Matrix3d::Identity());
    ProcrustesMean mean;
    mean.points =
        (meshes.front().rowwise() - placements.front().centre) * placements.front().factor;
    while (!mean.converged && mean.iterations < options.max_iterations) {
        ++mean.iterations;
        parallel_for(count, 4, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                rotations[i] = turn_towards(mean.points, meshes[i], placements[i], rotations[i]);
        });
        Points next = Points::Zero(mean.points.rows(), 3);
        parallel_for(to_size(next.rows()), 512, [&](std::size_t begin, std::size_t end) {
            const auto first = static_cast<Eigen::Index>(begin);
            const auto rows = static_cast<Eigen::Index>(end - begin);
            for (std::size_t i = 0; i < count; ++i)
                next.middleRows(first, rows) +=
                    (meshes[i].middleRows(first, rows).rowwise() - placements[i].centre) *
                    (placements[i].factor * rotations[i].transpose());
        });
        next /= static_cast<double>(count);
        mean.converged = (next - mean.points).norm() <= options.tolerance * mean.points.norm();
        mean.points = std::move(next);
    }
    mean.points = mean.points * rotations.front(); // stand as the first mesh
    return mean;
}

} // namespace shape
