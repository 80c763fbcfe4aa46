// SPDX-License-Identifier: MIT

#include "tools/input/label_gaps.h"

#include <algorithm>
#include <filesystem>

#include "libshape/base/format.h"
#include "libshape/io/collection_stream.h"
#include "libshape/mesh/oddities.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

/// "label 'sex' is" or "labels 'sex' and 'age' are".
std::string subject(const std::vector<std::string>& labels)
{
    std::string text = labels.size() == 1 ? "label " : "labels ";
    for (std::size_t i = 0; i < labels.size(); ++i)
        text += join(i == 0 ? "'" : i + 1 < labels.size() ? ", '" : " and '", labels[i], "'");
    return text + (labels.size() == 1 ? " is" : " are");
}

} // namespace

void LabelGaps::add(const std::vector<std::string>& names, const Labels& labels)
{
    std::set<std::string> columns;
    for (const LabelColumn& label : labels) {
        columns.insert(label.name);
        if (std::ranges::find(labels_, label.name) == labels_.end())
            labels_.push_back(label.name);
    }
    meshes_with_[columns].insert(names.begin(), names.end());
}

void LabelGaps::add(const MeshInput& input, const MeshLabels& meshes)
{
    if (!input.labels.empty())
        return add(meshes.names, meshes.labels);
    for (const std::filesystem::path& file : mesh_files(input))
        if (is_collection_file(file)) { // others have no labels
            const MeshStream read = open_collection(file);
            add(read.names, read.labels);
        }
}

void LabelGaps::warn(const Session& session, const std::vector<std::string>& names,
                     const std::string& remedy) const
{
    // Labels that the same meshes lack are told together, as they come.
    std::vector<std::vector<std::size_t>> lacking;
    std::map<std::vector<std::size_t>, std::vector<std::string>> labels;
    for (const std::string& label : labels_) {
        const auto is_lacking = [&](const std::string& name) {
            return std::ranges::none_of(meshes_with_, [&](const auto& part) {
                return part.first.contains(label) && part.second.contains(name);
            });
        };
        std::vector<std::size_t> meshes;
        for (std::size_t i = 0; i < names.size(); ++i)
            if (is_lacking(names[i]))
                meshes.push_back(i);
        if (meshes.empty())
            continue;
        if (!labels.contains(meshes))
            lacking.push_back(meshes);
        labels[meshes].push_back(label);
    }
    std::string text;
    for (const std::vector<std::size_t>& meshes : lacking)
        text +=
            join(text.empty() ? "" : ", ", subject(labels[meshes]), " left empty for ",
                 meshes.size(), " of ", names.size(), " meshes (", list_names(names, meshes), ")");
    if (!text.empty())
        session.warn(join(text, ", as they came without; ", remedy));
}

} // namespace shape::tools
