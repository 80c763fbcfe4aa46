// SPDX-License-Identifier: MIT

#include "libshape/model/updated_model.h"

#include <set>
#include <string>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/joined_labels.h"
#include "libshape/model/model_frame.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

void check_fit(const ShapeModel& model, const Collection& added)
{
    const Index count = model.scores.rows();
    if (model.mode_count() != count - 1)
        throw InvalidInput(join("update: the model has ", model.mode_count(), " modes of ",
                                count - 1,
                                "; only one of all modes still knows its meshes: fit all of them "
                                "again"));
    const EdgeSpace* edge = std::get_if<EdgeSpace>(&model.space);
    if (edge == nullptr || edge->length_factors.size() > 0 || edge->dihedral_factors.size() > 0 ||
        edge->position_factors.size() > 0)
        throw InvalidInput(
            "update: the space of the model depends on all its meshes (area weights, "
            "dihedral angles, positions, Procrustes): fit all of them again");
    if (added.size() == 0)
        throw InvalidInput("update: there is no mesh to add");
    if (!(added.topology == model.topology))
        throw InvalidInput(join("update: ", describe_correspondence_break(
                                                {"the model", "the model", model.reference_points,
                                                 model.topology.faces()},
                                                {added.names.front(), "mesh " + added.names.front(),
                                                 added.points.front(), added.topology.faces()})));
    const std::set<std::string> names(model.names.begin(), model.names.end());
    for (const std::string& name : added.names)
        if (names.contains(name))
            throw InvalidInput(join("update: the model has a mesh '", name, "' already"));
}

/// The rows of both.
RowMatrix stacked(const RowMatrix& above, const RowMatrix& below)
{
    RowMatrix all(above.rows() + below.rows(), above.cols());
    all << above, below;
    return all;
}

} // namespace

ShapeModel update_model(const ShapeModel& model, const Collection& added,
                        const ModelOptions& options)
{
    check(options);
    check_fit(model, added);
    RowMatrix coordinates = stacked((model.scores * model.modes).rowwise() + model.mean.transpose(),
                                    encode(model.space, added));
    const auto angles = [&] {
        RowMatrix measured(static_cast<Index>(added.size()), model.topology.edge_count());
        for (std::size_t i = 0; i < added.size(); ++i)
            measured.row(static_cast<Index>(i)) =
                dihedral_angles(added.topology, added.points[i]).transpose();
        const RowMatrix known = (model.scores * model.mode_dihedral_angles).rowwise() +
                                model.mean_dihedral_angles.transpose();
        return unify_branches(stacked(known.unaryExpr(&wrapped_angle), measured));
    };
    Eigen::VectorXd all_sizes(coordinates.rows());
    all_sizes << model.sizes, sizes(model.space, added);
    Labels labels = model.labels;
    append_labels(labels, model.names.size(), added.labels, added.size());
    std::vector<std::string> names = model.names;
    names.insert(names.end(), added.names.begin(), added.names.end());
    return model_of({.topology = model.topology,
                     .reference_points = model.reference_points,
                     .space = model.space,
                     .names = std::move(names),
                     .labels = std::move(labels)},
                    std::move(coordinates), angles, std::move(all_sizes), options);
}

} // namespace shape
