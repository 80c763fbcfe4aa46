// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"
#include "libshape/statistics/column_effects.h"
#include "tools/output/mesh_output.h"
#include "tools/program/session.h"

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace shape::tools {

/// Adds --effects.
CLI::Option* add_effects(CLI::App& command, std::string& path);

/// Refuses the files of --effects before any work is done.
/// @throws as check_ending() and check_output().
void check_effects(const Session& session, const std::filesystem::path& path,
                   const std::vector<std::filesystem::path>& inputs);

/// Writes effects per edge as a table beside `path`, and averaged to the vertices of a mesh as
/// `path`; says how many edges are significant.
/// @param form  Its --ascii, --float and --colors are heeded.
/// @return The fields `outputs`, `edges`, `significant_edges` and `largest_effect`.
[[nodiscard]] Json write_effects(const Session& session, const std::filesystem::path& path,
                                 const Topology& topology, const Points& points,
                                 const ColumnEffects& effects, const MeshOutputArguments& form);

} // namespace shape::tools
