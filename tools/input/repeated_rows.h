// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "tools/input/label_input.h"

namespace shape::tools {

/// Whether meshes are repeated measurements of fewer things, where an analysis counts each as an independent
/// observation: what that analysis knows, and what it says if they are.
struct RepetitionQuestion
{
    /// N by C; with no columns no two meshes differ in them.
    Eigen::MatrixXd covariates = {};
    std::vector<std::string> columns = {}; ///< Labels that the covariates come from.
    bool are_groups = false;               ///< They are codes() of groups, not numbers.
    /// The covariate that is the sizes of the meshes, if any: repeated measurements have them nearly in common.
    std::optional<Eigen::Index> sizes = {};
    /// What follows if rows are repeated and what to do, up to a label: "then chance looks significant. Give
    /// --within".
    std::string remedy = {};
    std::string unnamed = {}; ///< How that ends where no label names the blocks.
    /// Nothing is tested: only blocks of unequal numbers of meshes matter, of which the larger weigh more in a mean.
    bool is_of_means = false;
};

/// What is said if labels say that meshes are repeated measurements. Within the meshes of one value all covariates are the
/// same (sizes: have a standard deviation of at most half that of all, or in the second case a quarter), and
/// - the label is called as those of a person or a specimen are (subject, patient_id, ...), and at least two meshes
///   and a tenth of all repeat another one's value; or
/// - all meshes have a value, and there are at least 5 of them, of 2 to 20 meshes on average.
[[nodiscard]] std::optional<std::string> doubt_about_rows(const MeshLabels& meshes,
                                                          const RepetitionQuestion& question);

/// What is said if shapes say so, of six meshes or more: in three blocks or more, of two meshes or more on average, within
/// which all covariates are the same (sizes as in the first case above), meshes differ much less from one another than from those of other blocks with
/// the same covariates. Blocks are the values of a label, or what names have before their last separator (_, -, . or
/// a blank), where the distances (root mean square) differ by a factor of two; or the sets of single_linkage_sets().
/// Where all blocks differ in their covariates they may be what these do: then of groups nothing is said, and of
/// numbers only if distances differ by a factor of four.
/// @param products  N by N inner products of the shapes, about any point.
[[nodiscard]] std::optional<std::string> doubt_about_close_rows(const MeshLabels& meshes,
                                                                const RepetitionQuestion& question,
                                                                const Eigen::MatrixXd& products);

/// Say that on stderr.
/// @return Whether there was anything to say.
bool warn_of_repeated_rows(const Session& session, const MeshLabels& meshes,
                           const RepetitionQuestion& question);
void warn_of_close_rows(const Session& session, const MeshLabels& meshes,
                        const RepetitionQuestion& question, const Eigen::MatrixXd& products);

} // namespace shape::tools
