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
    return {text_name(path_.stem().string()), path_.string(),
            Eigen::Map<const Points>(coordinates_.data(), vertex_count(), 3),
            Eigen::Map<const Faces>(corners_.data(), face_count(), 3)};
}

} // namespace shape::internal
