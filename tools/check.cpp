// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/conformal/sphere_map.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/edge_lengths.h"
#include "tools/commands.h"
#include "tools/input/mesh_input.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    MeshInput meshes;
    std::int64_t limit = 20;
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

std::vector<CheckedMesh> check_all(const Session& session, const Arguments& arguments)
{
    const Progress progress = session.progress();
    const std::vector<std::filesystem::path> files = mesh_files(arguments.meshes);
    std::vector<CheckedMesh> checked;
    std::optional<NamedMesh> reference; // the first mesh that can be read
    std::set<std::string> names;
    for (std::size_t i = 0; i < files.size(); ++i) {
        progress("checking", i, files.size());
        FileContent content;
        try {
            content = read_mesh_file(files[i], arguments.meshes.triangulate);
        } catch (const InvalidInput& error) {
            checked.push_back({files[i].stem().string(),
                               files[i].string(),
                               {{"unreadable", -1, -1, error.what()}},
                               "the mesh cannot be read"});
        }
        for (const NamedMesh& mesh : content.meshes) {
            if (!reference)
                reference = mesh;
            checked.push_back({mesh.name, mesh.path,
                               find_all(mesh, *reference, static_cast<int>(arguments.limit))});
            checked.back().no_sphere = why_no_sphere(mesh, checked.back().findings);
            if (!names.insert(mesh.name).second)
                checked.back().findings.push_back(
                    {"repeated_name", -1, -1,
                     join("the name '", mesh.name, "' occurs twice; rename one of the files")});
        }
    }
    progress("checking", files.size(), files.size());
    return checked;
}

std::string print(const std::vector<CheckedMesh>& checked)
{
    std::string text;
    for (const CheckedMesh& mesh : checked) {
        text += join(mesh.path, ": ", mesh.findings.empty() ? "ok" : "broken", "\n");
        for (const Finding& finding : mesh.findings)
            text += join("  ", finding.kind, ": ", finding.message, "\n");
        text += mesh.no_sphere.empty()
                    ? "  conformal map to the sphere: qualifies\n"
                    : join("  conformal map to the sphere: no, ", mesh.no_sphere, "\n");
    }
    return text;
}

Json figures(const std::vector<CheckedMesh>& checked)
{
    Json meshes = Json::array();
    for (const CheckedMesh& mesh : checked) {
        Json defects = Json::array();
        for (const Finding& finding : mesh.findings)
            defects.push_back({{"kind", finding.kind},
                               {"face", finding.face},
                               {"vertex", finding.vertex},
                               {"message", finding.message}});
        meshes.push_back({{"name", mesh.name},
                          {"path", mesh.path},
                          {"ok", mesh.findings.empty()},
                          {"defects", defects},
                          {"conformal_sphere", mesh.no_sphere.empty()},
                          {"no_conformal_sphere", mesh.no_sphere}});
    }
    return meshes;
}

void run(const Session& session, const Arguments& arguments)
{
    const std::vector<CheckedMesh> checked = check_all(session, arguments);
    const auto is_broken = [](const CheckedMesh& mesh) { return !mesh.findings.empty(); };
    const auto broken = std::count_if(checked.begin(), checked.end(), is_broken);
    if (!session.json)
        session.print(print(checked));
    session.print_figures({{"meshes", figures(checked)}, {"broken", broken}});
    if (broken == 0)
        return;
    const auto first = std::find_if(checked.begin(), checked.end(), is_broken);
    const std::string& message = first->findings.front().message;
    const bool names_file = message.starts_with(first->path);
    throw InvalidInput(join(broken, " of ", counted(checked.size(), "mesh", "meshes"),
                            broken == 1 ? " is" : " are", " broken, first ",
                            names_file ? "" : first->path + ": ", message));
}

} // namespace

Run set_up_check(CLI::App& command)
{
    command.description(
        "Say which mesh breaks what, where, and how it could be repaired: syntax, indices,\n"
        "manifold edges and vertices, orientation, one component, degenerate triangles, the\n"
        "inequalities of edge-length space, and correspondence with the first mesh. Says\n"
        "also which meshes `shape conformal` can map to the sphere, and why not. Indices count\n"
        "from 0. The exit code is 3 if anything is broken.");
    command.footer("Example:\n  shape check faces/ --json");
    const auto arguments = std::make_shared<Arguments>();
    add_mesh_input(command, arguments->meshes);
    add_integer(command, "--limit", arguments->limit,
                "List at most this many defects of each kind and mesh, [1, 1000000] (default: 20)",
                1, 1'000'000);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
