// SPDX-License-Identifier: MIT

#include "libshape/model/nuisance.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/statistics/projection.h"

namespace shape {
using namespace internal;
namespace {

void check_topology(const Nuisance& nuisance, const Collection& meshes)
{
    if (!(meshes.topology == nuisance.topology))
        throw InvalidInput(join(
            "nuisance: the meshes have another triangulation than its directions; ",
            describe_correspondence_break({"the nuisance", "the nuisance",
                                           nuisance.reference_points, nuisance.topology.faces()},
                                          {meshes.names.front(), "mesh " + meshes.names.front(),
                                           meshes.points.front(), meshes.topology.faces()})));
}

} // namespace

Nuisance leading_modes(const ShapeModel& model, int count)
{
    if (count < 1 || count > model.mode_count())
        throw InvalidInput(
            join("leading modes: ", count, " modes, must be in [1, ", model.mode_count(), "]"));
    return {model.topology, model.reference_points,     model.space,
            model.mean,     model.modes.topRows(count), model.mode_dihedral_angles.topRows(count)};
}

Nuisance direction_of(const DifferenceVector& difference)
{
    const double length = difference.edge_lengths.norm();
    if (!(length > 0.0))
        throw InvalidInput("direction: the difference is 0");
    return {difference.topology,
            difference.reference_points,
            EdgeSpace{difference.scale, LengthCoordinates::Plain, {}, {}, {}},
            difference.mean_edge_lengths,
            difference.edge_lengths.transpose() / length,
            difference.dihedral_angles.transpose() / length};
}

RowMatrix amounts_of(const Nuisance& nuisance, const Collection& collection)
{
    check_topology(nuisance, collection);
    return project_onto_subspace(encode(nuisance.space, collection), nuisance.origin,
                                 nuisance.directions)
        .scores;
}

DecodedShape with_amounts(const Nuisance& nuisance, const Collection& mesh,
                          const Eigen::VectorXd& amounts)
{
    if (mesh.size() != 1 || amounts.size() != nuisance.directions.rows() || !amounts.allFinite())
        throw InvalidInput(join("with amounts: ", mesh.size(), " meshes and ", amounts.size(),
                                " amounts, must be one and ", nuisance.directions.rows(),
                                " finite numbers"));
    check_topology(nuisance, mesh);
    const RowMatrix coordinates = encode(nuisance.space, mesh);
    const Eigen::VectorXd now =
        project_onto_subspace(coordinates, nuisance.origin, nuisance.directions)
            .scores.row(0)
            .transpose();
    const Eigen::VectorXd change = amounts - now;
    return decode(nuisance.space,
                  coordinates.row(0).transpose() + nuisance.directions.transpose() * change,
                  companions(nuisance.space, mesh).row(0).transpose() +
                      nuisance.dihedral_angles.transpose() * change,
                  sizes(nuisance.space, mesh)[0]);
}

} // namespace shape
