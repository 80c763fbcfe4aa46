// SPDX-License-Identifier: MIT

#include "libshape/io/gltf_file.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
#include "libshape/base/version.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/mesh_formats.h"
#include "libshape/mesh/keyframes.h"

namespace shape {
using namespace internal;
namespace {

using Json = nlohmann::ordered_json;
using FloatPoints = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

// The numbers by which glTF names types and buffers.
constexpr int type_float = 5126;
constexpr int type_uint32 = 5125;
constexpr int vertex_buffer = 34962;
constexpr int index_buffer = 34963;

constexpr double largest_glb = 4294967295.0; // [byte]; a GLB file states its length in 32 bits

/// The description of a glTF file and its only buffer, which grows by one array at a time.
struct Asset
{
    Json description;
    std::string buffer;

    Asset()
    {
        description["asset"] = {{"version", "2.0"}, {"generator", join("libshape ", version())}};
        description["scene"] = 0;
        description["scenes"] = Json::array({{{"nodes", Json::array({0})}}});
    }

    /// Appends an array of 4-byte numbers; returns the index of its accessor.
    template <class Array>
    std::size_t add(const Array& array, const char* type, Eigen::Index count, Json details,
                    int target = 0)
    {
        static_assert(sizeof(array(0)) == 4 && std::endian::native == std::endian::little,
                      "what is appended is aligned, and its bytes are those of the file");
        const auto size = to_size(array.size()) * sizeof(array(0));
        Json view{{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", size}};
        if (target != 0)
            view["target"] = target;
        buffer.append(reinterpret_cast<const char*>(array.data()), size);
        details.update(
            {{"bufferView", description["bufferViews"].size()}, {"type", type}, {"count", count}});
        description["bufferViews"].push_back(std::move(view));
        description["accessors"].push_back(std::move(details));
        return description["accessors"].size() - 1;
    }

    std::size_t add_vectors(const FloatPoints& vectors, Json details = Json::object())
    {
        details["componentType"] = type_float;
        return add(vectors, "VEC3", vectors.rows(), std::move(details), vertex_buffer);
    }

    /// Positions state their bounds.
    std::size_t add_positions(const FloatPoints& positions)
    {
        Json low = Json::array();
        Json high = Json::array();
        for (int axis = 0; axis < 3; ++axis) {
            low.push_back(positions.col(axis).minCoeff());
            high.push_back(positions.col(axis).maxCoeff());
        }
        return add_vectors(positions, {{"min", low}, {"max", high}});
    }

    std::size_t add_numbers(const Eigen::VectorXf& numbers)
    {
        return add(numbers, "SCALAR", numbers.size(),
                   {{"componentType", type_float},
                    {"min", Json::array({numbers.minCoeff()})},
                    {"max", Json::array({numbers.maxCoeff()})}});
    }

    std::size_t add_indices(const Faces& faces)
    {
        return add(faces, "SCALAR", faces.size(), {{"componentType", type_uint32}}, index_buffer);
    }
};

/// Single precision, relative to a centre.
FloatPoints relative_positions(const Points& points, const Eigen::RowVector3d& centre)
{
    FloatPoints positions = (points.rowwise() - centre).cast<float>();
    if (!positions.allFinite())
        throw InvalidInput("points: a coordinate is beyond the single precision of glTF");
    return positions;
}

/// Unit normals, area-weighted means over the faces at each vertex; +z where they cancel.
FloatPoints vertex_normals(const Points& points, const Faces& faces)
{
    Points sums = Points::Zero(points.rows(), 3);
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
        const Eigen::RowVector3d a = points.row(faces(f, 0));
        const Eigen::RowVector3d b = points.row(faces(f, 1));
        const Eigen::RowVector3d c = points.row(faces(f, 2));
        for (int corner = 0; corner < 3; ++corner)
            sums.row(faces(f, corner)) += (b - a).cross(c - a);
    }
    for (Eigen::Index v = 0; v < sums.rows(); ++v)
        sums.row(v) = sums.row(v).norm() > 0.0 ? Eigen::RowVector3d(sums.row(v).stableNormalized())
                                               : Eigen::RowVector3d::UnitZ();
    return sums.cast<float>();
}

/// Whether an edge has a face on one side only.
bool has_boundary(const Faces& faces)
{
    std::vector<std::pair<int, int>> halfedges;
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        for (int corner = 0; corner < 3; ++corner)
            halfedges.emplace_back(faces(f, corner), faces(f, (corner + 1) % 3));
    std::sort(halfedges.begin(), halfedges.end());
    return std::any_of(halfedges.begin(), halfedges.end(), [&](const auto& halfedge) {
        return !std::binary_search(halfedges.begin(), halfedges.end(),
                                   std::pair(halfedge.second, halfedge.first));
    });
}

Eigen::RowVector3d centre_of(const Points& points)
{
    return 0.5 * (points.colwise().minCoeff() + points.colwise().maxCoeff());
}

/// A scene that shows one mesh.
Asset mesh_asset(const Points& points, const Faces& faces)
{
    Asset asset;
    const Eigen::RowVector3d centre = centre_of(points);
    const std::size_t positions = asset.add_positions(relative_positions(points, centre));
    const std::size_t normals = asset.add_vectors(vertex_normals(points, faces));
    const std::size_t indices = asset.add_indices(faces);
    asset.description["nodes"] =
        Json::array({{{"mesh", 0}, {"translation", {centre.x(), centre.y(), centre.z()}}}});
    asset.description["materials"] = Json::array({{{"pbrMetallicRoughness",
                                                    {{"baseColorFactor", {0.67, 0.56, 0.48, 1.0}},
                                                     {"metallicFactor", 0.0},
                                                     {"roughnessFactor", 0.7}}},
                                                   {"doubleSided", has_boundary(faces)}}});
    const Json primitive{{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
                         {"indices", indices},
                         {"material", 0}};
    asset.description["meshes"] = Json::array({{{"primitives", Json::array({primitive})}}});
    return asset;
}

/// Adds a morph target for every keyframe but the first, and the animation of their weights: at its
/// own time a target has weight 1 and all others 0.
void animate(Asset& asset, const std::vector<Points>& frames, const Faces& faces,
             const std::vector<std::size_t>& keyframes, double frames_per_second)
{
    const auto count = static_cast<Eigen::Index>(keyframes.size());
    const Eigen::RowVector3d centre = centre_of(frames.front());
    const FloatPoints first_positions = relative_positions(frames.front(), centre);
    const FloatPoints first_normals = vertex_normals(frames.front(), faces);
    Json targets = Json::array();
    Json names = Json::array();
    Eigen::VectorXf times(count);
    Eigen::MatrixXf weights = Eigen::MatrixXf::Zero(count - 1, count); // a column a keyframe
    for (Eigen::Index k = 0; k < count; ++k) {
        const std::size_t frame = keyframes[to_size(k)];
        times[k] = static_cast<float>(static_cast<double>(frame) / frames_per_second);
        if (k == 0)
            continue;
        weights(k - 1, k) = 1.0F;
        const Points& points = frames[frame];
        targets.push_back(
            {{"POSITION",
              asset.add_positions(relative_positions(points, centre) - first_positions)},
             {"NORMAL", asset.add_vectors(vertex_normals(points, faces) - first_normals)}});
        names.push_back(join("frame ", frame));
    }
    Json& mesh = asset.description["meshes"][0];
    mesh["primitives"][0]["targets"] = targets;
    mesh["weights"] = std::vector<int>(keyframes.size() - 1, 0);
    mesh["extras"] = {{"targetNames", names}}; // where programs look for them by convention
    const std::size_t input = asset.add_numbers(times);
    const std::size_t output = asset.add_numbers(weights.reshaped());
    const Json sampler{{"input", input}, {"output", output}, {"interpolation", "LINEAR"}};
    const Json channel{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}};
    asset.description["animations"] = Json::array({{{"name", "frames"},
                                                    {"samplers", Json::array({sampler})},
                                                    {"channels", Json::array({channel})}}});
}

void append_uint32(std::string& text, std::size_t value)
{
    for (int shift = 0; shift < 32; shift += 8)
        text += static_cast<char>((value >> shift) & 0xffU);
}

/// The two chunks of a GLB file behind its head.
std::string print(Asset asset)
{
    asset.description["buffers"] = Json::array({{{"byteLength", asset.buffer.size()}}});
    std::string description = asset.description.dump();
    description.append((4 - description.size() % 4) % 4, ' ');
    const std::size_t size = 12 + 8 + description.size() + 8 + asset.buffer.size();
    if (static_cast<double>(size) > largest_glb)
        throw LimitExceeded(
            join("a GLB file of ", size, " bytes; the limit is 4 GiB: write fewer frames"));
    std::string text = "glTF";
    text.reserve(size);
    append_uint32(text, 2);
    append_uint32(text, size);
    append_uint32(text, description.size());
    text += "JSON" + description;
    append_uint32(text, asset.buffer.size());
    text += std::string("BIN\0", 4);
    text += asset.buffer;
    return text;
}

} // namespace

std::string internal::print_glb(const Points& points, const Faces& faces, const MeshWriteOptions&)
{
    return print(mesh_asset(points, faces));
}

void check(const GlbAnimationOptions& options)
{
    require_not_negative(options.tolerance, "GlbAnimationOptions.tolerance");
    require_positive(options.frames_per_second, "GlbAnimationOptions.frames_per_second");
    // Times are single precision; beyond these they would be infinite, or one time of all frames.
    if (options.frames_per_second < 1e-6 || options.frames_per_second > 1e6)
        throw InvalidInput(join("GlbAnimationOptions.frames_per_second is ",
                                options.frames_per_second, ", must be in [1e-6, 1e6]"));
}

GlbAnimation write_glb_animation(const std::filesystem::path& path,
                                 const std::vector<Points>& frames, const Faces& faces,
                                 const GlbAnimationOptions& options)
{
    check(options);
    if (frames.size() < 2)
        throw InvalidInput(join("frames has ", frames.size(), " entries, an animation needs two"));
    check_mesh(frames.front(), faces);
    const double diagonal = bounding_box_diagonal(frames.front());
    const Keyframes keyframes = choose_keyframes(frames, options.tolerance * diagonal);
    const double size = 24.0 * static_cast<double>(keyframes.frames.size()) *
                        static_cast<double>(frames.front().rows());
    if (size > largest_glb)
        throw LimitExceeded(join(keyframes.frames.size(), " keyframes of ", frames.front().rows(),
                                 " vertices; a GLB file cannot have 4 GiB: write fewer frames, or ",
                                 "allow a larger error"));
    Asset asset = mesh_asset(frames.front(), faces);
    animate(asset, frames, faces, keyframes.frames, options.frames_per_second);
    write_file_atomically(path, print(std::move(asset)));
    return {.keyframes = keyframes.frames,
            .error = diagonal > 0.0 ? keyframes.error / diagonal : 0.0,
            .seconds = static_cast<double>(frames.size() - 1) / options.frames_per_second};
}

} // namespace shape
