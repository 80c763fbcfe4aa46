// SPDX-License-Identifier: MIT

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <vector>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/rounded.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/json_depth.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/mesh_builder.h"
#include "libshape/io/mesh_formats.h"

// Binary glTF 2.0: a description in JSON and a buffer that its accessors look into.

namespace shape::internal {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t description_limit = std::uint64_t{64} << 20; ///< [byte]

/// The description and the buffer; every access is checked, for the file may say anything.
class Glb
{
public:
    Glb(std::string_view content, std::string path, const GlbLimits& limits)
        : path_(std::move(path)), limits_(limits)
    {
        const auto number = [&](std::size_t offset) {
            std::uint32_t value = 0;
            std::memcpy(&value, content.data() + offset, sizeof value);
            return value;
        };
        if (content.size() < 20 || !content.starts_with("glTF"))
            fail("must start with 'glTF'; is this a GLB file?");
        if (number(4) != 2)
            fail(join("version is ", number(4), ", must be 2"));
        if (number(8) < 20 || number(8) > content.size())
            fail(join("states ", number(8), " bytes, has ", content.size()));
        content = content.substr(0, number(8));
        const std::uint64_t size = number(12);
        if (content.substr(16, 4) != "JSON" || 20 + size > content.size())
            fail("has no JSON chunk that it could hold");
        if (size > description_limit)
            throw LimitExceeded(join(path_, ": a description of ", size, " bytes; the limit is ",
                                     description_limit));
        if (!is_shallow_json(content.substr(20, size)))
            fail(join("the JSON chunk is nested deeper than ", deepest_json, " levels"));
        try {
            root_ = Json::parse(content.substr(20, size));
        } catch (const Json::exception& error) {
            fail(join("the JSON chunk is damaged: ", error.what()));
        }
        if (!root_.is_object())
            fail("the JSON chunk is not an object");
        const std::size_t next = 20 + (size + 3) / 4 * 4;
        if (next + 8 <= content.size() && content.substr(next + 4, 4) == std::string("BIN\0", 4)) {
            if (number(next) > content.size() - next - 8)
                fail("the BIN chunk is longer than the file");
            buffer_ = content.substr(next + 8, number(next));
        }
    }

    [[noreturn]] void fail(std::string_view rule) const
    {
        throw InvalidInput(join(path_, ": ", rule));
    }

    /// An entry of one of the lists of the description.
    const Json& entry(const char* list, std::int64_t index) const
    {
        const auto found = root_.find(list);
        if (found == root_.end() || !found->is_array() || index < 0 ||
            index >= std::ssize(*found) || !(*found)[to_size(index)].is_object())
            fail(join("there is no entry ", index, " of ", list));
        return (*found)[to_size(index)];
    }

    std::int64_t integer(const Json& object, const char* name,
                         std::optional<std::int64_t> otherwise = std::nullopt) const
    {
        const auto found = object.find(name);
        if (found == object.end() && otherwise)
            return *otherwise;
        if (found == object.end() || !found->is_number_integer())
            fail(join("'", name, "' is missing or no integer"));
        constexpr std::int64_t most = std::int64_t{1} << 40; // more than any file holds
        const auto value = found->get<std::int64_t>();       // negative beyond 2^63
        if (value < 0 || value > most)
            fail(join("'", name, "' is ", found->dump(), ", must be in [0, ", most, "]"));
        return value;
    }

    /// A list of the object; empty if there is none.
    const Json& list(const Json& object, const char* name) const
    {
        static const Json none = Json::array();
        const auto found = object.find(name);
        if (found == object.end())
            return none;
        if (!found->is_array())
            fail(join("'", name, "' is not a list"));
        return *found;
    }

    std::string text(const Json& object, const char* name) const
    {
        const auto found = object.find(name);
        return found != object.end() && found->is_string() ? found->get<std::string>() : "";
    }

    [[nodiscard]] std::int64_t accessor_count(std::int64_t index) const
    {
        return integer(entry("accessors", index), "count");
    }

    /// The values of an accessor, count by `components`.
    [[nodiscard]] Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values(
        std::int64_t index, int components) const
    {
        const Json& accessor = entry("accessors", index);
        const std::string wanted = components == 3 ? "VEC3" : "SCALAR";
        if (text(accessor, "type") != wanted)
            fail(join("accessor ", index, " must have the type ", wanted));
        const std::int64_t count = accessor_count(index);
        const std::int64_t most =
            components == 3 ? MeshBuilder::vertex_limit : 3 * MeshBuilder::face_limit;
        if (count > most)
            throw LimitExceeded(
                join(path_, ": accessor ", index, " has ", count, " values; the limit is ", most));
        const std::int64_t type = integer(accessor, "componentType");
        if (components == 1)
            check_index_type(type);
        const bool is_normalised =
            accessor.contains("normalized") && accessor["normalized"] == Json(true);
        const auto sparse = accessor.find("sparse");
        const bool has_view = accessor.contains("bufferView");
        std::optional<View> view;
        // What is all zeros but for some has the length of what is in the file.
        if (!has_view && (components == 1 || count > static_cast<std::int64_t>(buffer_.size()) / 3))
            fail(join("accessor ", index, " has ", count, " values and no bufferView"));
        if (has_view)
            view = view_of(accessor, count, components, type);
        Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> result(count,
                                                                                      components);
        result.setZero();
        if (view)
            for (std::int64_t i = 0; i < count; ++i)
                for (int c = 0; c < components; ++c)
                    result(i, c) = view->value(i, c, type, is_normalised);
        if (sparse == accessor.end())
            return result;
        const std::int64_t changed = integer(*sparse, "count");
        if (changed > count || !sparse->contains("indices") || !sparse->contains("values"))
            fail(join("accessor ", index, " is sparse in a way that does not fit"));
        const Json& where = (*sparse)["indices"];
        const std::int64_t where_type = integer(where, "componentType");
        check_index_type(where_type);
        const View places = view_of(where, changed, 1, where_type);
        const View news = view_of((*sparse)["values"], changed, components, type);
        for (std::int64_t i = 0; i < changed; ++i) {
            const auto row = static_cast<std::int64_t>(places.value(i, 0, where_type, false));
            if (row < 0 || row >= count)
                fail(join("accessor ", index, " changes value ", row, " of ", count));
            for (int c = 0; c < components; ++c)
                result(row, c) = news.value(i, c, type, is_normalised);
        }
        return result;
    }

    [[nodiscard]] const Json& root() const { return root_; }
    /// GlbLimits::rows, of so many bytes each.
    [[nodiscard]] std::int64_t row_limit(std::size_t bytes) const
    {
        return std::max(limits_.rows, static_cast<std::int64_t>(buffer_.size() / bytes));
    }

private:
    struct View
    {
        const char* bytes;
        std::int64_t stride;
        std::int64_t size; ///< Of a component.

        [[nodiscard]] double value(std::int64_t row, int column, std::int64_t type,
                                   bool is_normalised) const
        {
            const char* const at = bytes + row * stride + column * size;
            const auto read = [&]<class Value>(Value value) {
                std::memcpy(&value, at, sizeof value);
                return static_cast<double>(value);
            };
            const auto scaled = [&](double value, double largest) {
                return is_normalised ? std::max(value / largest, -1.0) : value;
            };
            switch (type) {
                case 5120:
                    return scaled(read(std::int8_t{}), 127.0);
                case 5121:
                    return scaled(read(std::uint8_t{}), 255.0);
                case 5122:
                    return scaled(read(std::int16_t{}), 32767.0);
                case 5123:
                    return scaled(read(std::uint16_t{}), 65535.0);
                case 5125:
                    return read(std::uint32_t{});
                default:
                    return read(float{});
            }
        }
    };

    void check_index_type(std::int64_t type) const
    {
        if (type != 5121 && type != 5123 && type != 5125)
            fail(join("indices have the componentType ", type, ", must be 5121, 5123 or 5125"));
    }

    /// @param part  An accessor, or the indices or values of a sparse one.
    [[nodiscard]] View view_of(const Json& part, std::int64_t count, int components,
                               std::int64_t type) const
    {
        const std::int64_t size = type == 5120 || type == 5121   ? 1
                                  : type == 5122 || type == 5123 ? 2
                                  : type == 5125 || type == 5126 ? 4
                                                                 : 0;
        if (size == 0)
            fail(join("componentType ", type, " does not exist"));
        const std::int64_t index = integer(part, "bufferView");
        const Json& view = entry("bufferViews", index);
        const Json& buffer = entry("buffers", integer(view, "buffer"));
        if (integer(view, "buffer") != 0 || buffer.contains("uri"))
            fail(
                "the data lie in another file, or in the text of this one (uri); export as one "
                ".glb file");
        const std::int64_t begin = integer(view, "byteOffset", 0);
        const std::int64_t length = integer(view, "byteLength");
        const std::int64_t offset = integer(part, "byteOffset", 0);
        const std::int64_t stride = integer(view, "byteStride", size * components);
        const auto available = static_cast<std::int64_t>(buffer_.size());
        if (begin + length > available || offset > length ||
            (count > 0 && (stride < size * components || (count - 1) > (length - offset) / stride ||
                           (count - 1) * stride + size * components > length - offset)))
            fail(join("bufferView ", index, " does not hold the ", count,
                      " values that are to be in it, or lies outside the file"));
        return {buffer_.data() + begin + offset, stride, size};
    }

    std::string path_;
    GlbLimits limits_;
    Json root_;
    std::string_view buffer_;
};

Eigen::Matrix4d local_matrix(const Glb& glb, const Json& node)
{
    constexpr double rounding_of_8_bits = 0.00769; // as the glTF validator allows it
    constexpr double rounding_of_text = 1e-6;
    const auto numbers = [&](const char* name, std::vector<double> standard) {
        const Json& list = glb.list(node, name);
        if (list.empty())
            return standard;
        if (list.size() != standard.size())
            glb.fail(join("'", name, "' of a node has ", list.size(), " numbers"));
        for (std::size_t i = 0; i < standard.size(); ++i) {
            if (!list[i].is_number())
                glb.fail(join("'", name, "' of a node holds something other than numbers"));
            standard[i] = list[i].get<double>();
        }
        return standard;
    };
    if (node.contains("matrix")) {
        for (const char* other : {"translation", "rotation", "scale"})
            if (node.contains(other)) // glTF 2.0, section 5.25
                glb.fail(join("a node has both 'matrix' and '", other,
                              "', which glTF forbids as one may say other than the other; take one "
                              "of them out, or export again"));
        const std::vector<double> columns = numbers("matrix", std::vector<double>(16, 0.0));
        Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix4d>(columns.data());
        const Eigen::RowVector4d last = matrix.row(3);
        if ((last - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > rounding_of_text)
            glb.fail(join("'matrix' of a node has the last row (", last[0], ", ", last[1], ", ",
                          last[2], ", ", last[3],
                          "), must be (0, 0, 0, 1): glTF knows no perspective; apply the "
                          "transformation in the program that made it and export again"));
        return matrix;
    }
    const std::vector<double> move = numbers("translation", {0, 0, 0});
    const std::vector<double> turn = numbers("rotation", {0, 0, 0, 1});
    const std::vector<double> scale = numbers("scale", {1, 1, 1});
    const Eigen::Quaterniond rotation(turn[3], turn[0], turn[1], turn[2]);
    if (!(std::abs(rotation.norm() - 1.0) <= rounding_of_8_bits))
        glb.fail(join("'rotation' of a node has the norm ", rotation.norm(),
                      ", must be 1 (a unit quaternion); export again, rotation applied"));
    const Eigen::Affine3d matrix = Eigen::Translation3d(move[0], move[1], move[2]) *
                                   rotation.normalized() *
                                   Eigen::Scaling(scale[0], scale[1], scale[2]);
    return matrix.matrix();
}

/// The nodes of the scene; of a file without one, a library of objects, those that are no node's child.
Json root_nodes(const Glb& glb)
{
    if (!glb.list(glb.root(), "scenes").empty())
        return glb.list(glb.entry("scenes", glb.integer(glb.root(), "scene", 0)), "nodes");
    const Json& nodes = glb.list(glb.root(), "nodes");
    std::set<Json> children;
    for (const Json& node : nodes)
        for (const Json& child : glb.list(node, "children"))
            children.insert(child);
    Json roots = Json::array();
    for (std::size_t i = 0; i < nodes.size(); ++i)
        if (!children.contains(i))
            roots.push_back(i);
    return roots;
}

struct PlacedMesh
{
    const Json* node;
    Eigen::Matrix4d place;
};

/// The nodes of the scene that have a mesh, in the order of the file's tree.
std::vector<PlacedMesh> placed_meshes(const Glb& glb)
{
    std::vector<std::pair<std::int64_t, Eigen::Matrix4d>> open;
    const auto push = [&](const Json& nodes, const Eigen::Matrix4d& parent) {
        for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
            if (!node->is_number_unsigned() || node->get<std::int64_t>() < 0) // beyond 2^63
                glb.fail(join("a node is referred to by ", in_quotes(node->dump()),
                              ", must be the number of one"));
            open.emplace_back(node->get<std::int64_t>(), parent);
        }
    };
    push(root_nodes(glb), Eigen::Matrix4d::Identity());
    std::set<std::int64_t> seen;
    std::vector<PlacedMesh> meshes;
    while (!open.empty()) {
        const auto [index, parent] = open.back();
        open.pop_back();
        if (!seen.insert(index).second)
            glb.fail(join("node ", index, " is met twice; nodes must form a tree"));
        const Json& node = glb.entry("nodes", index);
        const Eigen::Matrix4d place = parent * local_matrix(glb, node);
        if (node.contains("mesh")) // a skin places the mesh by its bones: here it stays in rest
            meshes.push_back(
                {&node, node.contains("skin") ? Eigen::Matrix4d::Identity().eval() : place});
        push(glb.list(node, "children"), place);
    }
    return meshes;
}

/// Refuses what hides a mesh: scales of 0 and near it, as animations have them.
void check_scales(const Glb& glb, std::int64_t mesh, const Eigen::Matrix4d& place)
{
    constexpr double flat = 1.0001e-4; // of the largest scale
    constexpr double no_unit = 1e-10;  // an angstrom in metres
    const Eigen::Matrix3d linear = place.topLeftCorner<3, 3>();
    if (!linear.allFinite())
        glb.fail(join("the node of mesh ", mesh, " scales it by a number that is not finite"));
    const Eigen::Vector3d scales = Eigen::JacobiSVD<Eigen::Matrix3d>(linear).singularValues();
    const char* const remedy = "; take the node out, or give it a scale, and export again";
    if (!(scales[0] >= no_unit))
        glb.fail(join("the node of mesh ", mesh, " shrinks it to nothing (a scale of ",
                      rounded(scales[0]), " makes it invisible)", remedy));
    if (scales[2] <= flat * scales[0])
        glb.fail(join("the node of mesh ", mesh, " flattens it (a scale of ", rounded(scales[2]),
                      scales[2] > 0.0 ? join(" beside one of ", rounded(scales[0])) : "", ")",
                      remedy));
}

Points moved(const Points& points, const Eigen::Matrix4d& place)
{
    if (place.isIdentity(0.0))
        return points;
    return (points * place.topLeftCorner<3, 3>().transpose()).rowwise() +
           place.topRightCorner<3, 1>().transpose();
}

std::vector<std::string> target_names(const Glb& glb, const Json& mesh, std::size_t count)
{
    std::vector<std::string> names;
    const auto extras = mesh.find("extras");
    if (extras != mesh.end() && extras->is_object())
        for (const Json& name : glb.list(*extras, "targetNames"))
            names.push_back(name.is_string() ? name.get<std::string>() : "");
    names.resize(count);
    for (std::size_t i = 0; i < count; ++i)
        if (names[i].empty())
            names[i] = join("target_", i + 1);
    return names;
}

/// Refuses what would read as another mesh: later versions, and extensions that a reader must know, but for those
/// of colours, light and the types of numbers.
void check_claims(const Glb& glb)
{
    const auto asset = glb.root().find("asset");
    const std::string version =
        asset != glb.root().end() && asset->is_object() ? glb.text(*asset, "version") : "";
    if (!version.starts_with("2."))
        glb.fail(join("the version of glTF is ", in_quotes(version), ", must be 2.0"));
    for (const Json& used : glb.list(glb.root(), "extensionsUsed"))
        if (used == "EXT_mesh_gpu_instancing")
            glb.fail(
                "shows copies of a mesh (EXT_mesh_gpu_instancing), which are not read; make them "
                "meshes of their own, or export without instancing");
    for (const Json& required : glb.list(glb.root(), "extensionsRequired")) {
        const std::string name = required.is_string() ? required.get<std::string>() : "";
        const bool is_compression = name.find("compression") != std::string::npos;
        bool is_harmless = name == "KHR_mesh_quantization";
        for (const char* of_looks : {"KHR_materials_", "KHR_texture_", "EXT_texture_",
                                     "KHR_lights_", "EXT_lights_", "MSFT_texture_"})
            is_harmless = is_harmless || name.starts_with(of_looks);
        if (!is_harmless)
            glb.fail(join("needs the extension ", in_quotes(name),
                          ", which is not read; export without ",
                          is_compression ? "compression" : "it"));
    }
}

/// The mesh and its morph targets as they are put together: coordinates of each, of the same vertices.
struct Members
{
    std::vector<std::vector<double>> coordinates;
    MeshBuilder base;

    /// Vertices of a primitive in all of them, the mesh first.
    void add_vertices(const Glb& glb, std::int64_t accessor, const Json& targets,
                      const std::filesystem::path& path)
    {
        const std::int64_t count = base.vertex_count() + glb.accessor_count(accessor);
        const std::int64_t limit = glb.row_limit(12);
        if (count > limit / std::ssize(coordinates))
            throw LimitExceeded(join(path.string(), ": ", coordinates.size(), " meshes of ", count,
                                     " vertices; the limit is ", limit, " vertices in all"));
        const auto positions = glb.values(accessor, 3);
        base.reserve(count, 0);
        for (const auto& row : positions.rowwise())
            base.add_vertex(row[0], row[1], row[2]);
        const auto append = [](std::vector<double>& to, const auto& points) {
            to.insert(to.end(), points.data(), points.data() + points.size());
        };
        append(coordinates[0], positions);
        for (std::size_t t = 0; t < targets.size(); ++t) {
            Points target = positions;
            if (targets[t].contains("POSITION")) {
                const auto offsets = glb.values(glb.integer(targets[t], "POSITION"), 3);
                if (offsets.rows() != target.rows())
                    glb.fail(join("morph target ", t, " moves ", offsets.rows(),
                                  " vertices, the mesh has ", target.rows()));
                target += offsets;
            }
            if (!target.allFinite())
                glb.fail(join("morph target ", t, " has a coordinate that is not finite"));
            append(coordinates[t + 1], target);
        }
    }

    /// Triangles of a primitive whose `count` vertices begin with `first`.
    void add_triangles(const Glb& glb, const Json& primitive, std::int64_t first,
                       std::int64_t count)
    {
        const auto corners = [&]() -> Eigen::Matrix<double, Eigen::Dynamic, 1> {
            if (primitive.contains("indices"))
                return glb.values(glb.integer(primitive, "indices"), 1);
            return Eigen::VectorXd::LinSpaced(count, 0.0, static_cast<double>(count - 1));
        }();
        if (corners.size() % 3 != 0)
            glb.fail(join("triangles have ", corners.size(), " corners"));
        for (Eigen::Index c = 0; c < corners.size(); c += 3) {
            std::array<std::int64_t, 3> face{};
            for (int i = 0; i < 3; ++i) {
                face[to_size(i)] = static_cast<std::int64_t>(corners[c + i]);
                if (face[to_size(i)] >= count)
                    glb.fail(join("a triangle names vertex ", face[to_size(i)], " of ", count));
                face[to_size(i)] += first;
            }
            base.add_polygon(face);
        }
    }
};

using Primitives = std::vector<const Json*>;

/// Those of a mesh that are triangles. Points and lines, as exporters make of loose vertices and edges, are passed over.
Primitives triangles_of(const Glb& glb, const Json& mesh)
{
    constexpr std::int64_t triangles = 4; // below it points and lines, above strips and fans
    const Json& all = glb.list(mesh, "primitives");
    if (all.empty())
        glb.fail("a mesh has no primitives");
    Primitives chosen;
    for (const Json& primitive : all) {
        if (!primitive.is_object() || !primitive.contains("attributes"))
            glb.fail("a primitive has no attributes");
        const std::int64_t mode = glb.integer(primitive, "mode", triangles);
        if (mode < triangles)
            continue;
        if (mode > triangles)
            glb.fail(join("a primitive has the mode ", mode,
                          " (strips or fans), must be 4: triangles; export single triangles"));
        const auto extensions = primitive.find("extensions");
        if (extensions != primitive.end() && extensions->contains("KHR_draco_mesh_compression"))
            glb.fail("the mesh is compressed by Draco; export without compression");
        chosen.push_back(&primitive);
    }
    return chosen;
}

/// The same for every mesh that a node shows, by its number.
std::map<std::int64_t, Primitives> triangles_of_meshes(const Glb& glb,
                                                       const std::vector<PlacedMesh>& placed)
{
    std::map<std::int64_t, Primitives> triangles;
    for (const PlacedMesh& node : placed) {
        const std::int64_t mesh = glb.integer(*node.node, "mesh");
        const auto [place, is_new] = triangles.try_emplace(mesh);
        if (is_new)
            place->second = triangles_of(glb, glb.entry("meshes", mesh));
    }
    return triangles;
}

/// The mesh itself, then each of its morph targets with weight one.
/// @param primitives  Of triangles, at least one.
std::vector<Points> members(const Glb& glb, const Primitives& primitives, Faces& faces,
                            const MeshReadOptions& options, const std::filesystem::path& path)
{
    // Materials of one surface are primitives that look into one array of vertices: those are one set.
    std::map<std::vector<std::int64_t>, std::int64_t>
        known; // accessors of a primitive to its first vertex
    Members all{{}, MeshBuilder(path, options, [&](std::string_view rule) { glb.fail(rule); })};
    for (const Json* const described : primitives) {
        const Json& primitive = *described;
        const Json& targets = glb.list(primitive, "targets");
        if (described == primitives.front())
            all.coordinates.resize(1 + targets.size());
        else if (all.coordinates.size() != 1 + targets.size())
            glb.fail("the primitives of a mesh have different numbers of morph targets");
        const std::int64_t accessor = glb.integer(primitive["attributes"], "POSITION");
        const std::int64_t count = glb.accessor_count(accessor);
        std::vector<std::int64_t> accessors{accessor};
        for (const Json& target : targets)
            accessors.push_back(target.contains("POSITION") ? glb.integer(target, "POSITION") : -1);
        const auto [place, is_new] = known.try_emplace(accessors, all.base.vertex_count());
        if (is_new)
            all.add_vertices(glb, accessor, targets, path);
        all.add_triangles(glb, primitive, place->second, count);
    }
    faces = all.base.finish().faces;
    std::vector<Points> result;
    for (std::vector<double>& of_member : all.coordinates) {
        result.emplace_back(Eigen::Map<const Points>(of_member.data(), all.base.vertex_count(), 3));
        of_member = {};
    }
    return result;
}

} // namespace

MeshFileContent parse_glb(std::string_view content, const std::filesystem::path& path,
                          const MeshReadOptions& options)
{
    return parse_glb(content, path, options, {});
}

MeshFileContent parse_glb(std::string_view content, const std::filesystem::path& path,
                          const MeshReadOptions& options, const GlbLimits& limits)
{
    const Glb glb(content, path.string(), limits);
    check_claims(glb);
    std::vector<PlacedMesh> placed = placed_meshes(glb);
    if (placed.empty())
        glb.fail("no node of the scene has a mesh");
    const std::map<std::int64_t, Primitives> triangles = triangles_of_meshes(glb, placed);
    std::erase_if(placed, [&](const PlacedMesh& node) {
        return triangles.at(glb.integer(*node.node, "mesh")).empty();
    });
    if (placed.empty())
        glb.fail("its meshes are points and lines alone; export them with their faces");
    const std::string stem = text_name(path.stem().string());
    MeshFileContent result{.meshes = {}, .single_precision = true};
    std::set<std::string> taken;
    std::map<std::string, int> numbers; // the next one of a name that many want
    const auto add = [&](std::string name, Points points, const Faces& faces) {
        const std::string wanted = name;
        while (!taken.insert(name).second)
            name = join(wanted, " (", ++numbers.try_emplace(wanted, 1).first->second, ")");
        result.meshes.push_back({name, path.string(), std::move(points), faces});
    };
    const std::int64_t row_limit = glb.row_limit(6);
    std::int64_t rows = 0;
    for (const PlacedMesh& node : placed) {
        const std::int64_t number = glb.integer(*node.node, "mesh");
        const Json& mesh = glb.entry("meshes", number);
        Faces faces;
        std::vector<Points> points = members(glb, triangles.at(number), faces, options, path);
        if (result.meshes.size() + points.size() > limits.meshes)
            throw LimitExceeded(join(path.string(),
                                     ": its nodes and their morph targets are more than ",
                                     limits.meshes, " meshes, the limit; export fewer in a file"));
        rows += std::ssize(points) * std::max(points.front().rows(), faces.rows());
        if (rows > row_limit)
            throw LimitExceeded(
                join(path.string(), ": its nodes place more than ", row_limit,
                     " vertices or faces in all, the limit; export fewer in a file"));
        check_scales(glb, number, node.place);
        if (node.place.topLeftCorner<3, 3>().determinant() < 0.0) // glTF 2.0, section 3.7.4
            faces.col(1).swap(faces.col(2));
        std::string name = stem;
        if (placed.size() > 1) {
            const std::string own = glb.text(*node.node, "name");
            name =
                join(stem, "_", text_name(own.empty() ? join("node ", &node - &placed[0]) : own));
        }
        const std::vector<std::string> names = target_names(glb, mesh, points.size() - 1);
        for (std::size_t i = 0; i < points.size(); ++i) {
            Points in_scene = moved(points[i], node.place);
            if (!in_scene.allFinite())
                glb.fail("a node moves its mesh to where coordinates are not finite");
            add(i == 0 ? name : join(name, "_", text_name(names[i - 1])), std::move(in_scene),
                faces);
        }
    }
    return result;
}

} // namespace shape::internal
