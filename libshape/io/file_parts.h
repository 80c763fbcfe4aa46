// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/io/hdf5/reader.h"
#include "libshape/io/hdf5/writer.h"
#include "libshape/io/model_file.h"
#include "libshape/mesh/labels.h"
#include "libshape/mesh/topology.h"

// What the files of collections, models and differences have in common. Internal to io/. The
// functions that add to a content refer to their arguments, which must outlive it.

namespace shape::internal {

/// A content with the attributes that say what the file is.
[[nodiscard]] Hdf5Content begin_content(FileKind kind);

/// @throws WrongFileKind if the file is of another kind; InvalidInput if of a version that is not known.
void check_kind(const Hdf5File& file, FileKind kind);

void add_topology(Hdf5Content& content, const Topology& topology);

/// @throws InvalidInput if the faces are not a Topology or the edges are not its edges.
[[nodiscard]] Topology read_topology(const Hdf5File& file, Eigen::Index vertex_count);

/// Angles of boundary edges are 0: others tell of faces that are missing.
/// @param angles  Rows of #E [rad].
void check_boundary_angles(const Hdf5File& file, const std::string& name, const Topology& topology,
                           const RowMatrix& angles);

void add_strings(Hdf5Content& content, std::string name, Eigen::Index count,
                 const std::vector<std::string>& strings);

/// @throws InvalidInput if a name occurs twice.
void add_names(Hdf5Content& content, Eigen::Index count, const std::vector<std::string>& names);
[[nodiscard]] std::vector<std::string> read_names(const Hdf5File& file, Eigen::Index count);

/// Names that HDF5 has no room for (a `/` is a path there, `.` the group) are percent-encoded, and the attribute
/// label_names says so.
/// @throws InvalidInput if a column name is not storable (is_storable_label()) or occurs twice.
void add_labels(Hdf5Content& content, Eigen::Index count, const Labels& labels);
[[nodiscard]] Labels read_labels(const Hdf5File& file, Eigen::Index count);

void add_scale(Hdf5Content& content, Scale scale);
[[nodiscard]] Scale read_scale(const Hdf5File& file);

/// Adds the numbers of a matrix or vector.
/// @throws InvalidInput if one is not finite.
template <class Matrix>
void add_numbers(Hdf5Content& content, std::string name, Extents extents, const Matrix& values)
{
    if (!values.allFinite())
        throw InvalidInput(name + ": a value is not finite");
    content.datasets.push_back({std::move(name), std::move(extents),
                                std::span<const double>(values.data(), to_size(values.size()))});
}

} // namespace shape::internal
