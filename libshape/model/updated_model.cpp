// SPDX-License-Identifier: MIT

#include "libshape/model/updated_model.h"

#include <set>
#include <string>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
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
    // The sums of both are exact to some 1e-15; modes below 1e-12 of the largest are not kept.
    constexpr double rounding = 1e-12;
    const double lost = model.total_variance - model.variances.sum();
    if (model.mode_count() != count - 1 && !(lost <= rounding * model.total_variance))
        throw InvalidInput(join("update: the model has ", model.mode_count(), " modes of ",
                                count - 1, ", which lack ", 100.0 * lost / model.total_variance,
                                " % of its variance; only one of all modes still knows its meshes: "
                                "fit all of them again"));
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

} // namespace

ShapeModel update_model(const ShapeModel& model, const Collection& added,
                        const ModelOptions& options)
{
    check(options);
    check_fit(model, added);
    const Index known = model.scores.rows();
    const auto count = static_cast<Index>(added.size());
    RowMatrix coordinates(known + count, model.mean.size());
    coordinates.topRows(known).noalias() = model.scores * model.modes;
    coordinates.topRows(known).rowwise() += model.mean.transpose();
    coordinates.bottomRows(count) = encode(model.space, added);
    const auto angles = [&] {
        RowMatrix all(known + count, model.topology.edge_count());
        all.topRows(known).noalias() = model.scores * model.mode_dihedral_angles;
        all.topRows(known).rowwise() += model.mean_dihedral_angles.transpose();
        all.topRows(known) = all.topRows(known).unaryExpr(&wrapped_angle);
        for (Index i = 0; i < count; ++i)
            all.row(known + i) =
                dihedral_angles(added.topology, added.points[to_size(i)]).transpose();
        return unify_branches(std::move(all));
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

std::uint64_t update_memory(const ShapeModel& model, Index added, const ModelOptions& options)
{
    const auto edges = static_cast<std::uint64_t>(model.topology.edge_count());
    const auto before = static_cast<std::uint64_t>(model.scores.rows());
    const auto after = before + static_cast<std::uint64_t>(added);
    const std::uint64_t modes =
        options.modes > 0 ? static_cast<std::uint64_t>(options.modes) : after - 1;
    // Of each edge both models hold a length and an angle a mode; beside them stand all coordinates and then, while their
    // branches are unified, all angles, each with a copy of some or all.
    const std::uint64_t numbers =
        2 * edges * (static_cast<std::uint64_t>(model.mode_count()) + modes + after) +
        3 * static_cast<std::uint64_t>(model.topology.vertex_count()) *
            static_cast<std::uint64_t>(added) +
        3 * after * after;
    return sizeof(double) * numbers;
}

} // namespace shape
