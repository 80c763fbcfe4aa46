// SPDX-License-Identifier: MIT

#include "tools/input/mesh_input.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/defects.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

std::string lower_extension(const fs::path& path)
{
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

bool is_mesh_file(const fs::path& path)
{
    const std::string extension = lower_extension(path);
    return extension == ".obj" || extension == ".ply" || extension == ".off";
}

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/// The piece of the text at `position`: a run of digits, or one other character.
std::string_view piece_at(std::string_view text, std::size_t position)
{
    std::size_t end = position + 1;
    if (is_digit(text[position]))
        while (end < text.size() && is_digit(text[end]))
            ++end;
    return text.substr(position, end - position);
}

std::string_view without_leading_zeros(std::string_view digits)
{
    return digits.substr(std::min(digits.find_first_not_of('0'), digits.size() - 1));
}

/// Runs of digits compare as numbers, everything else by character; equal ones by character alone.
bool natural_less(const std::string& a, const std::string& b)
{
    std::size_t i = 0;
    std::size_t j = 0;
    while (i < a.size() && j < b.size()) {
        const std::string_view p = piece_at(a, i);
        const std::string_view q = piece_at(b, j);
        i += p.size();
        j += q.size();
        if (is_digit(p[0]) && is_digit(q[0])) {
            const std::string_view m = without_leading_zeros(p);
            const std::string_view n = without_leading_zeros(q);
            if (m != n)
                return std::pair(m.size(), m) < std::pair(n.size(), n);
        } else if (p != q) {
            return p < q;
        }
    }
    return std::pair(a.size() - i, a) < std::pair(b.size() - j, b);
}

std::vector<fs::path> mesh_files_of_directory(const fs::path& directory)
{
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(directory))
        if (is_mesh_file(entry.path()) && entry.path().filename().string().front() != '.')
            files.push_back(entry.path());
    if (files.empty())
        throw InvalidInput(join(directory.string(),
                                ": the directory holds no mesh file "
                                "(.obj .ply .off)"));
    std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
        return natural_less(a.filename().string(), b.filename().string());
    });
    return files;
}

/// A collection file alone: its meshes share their faces, which then need not be held once a mesh.
Collection read_single_collection(const fs::path& path)
{
    Collection collection = read_collection(path);
    const Faces& faces = collection.topology.faces();
    for (std::size_t i = 0; i < collection.size(); ++i) {
        const std::vector<Defect> defects =
            find_degenerate_geometry(faces, collection.points[i], 1);
        if (!defects.empty())
            throw InvalidInput(
                join(path.string(), ": mesh ", collection.names[i], ": ", defects.front().message));
    }
    return collection;
}

/// Appends the labels of `count` meshes to those of the `before` meshes that stand already.
void append_labels(Labels& all, std::size_t before, const Labels& labels, std::size_t count)
{
    const auto column_of = [&](const std::string& name) -> LabelColumn& {
        const auto found = std::find_if(all.begin(), all.end(),
                                        [&](const LabelColumn& c) { return c.name == name; });
        if (found != all.end())
            return *found;
        return all.emplace_back(LabelColumn{name, std::vector<std::string>(before)});
    };
    for (const LabelColumn& column : labels) {
        std::vector<std::string>& values = column_of(column.name).values;
        values.insert(values.end(), column.values.begin(), column.values.end());
    }
    for (LabelColumn& column : all)
        column.values.resize(before + count);
}

} // namespace

void add_mesh_input(CLI::App& command, MeshInput& input, const std::string& name)
{
    command
        .add_option(name, input.paths,
                    "Mesh files (.obj .ply .off), directories (their mesh files in natural\n"
                    "name order) and collection files (.h5), in any mix")
        ->required()
        ->option_text("PATH ... REQUIRED");
    command.add_flag("--triangulate", input.triangulate,
                     "Split polygons as fans from their first corner (default: refuse them)");
}

bool is_collection_file(const fs::path& path)
{
    return lower_extension(path) == ".h5";
}

std::vector<fs::path> mesh_files(const MeshInput& input)
{
    std::vector<fs::path> files;
    for (const fs::path path : input.paths) {
        if (!fs::exists(path))
            throw FileError(join(path.string(), ": no such file or directory"));
        if (fs::is_directory(path)) {
            const std::vector<fs::path> members = mesh_files_of_directory(path);
            files.insert(files.end(), members.begin(), members.end());
        } else {
            files.push_back(path);
        }
    }
    return files;
}

std::vector<fs::path> input_files(const MeshInput& input)
{
    std::vector<fs::path> files = mesh_files(input);
    if (!input.labels.empty())
        files.emplace_back(input.labels);
    return files;
}

FileContent read_mesh_file(const fs::path& path, bool triangulate)
{
    FileContent content;
    if (!is_collection_file(path)) {
        content.meshes.push_back(read_mesh(path, {.triangulate = triangulate}));
        return content;
    }
    Collection collection = read_collection(path);
    for (std::size_t i = 0; i < collection.size(); ++i)
        content.meshes.push_back({collection.names[i],
                                  join(path.string(), ": mesh ", collection.names[i]),
                                  std::move(collection.points[i]), collection.topology.faces()});
    content.labels = std::move(collection.labels);
    return content;
}

Collection read_meshes(const Session& session, const MeshInput& input)
{
    const Progress progress = session.progress();
    const std::vector<fs::path> files = mesh_files(input);
    if (files.size() == 1 && is_collection_file(files.front())) {
        Collection collection = read_single_collection(files.front());
        if (!input.labels.empty())
            collection.labels = read_labels(input.labels, collection.names);
        return collection;
    }
    std::vector<NamedMesh> meshes;
    Labels labels;
    for (std::size_t i = 0; i < files.size(); ++i) {
        FileContent content = read_mesh_file(files[i], input.triangulate);
        append_labels(labels, meshes.size(), content.labels, content.meshes.size());
        std::move(content.meshes.begin(), content.meshes.end(), std::back_inserter(meshes));
        progress("reading", i + 1, files.size());
    }
    Collection collection = collect(std::move(meshes));
    collection.labels = input.labels.empty() ? labels : read_labels(input.labels, collection.names);
    return collection;
}

} // namespace shape::tools
