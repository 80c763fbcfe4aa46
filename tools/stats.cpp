// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/base/version.h"
#include "libshape/io/model_file.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/joined_labels.h"
#include "libshape/model/shape_model.h"
#include "libshape/model/streamed_fit.h"
#include "libshape/model/unlike_meshes.h"
#include "libshape/model/updated_model.h"
#include "libshape/statistics/bootstrap.h"
#include "libshape/statistics/principal_components.h"
#include "tools/commands.h"
#include "tools/input/label_gaps.h"
#include "tools/input/label_input.h"
#include "tools/input/mesh_stream_input.h"
#include "tools/input/repeated_rows.h"
#include "tools/input/space_arguments.h"
#include "tools/output/model_tables.h"
#include "tools/output/output_rules.h"
#include "tools/output/pass_store.h"
#include "tools/output/test_tables.h"
#include "tools/output/unlike_warnings.h"
#include "tools/program/arguments.h"
#include "tools/program/memory.h"
#include "tools/program/ranks.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    LabelledInput input;
    std::string output;
    std::int64_t modes = 0;
    double variance = 1.0;
    SpaceOptions space = {};
    std::int64_t replicates = 0;
    std::string within;
    MemoryArgument memory;
    FitAlgorithm algorithm = FitAlgorithm::Automatic;
    double tolerance = 1e-6;
    bool resume = false;
    double save_every = 30.0;
    std::string update; ///< The model that the meshes are added to.
};

/// Scores in the modes of the model and in further ones, up to 99 % of the variance: resampled modes
/// leave the span of the model's, and what they find beyond 99 % is less than 1 % of 1 / N.
RowMatrix wide_scores(const Collection& collection, const ShapeModel& model)
{
    RowMatrix scores =
        principal_components(encode(model.space, collection), {.variance = 0.99}).scores;
    return scores.cols() > model.mode_count() ? scores : model.scores;
}

/// "mode 3" or "modes 3, 4 and 7 to 9".
std::string list_modes(const std::vector<std::size_t>& modes)
{
    std::string text;
    for (std::size_t i = 0; i < modes.size();) {
        std::size_t last = i;
        while (last + 1 < modes.size() && modes[last + 1] == modes[last] + 1)
            ++last;
        text += join(i > 0 ? ", " : "", modes[i]);
        if (last > i)
            text += join(last > i + 1 ? " to " : ", ", modes[last]);
        i = last + 1;
    }
    return join(modes.size() == 1 ? "mode " : "modes ", text);
}

/// Says of which modes the estimate lies outside its own interval, and why.
void explain_outside(const Session& session, const std::vector<std::size_t>& below,
                     const std::vector<std::size_t>& above)
{
    if (!above.empty())
        session.warn(
            join("the variance of ", list_modes(above),
                 " lies above its interval: a resampled collection repeats some meshes and "
                 "lacks about a third of the others, so its later modes hold less; such an "
                 "interval says how the estimate scatters, not where the true value lies"));
    if (!below.empty())
        session.warn(join("the variance of ", list_modes(below),
                          " lies below its interval: the largest variances of few meshes are too "
                          "large by chance, and resampling adds as much again; the true value is "
                          "likely smaller, not larger"));
}

/// Intervals of the variances of few end too low, as docs/groups.md has it.
void warn_of_few(const Session& session, int drawn, const std::string& within)
{
    constexpr int enough = 30; // of which nine intervals of ten hold the true variance
    if (drawn < enough)
        session.warn(join(
            "--bootstrap: ", drawn, within.empty() ? " meshes" : join(" values of ", within),
            " are few: 95 % intervals of variances end too low then; of 5, 10, 20 and 30 that are "
            "drawn anew about 63, 78, 85 and 88 % held the true variance, the others lay below "
            "it"));
}

/// The modes of the model and, if they are asked for, 95 % intervals of their variances.
Json figures_of_modes(const Session& session, const Arguments& arguments,
                      const Collection& collection, const ShapeModel& model)
{
    Json modes = mode_figures(model);
    if (arguments.replicates == 0)
        return modes;
    if (arguments.within.empty())
        warn_of_repeated_rows(session, collection,
                              {.covariates = Eigen::MatrixXd(model.scores.rows(), 0),
                               .remedy = "then the intervals are too narrow. Give --within"});
    const Grouping blocks = group_by_label_or_each(collection, arguments.within);
    const std::vector<Interval> intervals =
        variance_intervals(wide_scores(collection, model), model.mode_count(),
                           {blocks, one_group(model.scores.rows())},
                           {.replicates = static_cast<int>(arguments.replicates),
                            .seed = static_cast<std::uint64_t>(session.seed)});
    if (const auto doubt = doubt_of_replicates(arguments.replicates)) {
        session.warn(join("--bootstrap: ", *doubt));
        for (Json& mode : modes)
            for (const char* key : {"variance_low", "variance_high", "variance_outside"})
                mode[key] = nullptr;
        return modes;
    }
    warn_of_few(session, blocks.group_count(), arguments.within);
    std::vector<std::size_t> below;
    std::vector<std::size_t> above;
    for (std::size_t k = 0; k < intervals.size(); ++k) {
        const double estimate = model.variances[static_cast<Eigen::Index>(k)];
        modes[k]["variance_low"] = intervals[k].low;
        modes[k]["variance_high"] = intervals[k].high;
        const bool is_below = estimate < intervals[k].low;
        const bool is_above = estimate > intervals[k].high;
        modes[k]["variance_outside"] = is_below ? "below" : is_above ? "above" : "no";
        if (is_below)
            below.push_back(k + 1);
        if (is_above)
            above.push_back(k + 1);
        session.message(join("mode ", k + 1, ": variance ", estimate, ", 95 %: ", intervals[k].low,
                             " to ", intervals[k].high,
                             is_below   ? " (below its interval)"
                             : is_above ? " (above its interval)"
                                        : ""));
    }
    explain_outside(session, below, above);
    return modes;
}

ModelOptions model_options(const Arguments& arguments)
{
    return {.modes = static_cast<int>(arguments.modes),
            .variance = arguments.variance,
            .space = arguments.space};
}

/// A model, how it was found, and what is said of its modes.
struct Findings
{
    StreamedFit fit;
    bool in_memory = true;
    Json modes = {};
};

constexpr const char* way_to_label = "give them with --labels";

/// The collection goes when this returns.
Findings fit_in_memory(const Session& session, const Arguments& arguments)
{
    const Collection collection = read_labelled(session, arguments.input);
    LabelGaps gaps;
    gaps.add(arguments.input.meshes, collection);
    gaps.warn(session, collection.names, way_to_label);
    Findings found{.fit = {.model = fit_model(collection, model_options(arguments))}};
    warn_of_alignment(session, found.fit.model.space);
    throw_if_stop_requested();
    found.modes = figures_of_modes(session, arguments, collection, found.fit.model);
    return found;
}

/// All that the passes depend on.
Json identity_of(const Session& session, const Arguments& arguments, const MeshStream& meshes)
{
    const std::uint64_t memory = arguments.memory.bytes;
    const FitAlgorithm algorithm =
        algorithm_for(meshes.size(), model_options(arguments),
                      {.memory = memory, .algorithm = arguments.algorithm});
    Json identity{{"version", version()}};
    for (const std::filesystem::path& path : input_files(arguments.input.meshes))
        identity["inputs"].push_back(
            {std::filesystem::absolute(path).string(), std::filesystem::file_size(path),
             std::filesystem::last_write_time(path).time_since_epoch().count()});
    identity["only"] = arguments.input.only;
    identity["modes"] = arguments.modes;
    identity["variance"] = arguments.variance;
    identity["space"] = {static_cast<int>(arguments.space.scale),
                         static_cast<int>(arguments.space.coordinates),
                         static_cast<int>(arguments.space.weighting),
                         arguments.space.dihedral_weight, arguments.space.position_weight};
    identity["algorithm"] = static_cast<int>(algorithm);
    identity["tolerance"] = arguments.tolerance;
    if (algorithm == FitAlgorithm::Krylov) // by it Krylov restarts; of Gram it changes no bit
        identity["memory"] = memory > 0 ? memory : usual_memory();
    identity["seed"] = session.seed;
    identity["partial_sums"] = ranks().partial_sums;
    return identity;
}

Findings fit_in_passes(const Session& session, const Arguments& arguments, const MeshStream& meshes)
{
    PassStore store(session, arguments.output, identity_of(session, arguments, meshes),
                    arguments.resume, arguments.save_every);
    const StreamOptions options{.memory = arguments.memory.bytes,
                                .algorithm = arguments.algorithm,
                                .tolerance = arguments.tolerance,
                                .seed = static_cast<std::uint64_t>(session.seed),
                                .progress = session.progress(),
                                .save =
                                    [&](const PassState& state) {
                                        if (ranks().is_root())
                                            store.save(state);
                                    },
                                .ranks = ranks(),
                                .state = store.state(),
                                .scratch = scratch_folder(arguments.output)};
    const auto fit = [&] {
        try {
            return fit_model(meshes, model_options(arguments), options);
        } catch (const Interrupted&) {
            throw Interrupted(store.on_interrupt());
        }
    };
    Findings found{.fit = fit(), .in_memory = false, .modes = {}};
    found.modes = mode_figures(found.fit.model);
    if (!ranks().is_root())
        return found;
    return_freed_memory();
    write_model(arguments.output, found.fit.model);
    store.finish();
    return found;
}

/// By so much a mesh may differ from one of its name, over its size, and be that one: single precision leaves 1e-7.
constexpr double resaved = 1e-6;

/// Of the meshes that the model has, the first stands in it whole: it must be the one of the input, if that has it.
void check_first_mesh(const ShapeModel& model, const std::string& name, const Points& points,
                      const std::string& path)
{
    // Moved, or saved again in single precision, it is the same.
    const Points& known = model.reference_points;
    if (!((best_rigid_motion(points, known)(points) - known).rowwise().norm().maxCoeff() <=
          resaved * bounding_box_diagonal(known)))
        throw InvalidInput(join(path, ": its mesh ", name,
                                " is another than that of the input: meshes are told apart by "
                                "their names; give those of the other collection other names"));
}

/// Gives the meshes of a model the labels that they have in the input, and says which were others.
void take_labels_of(const Session& session, const Arguments& arguments, const MeshLabels& input,
                    ShapeModel& model)
{
    const std::vector<ReplacedLabel> replaced =
        take_labels(model.labels, model.names, input.labels, input.names);
    if (replaced.empty())
        return;
    const ReplacedLabel& first = replaced.front();
    session.warn(join(arguments.update, ": ", counted(replaced.size(), "label"),
                      replaced.size() == 1 ? " is another" : " are others",
                      " than in the input, which counts; first that of mesh ", first.mesh, ", ",
                      first.label, ": '", first.before, "', now '", first.now, "'"));
}

/// Meshes of the input that have the name of one of the model and another size: they were corrected since.
std::vector<std::string> changed_meshes(const ShapeModel& model, const Collection& input)
{
    std::map<std::string, double> known;
    for (std::size_t i = 0; i < model.names.size(); ++i)
        known.emplace(model.names[i], model.sizes[static_cast<Eigen::Index>(i)]);
    const Eigen::VectorXd now = sizes(model.space, input);
    std::vector<std::string> changed;
    for (std::size_t i = 0; i < input.size(); ++i) {
        const auto before = known.find(input.names[i]);
        if (before != known.end() && !(std::abs(now[static_cast<Eigen::Index>(i)] -
                                                before->second) <= resaved * before->second))
            changed.push_back(input.names[i]);
    }
    return changed;
}

/// Meshes are told apart by their names: those that the model has stay what they were.
void warn_of_changed(const Session& session, const Arguments& arguments,
                     const std::vector<std::string>& changed)
{
    if (changed.empty())
        return;
    session.warn(join(counted(changed.size(), "mesh", "meshes"), " of the input ",
                      changed.size() == 1 ? "is another" : "are others", " than in ",
                      arguments.update, ", which keeps those that it has: ", list_names(changed),
                      "; to replace them, fit all meshes anew without --update"));
}

/// All that it takes is held in memory.
void check_update_memory(const Arguments& arguments, const ShapeModel& model, std::size_t added)
{
    const std::uint64_t wanted =
        update_memory(model, static_cast<Eigen::Index>(added), model_options(arguments));
    const std::uint64_t allowed =
        arguments.memory.bytes > 0 ? arguments.memory.bytes : usual_memory();
    if (wanted > allowed)
        throw LimitExceeded(
            join("--update: the ", model.names.size(), " meshes of ", arguments.update, " and ",
                 counted(added, "mesh", "meshes"), " more need ", (wanted >> 20) + 1,
                 " MiB, the memory allowed is ", allowed >> 20,
                 " MiB; allow more (--memory), or fit all of them without --update, "
                 "which reads them in passes"));
}

void warn_of_unlike_added(const Session& session, const Arguments& arguments,
                          const ShapeModel& model, const Collection& added)
{
    const std::string others = join("the meshes of ", arguments.update);
    warn_of_unlike(session, added.names,
                   unlike_meshes(known_meshes(model), added, sizes(model.space, added)),
                   {.others = others, .mirrored = effect_of_mirroring(model.space)});
    warn_of_far(session, added.names, far_meshes(model, project(model, added)), others);
}

/// Adds to a model the meshes that it does not have, which alone are read, and the model's first one.
Findings update(const Session& session, const Arguments& arguments)
{
    if (ranks().count > 1)
        throw UsageError("--update runs in one process, without mpirun");
    ShapeModel model = read_model(arguments.update);
    const std::set<std::string> known(model.names.begin(), model.names.end());
    const auto is_new = [&](const std::vector<std::string>& names) {
        std::vector<std::size_t> chosen;
        for (std::size_t i = 0; i < names.size(); ++i)
            if (!known.contains(names[i]))
                chosen.push_back(i);
        return chosen;
    };
    const auto check_first = [&](const auto& meshes, const auto& points_of) {
        const auto first = std::ranges::find(meshes.names, model.names.front());
        if (first != meshes.names.end())
            check_first_mesh(model, *first, points_of(to_size(first - meshes.names.begin())),
                             arguments.update);
    };
    LabelledInput input = arguments.input;
    input.meshes.known = NamedMesh{model.names.front(), arguments.update, model.reference_points,
                                   model.topology.faces()};
    LabelGaps gaps;
    gaps.add(model.names, model.labels);
    std::size_t passed_over = 0;
    const Collection added = [&] {
        const auto stream = open_labelled(session, input, true);
        if (!stream) {
            const Collection all = read_labelled(session, input);
            check_first(all, [&](std::size_t i) { return all.points[i]; });
            gaps.add(input.meshes, all);
            take_labels_of(session, arguments, all, model);
            warn_of_changed(session, arguments, changed_meshes(model, all));
            const std::vector<std::size_t> fresh = is_new(all.names);
            check_update_memory(arguments, model, fresh.size());
            return subset(all, fresh);
        }
        check_first(*stream, [&](std::size_t i) {
            Points points;
            for_each_block(
                subset(*stream, {i}), 0, 1, 1,
                [&](Eigen::Index, const Collection& block) { points = block.points.front(); });
            return points;
        });
        gaps.add(input.meshes, *stream);
        take_labels_of(session, arguments, *stream, model);
        const MeshStream fresh = subset(*stream, is_new(stream->names));
        passed_over = stream->names.size() - fresh.names.size();
        check_update_memory(arguments, model, fresh.names.size());
        Collection read{fresh.topology, fresh.names, {}, fresh.labels};
        for_each_block(fresh, 0, fresh.size(), 32, [&](Eigen::Index, const Collection& block) {
            read.points.insert(read.points.end(), block.points.begin(), block.points.end());
        });
        return read;
    }();
    Findings found{.fit = {.model = update_model(model, added, model_options(arguments))}};
    warn_of_unlike_added(session, arguments, model, added);
    gaps.warn(session, found.fit.model.names, way_to_label);
    session.message(join(
        counted(added.size(), "mesh", "meshes"), " added to the ", model.names.size(), " of ",
        arguments.update,
        passed_over == 0 ? ""
                         : join("; ", passed_over, " that it has by their names were not read")));
    found.modes = mode_figures(found.fit.model);
    write_model(arguments.output, found.fit.model);
    return found;
}

/// Passes are for what does not fit, or for who asks for them; not for what needs all meshes at once.
Findings fit_and_write(const Session& session, const Arguments& arguments)
{
    if (!arguments.update.empty())
        return update(session, arguments);
    const bool asks = arguments.memory.bytes > 0 || arguments.resume || ranks().partial_sums > 1 ||
                      arguments.algorithm != FitAlgorithm::Automatic;
    const bool can = arguments.replicates == 0 && arguments.space.kind == SpaceKind::Edge;
    if (can)
        if (const auto meshes = open_labelled(session, arguments.input, asks))
            return fit_in_passes(session, arguments, *meshes);
    if (asks)
        throw UsageError(
            "--memory, --algorithm, --resume and mpirun are for one collection file (.h5) in edge "
            "space without --bootstrap; `shape collect` makes one");
    Findings found = fit_in_memory(session, arguments);
    return_freed_memory();
    write_model(arguments.output, found.fit.model);
    return found;
}

/// "in memory", or how in how many passes.
std::string describe(const Findings& found)
{
    if (found.in_memory)
        return {};
    if (found.fit.algorithm == FitAlgorithm::Gram)
        return join(", by inner products in ", counted(found.fit.passes, "pass", "passes"));
    char error[32];
    std::snprintf(error, sizeof error, "%.1e", found.fit.error);
    return join(", by block Krylov in ", counted(found.fit.passes, "pass", "passes"),
                ", variances within ", error, " of themselves as estimated");
}

void run(const Session& session, const Arguments& arguments)
{
    check_space_options(arguments.space);
    check_ending("-o", arguments.output, ".h5");
    if (arguments.variance > 1.0)
        throw UsageError(join("--variance: ", arguments.variance,
                              " must be a share in (0, 1], such as 0.95 for 95 %"));
    if (arguments.tolerance >= 1.0)
        throw UsageError(join("--tolerance: ", arguments.tolerance, " must be in (0, 1)"));
    if (arguments.save_every < 0.0)
        throw UsageError(join("--save-every: ", arguments.save_every, " must be at least 0 s"));
    std::vector<std::filesystem::path> inputs = input_files(arguments.input.meshes);
    if (!arguments.update.empty())
        inputs.emplace_back(arguments.update);
    check_output(session, arguments.output, inputs);
    const Findings found = fit_and_write(session, arguments);
    const ShapeModel& model = found.fit.model;
    session.message(join(arguments.output, ": ", counted(model.mode_count(), "mode"), " of ",
                         model.names.size(), " meshes", describe(found), "\n",
                         mode_table(found.modes)));
    Json figures{{"outputs", {arguments.output}},
                 {"meshes", model.names.size()},
                 {"vertices", model.topology.vertex_count()},
                 {"edges", model.topology.edge_count()}};
    figures.update(space_figures(model.space));
    figures["algorithm"] = found.fit.algorithm == FitAlgorithm::Gram ? "gram" : "krylov";
    figures["passes"] = found.fit.passes;
    figures["variance_error"] = found.fit.error;
    figures["mean_size"] = model.mean_size();
    figures["total_variance"] = model.total_variance;
    figures["modes"] = found.modes;
    session.print_figures(figures);
}

} // namespace

Run set_up_stats(CLI::App& command)
{
    command.description(
        "Fit a statistical model of meshes in correspondence: the mean in a space of shapes, the\n"
        "principal modes with their variances (divisor N - 1), and the scores of the meshes.");
    command.footer(
        "Examples:\n"
        "  shape stats faces.h5 -o model.h5 --variance 0.95\n"
        "  shape stats faces.h5 -o aligned.h5 --space procrustes\n"
        "  shape stats many.h5 -o model.h5 --modes 50 --memory 1G");
    const auto arguments = std::make_shared<Arguments>();
    add_labelled_input(command, arguments->input);
    add_output_file(command, arguments->output, "Model to write (.h5)");
    CLI::Option* modes =
        add_integer(command, "--modes", arguments->modes,
                    "Number of modes to keep, [1, N - 1] (default: all with any variance)", 1,
                    std::numeric_limits<int>::max());
    add_number(command, "--variance", arguments->variance,
               "Keep the fewest modes with this share of the total variance, (0, 1]",
               Sign::Positive)
        ->excludes(modes);
    CLI::Option* bootstrap = add_integer(
        command, "--bootstrap", arguments->replicates,
        "Find 95 % intervals of the variances from N resampled collections, [0, 1000000]\n"
        "(default: 0, none), of which it takes 39; of fewer than 30 meshes they end too low",
        0, 1000000);
    add_label(command, "--within", arguments->within,
              "Resample meshes with the same value of it together, such as all of a subject")
        ->needs(bootstrap);
    add_space_options(command, arguments->space);
    add_memory(command, arguments->memory);
    add_choice(
        command, "--algorithm", arguments->algorithm,
        "How modes of a large collection are found. gram: exactly, from all inner products;\n"
        "krylov: by a random block Krylov method, which takes fewer operations and memory\n"
        "for many meshes (default: auto, whichever is quicker)",
        {{"auto", FitAlgorithm::Automatic},
         {"gram", FitAlgorithm::Gram},
         {"krylov", FitAlgorithm::Krylov}});
    add_number(command, "--tolerance", arguments->tolerance,
               "Relative error of each variance that krylov may leave, (0, 1) (default: 1e-6)",
               Sign::Positive);
    command.add_flag("--resume", arguments->resume,
                     "Go on where a run of the same command that was killed had got to, as\n"
                     "OUTPUT.unfinished has it; to the same bits");
    add_number(command, "--save-every", arguments->save_every,
               "At least this much time lies between two states that are kept for --resume\n"
               "[s], after a pass each (default: 30)");
    CLI::Option* update = command
                              .add_option("--update", arguments->update,
                                          "Model of all its modes (.h5) to which the meshes are "
                                          "added that it does not have;\n"
                                          "those it has are not read, but their labels. The result "
                                          "is that of a run on all of\n"
                                          "them, in its space; all is held in memory (--memory)")
                              ->option_text("MODEL")
                              ->excludes(bootstrap);
    exclude_space_options(command, *update);
    for (const char* option : {"--algorithm", "--tolerance", "--resume", "--save-every"})
        update->excludes(command.get_option(option));
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
