// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/format.h"
#include "libshape/io/model_file.h"
#include "libshape/model/shape_model.h"
#include "libshape/statistics/bootstrap.h"
#include "libshape/statistics/principal_components.h"
#include "tools/commands.h"
#include "tools/input/label_input.h"
#include "tools/input/space_arguments.h"
#include "tools/output/model_tables.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"
#include "tools/program/interrupt.h"
#include "tools/program/memory.h"
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

/// The modes of the model and, if they are asked for, 95 % intervals of their variances.
Json figures_of_modes(const Session& session, const Arguments& arguments,
                      const Collection& collection, const ShapeModel& model)
{
    Json modes = mode_figures(model);
    if (arguments.replicates == 0)
        return modes;
    const std::vector<Interval> intervals = variance_intervals(
        wide_scores(collection, model), model.mode_count(),
        {group_by_label_or_each(collection, arguments.within), one_group(model.scores.rows())},
        {.replicates = static_cast<int>(arguments.replicates),
         .seed = static_cast<std::uint64_t>(session.seed)});
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

/// The model and what is said of its modes. The collection goes when this returns.
std::pair<ShapeModel, Json> fit(const Session& session, const Arguments& arguments)
{
    const Collection collection = read_labelled(session, arguments.input);
    ShapeModel model = fit_model(collection, {.modes = static_cast<int>(arguments.modes),
                                              .variance = arguments.variance,
                                              .space = arguments.space});
    warn_of_alignment(session, model.space);
    throw_if_interrupted();
    Json modes = figures_of_modes(session, arguments, collection, model);
    return {std::move(model), std::move(modes)};
}

void run(const Session& session, const Arguments& arguments)
{
    check_space_options(arguments.space);
    check_ending("-o", arguments.output, ".h5");
    check_output(session, arguments.output, input_files(arguments.input.meshes));
    const auto [model, modes] = fit(session, arguments);
    return_freed_memory();
    write_model(arguments.output, model);
    session.message(join(arguments.output, ": ", counted(model.mode_count(), "mode"), " of ",
                         model.names.size(), " meshes\n", mode_table(model)));
    Json figures{{"outputs", {arguments.output}},
                 {"meshes", model.names.size()},
                 {"vertices", model.topology.vertex_count()},
                 {"edges", model.topology.edge_count()}};
    figures.update(space_figures(model.space));
    figures["mean_size"] = model.mean_size();
    figures["total_variance"] = model.total_variance;
    figures["modes"] = modes;
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
        "  shape stats faces.h5 -o aligned.h5 --space procrustes");
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
        "(default: 0, none)",
        0, 1000000);
    add_label(command, "--within", arguments->within,
              "Resample meshes with the same value of it together, such as all of a subject")
        ->needs(bootstrap);
    add_space_options(command, arguments->space);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
