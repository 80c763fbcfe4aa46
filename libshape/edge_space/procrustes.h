// SPDX-License-Identifier: MIT

#pragma once

#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/points.h"

namespace shape {

struct ProcrustesOptions
{
    /// Unit: every mesh is brought to centroid size 1 first. None: sizes stay.
    Scale scale = Scale::Unit;
    /// The alignment ends after this many iterations; >= 1.
    int max_iterations = 100;
    /// It ends once the mean moves by |m' - m| <= tolerance * |m|; > 0.
    double tolerance = 1e-12;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const ProcrustesOptions& options);

/// The mean of meshes after generalised Procrustes alignment.
struct ProcrustesMean
{
    Points points; ///< #V by 3, centroid at 0, standing as the first mesh; [1] or [length].
    int iterations = 0;
    bool converged = false; ///< The criterion was met within max_iterations.
};

/// sqrt of the sum of squared distances of the vertices from their centroid [length].
[[nodiscard]] double centroid_size(const Points& points);

/// The mesh with its centroid moved to 0, divided by its centroid size for Scale::Unit, and turned
/// (reflections excluded) towards a reference in the sum of squared distances.
/// @param reference  #V by 3, centroid at 0.
/// @throws InvalidInput if the shapes differ or are empty, or for Scale::Unit if all vertices
///     coincide.
[[nodiscard]] Points aligned_with(const Points& reference, const Points& points, Scale scale);

/// Generalised Procrustes analysis (Gower 1975; Rohlf and Slice 1990, partial): meshes are centred
/// and, for Scale::Unit, brought to centroid size 1; then they are turned towards their mean and
/// the mean is taken again, from the first mesh on, until it stands still.
///
/// Minimises sum_i |R_i x_i - m|^2 over the rotations R_i and m, and with it the sum of squared
/// distances between all pairs. The mean is the plain one, of centroid size <= 1 for Scale::Unit.
///
/// @throws InvalidInput if there is no mesh, one has other vertices than the first, an option is
///     out of its range, or aligned_with() refuses a mesh.
/// Cost: O(N #V) an iteration; memory for one mean and N rotations beside the meshes.
/// Determinism: same bits for any thread count.
[[nodiscard]] ProcrustesMean procrustes_mean(const std::vector<Points>& meshes,
                                             const ProcrustesOptions& options = {});

} // namespace shape
