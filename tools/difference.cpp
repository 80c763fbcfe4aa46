// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/format.h"
#include "libshape/io/model_file.h"
#include "libshape/model/difference.h"
#include "tools/commands.h"
#include "tools/common/arguments.h"
#include "tools/common/effects_output.h"
#include "tools/common/embedding_run.h"
#include "tools/common/interrupt.h"
#include "tools/common/mesh_input.h"
#include "tools/common/mesh_output.h"
#include "tools/common/model_tables.h"
#include "tools/common/output_rules.h"
#include "tools/common/session.h"

namespace shape::tools {
namespace {

struct Arguments
{
    MeshInput meshes;
    std::string pair_by;
    std::string from;
    std::string to;
    Scale scale = Scale::Unit;
    std::string output;
    std::string effects;
    bool apply = false;
    double amount = 1.0;
    std::optional<double> size;
    MeshOutputArguments mesh;
    EmbeddingArguments embedding;
};

/// The two sides of LABEL=VALUE.
std::pair<std::string, std::string> label_and_value(const std::string& option,
                                                    const std::string& text)
{
    const std::size_t sign = text.find('=');
    if (sign == std::string::npos || sign == 0)
        throw UsageError(join(option, ": '", text, "' must be LABEL=VALUE"));
    return {text.substr(0, sign), text.substr(sign + 1)};
}

DifferenceOptions difference_options(const Arguments& arguments)
{
    const auto [from_label, from_value] = label_and_value("--from", arguments.from);
    const auto [to_label, to_value] = label_and_value("--to", arguments.to);
    return {.pair_by = arguments.pair_by,
            .from_label = from_label,
            .from_value = from_value,
            .to_label = to_label,
            .to_value = to_value,
            .scale = arguments.scale};
}

/// Embeds mean(from) + amount * difference.
Json apply(const Session& session, const Arguments& arguments, const DifferenceVector& difference,
           MeshOutput& output)
{
    const double size = arguments.size.value_or(difference.from_size);
    const EmbeddingTarget target{
        "applied", [&] { return apply_difference(difference, arguments.amount, size); }};
    return embed_and_write(session, arguments.embedding, difference.topology,
                           {difference.reference_points}, {target}, output);
}

/// Writes where the pairs differ, on the mean of the meshes that the difference starts from.
Json find_effects(const Session& session, const Arguments& arguments,
                  const DifferenceVector& difference, const ColumnEffects& effects)
{
    const Embedder embedder(difference.topology, {difference.reference_points},
                            arguments.embedding.options);
    const ShapePoint start = apply_difference(difference, 0.0, difference.from_size);
    return write_effects(session, arguments.effects, difference.topology,
                         embedder.embed(start).points, effects);
}

void run(const Session& session, const Arguments& arguments)
{
    const DifferenceOptions options = difference_options(arguments);
    if (arguments.size && options.scale == Scale::None)
        throw UsageError("--size has no meaning with --scale none, lengths stay as they are");
    if (arguments.embedding.residuals && !arguments.apply)
        throw UsageError("--residuals needs --apply: no mesh comes out without it");
    check_ending("-o", arguments.output, ".h5");
    const std::vector<std::filesystem::path> inputs = input_files(arguments.meshes);
    check_output(session, arguments.output, inputs);
    if (!arguments.effects.empty())
        check_effects(session, arguments.effects, inputs);
    std::unique_ptr<MeshOutput> mesh;
    if (arguments.apply)
        mesh = std::make_unique<MeshOutput>(session, arguments.mesh,
                                            std::vector<std::string>{"applied"}, inputs);
    const Collection collection = read_meshes(session, arguments.meshes);
    const DifferenceVector difference = mean_difference(collection, options);
    std::optional<ColumnEffects> effects;
    if (!arguments.effects.empty())
        effects = difference_effects(collection, options);
    throw_if_interrupted();
    Json figures{{"outputs", Json::array()}};
    if (mesh)
        figures = apply(session, arguments, difference, *mesh);
    write_difference(arguments.output, difference);
    figures["outputs"].push_back(arguments.output);
    figures["pairs"] = difference.pairs.size();
    figures["scale"] = name(difference.scale);
    figures["norm"] = difference.edge_lengths.norm();
    figures["from_size"] = difference.from_size;
    figures["to_size"] = difference.to_size;
    session.message(
        join(arguments.output, ": mean difference of ", difference.pairs.size(), " pairs"));
    if (effects)
        figures["effects"] = find_effects(session, arguments, difference, *effects);
    session.print_figures(figures);
}

} // namespace

Run set_up_difference(CLI::App& command)
{
    command.description(
        "Find the mean difference of pairs of meshes in edge-length space (for example of the\n"
        "same person with two expressions) and apply it to the mean of the meshes it starts\n"
        "from. Meshes without a partner are left out.");
    command.footer(
        "Examples:\n"
        "  shape difference faces.h5 --pair-by subject --from expression=neutral \\\n"
        "      --to expression=happy -o smile.h5 --apply --amount 1.5 --mesh smile.ply\n"
        "  shape difference faces.h5 --pair-by subject --from expression=neutral \\\n"
        "      --to expression=happy -o smile.h5 --effects smile_effects.ply");
    const auto arguments = std::make_shared<Arguments>();
    add_mesh_input(command, arguments->meshes);
    add_labels(command, arguments->meshes);
    command
        .add_option("--pair-by", arguments->pair_by, "Meshes with the same value of it are a pair")
        ->required()
        ->option_text("LABEL REQUIRED");
    command.add_option("--from", arguments->from, "Where the difference starts")
        ->required()
        ->option_text("LABEL=VALUE REQUIRED");
    command.add_option("--to", arguments->to, "Where the difference ends")
        ->required()
        ->option_text("LABEL=VALUE REQUIRED");
    add_choice(command, "--scale", arguments->scale,
               "unit: lengths are divided by their sum (default); none: lengths stay as they are",
               {{"unit", Scale::Unit}, {"none", Scale::None}});
    add_output_file(command, arguments->output, "Difference to write (.h5)");
    add_effects(command, arguments->effects);
    CLI::Option* apply_flag = command.add_flag("--apply", arguments->apply,
                                               "Make the mesh of mean(from) + amount x difference");
    CLI::Option* mesh = command
                            .add_option("--mesh", arguments->mesh.path,
                                        "Where that mesh goes (.obj .ply .off .glb)")
                            ->option_text("FILE");
    apply_flag->needs(mesh);
    mesh->needs(apply_flag);
    add_number(command, "--amount", arguments->amount,
               "How much of the difference, any number (default: 1)")
        ->needs(apply_flag);
    add_number(command, "--size", arguments->size,
               "Sum of the edge lengths of mean(from) [unit of the input], > 0\n"
               "(default: the mean size of the `from` meshes)",
               Sign::Positive)
        ->needs(apply_flag);
    add_embedding_options(command, arguments->embedding);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
