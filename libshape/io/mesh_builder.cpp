// SPDX-License-Identifier: MIT

#include "libshape/io/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/mesh/polygon_cut.h"

namespace shape::internal {

std::string text_name(const std::string& name)
{
    const bool is_text = is_utf8(name);
    std::string text;
    for (const char c : name) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte >= 0x20 && byte != 0x7f && (byte < 0x80 || is_text)) {
            text += c;
            continue;
        }
        constexpr const char* digits = "0123456789ABCDEF";
        text += '%';
        text += digits[byte >> 4U];
        text += digits[byte & 15U];
    }
    return text;
}

MeshBuilder::MeshBuilder(std::filesystem::path path, const MeshReadOptions& options, Fail fail)
    : path_(std::move(path)), options_(options), fail_(std::move(fail))
{
}

void MeshBuilder::check_limit(std::string_view what, std::int64_t count, std::int64_t limit) const
{
    if (count > limit)
        throw LimitExceeded(
            join(path_.string(), ": the mesh has ", count, " ", what, "; the limit is ", limit));
}

void MeshBuilder::reserve(std::int64_t vertices, std::int64_t faces)
{
    check_limit("vertices", vertices, vertex_limit);
    check_limit("faces", faces, face_limit);
    coordinates_.reserve(to_size(3 * vertices));
    corners_.reserve(to_size(3 * faces));
}

void MeshBuilder::add_vertex(double x, double y, double z)
{
    if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z))
        fail_(join("vertex ", vertex_count(), " has a coordinate that is not finite (", x, ", ", y,
                   ", ", z, ")"));
    coordinates_.insert(coordinates_.end(), {x, y, z});
    check_limit("vertices", vertex_count(), vertex_limit);
}

void MeshBuilder::add_polygon(std::span<const std::int64_t> corners)
{
    if (corners.size() < 3)
        fail_(join("a face has ", corners.size(), " corners; it needs at least 3"));
    if (corners.size() > 3 && !options_.triangulate)
        fail_(
            join("a face has ", corners.size(),
                 " corners; polygons are refused unless they are to be split (option triangulate); "
                 "or export triangles (`Triangulate Faces`)"));
    const std::int64_t count = std::max(vertex_count(), expected_);
    for (const std::int64_t v : corners)
        if (v < 0 || v >= count)
            fail_(join("a face names vertex ", v, " (counted from 0) after only ",
                       counted(count, "vertex", "vertices")));
    if (corners.size() > 3) {
        polygons_.push_back(face_count());
        sizes_.push_back(static_cast<int>(corners.size()));
    }
    for (std::size_t i = 2; i < corners.size(); ++i)
        corners_.insert(corners_.end(),
                        {static_cast<int>(corners[0]), static_cast<int>(corners[i - 1]),
                         static_cast<int>(corners[i])});
    check_limit("faces", face_count(), face_limit);
}

std::int64_t MeshBuilder::vertex_count() const
{
    return static_cast<std::int64_t>(coordinates_.size() / 3);
}

std::int64_t MeshBuilder::face_count() const
{
    return static_cast<std::int64_t>(corners_.size() / 3);
}

NamedMesh MeshBuilder::finish() const
{
    if (coordinates_.empty() || corners_.empty())
        throw InvalidInput(
            join(path_.string(), ": the file has ", counted(vertex_count(), "vertex", "vertices"),
                 " and ", counted(face_count(), "face"),
                 "; a mesh needs some of both (export the faces as well, and only the surface)"));
    const std::vector<int> cut = polygons_.empty() ? std::vector<int>() : cut_corners();
    const std::vector<int>& corners = polygons_.empty() ? corners_ : cut;
    return {text_name(path_.stem().string()), path_.string(),
            Eigen::Map<const Points>(coordinates_.data(), vertex_count(), 3),
            Eigen::Map<const Faces>(corners.data(), face_count(), 3)};
}

Points MeshBuilder::positions_of(const std::vector<int>& vertices) const
{
    Points points(std::ssize(vertices), 3);
    for (std::size_t i = 0; i < vertices.size(); ++i)
        points.row(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::RowVector3d>(
            coordinates_.data() + 3 * std::ptrdiff_t{vertices[i]});
    return points;
}

std::string MeshBuilder::describe(std::size_t polygon) const
{
    constexpr std::size_t most = 8;
    std::int64_t face = polygons_[polygon]; // less what the polygons before have more than one
    for (std::size_t p = 0; p < polygon; ++p)
        face -= sizes_[p] - 3;
    const std::vector<int> vertices = fans().vertices_of(polygon);
    std::string text = join("face ", face, " (vertices ", vertices[0]);
    for (std::size_t i = 1; i < std::min(most, vertices.size()); ++i)
        text += join(", ", vertices[i]);
    return text + (vertices.size() > most ? ", ...)" : ")");
}

void MeshBuilder::refuse_crossing(std::size_t polygon) const
{
    throw InvalidInput(join(path_.string(), ": ", describe(polygon),
                            " crosses itself: however it is cut, a triangle folds over; "
                            "repair it, or cut it in "
                            "the program that made it (`Triangulate Faces`)"));
}

void MeshBuilder::cut_alone(std::size_t polygon, std::vector<int>& corners) const
{
    const std::vector<int> vertices = fans().vertices_of(polygon);
    const auto cut =
        cut_polygon(positions_of(vertices)); // the fan, which is there, unless it folds over
    if (!cut)
        refuse_crossing(polygon);
    std::size_t next = to_size(3 * polygons_[polygon]);
    for (const CutTriangle& triangle : *cut)
        for (const int corner : triangle)
            corners[next++] = vertices[to_size(corner)];
}

std::vector<int> MeshBuilder::cut_corners() const
{
    PolygonCuts* const cuts = options_.cuts;
    const KnownTriangulation* nearest = nullptr;
    KnownCut cut{corners_, {}};
    cut.missed.resize(polygons_.size());
    std::iota(cut.missed.begin(), cut.missed.end(), std::size_t{0});
    if (cuts != nullptr) {
        ++cuts->cut_meshes;
        for (const KnownTriangulation& known : cuts->known) {
            if (known.vertices != vertex_count() || known.faces.rows() != face_count())
                continue;
            KnownCut as_this = cut_as_known(fans(), known.faces);
            if (as_this.missed.size() >= cut.missed.size())
                continue;
            nearest = &known;
            cut = std::move(as_this);
            if (cut.missed.empty())
                break;
        }
    }
    for (const std::size_t polygon : cut.missed)
        cut_alone(polygon, cut.corners);
    if (nearest != nullptr)
        note_folded(cut.corners, *nearest);
    if (cut.has_all) // the triangles of a polygon have no order of their own
        cut.corners.assign(nearest->faces.data(), nearest->faces.data() + nearest->faces.size());
    return std::move(cut.corners);
}

/// Polygons that fold over as they are cut, though they would not if they were cut alone.
void MeshBuilder::note_folded(const std::vector<int>& corners,
                              const KnownTriangulation& known) const
{
    std::size_t count = 0;
    std::size_t first = 0;
    for (std::size_t p = 0; p < polygons_.size(); ++p) {
        const std::vector<int> vertices = fans().vertices_of(p);
        const Points points = positions_of(vertices);
        std::vector<CutTriangle> cut(to_size(sizes_[p] - 2));
        for (std::size_t i = 0; i < cut.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c) {
                const int vertex = corners[3 * (to_size(polygons_[p]) + i) + c];
                cut[i][c] =
                    static_cast<int>(std::ranges::find(vertices, vertex) - vertices.begin());
            }
        if (!folds_over(points, cut))
            continue;
        if (!cut_polygon(points))
            refuse_crossing(p);
        if (count++ == 0)
            first = p;
    }
    if (count > 0)
        options_.cuts->folded.push_back(
            {path_.string(),
             join(path_.string(), ": ", counted(count, "polygon"), " cut as in ", known.path,
                  count == 1 ? " folds" : " fold", " over there, first ", describe(first),
                  "; cut them in the program that made them, the same way in all files")});
}

} // namespace shape::internal
