// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <span>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/rounded.h"
#include "libshape/conformal/sphere_map.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/io/mesh_endings.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/coincident_vertices.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/joined_labels.h"
#include "libshape/mesh/mesh_repair.h"
#include "libshape/mesh/oddities.h"
#include "libshape/model/outlying_meshes.h"
#include "tools/commands.h"
#include "tools/input/mesh_input.h"
#include "tools/output/mesh_output.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    MeshInput meshes;
    std::int64_t limit = 20;
    bool verbose = false;
    MeshOutputArguments fixed; ///< No path: nothing is repaired.
    Components components = Components::KeepMain;
};

/// Something that is wrong with a mesh, and where.
struct Finding
{
    std::string kind;
    int face = -1;
    int vertex = -1;
    std::string message;
};

struct CheckedMesh
{
    std::string name;
    std::string path;
    std::vector<Finding> findings;
    std::string no_sphere = {}; ///< Why it has no conformal map to the sphere; empty if it has.
    std::vector<Finding> warnings = {};
    bool is_readable = true;
    [[nodiscard]] bool is_broken() const { return !findings.empty(); }
};

/// All that is found: in single meshes, and in the sound ones together.
struct Result
{
    std::vector<CheckedMesh> meshes;
    std::vector<Finding> warnings;    ///< What concerns several meshes at once.
    std::optional<Topology> topology; ///< The topology that meshes in correspondence share.
    std::vector<NamedMesh> readable;
    Labels labels;                      ///< Of the readable ones, as collection files hold them.
    std::set<std::string> triangulated; ///< Paths of those that were split into triangles.
    std::vector<std::pair<std::string, std::string>> unreadable; ///< Names of the rest, and why.
};

const char* kind_name(DefectKind kind)
{
    switch (kind) {
        case DefectKind::Empty:
            return "empty";
        case DefectKind::IndexOutOfRange:
            return "index_out_of_range";
        case DefectKind::DegenerateFace:
            return "degenerate_face";
        case DefectKind::DuplicateFace:
            return "duplicate_face";
        case DefectKind::NonManifoldEdge:
            return "non_manifold_edge";
        case DefectKind::FlippedFace:
            return "flipped_face";
        case DefectKind::BowTie:
            return "bow_tie";
        case DefectKind::IsolatedVertex:
            return "isolated_vertex";
        case DefectKind::SeveralComponents:
            return "several_components";
        case DefectKind::NotFinite:
            return "not_finite";
        case DefectKind::DegenerateTriangle:
            return "degenerate_triangle";
        case DefectKind::SizeOutOfRange:
            return "size_out_of_range";
    }
    return "";
}

void append(std::vector<Finding>& findings, const std::vector<Defect>& defects)
{
    for (const Defect& defect : defects)
        findings.push_back({kind_name(defect.kind), defect.face, defect.vertex, defect.message});
}

/// The inequalities of edge-length space; a mesh without defects can break them by rounding alone.
void append_boundaries(std::vector<Finding>& findings, const NamedMesh& mesh)
{
    const Topology topology(mesh.faces, static_cast<int>(mesh.points.rows()));
    const Eigen::VectorXd lengths = edge_lengths(topology, mesh.points);
    const Admissibility found = check_admissibility(topology, lengths);
    if (!found.triangles.empty())
        findings.push_back({"triangle_inequality", found.triangles.front().face, -1,
                            describe({found.triangles, {}}, topology, lengths)});
    if (!found.vertices.empty())
        findings.push_back({"vertex_inequality", -1, found.vertices.front().vertex,
                            describe({{}, found.vertices}, topology, lengths)});
}

std::vector<Finding> find_all(const NamedMesh& mesh, const NamedMesh& reference, int limit)
{
    std::vector<Finding> findings;
    const std::vector<Defect> defects =
        find_defects(mesh.faces, static_cast<int>(mesh.points.rows()), limit);
    append(findings, defects);
    const bool has_triangles = std::none_of(defects.begin(), defects.end(), [](const Defect& d) {
        return d.kind == DefectKind::Empty || d.kind == DefectKind::IndexOutOfRange;
    });
    if (has_triangles)
        append(findings, find_degenerate_geometry(mesh.faces, mesh.points, limit));
    const auto split = std::ranges::find_if(findings, [](const Finding& finding) {
        return finding.kind == kind_name(DefectKind::SeveralComponents) ||
               finding.kind == kind_name(DefectKind::BowTie);
    });
    if (split != findings.end() && has_triangles)
        split->message += describe_coincident(mesh.faces, mesh.points);
    if (findings.empty())
        append_boundaries(findings, mesh);
    const std::string difference = describe_correspondence_break(reference, mesh);
    if (!difference.empty())
        findings.push_back({"correspondence", -1, -1, difference});
    return findings;
}

/// Whether `shape conformal` takes the mesh, which is not a matter of right or wrong.
std::string why_no_sphere(const NamedMesh& mesh, const std::vector<Finding>& findings)
{
    // A wrong correspondence or name is not a fault of the surface.
    const auto is_surface = [](const Finding& f) {
        return f.kind == "correspondence" || f.kind == "repeated_name";
    };
    if (!std::all_of(findings.begin(), findings.end(), is_surface))
        return "the mesh is broken; repair what is listed first";
    return why_not_spherical(Topology(mesh.faces, static_cast<int>(mesh.points.rows())));
}

const char* kind_name(OddityKind kind)
{
    switch (kind) {
        case OddityKind::Seam:
            return "seam";
        case OddityKind::NearSeam:
            return "near_seam";
        case OddityKind::Mirrored:
            return "mirrored";
        case OddityKind::Bent:
            return "bent";
        case OddityKind::InsideOut:
            return "inside_out";
        case OddityKind::Size:
            return "size";
        case OddityKind::Stretched:
            return "stretched";
        case OddityKind::Copies:
            return "copies";
        case OddityKind::Coarse:
            return "coarse";
    }
    return "";
}

/// Vertices of the boundary that lie on or near one another in single meshes only, as closed lips do.
void find_touching(const Collection& collection, const std::vector<std::size_t>& index,
                   Result& result)
{
    if (collection.topology.is_closed())
        return;
    for (std::size_t i = 0; i < collection.size(); ++i) {
        const SeamVertices seams =
            seam_vertices(collection.topology.faces(), std::span(collection.points).subspan(i, 1));
        std::size_t count = 0;
        int first = collection.topology.vertex_count();
        for (const auto* groups : {&seams.coincident, &seams.near})
            for (const VertexGroup& group : *groups) {
                count += group.size();
                first = std::min(first, group.front());
            }
        if (count > 0)
            result.meshes[index[i]].warnings.push_back(
                {"touching", -1, first,
                 join(count, " boundary vertices lie on others",
                      seams.near.empty()
                          ? ""
                          : join(" or up to ", rounded(seams.gap), " of the diagonal away"),
                      " in this mesh, first vertex ", first, "; blends open them there")});
    }
}

/// Two names that are one to a table of labels.
void check_names(Result& result)
{
    std::vector<std::string> names;
    std::vector<std::string> paths;
    for (const CheckedMesh& mesh : result.meshes) {
        names.push_back(mesh.name);
        paths.push_back(mesh.path);
    }
    const auto alike = find_names_alike(names, paths);
    if (!alike)
        return;
    const Finding finding{"names_alike", -1, -1, alike->message};
    result.warnings.push_back(finding);
    for (const std::size_t i : {alike->first, alike->second})
        result.meshes[i].warnings.push_back(finding);
}

/// What is odd about the sound meshes together.
void check_together(Result& result)
{
    std::vector<NamedMesh> sound;
    std::vector<std::size_t> index; // into result.meshes
    for (std::size_t i = 0, next = 0; i < result.meshes.size(); ++i) {
        if (!result.meshes[i].is_readable)
            continue;
        NamedMesh& mesh = result.readable[next++];
        if (result.meshes[i].is_broken())
            continue;
        sound.push_back(mesh);
        index.push_back(i);
    }
    if (sound.empty())
        return;
    const Collection collection = collect(std::move(sound));
    result.topology = collection.topology;
    const auto warn = [&](const char* kind, const std::vector<std::size_t>& meshes, int vertex,
                          const std::string& message) {
        result.warnings.push_back({kind, -1, vertex, message});
        for (const std::size_t i : meshes)
            result.meshes[index[i]].warnings.push_back({kind, -1, vertex, message});
    };
    bool has_seam = false;
    std::set<std::size_t> stretched; // which is why they are far from the others
    for (const Oddity& oddity : find_oddities(collection)) {
        warn(kind_name(oddity.kind), oddity.meshes, -1, advice_on(oddity));
        if (oddity.kind == OddityKind::Stretched)
            stretched.insert(oddity.meshes.begin(), oddity.meshes.end());
        has_seam =
            has_seam || oddity.kind == OddityKind::Seam || oddity.kind == OddityKind::NearSeam;
    }
    if (!has_seam)
        find_touching(collection, index, result);
    for (const OutlyingMesh& outlier : find_outlying_meshes(collection))
        if (!stretched.contains(outlier.mesh))
            warn("outlier", {outlier.mesh}, outlier.vertex, outlier.message);
}

/// Warns of polygons that fold over as they are cut.
void check_folded(const PolygonCuts& cuts, Result& result)
{
    for (const PolygonCuts::Folded& folded : cuts.folded) {
        const Finding finding{"folded", -1, -1, folded.message};
        result.warnings.push_back(finding);
        for (CheckedMesh& mesh : result.meshes)
            if (mesh.path == folded.path)
                mesh.warnings.push_back(finding);
    }
}

/// @param cuts  How polygons are cut; what is read is added to it.
Result check_all(const Session& session, const Arguments& arguments, PolygonCuts& cuts)
{
    const Progress progress = session.progress();
    const std::vector<std::filesystem::path> files = mesh_files(arguments.meshes);
    const MeshNotices notices = notices_of(session);
    Result result;
    std::set<std::string> names;
    FormatNotes notes;
    for (std::size_t i = 0; i < files.size(); ++i) {
        progress("checking", i, files.size());
        FileContent content;
        const auto cannot_be_read = [&](const std::exception& error) {
            result.meshes.push_back({files[i].stem().string(),
                                     files[i].string(),
                                     {{"unreadable", -1, -1, error.what()}},
                                     "the mesh cannot be read"});
            result.meshes.back().is_readable = false;
        };
        try {
            content = read_mesh_file(files[i], arguments.meshes.triangulate, &cuts);
            notes.add(files[i], content);
        } catch (const InvalidInput& error) {
            cannot_be_read(error);
        } catch (const LimitExceeded& error) { // of this file; the others are checked all the same
            cannot_be_read(error);
        }
        append_labels(result.labels, result.readable.size(), content.labels, content.meshes.size());
        for (NamedMesh& mesh : content.meshes) {
            // The first mesh that can be read is what the others are compared with.
            const NamedMesh& reference = result.readable.empty() ? mesh : result.readable.front();
            CheckedMesh& checked = result.meshes.emplace_back(
                CheckedMesh{mesh.name, mesh.path,
                            find_all(mesh, reference, static_cast<int>(arguments.limit))});
            checked.no_sphere = why_no_sphere(mesh, checked.findings);
            if (!names.insert(mesh.name).second)
                checked.findings.push_back(
                    {"repeated_name", -1, -1,
                     join("the name '", mesh.name, "' occurs twice; rename one of the files")});
            result.readable.push_back(std::move(mesh));
        }
    }
    progress("checking", files.size(), files.size());
    if (auto better = better_cuts(cuts)) {
        cuts = std::move(*better);
        return check_all(session, arguments, cuts);
    }
    note_passed_over(notices, arguments.meshes);
    notes.say(notices);
    check_folded(cuts, result);
    check_names(result);
    check_together(result);
    return result;
}

std::ptrdiff_t count_broken(const Result& result)
{
    return std::ranges::count_if(result.meshes, &CheckedMesh::is_broken);
}

std::ptrdiff_t count_suspicious(const Result& result)
{
    return std::ranges::count_if(result.meshes, [](const CheckedMesh& mesh) {
        return !mesh.is_broken() && !mesh.warnings.empty();
    });
}

/// The surface that the sound meshes share.
std::string print(const Topology& topology, const Result& result)
{
    std::string text = join(
        "surface: ", counted(topology.vertex_count(), "vertex", "vertices"), ", ",
        counted(topology.edge_count(), "edge"), ", ", counted(topology.face_count(), "face"), ", ",
        topology.is_closed() ? "closed" : counted(topology.boundary_loop_count(), "boundary loop"),
        ", genus ", topology.genus(), "\n");
    const auto sound = std::ranges::find_if(
        result.meshes, [](const CheckedMesh& mesh) { return !mesh.is_broken(); });
    return text + (sound->no_sphere.empty()
                       ? "conformal map to the sphere: qualifies\n"
                       : join("conformal map to the sphere: no, ", sound->no_sphere, "\n"));
}

std::string print(const CheckedMesh& mesh)
{
    std::string text;
    for (const Finding& finding : mesh.findings)
        text += join("  ", finding.kind, ": ", finding.message, "\n");
    for (const Finding& warning : mesh.warnings)
        text += warning.kind == "touching"
                    ? join("  warning: ", warning.kind, ": ", warning.message, "\n")
                    : join("  warning: ", warning.kind, " (above)\n");
    return text;
}

/// What is said of a mesh, wherever its path stands in it.
std::string without(const std::string& path, std::string text)
{
    if (!path.empty())
        for (std::size_t at = text.find(path); at != text.npos; at = text.find(path, at))
            text.erase(at, path.size());
    return text;
}

/// "  and 3 more, alike: a.ply, b.ply and c.ply".
std::string print_alike(const std::vector<std::string>& paths)
{
    return join("  and ", paths.size(), " more, alike: ", list_names(paths), "\n");
}

/// A summary, then the meshes that something is wrong with, those alike together; with `verbose` each by itself, and the
/// good ones.
std::string print(const Result& result, bool verbose)
{
    const auto broken = count_broken(result);
    const auto suspicious = count_suspicious(result);
    const auto sound = std::ssize(result.meshes) - broken - suspicious;
    std::string text = join(counted(result.meshes.size(), "mesh", "meshes"), ": ", sound, " ok, ",
                            suspicious, " with warnings, ", broken, " broken\n");
    if (result.topology)
        text += print(*result.topology, result);
    for (const Finding& warning : result.warnings)
        text += join("warning: ", warning.kind, ": ", warning.message, "\n");
    struct Shown
    {
        const CheckedMesh* mesh;
        std::string found;
        std::vector<std::string> alike; ///< Paths of other broken meshes of which the same is said.
    };
    std::vector<Shown> shown;
    std::map<std::string, std::size_t> first; // what is said of a broken mesh, without its path
    for (const CheckedMesh& mesh : result.meshes) {
        const bool has_own = std::ranges::any_of(
            mesh.warnings, [](const Finding& warning) { return warning.kind == "touching"; });
        if (!verbose && !mesh.is_broken() && !has_own)
            continue;
        std::string found = print(mesh);
        if (!verbose && mesh.is_broken()) {
            const auto [place, is_new] = first.try_emplace(without(mesh.path, found), shown.size());
            if (!is_new) {
                shown[place->second].alike.push_back(mesh.path);
                continue;
            }
        }
        shown.push_back({&mesh, std::move(found), {}});
    }
    for (const auto& [mesh, found, alike] : shown) {
        text += join(mesh->path, ": ",
                     mesh->is_broken()         ? "broken"
                     : !mesh->warnings.empty() ? "ok, with warnings"
                                               : "ok",
                     "\n", found);
        if (!alike.empty())
            text += print_alike(alike);
        if (verbose)
            text += mesh->no_sphere.empty()
                        ? "  conformal map to the sphere: qualifies\n"
                        : join("  conformal map to the sphere: no, ", mesh->no_sphere, "\n");
    }
    return text;
}

Json figures(const std::vector<Finding>& findings)
{
    Json list = Json::array();
    for (const Finding& finding : findings)
        list.push_back({{"kind", finding.kind},
                        {"face", finding.face},
                        {"vertex", finding.vertex},
                        {"message", finding.message}});
    return list;
}

Json figures(const Result& result)
{
    Json meshes = Json::array();
    for (const CheckedMesh& mesh : result.meshes)
        meshes.push_back({{"name", mesh.name},
                          {"path", mesh.path},
                          {"ok", !mesh.is_broken()},
                          {"defects", figures(mesh.findings)},
                          {"warnings", figures(mesh.warnings)},
                          {"conformal_sphere", mesh.no_sphere.empty()},
                          {"no_conformal_sphere", mesh.no_sphere}});
    return meshes;
}

/// Reads again, as triangles, what only polygons kept from being read.
/// @return  What folds over, a sentence a mesh.
std::vector<std::string> read_polygons(Result& result)
{
    std::vector<NamedMesh> readable;
    PolygonCuts cuts;
    if (!result.readable.empty()) // what the others are compared with
        add_triangulation(cuts, result.readable.front());
    std::size_t next = 0;
    for (const CheckedMesh& mesh : result.meshes) {
        if (mesh.is_readable) {
            readable.push_back(std::move(result.readable[next++]));
            continue;
        }
        try {
            FileContent content = read_mesh_file(mesh.path, true, &cuts);
            for (NamedMesh& split : content.meshes) {
                result.triangulated.insert(split.path);
                readable.push_back(std::move(split));
            }
        } catch (const InvalidInput& error) {
            result.unreadable.emplace_back(mesh.name, error.what());
        }
    }
    result.readable = std::move(readable);
    std::vector<std::string> folded;
    for (const Finding& warning : result.warnings)
        if (warning.kind == "folded")
            folded.push_back(warning.message);
    for (const PolygonCuts::Folded& mesh : cuts.folded)
        folded.push_back(mesh.message);
    return folded;
}

/// Which part of a mesh that was split this is, as repair_meshes() names them: parts correspond to the same
/// part of other meshes, not to each other.
std::string part_of(const std::string& name, Components components)
{
    const std::size_t at = name.rfind("_part");
    return components == Components::Split && at != std::string::npos ? name.substr(at) : "";
}

/// What --fix writes, and what it leaves.
struct Fixed
{
    std::vector<NamedMesh> sound;
    Json left = Json::array();
    std::string text; ///< Of what is left.

    void leave(const std::string& name, const std::string& place, bool is_written,
               const std::string& why)
    {
        left.push_back({{"name", name}, {"written", is_written}, {"message", why}});
        text += join("  left to repair: ", place,
                     is_written ? " (written): " : " (not written): ", why, "\n");
    }
};

/// The directory of --fix is none of the inputs', nor spelled as a file is.
void check_fix_directory(const Arguments& arguments)
{
    const std::filesystem::path directory = arguments.fixed.path;
    const std::string name = directory.filename().string();
    const bool is_file =
        without_mesh_ending(name) != name ||
        std::ranges::any_of(std::array{".h5", ".csv", ".json", ".html"},
                            [&](const char* ending) { return has_ending(directory, ending); });
    if (is_file && !std::filesystem::is_directory(directory))
        throw UsageError(join("--fix: '", directory.string(),
                              "' has the ending of a file; name a directory for the repaired "
                              "meshes, such as '",
                              std::filesystem::path(directory).replace_extension().string(), "'"));
    for (const std::filesystem::path& input : input_files(arguments.meshes)) {
        const std::filesystem::path parent = input.has_parent_path() ? input.parent_path() : ".";
        if (std::filesystem::exists(directory) && std::filesystem::equivalent(parent, directory))
            throw UsageError(
                join("--fix: '", directory.string(), "' holds the input; name another directory"));
    }
}

/// Takes out the meshes that have the name of one before them: one of a name can be written.
void take_out_repeated(std::vector<NamedMesh>& meshes, Fixed& fixed)
{
    std::map<std::string, std::string> path_of;
    std::vector<NamedMesh> others;
    for (NamedMesh& mesh : meshes) {
        const auto [first, is_new] = path_of.try_emplace(mesh.name, mesh.path);
        if (is_new)
            others.push_back(std::move(mesh));
        else
            fixed.leave(mesh.name, mesh.path, false,
                        join("repeated_name: the mesh of ", first->second, " is called '",
                             mesh.name, "' too; rename one of the files"));
    }
    meshes = std::move(others);
}

/// Keeps what can be written, and says what is left to repair.
void sort_out(std::vector<NamedMesh> meshes, const Arguments& arguments, Fixed& fixed)
{
    std::set<std::string> taken;
    std::map<std::string, std::size_t> first_of_part; // among the sound ones
    for (NamedMesh& mesh : meshes) {
        const std::string part = part_of(mesh.name, arguments.components);
        const auto first = first_of_part.find(part);
        const std::vector<Finding> findings =
            find_all(mesh, first == first_of_part.end() ? mesh : fixed.sound[first->second],
                     static_cast<int>(arguments.limit));
        const bool is_repeated = taken.contains(mesh.name);
        const bool is_sound = !is_repeated && std::ranges::all_of(findings, [](const Finding& f) {
            return f.kind == "correspondence";
        });
        if (!findings.empty() || is_repeated)
            fixed.leave(mesh.name, mesh.name, is_sound,
                        is_repeated ? "repeated_name: another mesh has this name"
                                    : findings.front().kind + ": " + findings.front().message);
        if (is_sound) {
            first_of_part.emplace(part, fixed.sound.size());
            taken.insert(mesh.name);
            fixed.sound.push_back(std::move(mesh));
        }
    }
}

/// The labels of the meshes that are written, by the names of their files.
Table label_table(const Labels& labels, const std::map<std::string, std::size_t>& rows,
                  const std::vector<NamedMesh>& meshes, const std::vector<std::string>& paths,
                  Components components)
{
    Table table{{"mesh"}, {}};
    for (const LabelColumn& column : labels)
        table.columns.push_back(column.name);
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const std::string& name = meshes[i].name;
        auto found = rows.find(name);
        if (found == rows.end()) // a part of a mesh
            found = rows.find(name.substr(0, name.size() - part_of(name, components).size()));
        std::vector<std::string> row{std::filesystem::path(paths[i]).stem().string()};
        for (const LabelColumn& column : labels)
            row.push_back(found == rows.end() ? "" : column.values[found->second]);
        table.rows.push_back(std::move(row));
    }
    return table;
}

/// Writes the meshes, and beside them the labels, if they have some; returns the paths.
std::vector<std::string> write_fixed(const Session& session, const Arguments& arguments,
                                     const Labels& labels,
                                     const std::map<std::string, std::size_t>& rows,
                                     const std::vector<NamedMesh>& meshes)
{
    if (meshes.empty())
        return {};
    std::vector<std::string> names;
    for (const NamedMesh& mesh : meshes)
        names.push_back(mesh.name);
    MeshOutputArguments place = arguments.fixed;
    place.path = (std::filesystem::path(place.path) / "").string();
    std::vector<std::string> further;
    if (!labels.empty())
        further.emplace_back("labels.csv");
    MeshOutput output(session, place, names, input_files(arguments.meshes), further);
    for (std::size_t i = 0; i < meshes.size(); ++i)
        output.write(i, meshes[i].points, meshes[i].faces);
    for (const std::string& file : further)
        write_table(output.staged(file),
                    label_table(labels, rows, meshes, output.paths(), arguments.components));
    output.commit();
    return output.paths();
}

/// A number that tells a mesh from what it was before.
std::uint64_t fingerprint(const NamedMesh& mesh)
{
    std::uint64_t hash = 1469598103934665603U; // FNV-1a, of words, whose upper bits it leaves above
    const auto add = [&](std::uint64_t word) {
        hash = (hash ^ word) * 1099511628211U;
        hash ^= hash >> 32U;
    };
    add(static_cast<std::uint64_t>(mesh.points.rows()));
    for (const double x : mesh.points.reshaped())
        add(std::bit_cast<std::uint64_t>(x));
    for (const int v : mesh.faces.reshaped())
        add(static_cast<std::uint64_t>(v));
    return hash;
}

/// The names of the meshes written that are not what was read.
std::vector<std::string> names_of_repaired(const std::vector<NamedMesh>& written,
                                           const std::map<std::string, std::uint64_t>& before,
                                           const std::vector<std::string>& triangulated)
{
    std::vector<std::string> names;
    for (const NamedMesh& mesh : written) {
        const auto was = before.find(mesh.name);
        if (was == before.end() || was->second != fingerprint(mesh) ||
            std::ranges::find(triangulated, mesh.name) != triangulated.end())
            names.push_back(mesh.name);
    }
    return names;
}

/// "repaired: m2 of 7 meshes; the others are as they were".
std::string describe_repaired(const std::vector<std::string>& names, std::size_t written)
{
    return join("  repaired: ", list_names(names), " of ", counted(written, "mesh", "meshes"),
                names.size() == written ? "" : "; the others are as they were", "\n");
}

/// Writes what can be repaired; returns the figures.
Json fix(const Session& session, const Arguments& arguments, Result& result)
{
    std::map<std::string, std::size_t> rows; // of the labels
    for (std::size_t i = 0; i < result.readable.size(); ++i)
        rows.emplace(result.readable[i].name, i);
    const std::vector<std::string> folded = read_polygons(result);
    Fixed fixed;
    for (const auto& [name, why] : result.unreadable)
        fixed.leave(name, name, false, why);
    take_out_repeated(result.readable, fixed);
    std::vector<std::string> triangulated;
    for (const NamedMesh& mesh : result.readable)
        if (result.triangulated.contains(mesh.path))
            triangulated.push_back(mesh.name);
    std::map<std::string, std::uint64_t> before;
    for (const NamedMesh& mesh : result.readable)
        before.emplace(mesh.name, fingerprint(mesh));
    RepairedMeshes repaired = repair_meshes(
        std::move(result.readable),
        {.components = arguments.components, .find_outliers = [](const Collection& collection) {
             std::vector<std::size_t> meshes;
             for (const OutlyingMesh& outlier : find_outlying_meshes(collection))
                 meshes.push_back(outlier.mesh);
             return meshes;
         }});
    if (!triangulated.empty()) {
        repaired.changes.insert(repaired.changes.begin(),
                                join(list_names(triangulated), ": polygons split into triangles"));
    }
    repaired.kept.insert(repaired.kept.end(), folded.begin(), folded.end());
    sort_out(std::move(repaired.meshes), arguments, fixed);
    const std::vector<std::string> outputs =
        write_fixed(session, arguments, result.labels, rows, fixed.sound);
    std::string list;
    for (const std::string& change : repaired.changes)
        list += join("  ", change, "\n");
    for (const std::string& odd : repaired.kept)
        fixed.text += join("  left as it is: ", odd, "\n");
    if (repaired.asks_for_components)
        fixed.text += "  --components largest or split chooses among the pieces\n";
    if (outputs.size() > fixed.sound.size())
        fixed.text += join("  labels: ", outputs.back(), ", for --labels: files of single meshes ",
                           "hold none\n");
    const std::vector<std::string> changed = names_of_repaired(fixed.sound, before, triangulated);
    if (!changed.empty())
        fixed.text += describe_repaired(changed, fixed.sound.size());
    session.message(join(arguments.fixed.path, ": ", counted(fixed.sound.size(), "mesh", "meshes"),
                         " written, ", counted(repaired.changes.size(), "change"),
                         repaired.changes.empty() ? "" : ":", "\n", list, fixed.text));
    return {{"outputs", outputs},
            {"repaired", changed},
            {"changes", repaired.changes},
            {"kept", repaired.kept},
            {"left", fixed.left}};
}

void run(const Session& session, const Arguments& arguments)
{
    if (!arguments.fixed.path.empty())
        check_fix_directory(arguments);
    PolygonCuts cuts;
    Result result = check_all(session, arguments, cuts);
    const auto broken = count_broken(result);
    if (!session.json)
        session.print(session.readable(print(result, arguments.verbose)));
    Json all{{"meshes", figures(result)},
             {"broken", broken},
             {"suspicious", count_suspicious(result)},
             {"warnings", figures(result.warnings)}};
    bool is_repaired = false;
    if (!arguments.fixed.path.empty()) {
        all["fix"] = fix(session, arguments, result);
        is_repaired = all["fix"]["left"].empty();
    }
    session.print_figures(all);
    if (broken == 0 || is_repaired)
        return;
    const auto first = std::ranges::find_if(result.meshes, &CheckedMesh::is_broken);
    const std::string& message = first->findings.front().message;
    const bool names_file = message.starts_with(first->path);
    throw InvalidInput(join(broken, " of ", counted(result.meshes.size(), "mesh", "meshes"),
                            broken == 1 ? " is" : " are", " broken, first ",
                            names_file ? "" : first->path + ": ", message,
                            arguments.fixed.path.empty() && first->is_readable
                                ? "; --fix DIR writes repaired copies where that is safe"
                                : ""));
}

} // namespace

Run set_up_check(CLI::App& command)
{
    command.description(
        "Say which mesh breaks what, where, and how it could be repaired: syntax, indices,\n"
        "manifold edges and vertices, orientation, one component, degenerate triangles, the\n"
        "inequalities of edge-length space, and correspondence with the first mesh. Warns of what\n"
        "is seldom meant: seams (vertices that lie on or near one another), mirror images, sheets\n"
        "that bend the other way, surfaces that are inside out, sizes in other units, copies,\n"
        "coarse coordinates, meshes far from all others, names that tables of labels take for\n"
        "one. Says also whether `shape conformal` can map the surface to the sphere. Indices\n"
        "count from 0. The exit code is 3 if anything is broken, with --fix if something is left\n"
        "to repair; warnings alone leave it 0.");
    command.footer(
        "Examples:\n"
        "  shape check faces/ --verbose\n"
        "  shape check faces/ --fix repaired/");
    const auto arguments = std::make_shared<Arguments>();
    add_mesh_input(command, arguments->meshes);
    add_integer(command, "--limit", arguments->limit,
                "List at most this many defects of each kind and mesh, [1, 1000000] (default: 20)",
                1, 1'000'000);
    command.add_flag("--verbose", arguments->verbose, "List the good meshes as well");
    command
        .add_option(
            "--fix", arguments->fixed.path,
            "Write repaired copies of the meshes into this directory and list what was done:\n"
            "polygons split, seams welded, repeated faces and vertices without a face taken\n"
            "away, faces turned, pieces chosen, mirror images and surfaces that are inside out\n"
            "turned back, millimetres, centimetres and metres made one. What would be a guess is\n"
            "left and said: inches and feet, meshes far from all others, sheets that bend the\n"
            "other way, patches that nearly meet, pieces of like size. Meshes in correspondence\n"
            "stay so; labels go into labels.csv")
        ->option_text("DIR");
    add_choice(
        command, "--components", arguments->components,
        "With --fix, of a surface in several pieces: main: keep the one with the most faces, if "
        "no\n"
        "other has half of them or a fifth of all (default); largest: keep it whatever the others\n"
        "have; split: write each as a mesh of its own",
        {{"main", Components::KeepMain},
         {"largest", Components::KeepLargest},
         {"split", Components::Split}})
        ->needs(command.get_option("--fix"));
    add_mesh_format(command, arguments->fixed);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
