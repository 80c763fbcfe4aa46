// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace shape {

/// A named point on a mesh.
struct Landmark
{
    std::string scan; ///< Name of the mesh; empty: the file is of one mesh.
    std::string name;
    int vertex = -1; ///< Of the template, where the file says it; else -1.
    Eigen::Vector3d position = Eigen::Vector3d::Zero(); ///< [length]
};

/// The landmarks of a file.
struct LandmarkFile
{
    std::vector<Landmark> landmarks;
    /// Those whose three coordinates are missing: not to be seen on the scan, or not placed yet. Of the template a
    /// vertex may stand for them. Their positions mean nothing.
    std::vector<Landmark> missing;
};

/// Reads landmarks by the ending of the path:
///
///     .csv        columns name, x, y, z and, if there, scan and vertex (docs/correspondence.md); a
///                 scan may be named with the ending of its mesh file (.ply, .stl, ...)
///     .fcsv       3D Slicer, up to 4.11
///     .mrk.json   3D Slicer
///
/// Cells, names of columns and names of landmarks have no outer blanks and are missing by the rules of labels
/// (label_file.h); rows without anything in their cells are passed over. Points that Slicer calls undefined, missing or
/// a preview are missing too. Slicer's files say whether they count in LPS or RAS; positions come out in LPS, as Slicer
/// writes meshes.
/// @throws FileError if it cannot be read; InvalidInput naming file, row and rule for another ending,
///     a missing column, a landmark twice in a table without scan, one or two coordinates that are missing, a number that
///     is none, an unknown coordinate system, or no landmark.
[[nodiscard]] LandmarkFile read_landmarks(const std::filesystem::path& path);

/// Whether a path ends like one of these files.
[[nodiscard]] bool is_landmark_file(const std::filesystem::path& path);

} // namespace shape
