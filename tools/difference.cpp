// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/edge_space/shape_space.h"
#include "libshape/io/model_file.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/model/difference.h"
#include "tools/commands.h"
#include "tools/doubts.h"
#include "tools/input/label_input.h"
#include "tools/input/mesh_choice.h"
#include "tools/input/mesh_input.h"
#include "tools/input/space_arguments.h"
#include "tools/output/effects_output.h"
#include "tools/output/embedding_run.h"
#include "tools/output/mesh_output.h"
#include "tools/output/output_rules.h"
#include "tools/output/unlike_warnings.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    LabelledInput input;
    std::string pair_by;
    std::string from;
    std::string to;
    Scale scale = Scale::Unit;
    std::string output;
    std::string effects;
    std::vector<std::string> load;
    bool apply = false;
    std::string amounts;
    std::vector<std::string> onto;
    std::optional<double> size;
    MeshOutputArguments mesh;
    EmbeddingArguments embedding;
};

DifferenceOptions difference_options(const Arguments& arguments)
{
    const auto [from_label, from_value] = label_and_value("--from", arguments.from);
    const auto [to_label, to_value] = label_and_value("--to", arguments.to);
    if (from_label == to_label && from_value == to_value)
        throw UsageError(join("--from and --to are both ", arguments.to,
                              "; a difference goes from one group to another one"));
    return {.pair_by = arguments.pair_by,
            .from_label = from_label,
            .from_value = from_value,
            .to_label = to_label,
            .to_value = to_value,
            .scale = arguments.scale};
}

/// One number for each difference; 1 where nothing is said.
std::vector<double> amounts_of(const Arguments& arguments)
{
    const std::size_t count = std::max<std::size_t>(arguments.load.size(), 1);
    if (arguments.amounts.empty())
        return std::vector<double>(count, 1.0);
    std::vector<double> amounts = read_numbers(arguments.amounts, "--amount");
    if (amounts.size() != count)
        throw UsageError(join("--amount: ", counted(amounts.size(), "number"), " for ",
                              counted(count, "difference"), "; give one for each"));
    return amounts;
}

/// Writes where the pairs differ, on the mean of the meshes that the difference starts from.
Json find_effects(const Session& session, const Arguments& arguments,
                  const DifferenceVector& difference, const ColumnEffects& effects)
{
    const Embedder embedder(difference.topology, {difference.reference_points},
                            embedding_options(session, arguments.embedding.options));
    const ShapePoint start = start_of(difference, difference.from_size);
    return write_effects(session, arguments.effects, difference.topology,
                         embedder.embed(start).points, effects, arguments.mesh);
}

/// A mesh of those that a difference was found of, under the name of its file.
NamedMesh mesh_of(const DifferenceVector& difference, const std::string& file)
{
    return {file, file, difference.reference_points, difference.topology.faces()};
}

/// The start of a transfer: a mesh at its own size.
ShapePoint shape_of(const Topology& topology, const Points& points)
{
    return {edge_lengths(topology, points), dihedral_angles(topology, points)};
}

/// Applies differences to their starting mean, or to each of some meshes.
class Transfer
{
public:
    /// @param run  The meshes that --onto may name.
    /// @param known  One of those, or of the meshes of the difference; with their triangulation.
    Transfer(const Session& session, const Arguments& arguments, const Collection& run,
             const NamedMesh& known, std::vector<std::filesystem::path> inputs)
        : session_(session), arguments_(arguments), onto_{run.topology, {}, {}, {}}
    {
        std::vector<std::string> names{"applied"};
        if (!arguments.onto.empty()) {
            const MeshChoice choice{"--onto", arguments.onto, arguments.input.meshes.triangulate,
                                    notices_of(session).warn};
            for (std::filesystem::path& file : chosen_files(choice, run.names))
                inputs.push_back(std::move(file));
            onto_ = choose_meshes(choice, run, known);
            names = onto_.names;
        }
        MeshOutputArguments form = arguments.mesh;
        if (!arguments.effects.empty() && !arguments.embedding.residuals)
            form.colours.clear(); // they are of the effects
        output_ = std::make_unique<MeshOutput>(session, form, names, inputs);
    }

    [[nodiscard]] Json apply(const std::vector<DifferenceVector>& differences)
    {
        warn_of_unlike(differences.front());
        const std::vector<double> amounts = amounts_of(arguments_);
        const DifferenceVector& first = differences.front();
        if (arguments_.size && first.scale == Scale::None)
            throw UsageError("--size has no meaning with --scale none, lengths stay as they are");
        const auto resized = [&](double own_size) {
            return arguments_.size ? *arguments_.size / own_size : 1.0;
        };
        std::vector<EmbeddingTarget> targets;
        if (arguments_.onto.empty())
            targets.push_back({.name = "applied",
                               .shape =
                                   [&] {
                                       return apply_differences(start_of(first, first.from_size),
                                                                differences, amounts);
                                   },
                               .resized = resized(first.from_size)});
        for (std::size_t i = 0; i < onto_.size(); ++i)
            targets.push_back(
                {.name = onto_.names[i],
                 .shape =
                     [&, i] {
                         return apply_differences(shape_of(onto_.topology, onto_.points[i]),
                                                  differences, amounts);
                     },
                 .place = &onto_.points[i],
                 .resized = resized(edge_lengths(onto_.topology, onto_.points[i]).sum())});
        const Points& reference =
            onto_.points.empty() ? first.reference_points : onto_.points.front();
        return embed_and_write(session_, arguments_.embedding, first.topology, {reference}, targets,
                               *output_);
    }

private:
    void warn_of_unlike(const DifferenceVector& difference) const
    {
        Eigen::VectorXd sizes(std::ssize(onto_.points));
        for (std::size_t i = 0; i < onto_.size(); ++i)
            sizes[static_cast<Eigen::Index>(i)] =
                edge_lengths(onto_.topology, onto_.points[i]).sum();
        tools::warn_of_unlike(
            session_, onto_.names, marks_in_transfer(difference, onto_, sizes),
            words_of_transfer("--onto: ", join("the meshes of ", arguments_.load.empty()
                                                                     ? "the difference"
                                                                     : arguments_.load.front())));
    }

    const Session& session_;
    const Arguments& arguments_;
    Collection onto_;
    std::unique_ptr<MeshOutput> output_;
};

/// Differences that are added must be of meshes of one kind.
std::vector<DifferenceVector> read_differences(const Session& session,
                                               const std::vector<std::string>& files)
{
    std::vector<DifferenceVector> differences;
    for (const std::string& file : files)
        differences.push_back(read_difference(file));
    const DifferenceVector& first = differences.front();
    Collection meshes{first.topology, files, {}, {}};
    Eigen::VectorXd sizes(std::ssize(differences));
    for (std::size_t i = 0; i < files.size(); ++i) {
        const DifferenceVector& difference = differences[i];
        if (!(difference.topology == first.topology))
            throw InvalidInput(join(files[i], ": another triangulation than ", files.front(), "; ",
                                    describe_correspondence_break(mesh_of(first, files.front()),
                                                                  mesh_of(difference, files[i]))));
        if (difference.scale != first.scale)
            throw InvalidInput(join(files[i], ": --scale ", name(difference.scale), ", but ",
                                    files.front(), " has ", name(first.scale)));
        meshes.points.push_back(difference.reference_points);
        sizes[static_cast<Eigen::Index>(i)] = difference.from_size;
    }
    UnlikeWords words = words_of_transfer("--load: ", join("the meshes of ", files.front()));
    words.are_differences = true;
    warn_of_unlike(session, files, marks_in_transfer(first, meshes, sizes), words);
    return differences;
}

/// Applies differences that were saved.
void run_loaded(const Session& session, const Arguments& arguments)
{
    if (!arguments.input.meshes.paths.empty() || !arguments.output.empty())
        throw UsageError("--load applies saved differences; it takes neither MESHES nor -o");
    if (arguments.mesh.path.empty())
        throw UsageError("--load needs --mesh, where the result goes");
    const std::vector<DifferenceVector> differences = read_differences(session, arguments.load);
    const DifferenceVector& first = differences.front();
    const Collection none{first.topology, {}, {}, {}};
    Transfer transfer(session, arguments, none, mesh_of(first, arguments.load.front()),
                      {arguments.load.begin(), arguments.load.end()});
    Json figures = transfer.apply(differences);
    figures["differences"] = arguments.load;
    figures["amounts"] = amounts_of(arguments);
    figures["scale"] = name(differences.front().scale);
    session.print_figures(figures);
}

/// Finds a difference, and applies it if that is wanted.
void run_found(const Session& session, const Arguments& arguments)
{
    const std::pair<const char*, bool> required[] = {
        {"MESHES", !arguments.input.meshes.paths.empty()},
        {"--from", !arguments.from.empty()},
        {"--to", !arguments.to.empty()},
        {"-o", !arguments.output.empty()}};
    for (const auto& [option, is_given] : required)
        if (!is_given)
            throw UsageError(join(option, " is required (unless --load names differences)"));
    const DifferenceOptions options = difference_options(arguments);
    if (arguments.size && options.scale == Scale::None)
        throw UsageError("--size has no meaning with --scale none, lengths stay as they are");
    if (arguments.embedding.residuals && !arguments.apply)
        throw UsageError("--residuals needs --apply: no mesh comes out without it");
    (void)amounts_of(arguments); // refuse them before any work
    check_ending("-o", arguments.output, ".h5");
    const std::vector<std::filesystem::path> inputs = input_files(arguments.input.meshes);
    check_output(session, arguments.output, inputs);
    if (!arguments.effects.empty())
        check_effects(session, arguments.effects, inputs);
    const Collection collection = read_labelled(session, arguments.input);
    std::unique_ptr<Transfer> transfer;
    if (arguments.apply)
        transfer = std::make_unique<Transfer>(
            session, arguments, collection,
            NamedMesh{"the run", "the run", collection.points.front(), collection.topology.faces()},
            inputs);
    const DifferenceVector difference = mean_difference(collection, options);
    std::optional<ColumnEffects> effects;
    if (!arguments.effects.empty())
        effects = difference_effects(collection, options);
    if (options.pair_by.empty())
        if (const auto doubt = doubt_about_members(options, collection, effects.has_value()))
            session.warn(*doubt);
    throw_if_stop_requested();
    Json figures{{"outputs", Json::array()}};
    if (transfer)
        figures = transfer->apply({difference});
    write_difference(arguments.output, difference);
    figures["outputs"].push_back(arguments.output);
    figures["pairs"] = difference.pairs.size();
    figures["scale"] = name(difference.scale);
    figures["norm"] = difference.edge_lengths.norm();
    figures["from_size"] = difference.from_size;
    figures["to_size"] = difference.to_size;
    session.message(
        join(arguments.output, ": ",
             difference.pairs.empty()
                 ? "difference of the means of two groups without pairs"
                 : join("mean difference of ", counted(difference.pairs.size(), "pair"),
                        describe_repeated_pairs(options, collection, difference.pairs))));
    if (effects)
        figures["effects"] = find_effects(session, arguments, difference, *effects);
    session.print_figures(figures);
}

void add_finding_options(CLI::App& command, Arguments& arguments)
{
    const std::string group = "To find a difference";
    add_labelled_input(command, arguments.input);
    command.get_option("MESHES")->required(false)->option_text("PATH ...");
    add_label(
        command, "--pair-by", arguments.pair_by,
        "Meshes with the same value of it are a pair, or several on a side, whose mean counts;\n"
        "others are left out (default: no pairs,\n"
        "the means of all meshes of both groups are compared)")
        ->group(group);
    command.add_option("--from", arguments.from, "Where the difference starts")
        ->option_text("LABEL=VALUE")
        ->group(group);
    command.add_option("--to", arguments.to, "Where the difference ends")
        ->option_text("LABEL=VALUE")
        ->group(group);
    add_choice(command, "--scale", arguments.scale,
               "unit: lengths are divided by their sum (default); none: lengths stay as they are",
               {{"unit", Scale::Unit}, {"none", Scale::None}})
        ->group(group);
    add_output_file(command, arguments.output, "Difference to write (.h5)")
        ->required(false)
        ->option_text("FILE")
        ->group(group);
    add_effects(command, arguments.effects);
}

void add_applying_options(CLI::App& command, Arguments& arguments)
{
    const std::string group = "To apply it";
    CLI::Option* load =
        command
            .add_option("--load", arguments.load,
                        "Instead of finding one, apply these saved differences, all at once")
            ->option_text("FILE ...")
            ->group(group);
    for (const char* option :
         {"--pair-by", "--from", "--to", "--scale", "--labels", "--only", "--effects"})
        load->excludes(command.get_option(option));
    CLI::Option* apply = command
                             .add_flag("--apply", arguments.apply,
                                       "Make the mesh of start + amount x difference; implied by\n"
                                       "--load")
                             ->group(group);
    CLI::Option* mesh =
        command
            .add_option("--mesh", arguments.mesh.path,
                        "Where the result goes: a file (.obj .ply .off .stl .vtk .vtp .glb), or a\n"
                        "directory if there are several")
            ->option_text("PATH")
            ->group(group);
    apply->needs(mesh);
    command
        .add_option("--amount,--amounts", arguments.amounts,
                    "How much of the difference, any number (default: 1); with --load one for\n"
                    "each file")
        ->option_text("a1,a2,...")
        ->needs(mesh)
        ->group(group);
    command
        .add_option("--onto", arguments.onto,
                    "Start from these meshes, one result each: names of MESHES, mesh files,\n"
                    "directories or collection files of the same triangulation (default: start\n"
                    "from the mean of the meshes where the (first) difference starts)")
        ->option_text("MESH ...")
        ->needs(mesh)
        ->group(group);
    add_number(command, "--size", arguments.size,
               "Sum of the edge lengths of the start and of the result [unit of the input], > 0\n"
               "(default: the mesh's own; without --onto the mean size of the `from` meshes)",
               Sign::Positive)
        ->needs(mesh)
        ->group(group);
    add_mesh_format(command, arguments.mesh);
}

} // namespace

Run set_up_difference(CLI::App& command)
{
    command.description(
        "Find the mean difference of pairs of meshes in edge-length space (for example of the\n"
        "same person with two expressions), or of two groups without pairs, and apply it, or\n"
        "several that were saved: to the mean of the meshes it starts from, or to any mesh\n"
        "(expression transfer). Meshes without a partner are left out. A difference of --scale\n"
        "unit changes the shape of a mesh of any size and keeps that size; one of --scale none\n"
        "adds lengths as they are.");
    command.footer(
        "Examples:\n"
        "  shape difference faces.h5 --pair-by subject --from expression=neutral \\\n"
        "      --to expression=happy -o smile.h5 --apply --amount 1.5 --mesh smile.ply\n"
        "  shape difference faces.h5 --pair-by subject --from expression=neutral \\\n"
        "      --to expression=happy -o smile.h5 --effects smile_effects.ply\n"
        "  shape difference faces.h5 --from sex=f --to sex=m -o sex.h5 --effects sex_effects.ply\n"
        "  shape difference --load smile.h5 age.h5 --amounts 1,-0.5 --onto anna.ply \\\n"
        "      --mesh young_anna_smiles.ply");
    const auto arguments = std::make_shared<Arguments>();
    add_finding_options(command, *arguments);
    add_applying_options(command, *arguments);
    add_embedding_options(command, arguments->embedding);
    return [arguments](const Session& session) {
        if (!arguments->mesh.path.empty() && !arguments->apply && arguments->load.empty())
            throw UsageError("--mesh needs --apply (or --load)");
        arguments->load.empty() ? run_found(session, *arguments) : run_loaded(session, *arguments);
    };
}

} // namespace shape::tools
