// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libshape/io/mesh_file.h"
#include "libshape/mesh/known_cut.h"

namespace shape::internal {

/// The name as it is, or with the bytes that are not text as %XX: tables, pictures and JSON take
/// nothing but text, and on Linux a file may be called anything.
[[nodiscard]] std::string text_name(const std::string& name);

/// Takes the vertices and polygons of a file in their order and applies the rules that all formats
/// share. Internal to the readers.
class MeshBuilder
{
public:
    static constexpr std::int64_t vertex_limit = 20'000'000;
    static constexpr std::int64_t face_limit = 40'000'000;
    static constexpr std::int64_t corner_limit = 1024;
    static constexpr std::uint64_t file_limit = std::uint64_t{2} << 30; // [byte]

    /// Throws InvalidInput with a rule and the present place in the file.
    using Fail = std::function<void(std::string_view rule)>;

    MeshBuilder(std::filesystem::path path, const MeshReadOptions& options, Fail fail);

    void reserve(std::int64_t vertices, std::int64_t faces);
    /// Faces may come first: so many vertices are sure to follow.
    void expect_vertices(std::int64_t count) { expected_ = count; }
    void add_vertex(double x, double y, double z);

    /// @param corners  Vertex indices from 0, in range of the vertices added so far, or expected.
    void add_polygon(std::span<const std::int64_t> corners);

    [[nodiscard]] std::int64_t vertex_count() const;
    [[nodiscard]] std::int64_t face_count() const;

    /// @throws InvalidInput if there are no vertices or faces, or a polygon crosses itself.
    [[nodiscard]] NamedMesh finish() const;

private:
    [[nodiscard]] std::vector<int> cut_corners() const;
    void cut_alone(std::size_t polygon, std::vector<int>& corners) const;
    [[noreturn]] void refuse_crossing(std::size_t polygon) const;
    void note_folded(const std::vector<int>& corners, const KnownTriangulation& known) const;
    [[nodiscard]] Fans fans() const { return {corners_, polygons_, sizes_}; }
    [[nodiscard]] Points positions_of(const std::vector<int>& vertices) const;
    /// "face 12 (vertices 3, 4, 5, 6)", as the file counts faces.
    [[nodiscard]] std::string describe(std::size_t polygon) const;
    void check_limit(std::string_view what, std::int64_t count, std::int64_t limit) const;

    std::filesystem::path path_;
    MeshReadOptions options_;
    Fail fail_;
    std::int64_t expected_ = 0;
    std::vector<double> coordinates_;
    std::vector<int> corners_;           ///< Of triangles, polygons as fans.
    std::vector<std::int64_t> polygons_; ///< The first triangle of each of more than 3 corners.
    std::vector<int> sizes_;             ///< Corners of these.
};

} // namespace shape::internal
