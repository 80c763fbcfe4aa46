// SPDX-License-Identifier: MIT

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <unordered_map>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/mesh_builder.h"
#include "libshape/io/mesh_formats.h"

// STL knows triangles by the coordinates of their corners alone.

namespace shape::internal {
namespace {

constexpr std::size_t head_size = 84; ///< [byte]; a text of any content and the count
constexpr std::size_t face_size = 50; ///< [byte]; normal, three corners, 16 bits of anything

using Point = std::array<double, 3>;

struct PointHash
{
    std::size_t operator()(const Point& point) const
    {
        std::uint64_t hash = 0;
        for (const double value : point) {
            hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x9e3779b97f4a7c15;
            hash ^= hash >> 32;
        }
        return static_cast<std::size_t>(hash);
    }
};

/// Gives corners of equal coordinates one vertex, in the order in which they come first.
class CornerMerger
{
public:
    explicit CornerMerger(MeshBuilder& mesh) : mesh_(mesh) {}

    void add_face(const std::array<Point, 3>& corners)
    {
        std::array<std::int64_t, 3> face{};
        for (std::size_t c = 0; c < 3; ++c) {
            Point point = corners[c];
            for (double& value : point)
                value += 0.0; // -0 is 0
            const auto [found, is_new] = vertices_.try_emplace(point, mesh_.vertex_count());
            if (is_new)
                mesh_.add_vertex(point[0], point[1], point[2]);
            face[c] = found->second;
        }
        mesh_.add_polygon(face);
    }

private:
    MeshBuilder& mesh_;
    std::unordered_map<Point, std::int64_t, PointHash> vertices_;
};

std::uint32_t stated_count(std::string_view content)
{
    static_assert(std::endian::native == std::endian::little);
    std::uint32_t count = 0;
    std::memcpy(&count, content.data() + head_size - sizeof count, sizeof count);
    return count;
}

/// Keywords may be written in capitals.
bool is_keyword(std::string_view found, std::string_view keyword)
{
    return std::ranges::equal(found, keyword, {}, [](unsigned char c) {
        return static_cast<char>(c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c);
    });
}

/// Binary files may start with `solid` too: their length tells.
bool is_binary(std::string_view content)
{
    if (content.size() < head_size)
        return false;
    if (content.size() == head_size + face_size * std::size_t{stated_count(content)})
        return true;
    std::string_view text = content;
    if (text.starts_with("\xEF\xBB\xBF"))
        text.remove_prefix(3);
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
    return !is_keyword(text.substr(0, 5), "solid") ||
           content.substr(0, 512).find('\0') != content.npos;
}

/// What to do about a file that is longer or shorter than its count of faces says.
std::string advice_on_size(std::string_view content, std::size_t count)
{
    const std::size_t size = content.size();
    const std::size_t stated = head_size + face_size * count;
    if (size < stated)
        return "is this an STL file? Then it was cut off, or its count is wrong: export or copy it "
               "again";
    const std::size_t rest = size - stated;
    const bool is_filling = content.substr(stated).find_first_not_of('\0') == content.npos;
    if (rest % face_size == 0 && !is_filling)
        return join("what follows would be ", counted(rest / face_size, "more face", "more faces"),
                    ": the count was not written or is wrong; export it again");
    return join(
        "what follows byte ", stated,
        " belongs to no face: export it again, in another format if its program adds "
        "something of its own; or, if it is known to be of no use, cut it off (truncate -s ",
        stated, " FILE)");
}

void parse_binary(std::string_view content, const std::string& path, MeshBuilder& mesh,
                  std::size_t& offset)
{
    const std::size_t count = stated_count(content);
    const std::size_t size = head_size + face_size * count;
    if (content.size() != size)
        throw InvalidInput(join(path, ": byte 80: ", counted(count, "face"),
                                count == 1 ? " takes " : " take ", size, " bytes, the file has ",
                                content.size(), "; ", advice_on_size(content, count)));
    mesh.reserve(0, static_cast<std::int64_t>(count));
    CornerMerger merger(mesh);
    for (std::size_t f = 0; f < count; ++f) {
        offset = head_size + f * face_size;
        std::array<float, 9> values;
        std::memcpy(values.data(), content.data() + offset + 3 * sizeof(float), sizeof values);
        std::array<Point, 3> corners;
        for (std::size_t i = 0; i < values.size(); ++i)
            corners[i / 3][i % 3] = double{values[i]};
        merger.add_face(corners);
    }
}

void expect(LineReader& reader, std::string_view word)
{
    const std::string_view found = reader.token();
    if (!is_keyword(found, word))
        reader.fail(join("must be ", in_quotes(word), ", is ", in_quotes(found)));
}

void expect_line(LineReader& reader, std::string_view first, std::string_view second = {})
{
    if (!reader.next_line())
        reader.fail(join("the file ends before ", in_quotes(first)));
    expect(reader, first);
    if (!second.empty())
        expect(reader, second);
}

void parse_text(LineReader& reader, MeshBuilder& mesh)
{
    CornerMerger merger(mesh);
    bool is_open = false;
    while (reader.next_line()) {
        const std::string_view keyword = reader.token();
        if (is_keyword(keyword, is_open ? "endsolid" : "solid")) {
            is_open = !is_open;
            continue;
        }
        if (!is_keyword(keyword, "facet") || !is_open)
            reader.fail(join("must be ", is_open ? "'facet' or 'endsolid'" : "'solid'", ", is ",
                             in_quotes(keyword), "; is this an STL file?"));
        expect_line(reader, "outer", "loop");
        std::array<Point, 3> corners;
        for (Point& corner : corners) {
            expect_line(reader, "vertex");
            for (double& value : corner)
                value = reader.number("coordinate");
            reader.finish_line();
        }
        expect_line(reader, "endloop");
        expect_line(reader, "endfacet");
        merger.add_face(corners);
    }
    if (is_open)
        reader.fail("the file ends before 'endsolid'");
}

} // namespace

MeshFileContent parse_stl(std::string_view content, const std::filesystem::path& path,
                          const MeshReadOptions& options)
{
    const auto finish = [](const MeshBuilder& mesh, bool is_single) {
        return MeshFileContent{.meshes = {mesh.finish()},
                               .single_precision = is_single,
                               .merged_corners = 3 * mesh.face_count()};
    };
    if (is_binary(content)) {
        std::size_t offset = 0;
        MeshBuilder mesh(path, options, [&](std::string_view rule) {
            throw InvalidInput(join(path.string(), ": byte ", offset, ": ", rule));
        });
        parse_binary(content, path.string(), mesh, offset);
        return finish(mesh, true);
    }
    LineReader reader(content, path.string());
    MeshBuilder mesh(path, options, [&](std::string_view rule) { reader.fail(rule); });
    parse_text(reader, mesh);
    return finish(mesh, false);
}

std::string print_stl(const Points& points, const Faces& faces, const MeshWriteOptions& options)
{
    const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> corners = points.cast<float>();
    std::string text = options.ascii ? "solid libshape\n" : "binary STL written by libshape";
    if (!options.ascii) {
        text.resize(head_size - 4, ' ');
        const auto count = static_cast<std::uint32_t>(faces.rows());
        text.append(reinterpret_cast<const char*>(&count), sizeof count);
    }
    text.reserve(text.size() + to_size(faces.rows()) * (options.ascii ? 250 : face_size));
    for (const auto& face : faces.rowwise()) {
        const Eigen::Vector3d a = points.row(face[0]);
        const Eigen::Vector3d b = points.row(face[1]);
        const Eigen::Vector3d c = points.row(face[2]);
        const Eigen::Vector3d across = (b - a).eval().cross((c - a).eval());
        const Eigen::Vector3f normal =
            (across.norm() > 0.0 ? across.stableNormalized().eval() : across).cast<float>();
        if (options.ascii) {
            append_line(text, "facet normal", normal);
            text += "outer loop\n";
            for (const int v : face)
                append_line(text, "vertex", corners.row(v));
            text += "endloop\nendfacet\n";
            continue;
        }
        text.append(reinterpret_cast<const char*>(normal.data()), 3 * sizeof(float));
        for (const int v : face)
            text.append(reinterpret_cast<const char*>(corners.data() + 3 * Eigen::Index{v}),
                        3 * sizeof(float));
        text.append(2, '\0');
    }
    if (options.ascii)
        text += "endsolid libshape\n";
    return text;
}

} // namespace shape::internal
