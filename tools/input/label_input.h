// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libshape/mesh/collection.h"
#include "libshape/mesh/mesh_stream.h"
#include "libshape/statistics/grouping.h"
#include "tools/input/mesh_input.h"

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace shape::tools {

/// Meshes with labels, or some of them by their labels.
struct LabelledInput
{
    MeshInput meshes;
    std::vector<std::string> only; ///< LABEL=VALUE, or LABEL: any value.
};

/// Adds MESHES, --triangulate, --labels and --only.
void add_labelled_input(CLI::App& command, LabelledInput& input);

/// Adds an option that takes the name of a label.
CLI::Option* add_label(CLI::App& command, const std::string& option, std::string& label,
                       const std::string& description);

/// Reads the meshes and keeps those that have, for each label named by --only, one of its values, or
/// any at all.
/// @throws as read_meshes(); InvalidInput if a label does not exist or no mesh is left; UsageError
///     if a text is not LABEL[=VALUE].
[[nodiscard]] Collection read_labelled(const Session& session, const LabelledInput& input);

/// The meshes that --only lets in, ascending.
/// @throws as read_labelled().
[[nodiscard]] std::vector<std::size_t> chosen_meshes(const std::vector<std::string>& only,
                                                     const Labels& labels, std::size_t count);

/// The two sides of LABEL=VALUE.
/// @throws UsageError, which names the option, if the text has no such form or the value is missing
///     (label_value()).
[[nodiscard]] std::pair<std::string, std::string> label_and_value(const std::string& option,
                                                                  const std::string& text);

/// Names and labels of meshes, which are in memory or come in passes.
struct MeshLabels
{
    MeshLabels(const Collection& meshes) : names(meshes.names), labels(meshes.labels) {} // NOLINT
    MeshLabels(const MeshStream& meshes) : names(meshes.names), labels(meshes.labels) {} // NOLINT

    const std::vector<std::string>& names;
    const Labels& labels;

    [[nodiscard]] std::size_t size() const { return names.size(); }
};

/// The meshes by the value of a label.
/// @throws InvalidInput if there is no such label or a mesh has no value of it.
[[nodiscard]] Grouping group_by_label(const MeshLabels& meshes, const std::string& label);

/// As group_by_label(), or all meshes in one group if the label is empty.
[[nodiscard]] Grouping group_by_label_or_all(const MeshLabels& meshes, const std::string& label);

/// As group_by_label(), or every mesh in a group of its own if the label is empty.
[[nodiscard]] Grouping group_by_label_or_each(const MeshLabels& meshes, const std::string& label);

/// The number that a label says of a mesh.
/// @param names  Of the meshes. @param place  The file of the labels, or nothing. @param remedy  Ends the message.
/// @throws InvalidInput naming place, label, mesh and value if it is none.
[[nodiscard]] double number_of_label(const LabelColumn& label, std::size_t mesh,
                                     const std::vector<std::string>& names,
                                     const std::string& place, const std::string& remedy);

/// The numbers of labels, one column each; `size` stands for the sizes.
/// @throws InvalidInput if there is no such label, or a mesh has no value of it or one that is not a
///     number, or if squares of the numbers overflow or underflow.
/// @param table  Where the labels were read, if not in the files of the meshes.
[[nodiscard]] Eigen::MatrixXd covariates_of(const MeshLabels& meshes, const Eigen::VectorXd& sizes,
                                            const std::vector<std::string>& columns,
                                            const std::string& table);

/// Warns of numbers in these columns that are likely to stand for no value (missing_codes()), where labels come from
/// files of collections: tables say so themselves when they are read.
void warn_of_missing_codes(const Session& session, const LabelledInput& input, const Labels& labels,
                           const std::vector<std::string>& columns);

/// The number of the group of each observation, as a covariate.
[[nodiscard]] Eigen::MatrixXd codes(const Grouping& groups);

} // namespace shape::tools
