// SPDX-License-Identifier: MIT

#include "libshape/mesh/mesh_repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/rounded.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/coincident_vertices.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/handedness.h"
#include "libshape/mesh/oddities.h"
#include "libshape/mesh/partition.h"
#include "libshape/mesh/triangle_area.h"
#include "libshape/mesh/unit_ratio.h"

namespace shape {
using namespace internal;
namespace {

/// Meshes of one face list, treated alike.
struct Batch
{
    Faces faces;
    int vertex_count = 0;
    std::vector<std::string> names;
    std::vector<std::string> paths;
    std::vector<Points> points;

    [[nodiscard]] std::string who() const
    {
        std::vector<std::size_t> all(names.size());
        for (std::size_t i = 0; i < all.size(); ++i)
            all[i] = i;
        return list_names(names, all);
    }
};

using Changes = std::vector<std::string>;

Faces reversed(Faces faces)
{
    faces.col(1).swap(faces.col(2));
    return faces;
}

Points mirrored(Points points)
{
    points.col(0) = -points.col(0);
    return points;
}

std::vector<std::array<int, 3>> sorted_faces(const Faces& faces)
{
    std::vector<std::array<int, 3>> result;
    for (const auto& face : faces.rowwise()) {
        std::array<int, 3> corners{face[0], face[1], face[2]};
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()),
                    corners.end());
        result.push_back(corners);
    }
    std::sort(result.begin(), result.end());
    return result;
}

std::optional<Topology> topology_of(const Faces& faces, int vertex_count)
{
    if (!find_defects(faces, vertex_count, 1).empty())
        return std::nullopt;
    return Topology(faces, vertex_count);
}

/// Gives a mesh the faces of the first one if they are the same but for order and orientation.
void take_faces_of(const NamedMesh& first, NamedMesh& mesh, Changes& changes)
{
    if (mesh.points.rows() != first.points.rows() || mesh.faces.rows() != first.faces.rows() ||
        mesh.faces == first.faces)
        return;
    const auto wanted = sorted_faces(first.faces);
    if (sorted_faces(mesh.faces) == wanted) {
        mesh.faces = first.faces;
        changes.push_back(join(mesh.name, ": faces put into the order of ", first.name));
    } else if (sorted_faces(reversed(mesh.faces)) == wanted) {
        mesh.faces = first.faces;
        const auto topology = topology_of(first.faces, static_cast<int>(first.points.rows()));
        const bool is_mirrored = topology && is_mirror_image(*topology, mesh.points, first.points);
        if (is_mirrored)
            mesh.points = mirrored(mesh.points);
        changes.push_back(join(mesh.name, ": faces reversed",
                               is_mirrored ? " and x taken times -1 (it was a mirror image)"
                                           : " (it was inside out)"));
    }
}

void take_faces_of_first(std::vector<NamedMesh>& meshes, Changes& changes)
{
    for (std::size_t i = 1; i < meshes.size(); ++i)
        take_faces_of(meshes.front(), meshes[i], changes);
}

std::vector<Batch> batches_of(std::vector<NamedMesh> meshes)
{
    std::vector<Batch> batches;
    for (NamedMesh& mesh : meshes) {
        const auto count = static_cast<int>(mesh.points.rows());
        auto batch = std::find_if(batches.begin(), batches.end(), [&](const Batch& b) {
            return b.vertex_count == count && b.faces.rows() == mesh.faces.rows() &&
                   b.faces == mesh.faces;
        });
        if (batch == batches.end())
            batch = batches.insert(batch, {mesh.faces, count, {}, {}, {}});
        batch->names.push_back(std::move(mesh.name));
        batch->paths.push_back(std::move(mesh.path));
        batch->points.push_back(std::move(mesh.points));
    }
    return batches;
}

void apply(Batch& batch, const VertexChoice& choice)
{
    batch.faces = choice.faces;
    batch.vertex_count = static_cast<int>(choice.vertices.size());
    for (Points& points : batch.points)
        points = chosen_points(points, choice.vertices);
}

std::size_t defect_count(const Faces& faces, int vertex_count)
{
    return find_defects(faces, vertex_count, 1'000'000).size();
}

void weld_seams(Batch& batch, Changes& changes)
{
    const std::vector<VertexGroup> groups = coincident_vertices(batch.points);
    if (groups.empty())
        return;
    const VertexChoice choice = weld(batch.faces, batch.vertex_count, groups);
    const auto before = to_size(batch.vertex_count);
    if (choice.faces.rows() == 0 ||
        defect_count(choice.faces, static_cast<int>(choice.vertices.size())) >
            defect_count(batch.faces, batch.vertex_count))
        return;
    apply(batch, choice);
    std::size_t near = 0;
    for (const VertexGroup& group : coincident_vertices(batch.points, 100.0 * coincidence))
        near += group.size();
    changes.push_back(join(batch.who(), ": ",
                           counted(before - choice.vertices.size(), "vertex", "vertices"),
                           " welded to the ", groups.size(), " they lie on",
                           near > 0 ? join("; ", near,
                                           " more lie near others, but farther than 1e-7 of the "
                                           "diagonal away: were they rounded? They stay apart")
                                    : ""));
}

void drop_repeated_faces(Batch& batch, Changes& changes)
{
    std::set<std::array<int, 3>> seen;
    std::vector<bool> kept;
    for (const auto& face : batch.faces.rowwise()) {
        std::array<int, 3> corners{face[0], face[1], face[2]};
        std::sort(corners.begin(), corners.end());
        const bool is_triangle = corners[0] != corners[1] && corners[1] != corners[2];
        kept.push_back(is_triangle && seen.insert(corners).second);
    }
    const auto dropped = std::count(kept.begin(), kept.end(), false);
    if (dropped == 0 || dropped == std::ssize(kept))
        return;
    apply(batch, keep_faces(batch.faces, batch.vertex_count, kept));
    changes.push_back(join(batch.who(), ": ", counted(dropped, "face"),
                           " taken away that repeated another or named a vertex twice"));
}

/// The sides of faces by their edge.
std::map<std::pair<int, int>, std::vector<int>> faces_at_edges(const Faces& faces)
{
    std::map<std::pair<int, int>, std::vector<int>> at;
    for (int f = 0; f < faces.rows(); ++f)
        for (int c = 0; c < 3; ++c)
            at[std::minmax({faces(f, c), faces(f, (c + 1) % 3)})].push_back(f);
    return at;
}

bool runs_along(const Faces& faces, int face, int from, int to)
{
    for (int c = 0; c < 3; ++c)
        if (faces(face, c) == from && faces(face, (c + 1) % 3) == to)
            return true;
    return false;
}

/// Turns faces so that neighbours agree, in each piece as most of its faces are; pieces that have no
/// orientation (a Moebius strip) stay.
void orient_faces(Batch& batch, Changes& changes)
{
    const auto at_edges = faces_at_edges(batch.faces);
    const auto count = to_size(batch.faces.rows());
    std::vector<std::vector<std::pair<int, bool>>> neighbours(count); // and whether they disagree
    for (const auto& [edge, faces] : at_edges)
        if (faces.size() == 2) {
            const bool disagrees = runs_along(batch.faces, faces[0], edge.first, edge.second) ==
                                   runs_along(batch.faces, faces[1], edge.first, edge.second);
            neighbours[to_size(faces[0])].emplace_back(faces[1], disagrees);
            neighbours[to_size(faces[1])].emplace_back(faces[0], disagrees);
        }
    std::vector<int> turn(count, -1); // 0: as it is, 1: turned
    Faces turned = batch.faces;
    int turned_count = 0;
    for (std::size_t seed = 0; seed < count; ++seed) {
        if (turn[seed] >= 0)
            continue;
        turn[seed] = 0;
        std::vector<int> piece{static_cast<int>(seed)};
        bool is_orientable = true;
        for (std::size_t i = 0; i < piece.size(); ++i) {
            const auto f = to_size(piece[i]);
            for (const auto& [other, disagrees] : neighbours[f]) {
                int& state = turn[to_size(other)];
                const int wanted = disagrees ? 1 - turn[f] : turn[f];
                if (state < 0) {
                    state = wanted;
                    piece.push_back(other);
                }
                is_orientable = is_orientable && state == wanted;
            }
        }
        const auto flips =
            std::count_if(piece.begin(), piece.end(), [&](int f) { return turn[to_size(f)] == 1; });
        const int flipped = 2 * flips <= std::ssize(piece) ? 1 : 0;
        if (!is_orientable)
            continue;
        for (const int f : piece)
            if (turn[to_size(f)] == flipped) {
                std::swap(turned(f, 1), turned(f, 2));
                ++turned_count;
            }
    }
    if (turned_count == 0)
        return;
    batch.faces = turned;
    changes.push_back(
        join(batch.who(), ": ", counted(turned_count, "face"), " turned to agree with the others"));
}

double area_of(const std::vector<bool>& piece, const Faces& faces, const Points& points)
{
    double area = 0.0;
    const auto corner = [&](int f, int c) -> Eigen::RowVector3d { return points.row(faces(f, c)); };
    for (int f = 0; f < faces.rows(); ++f)
        if (piece[to_size(f)])
            area += triangle_area(corner(f, 0), corner(f, 1), corner(f, 2));
    return area;
}

/// The faces of each piece, those of most faces first and of equally many those of the larger area; pieces
/// hang together through edges.
std::vector<std::vector<bool>> pieces_of(const Faces& faces, const Points& points)
{
    Partition partition(to_size(faces.rows()));
    for (const auto& [edge, at] : faces_at_edges(faces))
        for (const int f : at)
            partition.unite(at.front(), f);
    std::map<int, std::vector<bool>> pieces;
    for (int f = 0; f < faces.rows(); ++f) {
        std::vector<bool>& piece = pieces[partition.root(f)];
        piece.resize(to_size(faces.rows()), false);
        piece[to_size(f)] = true;
    }
    struct Ranked
    {
        std::vector<bool> piece;
        std::ptrdiff_t faces;
        double area;
    };
    std::vector<Ranked> ranked;
    for (auto& [root, piece] : pieces) {
        const std::ptrdiff_t count = std::count(piece.begin(), piece.end(), true);
        const double area = area_of(piece, faces, points);
        ranked.push_back({std::move(piece), count, area});
    }
    std::stable_sort(ranked.begin(), ranked.end(), [](const Ranked& a, const Ranked& b) {
        return std::pair(a.faces, a.area) > std::pair(b.faces, b.area);
    });
    std::vector<std::vector<bool>> result;
    for (Ranked& each : ranked)
        result.push_back(std::move(each.piece));
    return result;
}

/// Pieces are chosen, and vertices without a face go.
std::vector<Batch> choose_pieces(const Batch& batch, Components components, Changes& changes)
{
    // Each takes time for the whole mesh and becomes a file of its own: more are crumbs of a scan, not parts.
    constexpr std::size_t most_pieces = 1000;
    std::vector<std::vector<bool>> pieces = pieces_of(batch.faces, batch.points.front());
    const bool splits = components == Components::Split && pieces.size() > 1;
    if (splits && pieces.size() > most_pieces)
        throw LimitExceeded(join(batch.who(), ": the surface has ", pieces.size(),
                                 " pieces; at most ", most_pieces, " are split"));
    std::vector<Batch> result;
    for (std::size_t p = 0; p < (splits ? pieces.size() : 1); ++p) {
        Batch part = batch;
        apply(part, keep_faces(batch.faces, batch.vertex_count, pieces[p]));
        if (splits)
            for (std::string& name : part.names)
                name += join("_part", p + 1);
        result.push_back(std::move(part));
    }
    const auto faces = std::count(pieces.front().begin(), pieces.front().end(), true);
    if (splits)
        changes.push_back(join(batch.who(), ": split into ", pieces.size(), " pieces"));
    else if (pieces.size() > 1)
        changes.push_back(join(batch.who(), ": kept the largest of ", pieces.size(), " pieces (",
                               faces, " of ", counted(batch.faces.rows(), "face"), ")"));
    else if (const int isolated = batch.vertex_count - result.front().vertex_count; isolated > 0)
        changes.push_back(join(batch.who(), ": ", counted(isolated, "vertex", "vertices"),
                               " without a face taken away"));
    return result;
}

void repair_orientation(Batch& batch, Changes& changes)
{
    const std::optional<Topology> topology = topology_of(batch.faces, batch.vertex_count);
    if (!topology)
        return;
    const Handedness found = compare_handedness(*topology, batch.points);
    for (const std::size_t i : found.mirrored)
        batch.points[i] = mirrored(batch.points[i]);
    if (!found.mirrored.empty())
        changes.push_back(join(list_names(batch.names, found.mirrored),
                               ": x taken times -1 (mirrored against the others)"));
    if (!found.inside_out)
        return;
    batch.faces = reversed(batch.faces);
    changes.push_back(join(batch.who(), ": faces reversed (inside out)"));
}

/// The logarithms of some sizes, and which meshes have them.
struct SizePart
{
    std::vector<std::size_t> meshes;
    std::vector<double> logarithms;

    void add(std::size_t mesh, double size)
    {
        meshes.push_back(mesh);
        logarithms.push_back(std::log(size));
    }
    [[nodiscard]] double mean() const
    {
        return std::accumulate(logarithms.begin(), logarithms.end(), 0.0) /
               static_cast<double>(logarithms.size());
    }
    /// About their mean.
    [[nodiscard]] double squares() const
    {
        double sum = 0.0;
        for (const double value : logarithms)
            sum += (value - mean()) * (value - mean());
        return sum;
    }
};

/// The odd sizes in parts that stand apart from one another, each on one side of the usual ones.
std::vector<SizePart> odd_parts(const std::vector<double>& sizes, std::vector<std::size_t> odd,
                                double usual)
{
    constexpr double apart = 1.6; // sizes of one part seldom leave such a gap
    std::ranges::stable_sort(odd, {}, [&](std::size_t i) { return sizes[i]; });
    std::vector<SizePart> parts;
    double before = 0.0;
    for (const std::size_t i : odd) {
        if (sizes[i] > apart * before || (before < usual) != (sizes[i] < usual))
            parts.emplace_back();
        parts.back().add(i, sizes[i]);
        before = sizes[i];
    }
    for (SizePart& part : parts)
        std::ranges::sort(part.meshes);
    return parts;
}

/// Feet in a yard, in which no scans are: nothing is scaled by it, but 2.54 and 3.28 are not to be taken for it.
constexpr double yards = 3.0;

/// All ratios of units that the ratio of the sizes of two parts may be, within three standard errors.
std::vector<UnitRatio> possible_units(const SizePart& part, const SizePart& usual)
{
    constexpr double usual_spread =
        0.1; // taken as one more measurement, as of few the spread shows little
    constexpr double least_tolerance = 0.05; // of the logarithm
    const auto n = static_cast<double>(part.meshes.size());
    const auto m = static_cast<double>(usual.meshes.size());
    const double spread = std::sqrt(
        (part.squares() + usual.squares() + usual_spread * usual_spread) / (n + m - 2.0 + 1.0));
    const double tolerance = std::max(least_tolerance, 3.0 * spread * std::sqrt(1.0 / n + 1.0 / m));
    const double ratio = usual.mean() - part.mean();
    std::vector<UnitRatio> found;
    const auto add = [&](const UnitRatio& units) {
        for (const double exact : {units.value, 1.0 / units.value})
            if (std::abs(ratio - std::log(exact)) <= tolerance)
                found.push_back({exact, units.units});
    };
    add({yards, "feet and yards"});
    for (const UnitRatio& units : unit_ratios)
        add(units);
    return found;
}

void repair_sizes(Batch& batch, Changes& changes, Changes& kept)
{
    const std::optional<Topology> topology = topology_of(batch.faces, batch.vertex_count);
    if (!topology)
        return;
    std::vector<double> sizes;
    for (const Points& points : batch.points)
        sizes.push_back(edge_lengths(*topology, points).sum());
    const std::vector<std::size_t> odd = odd_sizes(sizes);
    if (odd.empty())
        return;
    SizePart usual;
    for (std::size_t i = 0; i < sizes.size(); ++i)
        if (!std::binary_search(odd.begin(), odd.end(), i))
            usual.add(i, sizes[i]);
    for (const SizePart& part : odd_parts(sizes, odd, std::exp(usual.mean()))) {
        const std::vector<UnitRatio> possible = possible_units(part, usual);
        const std::string names = list_names(batch.names, part.meshes);
        if (possible.size() == 1 && possible[0].value != yards &&
            possible[0].value != 1.0 / yards) {
            for (const std::size_t i : part.meshes)
                batch.points[i] *= possible[0].value;
            changes.push_back(
                join(names, ": scaled by ", possible[0].value, " to the unit of the others"));
            continue;
        }
        const double ratio = std::exp(part.mean() - usual.mean());
        std::string units;
        for (std::size_t i = 0; i < possible.size(); ++i)
            units += join(i == 0                    ? ""
                          : i + 1 < possible.size() ? ", of "
                                                    : " or of ",
                          possible[i].units, " (",
                          rounded(std::max(possible[i].value, 1.0 / possible[i].value)), ")");
        kept.push_back(join(names, ": not scaled, ", rounded(std::max(ratio, 1.0 / ratio)),
                            " times ", ratio > 1.0 ? "larger" : "smaller", " than the others: ",
                            possible.empty() ? "that is the ratio of no two units"
                                             : "as sizes vary, that may be the ratio of " + units,
                            "; scale by what you know"));
    }
}

} // namespace

RepairedMeshes repair_meshes(std::vector<NamedMesh> meshes, const MeshRepairOptions& options)
{
    RepairedMeshes result;
    take_faces_of_first(meshes, result.changes);
    std::vector<std::vector<NamedMesh>> parts; // by their number
    for (Batch& batch : batches_of(std::move(meshes))) {
        weld_seams(batch, result.changes);
        drop_repeated_faces(batch, result.changes);
        orient_faces(batch, result.changes);
        const std::vector<Batch> pieces = choose_pieces(batch, options.components, result.changes);
        parts.resize(std::max(parts.size(), pieces.size()));
        for (std::size_t p = 0; p < pieces.size(); ++p)
            for (std::size_t i = 0; i < pieces[p].names.size(); ++i)
                parts[p].push_back(
                    {pieces[p].names[i], pieces[p].paths[i], pieces[p].points[i], pieces[p].faces});
    }
    for (std::vector<NamedMesh>& part : parts) {
        take_faces_of_first(part, result.changes); // as faces are that were turned
        for (Batch& batch : batches_of(std::move(part))) {
            repair_orientation(batch, result.changes);
            repair_sizes(batch, result.changes, result.kept);
            for (std::size_t i = 0; i < batch.names.size(); ++i)
                result.meshes.push_back(
                    {batch.names[i], batch.paths[i], batch.points[i], batch.faces});
        }
    }
    return result;
}

} // namespace shape
