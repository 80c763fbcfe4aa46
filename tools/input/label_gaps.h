// SPDX-License-Identifier: MIT

#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "tools/input/label_input.h"

namespace shape::tools {

class Session;

/// Labels of which meshes have no column while others that they are put together with have one, so that they are left
/// empty.
class LabelGaps
{
public:
    /// Meshes with these labels; further ones of meshes that are known already, too.
    void add(const std::vector<std::string>& names, const Labels& labels);
    /// Meshes that were read from an input: with those of its table of labels, if it has one, else of their files.
    void add(const MeshInput& input, const MeshLabels& meshes);

    /// Warns, in a line, of the labels that some of these meshes lack.
    /// @param remedy  What to do about it.
    void warn(const Session& session, const std::vector<std::string>& names,
              const std::string& remedy) const;

private:
    std::vector<std::string> labels_; ///< All of them, as they came.
    /// By the labels that they have.
    std::map<std::set<std::string>, std::set<std::string>> meshes_with_;
};

} // namespace shape::tools
