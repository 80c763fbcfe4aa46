// SPDX-License-Identifier: MIT

#include "tools/input/mesh_input.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <map>
#include <numeric>
#include <set>
#include <system_error>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/label_doubts.h"
#include "libshape/io/label_file.h"
#include "libshape/io/mesh_file.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/joined_labels.h"
#include "tools/input/natural_order.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

std::string lower_extension(const fs::path& path)
{
    return lower_case(path.extension().string());
}

bool is_mesh_file(const fs::path& path)
{
    constexpr std::array<std::string_view, 7> endings = {".obj", ".ply", ".off", ".stl",
                                                         ".vtk", ".vtp", ".glb"};
    return std::find(endings.begin(), endings.end(), lower_extension(path)) != endings.end();
}

bool is_hidden(const fs::path& path)
{
    return path.filename().string().starts_with('.');
}

/// The path as the system has it, without links and a slash at its end; empty if it cannot be known.
fs::path place_of(const fs::path& path)
{
    std::error_code error;
    const fs::path place = fs::weakly_canonical(path, error);
    return place.has_filename() ? place : place.parent_path();
}

/// Mesh files in the subfolders of a directory, which are not taken with it.
struct MeshesBelow
{
    std::vector<std::string> folders; ///< That hold some: from the directory on, in natural order.
    std::vector<std::string> unreadable; ///< Folders that permissions keep shut; likewise.
    std::size_t count = 0;
    bool is_all = true; ///< Whether everything else below was looked at.
};

/// Left out are hidden folders, links to folders, what is named beside the directory, and what libshape itself writes
/// beside meshes (residuals/, unfinished/, shards).
MeshesBelow meshes_below(const fs::path& directory, const MeshInput& input)
{
    constexpr int deepest = 4;
    constexpr std::size_t most_entries = 20'000; // some 50 ms
    const std::set<fs::path> named = [&] {
        std::set<fs::path> places;
        for (const std::string& path : input.paths)
            places.insert(place_of(path));
        return places;
    }();
    const auto is_passed_by = [&](const fs::path& folder) {
        const std::string name = folder.filename().string();
        return is_hidden(folder) || name == "residuals" || name == "unfinished" ||
               name.find(".shard-") != std::string::npos || named.contains(folder);
    };
    const fs::path root = place_of(directory);
    const auto is_shut = [](const fs::directory_entry& folder) {
        return !folder.is_symlink() && access(folder.path().c_str(), R_OK | X_OK) != 0 &&
               errno == EACCES;
    };
    MeshesBelow below;
    std::set<std::string> folders;
    std::size_t looked_at = 0;
    std::error_code error;
    constexpr auto options = fs::directory_options::skip_permission_denied;
    for (fs::recursive_directory_iterator entry(root, options, error), end; !error && entry != end;
         entry.increment(error)) {
        const fs::path& path = entry->path();
        if (entry.depth() > 0 && ++looked_at > most_entries) {
            below.is_all = false;
            break;
        }
        std::error_code unknown;
        if (entry->is_directory(unknown)) {
            if (entry.depth() >= deepest || is_passed_by(path)) {
                entry.disable_recursion_pending();
            } else if (is_shut(*entry)) {
                entry.disable_recursion_pending();
                below.unreadable.push_back(path.lexically_relative(root).string());
            }
        } else if (entry.depth() > 0 && is_mesh_file(path) && !is_hidden(path) &&
                   !named.contains(path)) {
            ++below.count;
            folders.insert(path.parent_path().lexically_relative(root).string());
        }
    }
    below.folders.assign(folders.begin(), folders.end());
    sort_naturally(below.folders);
    sort_naturally(below.unreadable);
    return below;
}

/// "3 subfolders (a, b and c/d)".
std::string describe(const std::vector<std::string>& folders)
{
    return join(counted(folders.size(), "subfolder"), " (", list_names(folders), ")");
}

/// "at least 12 mesh files in 3 subfolders (a, b and c/d)".
std::string describe(const MeshesBelow& below)
{
    return join(below.is_all ? "" : "at least ", counted(below.count, "mesh file"), " in ",
                describe(below.folders));
}

/// How the meshes of subfolders are named.
std::string way_to_take(const fs::path& directory, const MeshesBelow& below)
{
    const std::string first = (directory / below.folders.front()).string();
    return below.folders.size() == 1 ? join("name it: ", first)
                                     : join("name each of them, such as ", first);
}

/// Which subfolders cannot be looked into, and what to do if that is not meant.
std::string describe_unreadable(const fs::path& directory, const MeshesBelow& below)
{
    const std::string first = (directory / below.unreadable.front()).string();
    return join(describe(below.unreadable),
                " cannot be read (permission denied); to take meshes in ",
                below.unreadable.size() == 1
                    ? join("it, `chmod u+rx ", first, "` and name it")
                    : join("them, `chmod u+rx` each, such as ", first, ", and name them"));
}

std::vector<fs::path> mesh_files_of_directory(const fs::path& directory, const MeshInput& input)
{
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(directory))
        if (!entry.is_directory() && is_mesh_file(entry.path()) && !is_hidden(entry.path()))
            names.push_back(entry.path().filename().string());
    if (names.empty()) {
        const MeshesBelow below = meshes_below(directory, input);
        throw InvalidInput(join(
            directory.string(),
            ": the directory holds no mesh file (.obj .ply .off .stl .vtk .vtp .glb) itself",
            below.count > 0 ? join(", but ", describe(below), ": ", way_to_take(directory, below))
            : below.unreadable.empty()
                ? std::string("; other formats must be exported as one of them")
                : join(", and ", describe_unreadable(directory, below))));
    }
    sort_naturally(names);
    std::vector<fs::path> files;
    for (const std::string& name : names)
        files.push_back(directory / name);
    return files;
}

bool is_mesh_of_other_format(const fs::path& path)
{
    constexpr std::array<std::string_view, 12> others = {".vtu",  ".gltf", ".fbx", ".dae",
                                                         ".3ds",  ".x3d",  ".wrl", ".msh",
                                                         ".mesh", ".3mf",  ".usd", ".usdz"};
    return std::find(others.begin(), others.end(), lower_extension(path)) != others.end();
}

/// "s1.ply.gz": a mesh of either kind within.
bool is_compressed_mesh(const fs::path& path)
{
    constexpr std::array<std::string_view, 5> endings = {".gz", ".zip", ".bz2", ".xz", ".zst"};
    return std::find(endings.begin(), endings.end(), lower_extension(path)) != endings.end() &&
           (is_mesh_file(path.stem()) || is_mesh_of_other_format(path.stem()));
}

/// Names of the files of a directory that a rule picks, in natural order.
std::vector<std::string> picked_files(const fs::path& directory, bool (*is_picked)(const fs::path&))
{
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(directory))
        if (std::error_code unknown; is_picked(entry.path()) && !entry.is_directory(unknown))
            names.push_back(entry.path().filename().string());
    sort_naturally(names);
    return names;
}

/// Says which files of a directory hold meshes and are not taken with it.
void note_files_passed_over(const MeshNotices& notices, const fs::path& directory,
                            const MeshInput& input)
{
    if (const auto names = picked_files(directory, is_mesh_of_other_format); !names.empty())
        notices.warn(join(directory.string(), ": ", counted(names.size(), "mesh file"),
                          " of other formats passed over, first ", names.front(),
                          "; export as .ply or .obj"));
    if (const auto names = picked_files(directory, is_compressed_mesh); !names.empty())
        notices.warn(join(directory.string(), ": ", counted(names.size(), "compressed mesh file"),
                          " passed over, first ", names.front(), "; unpack ",
                          names.size() == 1 ? "it" : "them"));
    std::vector<std::string> collections = picked_files(directory, is_collection_file);
    if (collections.empty())
        return;
    std::set<fs::path> named;
    for (const std::string& path : input.paths)
        named.insert(place_of(path));
    std::erase_if(collections, [&](const std::string& name) {
        return named.contains(place_of(directory / name));
    });
    if (collections.size() == 1)
        notices.message(join(directory.string(), ": 1 collection or model, ", collections.front(),
                             ", is not taken; to take a collection, name it itself"));
    else if (!collections.empty())
        notices.message(join(directory.string(), ": ", collections.size(),
                             " collections or models, first ", collections.front(),
                             ", are not taken; to take a collection, name it itself"));
}

/// Each by itself: of two meshes that differ it is known which is the odd one.
void check_triangulation(const NamedMesh& known, const NamedMesh& mesh)
{
    const std::string difference = describe_correspondence_break(known, mesh);
    if (!difference.empty())
        throw InvalidInput(join("another triangulation than ", known.path, "; ", difference));
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

/// a, b, a becomes a, b, a (2).
void number_repeated_names(std::vector<NamedMesh>& meshes)
{
    std::set<std::string> taken;
    std::map<std::string, int> numbers; // the last one of a name that many have
    for (NamedMesh& mesh : meshes) {
        const std::string name = mesh.name;
        while (!taken.insert(mesh.name).second)
            mesh.name = join(name, " (", ++numbers.try_emplace(name, 1).first->second, ")");
    }
}

} // namespace

void add_mesh_input(CLI::App& command, MeshInput& input, const std::string& name)
{
    command
        .add_option(name, input.paths,
                    "Mesh files (.obj .ply .off .stl .vtk .vtp .glb), directories (their mesh\n"
                    "files in natural name order) and collection files (.h5), in any mix")
        ->required()
        ->option_text("PATH ... REQUIRED");
    command.add_flag(
        "--triangulate", input.triangulate,
        "Cut polygons into triangles: as fans from their first corner, or by ears where a fan\n"
        "would fold over; all meshes as the first one (default: refuse them)");
}

std::optional<NamesAlike> find_names_alike(const std::vector<std::string>& names,
                                           const std::vector<std::string>& paths)
{
    const auto alike = names_alike(names);
    if (!alike)
        return std::nullopt;
    return NamesAlike{
        alike->first, alike->second,
        join("the names of '", paths[alike->first], "' and '", paths[alike->second],
             "' differ by outer blanks, endings or the composition of accents alone: a table of "
             "labels cannot tell them apart unless it spells them so; rename one of them")};
}

Labels labels_of(const MeshNotices& notices, const std::string& path,
                 const std::vector<std::string>& names)
{
    LabelFile file = read_label_file(path, names);
    if (!file.unused.empty())
        notices.message(join(path, ": ", counted(file.unused.size(), "row"),
                             " of meshes that are not among these left out, first '",
                             file.unused.front(), "'"));
    if (!file.nameless.empty())
        notices.message(join(path, ": ", counted(file.nameless.size(), "column"),
                             " without a name left out, first column ", file.nameless.front() + 1));
    for (const std::string& sentence : doubts_about(file.labels))
        notices.warn(join(path, ": ", sentence));
    return std::move(file.labels);
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
            const std::vector<fs::path> members = mesh_files_of_directory(path, input);
            files.insert(files.end(), members.begin(), members.end());
        } else {
            files.push_back(path);
        }
    }
    return files;
}

void note_passed_over(const MeshNotices& notices, const MeshInput& input)
{
    for (const fs::path path : input.paths)
        if (fs::is_directory(path))
            note_files_passed_over(notices, path, input);
    for (const fs::path path : input.paths) {
        if (!fs::is_directory(path))
            continue;
        const MeshesBelow below = meshes_below(path, input);
        if (below.count > 0)
            notices.message(join(path.string(), ": ", describe(below),
                                 " not taken; to take them too, ", way_to_take(path, below)));
        if (!below.unreadable.empty())
            notices.warn(join(path.string(), ": ", describe_unreadable(path, below)));
    }
}

std::vector<fs::path> input_files(const MeshInput& input)
{
    std::vector<fs::path> files = mesh_files(input);
    if (!input.labels.empty())
        files.emplace_back(input.labels);
    return files;
}

FileContent read_mesh_file(const fs::path& path, bool triangulate, PolygonCuts* cuts)
{
    FileContent content;
    if (!is_collection_file(path)) {
        MeshFileContent file = read_mesh_members(path, {.triangulate = triangulate, .cuts = cuts});
        return {.meshes = std::move(file.meshes),
                .labels = {},
                .single_precision = file.single_precision,
                .merged_corners = file.merged_corners};
    }
    Collection collection = read_collection(path);
    if (cuts != nullptr && triangulate)
        add_triangulation(*cuts, {collection.names.front(), path.string(),
                                  collection.points.front(), collection.topology.faces()});
    for (std::size_t i = 0; i < collection.size(); ++i)
        content.meshes.push_back({collection.names[i],
                                  join(path.string(), ": mesh ", collection.names[i]),
                                  std::move(collection.points[i]), collection.topology.faces()});
    content.labels = std::move(collection.labels);
    return content;
}

void FormatNotes::add(const fs::path& path, const FileContent& content)
{
    if (content.single_precision && single_++ == 0)
        first_single_ = path.string();
    if (content.merged_corners > 0 && merged_++ == 0)
        first_merged_ = join(path.string(), ": ", content.merged_corners, " corners, ",
                             content.meshes.front().points.rows(), " vertices");
}

void FormatNotes::say(const MeshNotices& notices) const
{
    if (merged_ > 0)
        notices.message(
            join("STL: corners of equal coordinates became one vertex, in the order of "
                 "first appearance, in ",
                 counted(merged_, "file"), " (", first_merged_, ")"));
    if (single_ > 0)
        notices.message(join("single precision (float32, about 7 digits) in ",
                             counted(single_, "file"), ", first ", first_single_));
}

MeshNotices notices_of(const Session& session)
{
    return {.message = [&session](const std::string& text) { session.message(text); },
            .warn = [&session](const std::string& text) { session.warn(text); },
            .progress = session.progress()};
}

Collection read_meshes(const Session& session, const MeshInput& input)
{
    return read_meshes(notices_of(session), input);
}

std::string advice_on(const Oddity& oddity)
{
    switch (oddity.kind) {
        case OddityKind::Seam:
        case OddityKind::Mirrored:
            return oddity.message + ": `shape check MESHES --fix DIR`";
        case OddityKind::InsideOut:
            return oddity.message + ", or `shape check MESHES --fix DIR`";
        case OddityKind::Size:
            return oddity.message +
                   " (`shape check MESHES --fix DIR` scales by 10, 100 and 1000 where that leaves "
                   "no "
                   "doubt)";
        case OddityKind::NearSeam:
        case OddityKind::Bent:
        case OddityKind::Stretched:
        case OddityKind::Copies:
        case OddityKind::Coarse:
            break;
    }
    return oddity.message;
}

Collection read_meshes(const MeshNotices& notices, const MeshInput& input)
{
    const std::vector<fs::path> files = mesh_files(input);
    note_passed_over(notices, input);
    if (files.size() == 1 && is_collection_file(files.front())) {
        Collection collection = read_single_collection(files.front());
        if (input.known)
            check_triangulation(*input.known,
                                {collection.names.front(),
                                 join(files.front().string(), ": mesh ", collection.names.front()),
                                 collection.points.front(), collection.topology.faces()});
        if (!input.labels.empty())
            collection.labels = labels_of(notices, input.labels, collection.names);
        return collection;
    }
    PolygonCuts cuts;
    if (input.known && input.triangulate)
        add_triangulation(cuts, *input.known);
    std::vector<NamedMesh> meshes;
    Labels labels;
    FormatNotes notes;
    const auto read_all = [&] {
        meshes.clear();
        labels.clear();
        notes = {};
        for (std::size_t i = 0; i < files.size(); ++i) {
            FileContent content = read_mesh_file(files[i], input.triangulate, &cuts);
            notes.add(files[i], content);
            append_labels(labels, meshes.size(), content.labels, content.meshes.size());
            std::move(content.meshes.begin(), content.meshes.end(), std::back_inserter(meshes));
            if (notices.progress)
                notices.progress("reading", i + 1, files.size());
        }
    };
    read_all();
    if (auto better = better_cuts(cuts)) {
        cuts = std::move(*better);
        read_all();
    }
    notes.say(notices);
    for (const PolygonCuts::Folded& folded : cuts.folded)
        notices.warn(folded.message);
    if (input.known)
        for (const NamedMesh& mesh : meshes)
            check_triangulation(*input.known, mesh);
    if (input.may_repeat)
        number_repeated_names(meshes);
    std::vector<std::string> names;
    std::vector<std::string> paths;
    for (const NamedMesh& mesh : meshes) {
        names.push_back(mesh.name);
        paths.push_back(mesh.path);
    }
    if (const auto alike = find_names_alike(names, paths))
        notices.warn(alike->message);
    Collection collection = collect(std::move(meshes));
    collection.labels =
        input.labels.empty() ? labels : labels_of(notices, input.labels, collection.names);
    for (const Oddity& oddity : find_oddities(collection)) {
        const bool is_of_each = oddity.kind == OddityKind::Seam ||
                                oddity.kind == OddityKind::NearSeam ||
                                oddity.kind == OddityKind::Coarse;
        const bool is_copy = oddity.kind == OddityKind::Copies;
        if (is_of_each || (is_copy ? !input.may_repeat : !input.known))
            notices.warn(advice_on(oddity));
    }
    return collection;
}

} // namespace shape::tools
