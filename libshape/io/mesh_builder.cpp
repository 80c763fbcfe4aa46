// SPDX-License-Identifier: MIT

#include "libshape/io/mesh_builder.h"

#include <algorithm>
#include <cmath>
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

/// Vertices of a polygon, from the fan that stands for it.
std::vector<int> MeshBuilder::polygon_corners(std::size_t polygon) const
{
    const auto at = corners_.begin() + 3 * polygons_[polygon];
    std::vector<int> vertices(at, at + 2);
    for (int i = 2; i < sizes_[polygon]; ++i)
        vertices.push_back(at[3 * (i - 2) + 2]);
    return vertices;
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
    const std::vector<int> vertices = polygon_corners(polygon);
    std::string text = join("face ", face, " (vertices ", vertices[0]);
    for (std::size_t i = 1; i < std::min(most, vertices.size()); ++i)
        text += join(", ", vertices[i]);
    return text + (vertices.size() > most ? ", ...)" : ")");
}

std::vector<int> MeshBuilder::cut_corners() const
{
    PolygonCuts* const cuts = options_.cuts;
    if (cuts != nullptr && cuts->polygons == polygons_ && cuts->fans == corners_) {
        note_folded(cuts->corners);
        return cuts->corners;
    }
    std::vector<int> corners = corners_;
    for (std::size_t p = 0; p < polygons_.size(); ++p) {
        const std::vector<int> vertices = polygon_corners(p);
        const Points points = positions_of(vertices);
        if (!fan_folds_over(points))
            continue;
        const auto cut = cut_polygon(points);
        if (!cut)
            throw InvalidInput(join(path_.string(), ": ", describe(p),
                                    " crosses itself: however it is cut, a triangle folds over; "
                                    "repair it, or cut it in "
                                    "the program that made it (`Triangulate Faces`)"));
        std::size_t next = to_size(3 * polygons_[p]);
        for (const CutTriangle& triangle : *cut)
            for (const int corner : triangle)
                corners[next++] = vertices[to_size(corner)];
    }
    if (cuts != nullptr && cuts->corners.empty()) {
        cuts->fans = corners_;
        cuts->polygons = polygons_;
        cuts->corners = corners;
        cuts->first = path_.string();
    }
    return corners;
}

/// Polygons that fold over though those of the first mesh do not.
void MeshBuilder::note_folded(const std::vector<int>& corners) const
{
    std::vector<std::size_t> folded;
    for (std::size_t p = 0; p < polygons_.size(); ++p) {
        const std::vector<int> vertices = polygon_corners(p);
        std::vector<CutTriangle> cut;
        for (int i = 0; i < sizes_[p] - 2; ++i) {
            cut.emplace_back();
            for (int c = 0; c < 3; ++c) {
                const int vertex = corners[to_size(3 * (polygons_[p] + i) + c)];
                cut.back()[to_size(c)] = static_cast<int>(
                    std::find(vertices.begin(), vertices.end(), vertex) - vertices.begin());
            }
        }
        if (folds_over(positions_of(vertices), cut))
            folded.push_back(p);
    }
    if (!folded.empty())
        options_.cuts->folded.push_back(
            join(path_.string(), ": ", counted(folded.size(), "polygon"), " cut as in ",
                 options_.cuts->first, folded.size() == 1 ? " folds" : " fold",
                 " over there, first ", describe(folded.front()),
                 "; cut them in the program that made them, the same way in all files"));
}

} // namespace shape::internal
