// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "libshape/edge_space/shape_space.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/multiscale/multiscale_embedding.h"
#include "libshape/embedding/report.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// How a point of edge-length space becomes a mesh.
enum class EmbeddingMethod
{
    Dihedral, ///< Of libshape: linear start, then lengths and dihedral angles together. The default.
    Closure,  ///< Rojas 2014, section 2, as published.
    Multiscale, ///< Winkler 2010, section 3, as published.
};

/// Effort of EmbeddingMethod::Dihedral.
enum class EmbeddingQuality
{
    Preview, ///< A few steps, for interaction.
    Fine,    ///< To convergence.
};

/// Weight of angles [rad] against relative lengths: mu of docs/embedding.md, which says what it means.
inline constexpr double default_smoothness = 5e-3;

/// Largest weight of the distance from the companion mesh: nu of docs/embedding.md [1].
inline constexpr double default_anchor = 0.05;

/// Weight of the distance from positions that belong to the target, which are data as lengths are; where lengths and
/// angles hardly resist up to a hundred times as much in the end (docs/embedding.md, models).
inline constexpr double default_position_anchor = 1.0;

/// Fields that belong to a method may be set only where it is chosen; what is not set has its default.
struct EmbeddingOptions
{
    /// This is how meshes are made.
    EmbeddingMethod method = EmbeddingMethod::Dihedral;
    /// Dihedral takes this effort; default Fine.
    std::optional<EmbeddingQuality> quality = {};
    /// Dihedral weighs angles by this; > 0, default default_smoothness.
    std::optional<double> smoothness = {};
    /// Dihedral holds meshes near the companion that the turns of the target lead to by at most this,
    /// default default_anchor; near the positions of a target by this, default default_position_anchor;
    /// >= 0.
    std::optional<double> anchor = {};
    /// Multiscale starts to register patches from this; default Incremental.
    std::optional<RegistrationStart> registration_start = {};
    /// Multiscale draws the seed triangles of its patches by this; default 1.
    std::optional<std::uint64_t> seed = {};
    /// Faces that cross, though they do in no reference, are moved apart afterwards; of all methods. Where
    /// some still cross, the report says so.
    bool avoid_contact = false;
};

/// @throws InvalidInput naming the first field that breaks its rule, or that belongs to another method.
void check(const EmbeddingOptions& options);

/// Where the time of EmbeddingMethod::Multiscale goes.
struct MultiscaleTimes
{
    MultiscaleSetupTimes setup;
    MultiscalePoseTimes pose;
};

/// A mesh and what it is worth.
struct Embedding
{
    Points points; ///< #V by 3 [length], centroid at 0.
    EmbeddingReport report;
    std::optional<MultiscaleTimes> multiscale = {}; ///< Set by that method alone.
    /// The method that made it where the chosen one cannot start; see Embedder::embed().
    std::optional<EmbeddingMethod> instead = {};
};

/// A mesh that needs no embedding, as one: its targets are its own lengths and angles. The centroid
/// moves to 0.
[[nodiscard]] Embedding as_embedding(const Topology& topology, Points points);

/// Embeds points of one topology. What depends on topology and references alone is computed once, when
/// the first point is embedded.
class Embedder
{
public:
    /// @param references  Meshes of the topology near the points to come, at least one: the inputs of
    ///     a blend, the reference mesh of a model. Results are aligned with the first, and turns of
    ///     targets (ShapePoint::patch_turns) are against the first.
    /// @throws InvalidInput if an option breaks its rule, there is no reference, or one has
    ///     another size, edges of length 0 or a longest edge outside [1e-60, 1e60] [length].
    Embedder(const Topology& topology, std::vector<Points> references,
             const EmbeddingOptions& options = {});
    ~Embedder();
    Embedder(Embedder&&) noexcept;
    Embedder& operator=(Embedder&&) noexcept;

    /// The mesh of the target by the chosen method. Published methods cannot start where a target
    /// breaks a triangle inequality; there Dihedral makes the nearest mesh.
    /// @throws InvalidInput if target has other sizes, a value that is not finite, an angle beyond 1e9 rad or
    ///     a longest edge outside [1e-60, 1e60] [length].
    /// @throws NumericalError if a factorisation breaks down.
    /// Safe to call concurrently.
    [[nodiscard]] Embedding embed(const ShapePoint& target) const;

    /// A point of any space (shape_space.h): lengths and angles are embedded, positions are the mesh
    /// as it is, but for faces that `avoid_contact` moves apart. Throws and may be called as above.
    [[nodiscard]] Embedding embed(const DecodedShape& shape) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace shape
