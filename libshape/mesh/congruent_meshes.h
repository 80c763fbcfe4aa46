// SPDX-License-Identifier: MIT

#pragma once

#include <span>
#include <string>
#include <vector>

#include "libshape/base/progress.h"
#include "libshape/mesh/mesh_stream.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Meshes that are one, in place or moved.
struct Copies
{
    std::vector<std::size_t> meshes; ///< Two and more, ascending.
    /// The largest distance of a vertex of one from its place in another, over the diagonal [1]; 0: at most 1e-6.
    double difference = 0.0;
};

/// Meshes that a rigid motion takes onto one another, by the first of them. Mirror images and meshes of another scale
/// are no copies.
///
/// Mesh i is a copy of mesh j, of diagonal D, if abs(l_e - l'_e) <= 1e-6 D for every edge e, and after the best rigid
/// motion no vertex is further than that from its place; directly or by way of others. If not, the distances in place
/// decide, d the largest of a vertex and r the root of the mean of their squares:
/// - what both were rounded to (coordinate_spacing.h: s and s'; texts of few digits, single precision far from the
///   origin) may be the difference: d <= min(1e-3 D, sqrt(3) (s + s')), and no mesh that is none is nearer than 10 r; or
/// - they are nearer than meshes ever are: d <= 1e-4 D, and of three and more meshes that are none, none is nearer than
///   1000 r (by 64 vertices).
/// So neighbours in a sequence are not taken for copies, however small its steps, unless they are below 1e-6 D. Where
/// more than 32 meshes lie that near, only the first rule holds.
/// @param meshes  Each #V by 3 of finite numbers.
/// Cost: O(N #E + N log N), a comparison of two numbers for each pair of meshes of one size, and where these agree
/// too the edges up to the first that differs; O(N #V) for each mesh that another is near to.
[[nodiscard]] std::vector<Copies> congruent_meshes(const Topology& topology,
                                                   std::span<const Points> meshes);

/// "a and b are copies of one mesh, ...": what they differ by, and what to do.
[[nodiscard]] std::string describe(const Copies& copies, const std::vector<std::string>& names);

/// The meshes of a stream beside which congruent_meshes() tells whether some others are copies of them: those that are
/// nearly congruent to one (33 of each at most), and eight here and there, which show how far meshes are apart.
/// @param meshes  At least one, of the stream's triangulation.
/// @return Ascending. Cost: reads all meshes once and measures their edges.
[[nodiscard]] std::vector<std::size_t> meshes_to_compare(const MeshStream& stream,
                                                         std::span<const Points> meshes,
                                                         const Progress& progress = {});

} // namespace shape::internal
