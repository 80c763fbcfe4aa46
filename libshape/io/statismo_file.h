// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libshape/mesh/topology.h"
#include "libshape/model/linearised_model.h"

namespace shape {

/// Writes a model as Statismo 0.9 has it (HDF5), which Statismo, Scalismo, RvtkStatismo and Slicer's
/// extension read: positions of the mean, orthonormal basis, variances and scores in single precision,
/// triangles as int32, versions as scalars. Written as write_collection(). docs/ecosystem.md has the layout.
/// @param names  N, of the meshes that the model was made from.
/// @throws InvalidInput if sizes disagree or the path does not end in .h5; FileError if it cannot be written.
void write_statismo(const std::filesystem::path& path, const Topology& topology,
                    const LinearisedModel& model, const std::vector<std::string>& names);

} // namespace shape
