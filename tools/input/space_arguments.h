// SPDX-License-Identifier: MIT

#pragma once

#include <optional>
#include <string>

#include "libshape/edge_space/shape_space.h"
#include "tools/program/session.h"

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace shape::tools {

/// Adds --space, which is returned, --scale, --coordinates, --area-weighted, --with-dihedrals and
/// --with-positions.
CLI::Option* add_space_options(CLI::App& command, SpaceOptions& options);

/// Refuses all of these options beside another, which brings its own space.
void exclude_space_options(CLI::App& command, CLI::Option& other);

/// @throws UsageError if an option of edge space is given for Procrustes space.
void check_space_options(const SpaceOptions& options);

/// "unit" or "none".
[[nodiscard]] const char* name(Scale scale);

/// The fields space, scale and, in edge space, coordinates, area_weighted, with_dihedrals and
/// with_positions.
[[nodiscard]] Json space_figures(const ShapeSpace& space);

/// What is said of a Procrustes alignment that stopped short.
[[nodiscard]] std::optional<std::string> doubt_about_alignment(const ShapeSpace& space);

/// Says that on stderr.
void warn_of_alignment(const Session& session, const ShapeSpace& space);

} // namespace shape::tools
