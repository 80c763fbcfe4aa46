// SPDX-License-Identifier: MIT

#include "tools/input/mesh_choice.h"

#include <algorithm>
#include <iterator>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "tools/input/mesh_input.h"

namespace shape::tools {
using namespace internal;

namespace fs = std::filesystem;

std::vector<fs::path> chosen_files(const MeshChoice& choice, const std::vector<std::string>& names)
{
    std::vector<fs::path> files;
    for (const std::string& text : choice.texts) {
        if (std::find(names.begin(), names.end(), text) != names.end())
            continue;
        if (!fs::exists(text))
            throw InvalidInput(join(choice.option, ": '", text,
                                    "' is neither the name of a mesh of the run nor a file"));
        MeshInput input;
        input.paths = {text};
        const std::vector<fs::path> members = mesh_files(input);
        files.insert(files.end(), members.begin(), members.end());
    }
    return files;
}

Collection choose_meshes(const MeshChoice& choice, const Collection& run, const NamedMesh& known)
{
    std::vector<NamedMesh> meshes;
    PolygonCuts cuts;
    add_triangulation(cuts, known);
    for (const std::string& text : choice.texts) {
        const auto found = std::find(run.names.begin(), run.names.end(), text);
        if (found != run.names.end()) {
            const auto mesh = to_size(found - run.names.begin());
            meshes.push_back({text, text, run.points[mesh], run.topology.faces()});
            continue;
        }
        MeshChoice one = choice;
        one.texts = {text};
        for (const fs::path& file : chosen_files(one, {})) {
            FileContent content = read_mesh_file(file, choice.triangulate, &cuts);
            std::move(content.meshes.begin(), content.meshes.end(), std::back_inserter(meshes));
        }
    }
    for (const PolygonCuts::Folded& folded : cuts.folded)
        choice.warn(join(choice.option, ": ", folded.message));
    for (const NamedMesh& mesh : meshes) {
        const std::string difference = describe_correspondence_break(known, mesh);
        if (!difference.empty())
            throw InvalidInput(
                join(choice.option, ": another triangulation than ", known.path, "; ", difference));
    }
    return collect(std::move(meshes));
}

} // namespace shape::tools
