// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "libshape/base/progress.h"
#include "libshape/base/ranks.h"
#include "libshape/mesh/mesh_stream.h"
#include "libshape/model/shape_model.h"
#include "libshape/statistics/pass_state.h"

namespace shape {

/// How the modes of meshes that come by in passes are found.
enum class FitAlgorithm
{
    Automatic, ///< Gram where all modes are wanted or the matrix is small, else Krylov.
    Gram,   ///< Eigenvectors of the N by N inner products, summed tile by tile: exact to rounding.
    Krylov, ///< Block Krylov method, to a tolerance.
};

struct StreamOptions
{
    /// At most this much memory is used, for the model and its making together [byte]; 0: a quarter of the
    /// machine's. Less is taken where more would not help.
    std::uint64_t memory = 0;
    FitAlgorithm algorithm = FitAlgorithm::Automatic;
    /// The relative error of each variance that Krylov may leave, as it estimates it, where rounding leaves less; in (0, 1).
    double tolerance = 1e-6;
    /// What is random in the start of Krylov depends on this.
    std::uint64_t seed = 1;
    /// Called with kilobytes read, of the pass that its stage names.
    Progress progress = {};
    /// Called after a pass with what a later run needs to go on from there.
    std::function<void(const PassState&)> save = {};
    /// Other processes that share the passes.
    Ranks ranks = {};
    /// Such a state, of the same meshes, options and algorithm; the memory may be another for Gram, whose bits do not
    /// depend on it.
    std::optional<PassState> state = {};
    /// A folder where Gram may keep all coordinates, 8 N D bytes in a file without a name, so that one pass gives inner
    /// products and modes. Empty, or where the disk has less than twice that free, the former take about N / (2 h)
    /// passes, as h meshes are held at a time. Changes no bit; Krylov makes no use of it.
    std::filesystem::path scratch = {};
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const StreamOptions& options);

struct StreamedFit
{
    ShapeModel model;
    FitAlgorithm algorithm = FitAlgorithm::Gram; ///< The one that was taken.
    int passes = 0;                              ///< Over all or some of the meshes.
    /// Estimate of the largest relative error of a variance, for Krylov at least 4 epsilon times the ratio of the largest
    /// variance to the smallest, which rounding leaves; 0 for Gram.
    double error = 0.0;
};

/// The model that fit_model() makes of a collection, of one that need not fit into memory: positions
/// come by in passes, lengths and angles are measured as they do. Gram gives the same model but for
/// rounding, Krylov within the tolerance. Neither the memory nor the number of threads changes a bit
/// of what Gram gives; that of Krylov may depend on the memory, by which it restarts.
///
/// @throws as fit_model(); LimitExceeded if the memory does not suffice (it says what would); what
///     reading throws. Procrustes space is refused.
/// Cost: Gram N^2 E / 2 multiplications and two passes with a scratch folder, one if the space has no companion angles;
///     else about N / (2 h) + 1 where h meshes are held, one more if a mode has less than 1e-4 of the largest variance;
///     Krylov 2 N E s for each pass with s = K + max(10, K / 5).
[[nodiscard]] StreamedFit fit_model(const MeshStream& meshes, const ModelOptions& options,
                                    const StreamOptions& stream);

/// Gram or Krylov: which of them fit_model() takes for so many meshes.
[[nodiscard]] FitAlgorithm algorithm_for(Eigen::Index meshes, const ModelOptions& options,
                                         const StreamOptions& stream);

/// A quarter of the machine's memory [byte].
[[nodiscard]] std::uint64_t usual_memory();

} // namespace shape
