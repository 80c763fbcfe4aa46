// SPDX-License-Identifier: MIT

#include "tools/input/space_arguments.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "libshape/base/format.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;
namespace {

const char* name(LengthCoordinates coordinates)
{
    switch (coordinates) {
        case LengthCoordinates::Plain:
            return "plain";
        case LengthCoordinates::Squared:
            return "squared";
        case LengthCoordinates::Log:
            return "log";
    }
    return "";
}

} // namespace

CLI::Option* add_space_options(CLI::App& command, SpaceOptions& options)
{
    const std::string group = "Space of shapes";
    CLI::Option* space =
        add_choice(command, "--space", options.kind,
                   "edge: edge lengths, which are pose-invariant (default); procrustes: vertex\n"
                   "positions after generalised Procrustes alignment",
                   {{"edge", SpaceKind::Edge}, {"procrustes", SpaceKind::Procrustes}});
    space->group(group);
    add_choice(command, "--scale", options.scale,
               "unit: lengths are divided by their sum, positions by their centroid size, and\n"
               "size is kept apart (default); none: size is part of the shape",
               {{"unit", Scale::Unit}, {"none", Scale::None}})
        ->group(group);
    add_choice(command, "--coordinates", options.coordinates,
               "The function of the edge lengths that is the coordinate (default: plain)",
               {{"plain", LengthCoordinates::Plain},
                {"squared", LengthCoordinates::Squared},
                {"log", LengthCoordinates::Log}})
        ->group(group);
    command
        .add_flag_callback(
            "--area-weighted", [&options] { options.weighting = EdgeWeighting::Area; },
            "Weight the squared relative change of a length by the share of the mean's area\n"
            "around the edge, so that a densely meshed part does not dominate")
        ->group(group);
    add_number(command, "--with-dihedrals", options.dihedral_weight,
               "Dihedral angles are coordinates too: 1 rad counts as much as a relative change\n"
               "of length by this weight, > 0 (default: lengths alone)",
               Sign::Positive)
        ->group(group);
    add_number(command, "--with-positions", options.position_weight,
               "Vertex positions are coordinates too, after generalised Procrustes alignment:\n"
               "moving all vertices by 1 % of the diagonal counts as much as changing all\n"
               "lengths by this number of percent, > 0, say 5 (default: lengths alone)",
               Sign::Positive)
        ->group(group);
    return space;
}

void exclude_space_options(CLI::App& command, CLI::Option& other)
{
    for (const char* option : {"--space", "--scale", "--coordinates", "--area-weighted",
                               "--with-dihedrals", "--with-positions"})
        other.excludes(command.get_option(option));
}

void check_space_options(const SpaceOptions& options)
{
    if (options.kind == SpaceKind::Procrustes &&
        (options.coordinates != LengthCoordinates::Plain ||
         options.weighting != EdgeWeighting::Uniform || options.dihedral_weight != 0.0 ||
         options.position_weight != 0.0))
        throw UsageError(
            "--coordinates, --area-weighted, --with-dihedrals and --with-positions are "
            "options of --space edge");
}

const char* name(Scale scale)
{
    return scale == Scale::Unit ? "unit" : "none";
}

Json space_figures(const ShapeSpace& space)
{
    const EdgeSpace* edge = std::get_if<EdgeSpace>(&space);
    Json figures{{"space", edge ? "edge" : "procrustes"}, {"scale", name(scale_of(space))}};
    if (edge) {
        figures["coordinates"] = name(edge->coordinates);
        figures["area_weighted"] = edge->length_factors.size() > 0;
        figures["with_dihedrals"] = edge->dihedral_factors.size() > 0;
        figures["with_positions"] = edge->position_factors.size() > 0;
    }
    return figures;
}

std::optional<std::string> doubt_about_alignment(const ShapeSpace& space)
{
    const ProcrustesSpace* procrustes = std::get_if<ProcrustesSpace>(&space);
    if (!procrustes || procrustes->converged)
        return std::nullopt;
    return join("the Procrustes alignment still moved after ", procrustes->iterations,
                " iterations");
}

void warn_of_alignment(const Session& session, const ShapeSpace& space)
{
    if (const auto doubt = doubt_about_alignment(space))
        session.warn(*doubt);
}

} // namespace shape::tools
