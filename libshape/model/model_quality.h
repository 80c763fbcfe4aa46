// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "libshape/base/progress.h"
#include "libshape/edge_space/shape_space.h"
#include "libshape/embedding/embedder.h"
#include "libshape/mesh/collection.h"
#include "libshape/mesh/mesh_stream.h"
#include "libshape/model/streamed_fit.h"
#include "libshape/statistics/grouping.h"

namespace shape {

struct QualityOptions
{
    /// Models are made in this space.
    SpaceOptions space = {};
    /// Models are measured at these numbers of modes; ascending, >= 1. Empty: at usual_mode_counts() of the most that
    /// every model has.
    std::vector<int> modes = {};
    /// At most this many meshes, drawn from all, are reconstructed; >= 1.
    int tests = 25;
    /// This many random meshes are made; >= 1.
    int samples = 25;
    /// Meshes are made as these options say.
    EmbeddingOptions embedding = {};
    /// All draws depend on this.
    std::uint64_t seed = 1;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const QualityOptions& options);

/// A measure at every number of modes: over the meshes, mean and standard deviation (divisor n - 1).
struct QualityCurve
{
    Eigen::VectorXd mean;
    Eigen::VectorXd deviation; ///< 0 for one mesh.
};

/// How good a model is, by Davies (2002), but measured on decoded meshes. A distance between meshes
/// is either the root of the mean squared vertex distance after rigid alignment [length], or that of
/// the difference of edge lengths over the mean length [1]; for Scale::Unit both meshes are brought
/// to one size first (the mean centroid size of the collection; unit sum).
struct ModelQuality
{
    std::vector<int> modes;
    Eigen::VectorXd compactness;        ///< Share of the total variance in the first K modes [1].
    QualityCurve generalisation_vertex; ///< From meshes left out to their reconstructions [length].
    QualityCurve generalisation_edge;   ///< The same in edge lengths [1].
    QualityCurve specificity_vertex;    ///< From samples to the nearest mesh of the collection.
    QualityCurve specificity_edge;      ///< The same, nearest in edge lengths.
    int tests = 0;                      ///< Meshes that were left out and reconstructed.
    int infeasible = 0;                 ///< Decoded meshes whose lengths no mesh has.
    int decoded = 0;                    ///< All decoded meshes.
};

/// Measures the models of a collection with growing numbers of modes.
///
/// Generalisation: every fold is left out, the others make a model, and the tests of the fold are
/// projected into it and decoded at their own size. Specificity: scores are drawn from independent
/// normal distributions of the variances of the model of all meshes (those of the first modes stay
/// the same as modes are added) and decoded at mean size.
///
/// @param folds  N meshes in at least 2 folds, each left out once.
/// @param progress  Called with the meshes decoded.
/// @throws InvalidInput if a rule is broken, or a number of modes is more than a model without its
///     largest fold has; as Embedder::embed().
/// Cost: (tests + samples) times the numbers of modes embeddings, one fit for each fold with a test; where `modes` is
///     empty, all anew for each model that has fewer modes than those before it, which meshes of low rank make.
/// Determinism: same bits for any thread count.
[[nodiscard]] ModelQuality measure_quality(const Collection& collection, const Grouping& folds,
                                           const QualityOptions& options,
                                           const Progress& progress = {});

/// The same of meshes that need not fit into memory: each model is fitted in passes (streamed_fit.h), to
/// rounding the one in memory where it is found by Gram; beside the decoded meshes few are held.
/// @param stream  How; without progress, save and state, as it is for many models. Processes share the passes and
///     the meshes that are decoded.
/// @throws as both; InvalidInput if one of these three is set.
/// Cost: one fit in passes for each fold with a test, and one of all.
[[nodiscard]] ModelQuality measure_quality(const MeshStream& meshes, const Grouping& folds,
                                           const QualityOptions& options,
                                           const StreamOptions& stream,
                                           const Progress& progress = {});

/// N meshes in `count` folds of equal size (within one), drawn by chance; groups_of_one() if
/// count = N.
/// @throws InvalidInput if count is not in [2, N].
[[nodiscard]] Grouping random_folds(Eigen::Index meshes, int count, std::uint64_t seed);

/// 1, 2, 5, 10, 20, 50 as far as they are below `most`, and then `most` if it is <= 50.
[[nodiscard]] std::vector<int> usual_mode_counts(int most);

} // namespace shape
