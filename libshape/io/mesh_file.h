// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libshape/mesh/collection.h"
#include "libshape/mesh/points.h"

namespace shape {

/// Formats of single meshes.
enum class MeshFormat
{
    Obj,
    Ply, ///< Read: ascii and both binary orders. Written: binary little-endian, double coordinates.
    Off,
    Stl, ///< Single precision; corners of equal coordinates become one vertex.
    Vtk, ///< Legacy VTK polydata. Written: binary, double coordinates.
    Vtp, ///< XML polydata of VTK. Read only if the library was built with pugixml.
    Glb, ///< Binary glTF 2.0, single precision; see gltf_file.h.
};

/// A triangulation as whose triangles the polygons of other meshes of the same vertices are cut.
struct KnownTriangulation
{
    Faces faces;
    Eigen::Index vertices = 0;
    std::string path;    ///< For messages.
    bool is_cut = false; ///< Of polygons, so that other diagonals would do as well.
};

/// How polygons are cut so that meshes that are read one after another correspond: as the first of the triangulations of
/// as many vertices and faces that has all of their diagonals. Of one that has those of some polygons alone, these are
/// cut so, the others as they would be alone.
struct PolygonCuts
{
    /// Those that are there before, and what is read is added to; see add_triangulation().
    std::vector<KnownTriangulation> known;
    std::size_t cut_meshes = 0; ///< Meshes with polygons that were read.

    struct Folded
    {
        std::string path;
        std::string message; ///< With the path, the number of polygons and the first.
    };
    /// Each mesh of which polygons, cut so, fold over though they could be cut without folds.
    std::vector<Folded> folded;
};

/// Adds a triangulation unless it is known, at most 16.
void add_triangulation(PolygonCuts& cuts, const NamedMesh& mesh, bool is_cut = false);

/// Where the first mesh was cut from polygons, and one that was read as triangles differs from it by their diagonals alone:
/// what cuts the polygons of all as that one, once they are read anew.
[[nodiscard]] std::optional<PolygonCuts> better_cuts(const PolygonCuts& cuts);

struct MeshReadOptions
{
    /// Polygons are cut into triangles, else refused: as fans from their first corner, those of which the fan folds over
    /// (a triangle n, the polygon N, normals weighted by area, and n . N <= 0) by ears.
    bool triangulate = false;
    /// Meshes that are read with it are cut alike, if `triangulate`.
    PolygonCuts* cuts = nullptr;
};

/// The meshes of one file, and what its format has cost them.
struct MeshFileContent
{
    /// At least one. A GLB file has one for every node that shows a mesh, and after it one for every
    /// morph target, with weight one; all others have one.
    std::vector<NamedMesh> meshes;
    /// STL, VTK, VTP and GLB: coordinates are float32, of about 7 digits.
    bool single_precision = false;
    /// STL: this many corners became the vertices, by equal coordinates, numbered in the order of their
    /// first appearance. Else 0.
    Eigen::Index merged_corners = 0;
};

/// Reads a mesh strictly: vertex and face order and double precision are kept, nothing is guessed
/// (docs/formats.md says what is read). Only syntax is checked (numbers, counts, index range); the
/// surface itself is Topology's matter.
/// @throws FileError if the file cannot be read or is not a regular file.
/// @throws LimitExceeded beyond 2 GiB, 20 million vertices or 40 million triangles.
/// @throws InvalidInput naming file, line or byte offset, and rule, for anything malformed: an
///     unknown ending or that of a format not read, counts that disagree with the data or exceed
///     the file's size, coordinates that are missing or not finite, indices out of range, polygons
///     without `triangulate`, or that cross themselves; or if the file holds several meshes.
/// Cost: linear in the size of the file, which is held in memory.
[[nodiscard]] NamedMesh read_mesh(const std::filesystem::path& path,
                                  const MeshReadOptions& options = {});

/// The same of all meshes in a file; their names differ.
[[nodiscard]] MeshFileContent read_mesh_members(const std::filesystem::path& path,
                                                const MeshReadOptions& options = {});

/// Writes a mesh: the file appears whole or not at all: it is written beside, synced and renamed. read_mesh() gives every bit of it back, except of STL and
/// GLB, which are single precision. mesh_write_options.h has further ways to write.
/// @throws InvalidInput if a coordinate is not finite or a face names a missing vertex.
/// @throws FileError if it cannot be written.
void write_mesh(const std::filesystem::path& path, const Points& points, const Faces& faces,
                MeshFormat format);

/// The same in the format of mesh_format(path).
/// @throws as write_mesh() and mesh_format().
void write_mesh(const std::filesystem::path& path, const Points& points, const Faces& faces);

/// The format that the ending of a path tells (".obj", ".ply", ".off", ".stl", ".vtk", ".vtp",
/// ".glb", any case).
/// @throws InvalidInput for any other; the message lists those that exist.
[[nodiscard]] MeshFormat mesh_format(const std::filesystem::path& path);

/// ".obj" and so on.
[[nodiscard]] std::string file_ending(MeshFormat format);

} // namespace shape
