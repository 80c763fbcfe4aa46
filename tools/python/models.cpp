// SPDX-License-Identifier: MIT

#include <pybind11/pybind11.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <string>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/resized.h"
#include "libshape/io/model_file.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/model/group_means.h"
#include "libshape/statistics/group_comparison.h"
#include "libshape/statistics/group_spread.h"
#include "tools/commands.h"
#include "tools/doubts.h"
#include "tools/input/complete_labels.h"
#include "tools/input/space_arguments.h"
#include "tools/output/test_tables.h"
#include "tools/output/unlike_warnings.h"
#include "tools/program/progress_listener.h"
#include "tools/program/session.h"
#include "tools/python/handles.h"
#include "tools/python/jobs.h"

namespace shape::python {

using namespace internal;

std::shared_ptr<const Embedder> Embedders::get(const EmbeddingOptions& options) const
{
    const std::string key =
        join(static_cast<int>(options.method), " ",
             options.quality ? static_cast<int>(*options.quality) : -1, " ",
             print_number(options.smoothness.value_or(-1.0)), " ",
             options.seed ? std::to_string(*options.seed) : "none", " ", options.avoid_contact);
    const std::lock_guard lock(mutex_);
    std::shared_ptr<const Embedder>& made = made_[key];
    if (!made)
        made =
            std::make_shared<const Embedder>(topology_, std::vector<Points>{reference_}, options);
    return made;
}

EmbeddingOptions embedding_options(const std::string& method, const std::string& quality,
                                   double smoothness, std::uint64_t seed, bool avoid_contact)
{
    EmbeddingOptions options;
    if (method == "closure")
        options.method = EmbeddingMethod::Closure;
    else if (method == "multiscale")
        options.method = EmbeddingMethod::Multiscale;
    else if (method != "dihedral")
        throw InvalidInput(
            join("method: '", method, "' must be 'dihedral', 'closure' or 'multiscale'"));
    if (quality == "preview")
        options.quality = EmbeddingQuality::Preview;
    else if (quality == "fine")
        options.quality = EmbeddingQuality::Fine;
    else if (!quality.empty())
        throw InvalidInput(join("quality: '", quality, "' must be 'preview' or 'fine'"));
    if (!std::isnan(smoothness))
        options.smoothness = smoothness;
    if (options.method == EmbeddingMethod::Multiscale)
        options.seed = seed;
    options.avoid_contact = avoid_contact;
    check(options);
    return options;
}

SpaceOptions space_options(const std::string& space, const std::string& scale,
                           const std::string& coordinates, bool area_weighted,
                           double with_dihedrals, double with_positions)
{
    const auto choose = [](const char* argument, const std::string& value, auto choices) {
        std::string names;
        for (const auto& [name, choice] : choices) {
            if (value == name)
                return choice;
            names += join(names.empty() ? "'" : ", '", name, "'");
        }
        throw InvalidInput(join(argument, ": '", value, "' must be one of ", names));
    };
    SpaceOptions options{
        .kind = choose("space", space,
                       std::array{std::pair{"edge", SpaceKind::Edge},
                                  std::pair{"procrustes", SpaceKind::Procrustes}}),
        .scale = choose("scale", scale,
                        std::array{std::pair{"unit", Scale::Unit}, std::pair{"none", Scale::None}}),
        .coordinates = choose("coordinates", coordinates,
                              std::array{std::pair{"plain", LengthCoordinates::Plain},
                                         std::pair{"squared", LengthCoordinates::Squared},
                                         std::pair{"log", LengthCoordinates::Log}}),
        .weighting = area_weighted ? EdgeWeighting::Area : EdgeWeighting::Uniform,
        .dihedral_weight = with_dihedrals,
        .position_weight = with_positions};
    check(options);
    return options;
}

namespace {

py::object or_none(const std::optional<int>& count)
{
    return count ? py::object(py::int_(*count)) : py::object(py::none());
}

} // namespace

py::tuple to_python(Embedding embedding)
{
    const EmbeddingReport& report = embedding.report;
    py::dict figures;
    figures["status"] = name(report.status);
    figures["reason"] = report.reason;
    figures["edge_rms"] = report.edge_rms;
    figures["edge_max"] = report.edge_max;
    figures["edge_p999"] = report.edge_p999;
    figures["edge_p99"] = report.edge_p99;
    figures["dihedral_rms_deg"] = report.dihedral_rms_deg;
    figures["dihedral_p99_deg"] = report.dihedral_p99_deg;
    figures["dihedral_max_deg"] = report.dihedral_max_deg;
    figures["closure_energy"] = report.closure_energy;
    figures["inverted_faces"] = report.inverted_faces;
    figures["self_intersections"] = or_none(report.self_intersections);
    figures["new_self_intersections"] = or_none(report.new_self_intersections);
    figures["avoidable_self_intersections"] = or_none(report.avoidable_self_intersections);
    figures["companion_rms"] = std::isnan(report.companion_rms)
                                   ? py::object(py::none())
                                   : py::object(py::float_(report.companion_rms));
    figures["iterations"] = report.iterations;
    figures["converged"] = report.converged;
    figures["seconds"] = report.seconds;
    figures["setup_seconds"] = report.setup_seconds;
    return py::make_tuple(array_of(std::move(embedding.points)), figures);
}

namespace {

using CollectionPointer = std::shared_ptr<CollectionHandle>;
using ModelPointer = std::shared_ptr<ModelHandle>;
using DifferencePointer = std::shared_ptr<DifferenceHandle>;

/// A list of what there is.
std::vector<std::string> said(const std::optional<std::string>& doubt)
{
    return doubt ? std::vector{*doubt} : std::vector<std::string>{};
}

/// (model, warnings)
py::tuple fit(const CollectionPointer& handle, int modes, double variance,
              const SpaceOptions& space)
{
    const auto model = std::make_shared<ModelHandle>(run([=](const Progress&) {
        return fit_model(handle->collection,
                         {.modes = modes, .variance = variance, .space = space});
    }));
    return py::make_tuple(model, said(tools::doubt_about_alignment(model->model.space)));
}

/// Scores in standard deviations, as `shape generate --scores` takes them.
py::list decode(const ModelPointer& handle, const std::vector<Doubles>& deviations,
                std::optional<double> size, const EmbeddingOptions& options,
                const py::object& callback)
{
    std::vector<Eigen::VectorXd> points;
    for (const Doubles& row : deviations)
        points.push_back(vector_of(row));
    std::vector<Embedding> made = run(
        [=](const Progress& progress) {
            const ShapeModel& model = handle->model;
            const Eigen::VectorXd units = model.variances.cwiseSqrt();
            const std::shared_ptr<const Embedder> embedder = handle->embedders.get(options);
            if (size && !(*size > 0.0 && std::isfinite(*size)))
                throw InvalidInput(join("size: ", *size, ", must be > 0 and finite"));
            const double factor =
                size && scale_of(model.space) == Scale::Unit ? *size / model.mean_size() : 1.0;
            std::vector<Embedding> meshes;
            for (std::size_t i = 0; i < points.size(); ++i) {
                progress("embedding", i, points.size());
                if (points[i].size() > units.size())
                    throw InvalidInput(join("scores: ", points[i].size(), " given, the model has ",
                                            units.size(), " modes"));
                const Eigen::VectorXd scores = points[i].cwiseProduct(units.head(points[i].size()));
                const DecodedShape shape = model_point(model, scores, model.mean_size());
                meshes.push_back(resized(embedder->embed(shape), model.topology, shape, factor));
            }
            progress("embedding", points.size(), points.size());
            return meshes;
        },
        callback);
    py::list result;
    for (Embedding& mesh : made)
        result.append(to_python(std::move(mesh)));
    return result;
}

struct Projected
{
    Projection scores;
    std::vector<std::string>
        warnings; ///< Of meshes unlike those of the model, as the program has them.
};

Projected project_all(const ShapeModel& model, const Collection& meshes)
{
    Projection scores = project(model, meshes);
    const RowMatrix marks = unlike_meshes(known_meshes(model), meshes, scores.sizes);
    const std::string others = "the meshes of the model";
    std::vector<std::string> warnings = tools::unlike_warnings(
        meshes.names, marks,
        {.others = others, .mirrored = tools::effect_of_mirroring(model.space)});
    std::ranges::copy(tools::far_warnings(meshes.names, far_meshes(model, scores), others),
                      std::back_inserter(warnings));
    return {std::move(scores), std::move(warnings)};
}

py::tuple to_python(Projected projected)
{
    Projection& scores = projected.scores;
    return py::make_tuple(scores.names, python::to_python(scores.labels),
                          array_of(std::move(scores.scores)), array_of(std::move(scores.sizes)),
                          array_of(std::move(scores.residuals)), projected.warnings);
}

py::tuple project_collection(const ModelPointer& model, const CollectionPointer& meshes)
{
    return to_python(
        run([=](const Progress&) { return project_all(model->model, meshes->collection); }));
}

py::tuple project_points(const ModelPointer& handle, const Doubles& points, const std::string& name)
{
    const Points positions = points_of(points);
    return to_python(run([=](const Progress&) {
        const Topology& topology = handle->model.topology;
        if (positions.rows() != topology.vertex_count())
            throw InvalidInput(
                join("V has ", positions.rows(), " vertices, the model ", topology.vertex_count()));
        if (!positions.allFinite())
            throw InvalidInput("V has a coordinate that is not finite");
        if (const auto defects = find_degenerate_geometry(topology.faces(), positions, 1);
            !defects.empty())
            throw InvalidInput("V: " + defects.front().message);
        return project_all(handle->model, {topology, {name}, {positions}, {}});
    }));
}

/// Rows of scores in standard deviations, those of `shape generate --sample`.
Doubles sample(const ModelPointer& handle, int count, std::uint64_t seed)
{
    Random random(seed);
    RowMatrix rows(count, handle->model.mode_count());
    for (Eigen::Index i = 0; i < rows.size(); ++i)
        rows.data()[i] = random.normal();
    return array_of(std::move(rows));
}

/// (difference, warnings)
py::tuple find_difference(const CollectionPointer& handle, const std::string& pair_by,
                          const std::pair<std::string, std::string>& from,
                          const std::pair<std::string, std::string>& to, const std::string& scale)
{
    const DifferenceOptions options{.pair_by = pair_by,
                                    .from_label = from.first,
                                    .from_value = from.second,
                                    .to_label = to.first,
                                    .to_value = to.second,
                                    .scale = scale == "none" ? Scale::None : Scale::Unit};
    struct Found
    {
        DifferenceVector difference;
        std::vector<std::string> warnings;
    };
    Found found = run([=](const Progress&) {
        const Collection& collection = handle->collection;
        Found result{mean_difference(collection, options), {}};
        if (pair_by.empty())
            result.warnings = said(tools::doubt_about_members(options, collection, false));
        return result;
    });
    return py::make_tuple(std::make_shared<DifferenceHandle>(std::move(found.difference)),
                          found.warnings);
}

/// The difference added to meshes, or to the mean that it starts from if there are none: (meshes, warnings of those that
/// are unlike the meshes of the difference, as the program has them).
py::tuple apply(const DifferencePointer& handle, const std::vector<Doubles>& onto,
                const std::vector<std::string>& names, double amount,
                const EmbeddingOptions& options, const py::object& callback)
{
    struct Made
    {
        std::vector<Embedding> meshes;
        std::vector<std::string> warnings;
    };
    std::vector<Points> starts;
    for (const Doubles& points : onto)
        starts.push_back(points_of(points));
    Made made = run(
        [=](const Progress& progress) {
            const DifferenceVector& difference = handle->difference;
            const Topology& topology = difference.topology;
            Made all;
            if (starts.empty()) {
                const ShapePoint start = start_of(difference, difference.from_size);
                all.meshes.push_back(handle->embedders.get(options)->embed(
                    apply_differences(start, {difference}, {amount})));
                return all;
            }
            const Embedder embedder(topology, {starts.front()}, options);
            Eigen::VectorXd sizes(std::ssize(starts));
            for (std::size_t i = 0; i < starts.size(); ++i) {
                progress("embedding", i, starts.size());
                const ShapePoint start{edge_lengths(topology, starts[i]),
                                       dihedral_angles(topology, starts[i])};
                sizes[static_cast<Eigen::Index>(i)] = start.edge_lengths.sum();
                Embedding mesh = embedder.embed(apply_differences(start, {difference}, {amount}));
                mesh.points = best_rigid_motion(mesh.points, starts[i])(mesh.points);
                all.meshes.push_back(std::move(mesh));
            }
            progress("embedding", starts.size(), starts.size());
            all.warnings = tools::unlike_warnings(
                names, tools::marks_in_transfer(difference, {topology, names, starts, {}}, sizes),
                tools::words_of_transfer("onto: ", "the meshes of the difference"));
            return all;
        },
        callback);
    py::list meshes;
    for (Embedding& mesh : made.meshes)
        meshes.append(python::to_python(std::move(mesh)));
    return py::make_tuple(meshes, made.warnings);
}

py::dict to_python(const LinearModelTest& test)
{
    py::dict figures;
    figures["sum_of_squares"] = test.sum_of_squares;
    figures["residual_sum_of_squares"] = test.residual_sum_of_squares;
    figures["total_sum_of_squares"] = test.total_sum_of_squares;
    figures["degrees_of_freedom"] = test.degrees_of_freedom;
    figures["residual_degrees_of_freedom"] = test.residual_degrees_of_freedom;
    figures["f"] = test.f;
    figures["r_squared"] = test.r_squared;
    figures["p_value"] = test.p_value;
    figures["permutations"] = test.permutations;
    figures["smallest_p"] = test.permutations > 0 ? tools::smallest_p(test) : LinearModelTest::none;
    return figures;
}

/// (group names, members of each, overall test, list of (first, second, distance, radius, test, adjusted p, whether
/// within blocks), whether within blocks as a whole, meshes left out, warnings)
py::tuple compare(const CollectionPointer& handle, const std::string& by, const std::string& within,
                  const SpaceOptions& space, int permutations, int replicates, std::uint64_t seed)
{
    struct Found
    {
        Grouping groups;
        Grouping blocks;
        GroupComparison comparison;
        GroupSpread spread;
        std::vector<std::string> warnings;
    };
    const Found found = run([=](const Progress&) {
        const Collection& collection = handle->collection;
        const auto grouped = [&](const std::string& label) {
            return tools::group_by_label(
                collection, label, join("c[[v is not None for v in c.labels['", label, "']]]"));
        };
        const Grouping groups = grouped(by);
        const Grouping blocks = within.empty() ? groups_of_one(groups.size()) : grouped(within);
        std::vector<std::string> warnings;
        const auto warn = [&](const std::optional<std::string>& doubt) {
            if (doubt)
                warnings.push_back(*doubt);
            return doubt.has_value();
        };
        if (!within.empty())
            warn(tools::doubt_about_lost_meshes(groups, blocks, by, within));
        if (const auto doubt = tools::doubt_of_replicates(replicates))
            warnings.push_back(join("replicates: ", *doubt));
        const tools::RepetitionQuestion rows = tools::rows_of_comparison(groups, by);
        const bool are_rows_told =
            !within.empty() || warn(tools::doubt_about_rows(collection, rows));
        const GroupedShapes shapes = group_shapes(collection, groups, space);
        warn(tools::doubt_about_alignment(shapes.space));
        if (!are_rows_told)
            warn(tools::doubt_about_close_rows(collection, rows, shapes.products));
        const Eigen::MatrixXd no_covariates(groups.size(), 0);
        return Found{groups, blocks,
                     compare_groups(shapes.products, groups, blocks, no_covariates,
                                    {.permutations = permutations, .seed = seed}),
                     group_spread(shapes.products, groups, blocks, no_covariates,
                                  {.replicates = replicates, .seed = seed}),
                     warnings};
    });
    std::vector<std::size_t> counts;
    for (const std::vector<int>& of_group : members(found.groups))
        counts.push_back(of_group.size());
    py::list pairs;
    for (const PairComparison& pair : found.comparison.pairs)
        pairs.append(py::make_tuple(
            found.groups.names[to_size(pair.first)], found.groups.names[to_size(pair.second)],
            pair.distance, found.spread.distance_radii(pair.first, pair.second),
            to_python(pair.test), pair.adjusted_p,
            tools::is_within_blocks(found.groups, found.blocks, pair.first, pair.second)));
    return py::make_tuple(found.groups.names, counts, to_python(found.comparison.overall), pairs,
                          found.comparison.design == BlockDesign::Crossed,
                          found.comparison.left_out, found.warnings);
}

/// Carries out a command of the program that writes files, silently.
void command(const std::string& name, const std::vector<std::string>& arguments, bool force,
             const py::object& callback)
{
    run(
        [=](const Progress& progress) {
            const tools::ProgressListener listener(progress);
            CLI::App app("", name);
            const tools::Run made =
                name == "export" ? tools::set_up_export(app) : tools::set_up_explore(app);
            std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
            try {
                app.parse(reversed);
            } catch (const CLI::ParseError& error) {
                throw InvalidInput(error.what());
            }
            tools::Session session;
            session.command = name;
            session.quiet = true;
            session.force = force;
            made(session);
            return true;
        },
        callback);
}

template <class Handle, class Write>
void write_in_job(const std::shared_ptr<Handle>& handle, const std::string& path, Write write)
{
    run([=](const Progress&) {
        write(path, *handle);
        return true;
    });
}

void add_model_class(py::module_& module)
{
    const auto model_view = [](const Eigen::VectorXd ShapeModel::*member) {
        return [member](const ModelPointer& m) {
            const Eigen::VectorXd& vector = m->model.*member;
            return view(m, vector.data(), {vector.size()});
        };
    };
    const auto matrix_view = [](const RowMatrix ShapeModel::*member) {
        return [member](const ModelPointer& m) {
            const RowMatrix& matrix = m->model.*member;
            return view(m, matrix.data(), {matrix.rows(), matrix.cols()});
        };
    };
    py::class_<ModelHandle, ModelPointer>(module, "Model")
        .def_property_readonly("names", [](const ModelHandle& m) { return m.model.names; })
        .def_property_readonly(
            "labels", [](const ModelHandle& m) { return python::to_python(m.model.labels); })
        .def_property_readonly("mode_count",
                               [](const ModelHandle& m) { return m.model.mode_count(); })
        .def_property_readonly("mean_size",
                               [](const ModelHandle& m) { return m.model.mean_size(); })
        .def_property_readonly("total_variance",
                               [](const ModelHandle& m) { return m.model.total_variance; })
        .def_property_readonly(
            "space",
            [](const ModelHandle& m) {
                return std::holds_alternative<EdgeSpace>(m.model.space) ? "edge" : "procrustes";
            })
        .def_property_readonly("variances", model_view(&ShapeModel::variances))
        .def_property_readonly("mean", model_view(&ShapeModel::mean))
        .def_property_readonly("sizes", model_view(&ShapeModel::sizes))
        .def_property_readonly("modes", matrix_view(&ShapeModel::modes))
        .def_property_readonly("scores", matrix_view(&ShapeModel::scores))
        .def("reference_points",
             [](const ModelPointer& m) {
                 return view(m, m->model.reference_points.data(),
                             {m->model.reference_points.rows(), 3});
             })
        .def("faces", [](const ModelHandle& m) { return array_of_faces(m.model.topology.faces()); })
        .def("feasible_range",
             [](const ModelHandle& m, int mode) {
                 const FeasibleRange range = feasible_range(m.model, mode);
                 return std::pair(range.low, range.high);
             })
        .def("write", [](const ModelPointer& m, const std::string& path) {
            write_in_job(m, path, [](const std::string& to, const ModelHandle& model) {
                write_model(to, model.model);
            });
        });
    module.def("fit", fit);
    module.def("decode", decode);
    module.def("project_collection", project_collection);
    module.def("project_points", project_points);
    module.def("sample", sample);
    module.def("read_model", [](const std::string& path) {
        return std::make_shared<ModelHandle>(
            run([=](const Progress&) { return read_model(path); }));
    });
    module.def("command", command);
}

void add_difference_class(py::module_& module)
{
    py::class_<DifferenceHandle, DifferencePointer>(module, "Difference")
        .def_property_readonly("pairs",
                               [](const DifferenceHandle& d) { return d.difference.pairs; })
        .def_property_readonly("edge_lengths",
                               [](const DifferencePointer& d) {
                                   const Eigen::VectorXd& lengths = d->difference.edge_lengths;
                                   return view(d, lengths.data(), {lengths.size()});
                               })
        .def_property_readonly("dihedral_angles",
                               [](const DifferencePointer& d) {
                                   const Eigen::VectorXd& angles = d->difference.dihedral_angles;
                                   return view(d, angles.data(), {angles.size()});
                               })
        .def_property_readonly(
            "vertex_count",
            [](const DifferenceHandle& d) { return d.difference.topology.vertex_count(); })
        .def("reference_points",
             [](const DifferencePointer& d) {
                 return view(d, d->difference.reference_points.data(),
                             {d->difference.reference_points.rows(), 3});
             })
        .def(
            "faces",
            [](const DifferenceHandle& d) { return array_of_faces(d.difference.topology.faces()); })
        .def("write", [](const DifferencePointer& d, const std::string& path) {
            write_in_job(d, path, [](const std::string& to, const DifferenceHandle& difference) {
                write_difference(to, difference.difference);
            });
        });
    module.def("difference", find_difference);
    module.def("apply", apply);
    module.def("read_difference", [](const std::string& path) {
        return std::make_shared<DifferenceHandle>(
            run([=](const Progress&) { return read_difference(path); }));
    });
}

} // namespace

void add_models(py::module_& module)
{
    py::class_<EmbeddingOptions>(module, "EmbeddingOptions").def(py::init(&embedding_options));
    py::class_<SpaceOptions>(module, "SpaceOptions").def(py::init(&space_options));
    add_model_class(module);
    add_difference_class(module);
    module.def("groups", compare);
}

} // namespace shape::python
