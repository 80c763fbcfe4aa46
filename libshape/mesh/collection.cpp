// SPDX-License-Identifier: MIT

#include "libshape/mesh/collection.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>
#include <span>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/coincident_vertices.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/handedness.h"
#include "libshape/mesh/other_diagonals.h"
#include "libshape/mesh/partition.h"

namespace shape {
using namespace internal;
namespace {

using Triple = std::array<int, 3>;

/// The face starting at its lowest vertex: equal for equal faces with equal orientation.
Triple rotated_face(const Faces& faces, Eigen::Index f)
{
    Triple t{faces(f, 0), faces(f, 1), faces(f, 2)};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
}

Triple flipped(Triple t)
{
    std::swap(t[1], t[2]);
    return t;
}

std::multiset<Triple> face_set(const Faces& faces)
{
    std::multiset<Triple> set;
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        set.insert(rotated_face(faces, f));
    return set;
}

std::vector<int> sorted_degrees(const Faces& faces, Eigen::Index vertex_count)
{
    std::vector<int> degree(to_size(vertex_count), 0);
    for (const int v : faces.reshaped())
        if (v >= 0 && v < vertex_count)
            ++degree[to_size(v)];
    std::sort(degree.begin(), degree.end());
    return degree;
}

std::string print_face(const Faces& faces, Eigen::Index f)
{
    return join("(", faces(f, 0), ", ", faces(f, 1), ", ", faces(f, 2), ")");
}

/// All faces are reversed: the mesh is inside out, or it is a mirror image, sound in itself.
std::string cause_of_flipped_faces(const NamedMesh& reference, const NamedMesh& mesh)
{
    std::string cause = "the orientation of every face is flipped; ";
    const Handedness found = [&]() -> Handedness {
        try {
            const Topology topology(reference.faces, static_cast<int>(reference.points.rows()));
            return compare_handedness(topology, std::array{reference.points, mesh.points});
        } catch (const InvalidInput&) { // the reference is broken: a thing of its own
            return {};
        }
    }();
    if (!found.mirrored.empty())
        return cause +
               "the mesh is a mirror image: mirror it back (one coordinate times -1) and reverse "
               "its faces; reversing alone would let a mirror image pass";
    if (!found.bent.empty())
        return cause +
               "the mesh is a mirror image or bends the other way, which such surfaces do not "
               "tell: reverse its faces, and mirror it back (one coordinate times -1) if it is one";
    return cause + "the mesh is inside out: reverse its faces";
}

constexpr std::string_view way_to_share_diagonals =
    "; read the files that have the polygons (option triangulate), which are then cut as in the "
    "reference, or cut them in one way in all files (not by their shape)";

/// "12 quads are cut along their other diagonal, first that of vertices 0, 1, 5, 4".
std::string describe(const OtherDiagonals& diagonals)
{
    constexpr std::size_t most = 8;
    const bool are_quads = diagonals.quads == diagonals.polygons;
    std::string text = join(counted(diagonals.polygons, are_quads ? "quad" : "polygon"),
                            diagonals.polygons == 1 ? " is" : " are", " cut along ",
                            !are_quads                ? "other diagonals"
                            : diagonals.polygons == 1 ? "the other diagonal"
                                                      : "their other diagonal",
                            diagonals.polygons == 1 ? " (vertices " : ", first that of vertices ",
                            diagonals.first.front());
    for (std::size_t i = 1; i < std::min(most, diagonals.first.size()); ++i)
        text += join(", ", diagonals.first[i]);
    return join(text, diagonals.first.size() > most ? ", ..." : "",
                diagonals.polygons == 1 ? ")" : "");
}

/// The likely cause of two different face lists of the same size over as many vertices.
std::string likely_cause(const NamedMesh& reference, const NamedMesh& mesh)
{
    const std::multiset<Triple> wanted = face_set(reference.faces);
    const std::multiset<Triple> got = face_set(mesh.faces);
    if (wanted == got)
        return "the same faces stand in another order or start at another corner; write them as in "
               "the reference";
    std::multiset<Triple> mirrored;
    for (const Triple& t : got)
        mirrored.insert(flipped(t));
    if (wanted == mirrored)
        return cause_of_flipped_faces(reference, mesh);
    const auto common =
        std::count_if(got.begin(), got.end(), [&](const Triple& t) { return wanted.contains(t); });
    const auto total = static_cast<std::ptrdiff_t>(got.size());
    const auto flips = std::count_if(got.begin(), got.end(), [&](const Triple& t) {
        return !wanted.contains(t) && wanted.contains(flipped(t));
    });
    if (common + flips == total)
        return join(counted(flips, "face"), " flipped; orient all as in the reference");
    if (const auto diagonals = other_diagonals(reference.faces, mesh.faces))
        return join(describe(*diagonals), way_to_share_diagonals);
    Faces turned = mesh.faces;
    turned.col(1).swap(turned.col(2));
    if (const auto diagonals = other_diagonals(reference.faces, turned))
        return join("the orientation of every face is flipped, and ", describe(*diagonals),
                    "; reverse the faces and ", way_to_share_diagonals.substr(2));
    if (sorted_degrees(reference.faces, reference.points.rows()) ==
        sorted_degrees(mesh.faces, mesh.points.rows()))
        return "the vertices are probably permuted (the vertex degrees agree as a set); restore "
               "their order";
    if (2 * common >= total)
        return join(total - common,
                    " faces connect other vertices, and not only along other diagonals of the same "
                    "polygons; remesh all from one template");
    return "the meshes have another connectivity; remesh them from one template";
}

/// What find_defects() lists, and how many pieces hang together through edges.
struct Brokenness
{
    std::size_t defects;
    std::ptrdiff_t pieces;
};

Brokenness brokenness_of(const Faces& faces, int vertex_count)
{
    Partition pieces(to_size(faces.rows()));
    std::map<std::pair<int, int>, int> face_at;
    for (int f = 0; f < faces.rows(); ++f)
        for (int c = 0; c < 3; ++c) {
            const std::pair<int, int> edge = std::minmax({faces(f, c), faces(f, (c + 1) % 3)});
            pieces.unite(f, face_at.try_emplace(edge, f).first->second);
        }
    std::ptrdiff_t count = 0;
    for (int f = 0; f < faces.rows(); ++f)
        count += pieces.root(f) == f ? 1 : 0;
    return {find_defects(faces, vertex_count, std::numeric_limits<int>::max()).size(), count};
}

/// Whether a surface that Topology refuses comes nearer to one that it takes by welding what lies on one another.
/// Pieces and fans may; a face that is turned, say, stays so.
bool is_split(const NamedMesh& mesh)
{
    const auto count = static_cast<int>(mesh.points.rows());
    const std::vector<Defect> defects = find_defects(mesh.faces, count, 1);
    if (!mesh.points.allFinite() || (defects.front().kind != DefectKind::BowTie &&
                                     defects.front().kind != DefectKind::SeveralComponents))
        return false;
    const VertexChoice welded =
        weld(mesh.faces, count, seam_vertices(mesh.faces, std::span(&mesh.points, 1)).coincident);
    if (welded.faces.rows() == 0)
        return false;
    const Brokenness before = brokenness_of(mesh.faces, count);
    const Brokenness after = brokenness_of(welded.faces, static_cast<int>(welded.vertices.size()));
    return after.defects <= before.defects && after.pieces <= before.pieces &&
           (after.defects < before.defects || after.pieces < before.pieces);
}

} // namespace

Collection subset(const Collection& collection, const std::vector<std::size_t>& meshes)
{
    Collection result{collection.topology, {}, {}, {}};
    for (const LabelColumn& column : collection.labels)
        result.labels.push_back({column.name, {}});
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const std::size_t mesh = meshes[i];
        if (mesh >= collection.size())
            throw InvalidInput(
                join("meshes[", i, "] is ", mesh, ", must be in [0, ", collection.size(), ")"));
        result.names.push_back(collection.names[mesh]);
        result.points.push_back(collection.points[mesh]);
        for (std::size_t c = 0; c < result.labels.size(); ++c)
            result.labels[c].values.push_back(collection.labels[c].values[mesh]);
    }
    return result;
}

std::string describe_correspondence_break(const NamedMesh& reference, const NamedMesh& mesh)
{
    // Of two meshes in one file the path does not say which.
    const auto place_of = [&](const NamedMesh& one) {
        return reference.path == mesh.path ? join(one.path, ": mesh ", one.name) : one.path;
    };
    if (reference.points.rows() != mesh.points.rows() ||
        reference.faces.rows() != mesh.faces.rows())
        return join(place_of(mesh), ": ", mesh.points.rows(), " vertices and ",
                    counted(mesh.faces.rows(), "face"), ", but ", place_of(reference), " has ",
                    reference.points.rows(), " and ", reference.faces.rows(),
                    "; members of a collection need one triangulation (different counts)");
    if (reference.faces == mesh.faces)
        return {};
    Eigen::Index f = 0;
    while (reference.faces.row(f) == mesh.faces.row(f))
        ++f;
    return join(place_of(mesh), ": face ", f, " is ", print_face(mesh.faces, f), ", in ",
                place_of(reference), " it is ", print_face(reference.faces, f), "; ",
                likely_cause(reference, mesh));
}

Collection collect(std::vector<NamedMesh> meshes)
{
    if (meshes.empty())
        throw InvalidInput("a collection needs at least one mesh");
    const NamedMesh& reference = meshes.front();
    const auto topology = [&] {
        try {
            return Topology(reference.faces, static_cast<int>(reference.points.rows()));
        } catch (const InvalidInput& error) {
            const std::string said = join(reference.path, ": ", error.what());
            if (is_split(reference))
                throw SplitSurface(said + describe_coincident(reference.faces, reference.points));
            throw InvalidInput(said);
        }
    }();
    Collection collection{topology, {}, {}, {}};
    std::set<std::string> seen;
    for (const NamedMesh& mesh : meshes) {
        throw_if_stop_requested();
        const std::string difference = describe_correspondence_break(reference, mesh);
        if (!difference.empty())
            throw InvalidInput(difference);
        const std::vector<Defect> defects = find_degenerate_geometry(mesh.faces, mesh.points, 1);
        if (!defects.empty())
            throw InvalidInput(mesh.path + ": " + defects.front().message);
        if (!seen.insert(mesh.name).second)
            throw InvalidInput(join(mesh.path, ": the name '", mesh.name,
                                    "' occurs twice; names of a collection must differ: rename one "
                                    "of the files"));
    }
    for (NamedMesh& mesh : meshes) {
        collection.names.push_back(std::move(mesh.name));
        collection.points.push_back(std::move(mesh.points));
    }
    return collection;
}

} // namespace shape
