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
        // Where that is a guess, all meshes together say more once the faces agree.
        const Handedness found =
            topology ? compare_handedness(*topology, std::array{first.points, mesh.points})
                     : Handedness{};
        const bool is_mirrored = !found.mirrored.empty();
        if (is_mirrored)
            mesh.points = mirrored(mesh.points);
        changes.push_back(join(mesh.name, ": faces reversed",
                               is_mirrored ? " and x taken times -1 (it was a mirror image)"
                               : found.bent.empty()
                                   ? " (it was inside out)"
                                   : " (it was inside out, and bends the other way or is a mirror "
                                     "image)"));
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

std::size_t count_vertices(const std::vector<VertexGroup>& groups)
{
    std::size_t count = 0;
    for (const VertexGroup& group : groups)
        count += group.size();
    return count;
}

/// Makes one of the vertices that lie on one another, unless the surface would break; says what stays apart.
void weld_seams(Batch& batch, RepairedMeshes& result)
{
    SeamVertices seams = seam_vertices(batch.faces, batch.points);
    const std::vector<VertexGroup> groups = std::move(seams.coincident);
    if (!groups.empty()) {
        const VertexChoice choice = weld(batch.faces, batch.vertex_count, groups);
        const auto before = to_size(batch.vertex_count);
        if (choice.faces.rows() == 0 ||
            defect_count(choice.faces, static_cast<int>(choice.vertices.size())) >
                defect_count(batch.faces, batch.vertex_count)) {
            result.kept.push_back(join(batch.who(), ": ", count_vertices(groups),
                                       " boundary vertices that lie on one another stay apart: "
                                       "as one, they would break the surface"));
        } else {
            apply(batch, choice);
            seams = seam_vertices(batch.faces, batch.points);
            result.changes.push_back(join(
                batch.who(), ": ", counted(before - choice.vertices.size(), "vertex", "vertices"),
                " welded to the ", groups.size(), " they lie on"));
        }
    }
    if (!seams.near.empty())
        result.kept.push_back(
            join(batch.who(), ": ", count_vertices(seams.near),
                 " boundary vertices lie near one another, up to ", rounded(seams.gap),
                 " of the diagonal apart, and stay so; if they are one, merge them by that "
                 "distance in the program that made them"));
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

/// The pieces of a surface, those of most faces first and of equally many those of the larger area; they
/// hang together through edges.
struct Pieces
{
    std::vector<int> of_face; ///< From 0.
    std::vector<std::ptrdiff_t> faces;

    [[nodiscard]] std::vector<bool> mask(std::size_t piece) const
    {
        std::vector<bool> mask;
        for (const int p : of_face)
            mask.push_back(to_size(p) == piece);
        return mask;
    }
};

Pieces pieces_of(const Faces& faces, const Points& points)
{
    Partition partition(to_size(faces.rows()));
    for (const auto& [edge, at] : faces_at_edges(faces))
        for (const int f : at)
            partition.unite(at.front(), f);
    struct Piece
    {
        int root = 0;
        std::ptrdiff_t faces = 0;
        double area = 0.0;
    };
    std::vector<Piece> found;
    std::vector<int> number(to_size(faces.rows()), -1); // of a root
    const auto corner = [&](int f, int c) -> Eigen::RowVector3d { return points.row(faces(f, c)); };
    for (int f = 0; f < faces.rows(); ++f) {
        const int root = partition.root(f);
        int& piece = number[to_size(root)];
        if (piece < 0) {
            piece = static_cast<int>(found.size());
            found.push_back({root});
        }
        ++found[to_size(piece)].faces;
        found[to_size(piece)].area += triangle_area(corner(f, 0), corner(f, 1), corner(f, 2));
    }
    std::stable_sort(found.begin(), found.end(), [](const Piece& a, const Piece& b) {
        return std::pair(a.faces, a.area) > std::pair(b.faces, b.area);
    });
    Pieces pieces;
    for (std::size_t p = 0; p < found.size(); ++p) {
        number[to_size(found[p].root)] = static_cast<int>(p);
        pieces.faces.push_back(found[p].faces);
    }
    for (int f = 0; f < faces.rows(); ++f)
        pieces.of_face.push_back(number[to_size(partition.root(f))]);
    return pieces;
}

/// How many of the pieces meet the first one along a rim, on it or near it, at two places and more: they are patches of
/// one surface rather than crumbs.
std::size_t count_patches(const Batch& batch, const Pieces& pieces)
{
    std::vector<int> piece_of(to_size(batch.vertex_count), -1);
    for (int f = 0; f < batch.faces.rows(); ++f)
        for (const int v : batch.faces.row(f))
            piece_of[to_size(v)] = pieces.of_face[to_size(f)];
    std::vector<int> places(pieces.faces.size(), 0);
    const SeamVertices seams = seam_vertices(batch.faces, batch.points);
    for (const auto* groups : {&seams.coincident, &seams.near})
        for (const VertexGroup& group : *groups) {
            const std::set<int> met = [&] {
                std::set<int> those;
                for (const int v : group)
                    those.insert(piece_of[to_size(v)]);
                return those;
            }();
            if (met.contains(0))
                for (const int piece : met)
                    ++places[to_size(piece)];
        }
    return to_size(
        std::count_if(places.begin() + 1, places.end(), [](int count) { return count >= 2; }));
}

/// Whether the second of some pieces is too large for a crumb. Set by hand: teeth beside a jaw, or one of two halves, may
/// be what is meant.
bool has_rival(const std::vector<std::ptrdiff_t>& faces)
{
    const std::ptrdiff_t all = std::accumulate(faces.begin(), faces.end(), std::ptrdiff_t{0});
    return faces.size() > 1 && (2 * faces[1] >= faces[0] || 5 * faces[1] >= all);
}

/// Pieces are chosen, and vertices without a face go.
std::vector<Batch> choose_pieces(const Batch& batch, Components components, RepairedMeshes& result)
{
    // Each takes time for the whole mesh and becomes a file of its own: more are crumbs of a scan, not parts.
    constexpr std::size_t most_pieces = 1000;
    const Pieces pieces = pieces_of(batch.faces, batch.points.front());
    const std::size_t count = pieces.faces.size();
    const bool splits = components == Components::Split && count > 1;
    if (splits && count > most_pieces)
        throw LimitExceeded(join(batch.who(), ": the surface has ", count, " pieces; at most ",
                                 most_pieces, " are split"));
    if (!splits && count > 1)
        if (const std::size_t patches = count_patches(batch, pieces); patches > 0) {
            result.kept.push_back(
                join(batch.who(), ": all ", count, " pieces, as ", patches,
                     patches == 1 ? " meets" : " meet",
                     " the largest along its rim: patches of one surface? Merge their vertices in "
                     "the program that made them, or split the mesh into its pieces"));
            return {batch};
        }
    if (components == Components::KeepMain && has_rival(pieces.faces)) {
        result.asks_for_components = true;
        result.kept.push_back(join(batch.who(), ": all ", count, " pieces, as the largest has ",
                                   pieces.faces[0], " of ", counted(batch.faces.rows(), "face"),
                                   " and the next one ", pieces.faces[1],
                                   ": which of them is meant is a guess; keep the largest, or "
                                   "split the mesh into its pieces"));
        return {batch};
    }
    std::vector<Batch> parts;
    for (std::size_t p = 0; p < (splits ? count : 1); ++p) {
        Batch part = batch;
        apply(part, keep_faces(batch.faces, batch.vertex_count, pieces.mask(p)));
        if (splits)
            for (std::string& name : part.names)
                name += join("_part", p + 1);
        parts.push_back(std::move(part));
    }
    if (splits)
        result.changes.push_back(join(batch.who(), ": split into ", count, " pieces"));
    else if (count > 1)
        result.changes.push_back(join(batch.who(), ": kept the largest of ", count, " pieces (",
                                      pieces.faces.front(), " of ",
                                      counted(batch.faces.rows(), "face"), ")"));
    else if (const int isolated = batch.vertex_count - parts.front().vertex_count; isolated > 0)
        result.changes.push_back(join(batch.who(), ": ", counted(isolated, "vertex", "vertices"),
                                      " without a face taken away"));
    return parts;
}

/// Those of some meshes that are far from all others, of which nothing is guessed. Only sound ones are asked about.
std::vector<std::size_t> outliers_among(const Batch& batch, const Topology& topology,
                                        const std::vector<Points>& points,
                                        const MeshRepairOptions& options)
{
    if (!options.find_outliers)
        return {};
    Collection sound{topology, {}, {}, {}};
    std::vector<std::size_t> index;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!find_degenerate_geometry(batch.faces, points[i], 1).empty())
            continue;
        sound.names.push_back(batch.names[i]);
        sound.points.push_back(points[i]);
        index.push_back(i);
    }
    if (sound.points.empty())
        return {};
    std::vector<std::size_t> outliers;
    for (const std::size_t i : options.find_outliers(sound))
        outliers.push_back(index.at(i));
    return outliers;
}

/// Turns mirror images back, and surfaces that are inside out.
/// @return  Outliers, which are left alone.
std::vector<std::size_t> repair_orientation(Batch& batch, const Topology& topology,
                                            const MeshRepairOptions& options,
                                            RepairedMeshes& result)
{
    const Handedness found = compare_handedness(topology, batch.points);
    std::vector<Points> turned = batch.points; // a mirror image alone is no outlier
    for (const std::size_t i : found.mirrored)
        turned[i] = mirrored(std::move(turned[i]));
    std::vector<std::size_t> outliers = outliers_among(batch, topology, turned, options);
    if (!outliers.empty())
        result.kept.push_back(join(list_names(batch.names, outliers), ": far from all others",
                                   " (exchanged vertices or landmarks, a failed registration?), "
                                   "neither mirrored nor scaled; look at ",
                                   outliers.size() == 1 ? "it" : "them"));
    std::vector<std::size_t> mirror_images;
    for (const std::size_t i : found.mirrored)
        if (std::ranges::find(outliers, i) == outliers.end())
            mirror_images.push_back(i);
    for (const std::size_t i : mirror_images)
        batch.points[i] = std::move(turned[i]);
    if (!mirror_images.empty())
        result.changes.push_back(join(list_names(batch.names, mirror_images),
                                      ": x taken times -1 (mirrored against the others)"));
    if (!found.bent.empty())
        result.kept.push_back(join(list_names(batch.names, found.bent), ": not mirrored, ",
                                   found.bent.size() == 1 ? "it " : "they ",
                                   describe_bent(found.bent.size(), batch.names.size()),
                                   "; mirror by what you know"));
    if (found.inside_out) {
        batch.faces = reversed(batch.faces);
        result.changes.push_back(join(batch.who(), ": faces reversed (inside out)"));
    }
    return outliers;
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

/// What the sizes of two parts say of their units.
struct UnitGuess
{
    std::optional<double>
        scale; ///< Of the first part to the unit of the other, where it is beyond doubt.
    std::vector<UnitRatio> possible; ///< All that may be.
    bool has_few =
        false; ///< It would be beyond doubt if as many sizes as there are showed how they vary.
};

/// Units of ten, which scanners and programs export in, are told from real differences where the ratio is that of one of
/// them nearly and nothing else comes near. Inches and feet are never beyond doubt: kinds of animals, or ages, differ by
/// 2.5 too.
UnitGuess guess_units(const SizePart& part, const SizePart& usual)
{
    constexpr double usual_spread =
        0.1; // taken as one more measurement, as of few the spread shows little
    constexpr double least_tolerance = 0.05; // of the logarithm
    // Set by hand: twelve is 0.18 from ten, and real differences of nine 0.11; nothing real differs by about a hundred.
    constexpr double nearly_ten = 0.05;
    constexpr double most_error = 0.14;
    constexpr double most_error_shown = 0.08;
    constexpr double nearly_hundred = 0.25;
    const auto n = static_cast<double>(part.meshes.size());
    const auto m = static_cast<double>(usual.meshes.size());
    const double squares = part.squares() + usual.squares();
    const double per_spread = 3.0 * std::sqrt(1.0 / n + 1.0 / m);
    const double error =
        per_spread * std::sqrt((squares + usual_spread * usual_spread) / (n + m - 2.0 + 1.0));
    const double shown = per_spread * std::sqrt(squares / std::max(1.0, n + m - 2.0));
    const double ratio = usual.mean() - part.mean();
    UnitGuess guess;
    for (const UnitRatio& units : unit_ratios)
        for (const double exact : {units.value, 1.0 / units.value})
            if (std::abs(ratio - std::log(exact)) <= std::max(least_tolerance, error))
                guess.possible.push_back({exact, units.units});
    if (guess.possible.size() != 1)
        return guess;
    const double exact = guess.possible.front().value;
    const double power = std::abs(std::log10(exact));
    const double distance = std::abs(ratio - std::log(exact));
    const bool is_power = std::abs(power - std::round(power)) < 1e-9;
    const bool is_ten = is_power && power < 1.5;
    guess.has_few = is_ten && distance <= nearly_ten && shown <= most_error_shown &&
                    per_spread * usual_spread > most_error * std::sqrt(n + m - 1.0);
    if (is_ten ? distance <= nearly_ten && error <= most_error && shown <= most_error_shown
               : is_power && distance <= nearly_hundred)
        guess.scale = exact;
    return guess;
}

/// "centimetres and inches (times 0.394)", or several of them.
std::string describe(const std::vector<UnitRatio>& possible)
{
    std::string units;
    for (std::size_t i = 0; i < possible.size(); ++i)
        units += join(i == 0                    ? ""
                      : i + 1 < possible.size() ? ", of "
                                                : " or of ",
                      possible[i].units, " (times ", rounded(possible[i].value), ")");
    return units;
}

void repair_sizes(Batch& batch, const Topology& topology, const std::vector<std::size_t>& outliers,
                  RepairedMeshes& result)
{
    std::vector<std::size_t> index; // of those that are compared
    std::vector<double> sizes;
    for (std::size_t i = 0; i < batch.points.size(); ++i)
        if (std::ranges::find(outliers, i) == outliers.end()) {
            index.push_back(i);
            sizes.push_back(edge_lengths(topology, batch.points[i]).sum());
        }
    const std::vector<std::size_t> odd = odd_sizes(sizes);
    if (odd.empty())
        return;
    SizePart usual;
    for (std::size_t i = 0; i < sizes.size(); ++i)
        if (!std::binary_search(odd.begin(), odd.end(), i))
            usual.add(index[i], sizes[i]);
    for (const std::vector<std::size_t>& those : parts_of_odd_sizes(sizes, odd)) {
        SizePart part;
        for (const std::size_t i : those)
            part.add(index[i], sizes[i]);
        const UnitGuess guess = guess_units(part, usual);
        const std::string names = list_names(batch.names, part.meshes);
        if (guess.scale) {
            for (const std::size_t i : part.meshes)
                batch.points[i] *= *guess.scale;
            result.changes.push_back(
                join(names, ": scaled by ", *guess.scale, " to the unit of the others"));
            continue;
        }
        const double ratio = std::exp(part.mean() - usual.mean());
        result.kept.push_back(join(
            names, ": not scaled, ", rounded(std::max(ratio, 1.0 / ratio)), " times ",
            ratio > 1.0 ? "larger" : "smaller", " than the others: ",
            guess.possible.empty()
                ? "that is the ratio of no two units"
                : "that may be the ratio of " + describe(guess.possible) + ", or a real difference",
            guess.has_few ? ", and so few meshes do not show how sizes vary (one is scaled by ten "
                            "beside six others, two beside three)"
                          : "",
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
        weld_seams(batch, result);
        drop_repeated_faces(batch, result.changes);
        orient_faces(batch, result.changes);
        const std::vector<Batch> pieces = choose_pieces(batch, options.components, result);
        parts.resize(std::max(parts.size(), pieces.size()));
        for (std::size_t p = 0; p < pieces.size(); ++p)
            for (std::size_t i = 0; i < pieces[p].names.size(); ++i)
                parts[p].push_back(
                    {pieces[p].names[i], pieces[p].paths[i], pieces[p].points[i], pieces[p].faces});
    }
    for (std::vector<NamedMesh>& part : parts) {
        take_faces_of_first(part, result.changes); // as faces are that were turned
        for (Batch& batch : batches_of(std::move(part))) {
            if (const auto topology = topology_of(batch.faces, batch.vertex_count))
                repair_sizes(batch, *topology,
                             repair_orientation(batch, *topology, options, result), result);
            for (std::size_t i = 0; i < batch.names.size(); ++i)
                result.meshes.push_back(
                    {batch.names[i], batch.paths[i], batch.points[i], batch.faces});
        }
    }
    return result;
}

} // namespace shape
