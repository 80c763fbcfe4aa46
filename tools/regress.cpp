// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <Eigen/QR>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/oddities.h"
#include "libshape/model/covariate_effect.h"
#include "libshape/model/streamed_effect.h"
#include "libshape/report/plot.h"
#include "libshape/statistics/covariate_blocks.h"
#include "libshape/statistics/linear_model.h"
#include "tools/commands.h"
#include "tools/covariate_doubts.h"
#include "tools/input/label_input.h"
#include "tools/input/mesh_stream_input.h"
#include "tools/input/repeated_rows.h"
#include "tools/input/space_arguments.h"
#include "tools/output/embedding_run.h"
#include "tools/output/mesh_table.h"
#include "tools/output/output_rules.h"
#include "tools/output/pass_store.h"
#include "tools/output/plot_output.h"
#include "tools/output/test_tables.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    LabelledInput input;
    std::vector<std::string> on;
    std::string within;
    std::string output;
    std::string plot;
    std::int64_t permutations = 999;
    std::string at;
    MeshOutputArguments expected;
    MeshOutputArguments corrected;
    SpaceOptions space;
    MemoryArgument memory;
    EmbeddingArguments embedding;
};

/// The regression and its tests: of all covariates together, and of each beyond the others.
struct Findings
{
    std::vector<std::string> names; ///< N: of the meshes.
    Eigen::MatrixXd covariates;     ///< N by C.
    Eigen::VectorXd sizes;          ///< N [length].
    CovariateEffect effect;
    Eigen::VectorXd slope_norms;      ///< C.
    int passes = 0;                   ///< 0: in memory.
    bool are_slopes_compared = false; ///< compares_slopes().
    LinearModelTest together;
    std::vector<LinearModelTest> each;
};

/// Covariates of what counts once, about their means in the blocks.
Eigen::MatrixXd about_means(const Eigen::MatrixXd& covariates, const Grouping& blocks)
{
    const bool is_crossed = block_design(covariates, blocks) == BlockDesign::Crossed;
    std::vector<int> firsts; // in whose place the others of a row are, of the same covariates
    for (const std::vector<int>& row : members(covariate_rows(covariates, blocks)))
        firsts.push_back(row.front());
    Eigen::MatrixXd rows = covariates(firsts, Eigen::all);
    for (const std::vector<int>& block :
         members(is_crossed ? subset(blocks, firsts) : one_group(std::ssize(firsts)))) {
        const Eigen::RowVectorXd mean = rows(block, Eigen::all).colwise().mean();
        rows(block, Eigen::all).rowwise() -= mean;
    }
    return rows;
}

/// That covariates within blocks leave something to measure chance by, as they may not after a slip in a table that makes
/// them so.
void check_blocks(const Arguments& arguments, const Eigen::MatrixXd& covariates,
                  const Grouping& blocks)
{
    const int rows = covariate_rows(covariates, blocks).group_count();
    if (blocks.group_count() < 2 || rows > blocks.group_count() + covariates.cols())
        return;
    const std::vector<std::vector<int>> lists = members(blocks);
    std::vector<std::size_t> varying;
    for (std::size_t b = 0; b < lists.size(); ++b)
        if (const Eigen::MatrixXd own = covariates(lists[b], Eigen::all);
            (own.rowwise() - own.row(0)).cwiseAbs().maxCoeff() > 0.0)
            varying.push_back(b);
    throw InvalidInput(join("--on ", CLI::detail::join(arguments.on, ", "), ": differs within ",
                            varying.size(), " of ", counted(blocks.group_count(), "block"),
                            " of --within ", arguments.within, " (",
                            list_names(blocks.names, varying),
                            "), too few to tell slopes within blocks from chance. If that is a "
                            "slip, correct it; where it is the same in all meshes of each block, "
                            "the means of the blocks are regressed"));
}

/// Says by their names which covariates cannot be regressed on.
void check_covariates(const Session& session, const Arguments& arguments,
                      const Eigen::MatrixXd& covariates, const Grouping& blocks)
{
    constexpr double rounding = 1e-12; // that of the regression
    std::string nested;
    std::string crossed;
    for (Eigen::Index k = 0; k < covariates.cols(); ++k) {
        const std::string& name = arguments.on[to_size(k)];
        const Eigen::MatrixXd column = covariates.col(k);
        if (column.minCoeff() == column.maxCoeff())
            throw InvalidInput(join("--on ", name, ": is constant, ", column(0, 0), " for all ",
                                    counted(column.rows(), "mesh", "meshes"),
                                    "; shape is regressed on numbers that differ between meshes"));
        if ((column.array() - column.mean()).matrix().norm() <= rounding * column.norm())
            throw InvalidInput(join("--on ", name, ": is constant but for rounding, ",
                                    column.minCoeff(), " for all ",
                                    counted(column.rows(), "mesh", "meshes"), " up to ",
                                    column.maxCoeff() - column.minCoeff(),
                                    "; subtract what its values have in common"));
        const bool is_nested = block_design(column, blocks) == BlockDesign::Nested;
        if (!is_nested && about_means(column, blocks).norm() <= rounding * column.norm())
            throw InvalidInput(join("--on ", name, ": differs within the blocks of --within ",
                                    arguments.within,
                                    " by no more than rounding; write equal values alike"));
        (is_nested ? nested : crossed) = name;
    }
    if (!nested.empty() && !crossed.empty())
        throw InvalidInput(join("--on ", nested, ": is the same for all meshes of a value of ",
                                arguments.within, ", ", crossed,
                                " is not; regress on one of them at a time"));
    if (!crossed.empty()) {
        check_blocks(arguments, covariates, blocks);
        for (Eigen::Index k = 0; k < covariates.cols() && !arguments.within.empty(); ++k)
            if (const auto doubt = doubt_about_varying_blocks(
                    covariates.col(k), blocks, join("--on ", arguments.on[to_size(k)]),
                    arguments.within))
                session.warn(*doubt);
    }
    Eigen::MatrixXd directions = about_means(covariates, blocks);
    if (directions.rows() < covariates.cols() + 2)
        return; // fails as such
    directions.colwise().normalize();
    for (Eigen::Index k = 1; k < covariates.cols(); ++k) {
        Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(directions.leftCols(k + 1));
        qr.setThreshold(1e-9); // that of the regression
        if (qr.rank() <= k)
            throw InvalidInput(join(
                "--on ", arguments.on[to_size(k)],
                ": is a combination of the covariates before it (",
                CLI::detail::join(
                    std::vector<std::string>(arguments.on.begin(), arguments.on.begin() + k), ", "),
                ")", arguments.within.empty() ? "" : " where it is tested",
                "; leave one of them out"));
    }
}

/// Of slopes that one mesh or block determines.
void warn_of_slopes_of_one(const Session& session, const Arguments& arguments,
                           const Findings& findings, const Grouping& blocks)
{
    Grouping meshes = groups_of_one(findings.covariates.rows());
    meshes.names = findings.names;
    const bool are_blocks = !arguments.within.empty() && blocks.group_count() > 1;
    const Grouping& carriers = are_blocks ? blocks : meshes;
    const Grouping rows = covariate_rows(findings.covariates, blocks);
    for (Eigen::Index k = 0; k < findings.covariates.cols(); ++k) {
        const Eigen::VectorXd covariate = findings.covariates.col(k);
        const std::string option = join("--on ", arguments.on[to_size(k)]);
        if (are_blocks && doubt_about_varying_blocks(covariate, blocks, option, arguments.within))
            continue; // which is said
        Eigen::VectorXd shares =
            slope_shares(findings.effect.regression.weights.col(k), rows, carriers);
        if (!are_blocks || findings.effect.design == BlockDesign::Nested)
            shares =
                shares_beyond_means(shares, groups_of_one(shares.size()), one_group(shares.size()));
        if (const auto doubt = doubt_about_slope(covariate, carriers, shares, option,
                                                 are_blocks ? arguments.within : std::string()))
            session.warn(*doubt);
    }
}

/// Of meshes that are not given as blocks.
void warn_of_dependent_rows(const Session& session, const Arguments& arguments,
                            const MeshLabels& meshes, const Findings& findings)
{
    if (!arguments.within.empty())
        return;
    RepetitionQuestion rows{.covariates = findings.covariates,
                            .columns = arguments.on,
                            .remedy = "then chance looks significant. Give --within",
                            .unnamed = "a label that names them"};
    const auto size = std::find(arguments.on.begin(), arguments.on.end(), "size");
    if (size !=
        arguments.on.end()) { // which differs a little inside: --within would ask about that
        rows.sizes = size - arguments.on.begin();
        rows.remedy = "then chance looks significant. Take one mesh, or the mean, of each";
        rows.unnamed = "set";
    }
    if (!warn_of_repeated_rows(session, meshes, rows))
        warn_of_close_rows(session, meshes, rows, findings.effect.products);
}

/// The tests, from inner products.
void test(const Session& session, const Arguments& arguments, const Grouping& blocks,
          Findings& findings)
{
    const PermutationOptions options{.permutations = static_cast<int>(arguments.permutations),
                                     .seed = static_cast<std::uint64_t>(session.seed)};
    const ExchangeableRows rows =
        exchangeable_rows(findings.effect.products, findings.covariates, blocks);
    findings.are_slopes_compared = compares_slopes(rows);
    const Eigen::MatrixXd& all = rows.covariates;
    const Eigen::MatrixXd none(all.rows(), 0);
    findings.together = test_covariates(rows, all, none, options);
    if (all.cols() == 1) {
        findings.each = {findings.together};
        return;
    }
    for (Eigen::Index k = 0; k < all.cols(); ++k) {
        throw_if_stop_requested();
        Eigen::MatrixXd others(all.rows(), all.cols() - 1);
        others << all.leftCols(k), all.rightCols(all.cols() - 1 - k);
        try {
            findings.each.push_back(test_covariates(rows, all.col(k), others, options));
        } catch (const InvalidInput& error) {
            throw InvalidInput(join("--on ", arguments.on[to_size(k)], ": ", error.what()));
        }
    }
}

Findings find(const Session& session, const Arguments& arguments, const Collection& collection)
{
    Findings findings;
    findings.names = collection.names;
    const ShapeSpace space = make_space(collection, arguments.space);
    warn_of_alignment(session, space);
    findings.sizes = sizes(space, collection);
    findings.covariates =
        covariates_of(collection, findings.sizes, arguments.on, arguments.input.meshes.labels);
    const Grouping blocks = group_by_label_or_all(collection, arguments.within);
    check_covariates(session, arguments, findings.covariates, blocks);
    findings.effect = covariate_effect(collection, space, findings.covariates, blocks);
    findings.slope_norms = findings.effect.regression.slopes.rowwise().norm();
    warn_of_slopes_of_one(session, arguments, findings, blocks);
    warn_of_dependent_rows(session, arguments, collection, findings);
    throw_if_stop_requested();
    test(session, arguments, blocks, findings);
    return findings;
}

/// @param reference  Gets the first mesh.
Findings find_in_passes(const Session& session, const Arguments& arguments,
                        const MeshStream& meshes, Points& reference)
{
    Findings findings;
    findings.names = meshes.names;
    StreamedEffectOptions options;
    options.space = arguments.space;
    options.memory = arguments.memory.bytes;
    options.progress = session.progress();
    options.scratch = scratch_folder(arguments.output);
    const Grouping blocks = group_by_label_or_all(meshes, arguments.within);
    options.covariates = [&](const Eigen::VectorXd& sizes) {
        Eigen::MatrixXd covariates =
            covariates_of(meshes, sizes, arguments.on, arguments.input.meshes.labels);
        check_covariates(session, arguments, covariates, blocks);
        return covariates;
    };
    options.with_shapes = !arguments.expected.path.empty();
    StreamedEffect found = covariate_effect(meshes, blocks, options);
    findings.covariates = std::move(found.covariates);
    findings.sizes = std::move(found.sizes);
    findings.effect = std::move(found.effect);
    findings.slope_norms = std::move(found.slope_norms);
    warn_of_slopes_of_one(session, arguments, findings, blocks);
    warn_of_dependent_rows(session, arguments, meshes, findings);
    findings.passes = found.passes;
    reference = std::move(found.reference_points);
    throw_if_stop_requested();
    test(session, arguments, blocks, findings);
    return findings;
}

/// Columns `mesh`, the covariates, `score`.
Table score_table(const Arguments& arguments, const Findings& findings)
{
    Table table = mesh_table(findings.names, {});
    for (std::size_t k = 0; k < arguments.on.size(); ++k)
        add_column(table, arguments.on[k], findings.covariates.col(static_cast<Eigen::Index>(k)));
    add_column(table, "score", findings.effect.scores);
    check_columns(table);
    return table;
}

std::string draw_scores(const std::string& covariate, const Findings& findings)
{
    const Eigen::VectorXd x = findings.covariates.col(0);
    Eigen::MatrixX2d points(x.size(), 2);
    points << x, findings.effect.scores;
    const Eigen::MatrixX2d line{{x.minCoeff(), x.minCoeff()}, {x.maxCoeff(), x.maxCoeff()}};
    return plot_svg(
        {.title = {},
         .x_label = covariate,
         .y_label = "score along the regression, in units of " + covariate,
         .series = {{.name = "meshes", .points = points, .tips = findings.names, .curve = false},
                    {.name = "regression", .points = line, .tips = {}, .curve = true}},
         .equal_axes = false});
}

/// The values of --at as given and as numbers.
std::vector<std::pair<std::string, double>> places(const Arguments& arguments)
{
    std::vector<std::pair<std::string, double>> result;
    if (!arguments.at.empty())
        for (const std::string& text : split(arguments.at, ',')) {
            result.emplace_back(text, read_number(text, "--at"));
            if (arguments.on.front() == "size" && !(result.back().second > 0.0))
                throw UsageError(join("--at ", text, ": a size must be > 0"));
        }
    return result;
}

/// Warns of values of --at beyond those that were measured: there the line is a guess.
void warn_of_extrapolation(const Session& session, const Arguments& arguments,
                           const Findings& findings)
{
    const double low = findings.covariates.col(0).minCoeff();
    const double high = findings.covariates.col(0).maxCoeff();
    for (const auto& [text, value] : places(arguments))
        if (value < low || value > high)
            session.warn(
                join("--at ", text, " is outside the data: ", arguments.on.front(),
                     " is measured from ", low, " to ", high, ", and this lies ",
                     value < low ? (low - value) / (high - low) : (value - high) / (high - low),
                     " times that range beyond it; the expected shape is an "
                     "extrapolation that no mesh supports"));
}

/// The shapes expected at values of the one covariate; with their mean size, or that value of it.
std::vector<EmbeddingTarget> expected_targets(const Arguments& arguments, const Findings& findings)
{
    std::vector<EmbeddingTarget> targets;
    const double mean_size = findings.sizes.mean();
    const bool is_size =
        arguments.on.front() == "size" && scale_of(findings.effect.space) == Scale::Unit;
    for (const auto& [text, value] : places(arguments))
        targets.push_back({.name = join(arguments.on.front(), "_", text),
                           .shape =
                               [&findings, value = value, mean_size] {
                                   return expected_shape(findings.effect,
                                                         Eigen::VectorXd::Constant(1, value),
                                                         mean_size);
                               },
                           .resized = is_size ? value / mean_size : 1.0});
    return targets;
}

/// All meshes at the means of the covariates.
std::vector<EmbeddingTarget> corrected_targets(const Collection& collection,
                                               const Findings& findings)
{
    std::vector<EmbeddingTarget> targets;
    for (std::size_t i = 0; i < collection.size(); ++i)
        targets.push_back({collection.names[i],
                           [&collection, &findings, i] {
                               return move_along_slopes(
                                   findings.effect, subset(collection, {i}),
                                   findings.covariates.row(static_cast<Eigen::Index>(i)),
                                   findings.effect.regression.covariate_means);
                           },
                           &collection.points[i]});
    return targets;
}

/// A place for meshes, if one was named.
std::unique_ptr<MeshOutput> mesh_output(const Session& session, const Arguments& arguments,
                                        const std::string& path,
                                        const std::vector<EmbeddingTarget>& targets)
{
    if (path.empty())
        return nullptr;
    MeshOutputArguments place = arguments.expected;
    place.path = path;
    return std::make_unique<MeshOutput>(session, place, names(targets),
                                        input_files(arguments.input.meshes));
}

Json covariate_figures(const Arguments& arguments, const Findings& findings)
{
    Json figures = Json::array();
    for (std::size_t k = 0; k < arguments.on.size(); ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        Json covariate{{"name", arguments.on[k]},
                       {"mean", findings.effect.regression.covariate_means[row]},
                       {"slope_norm", findings.slope_norms[row]}};
        covariate.update(test_figures(findings.each[k]));
        figures.push_back(covariate);
    }
    return figures;
}

std::string summary(const Arguments& arguments, const Findings& findings)
{
    std::string text;
    if (!arguments.within.empty())
        text += findings.effect.design == BlockDesign::Crossed
                    ? join("within each ", arguments.within,
                           findings.are_slopes_compared
                               ? join(", against how much slopes differ between them")
                               : std::string(),
                           ":\n")
                    : join("means of each ", arguments.within,
                           ", within which the covariates are the same:\n");
    for (std::size_t k = 0; k < arguments.on.size(); ++k)
        text += join(arguments.on[k], findings.each.size() > 1 ? " beyond the others: " : ": ",
                     describe(findings.each[k]), "\n");
    if (findings.each.size() > 1)
        text += join("together: ", describe(findings.together), "\n");
    return text;
}

void check_outputs(const Session& session, const Arguments& arguments)
{
    const std::vector<std::filesystem::path> inputs = input_files(arguments.input.meshes);
    check_ending("-o", arguments.output, ".csv");
    check_output(session, arguments.output, inputs);
    if (!arguments.plot.empty()) {
        check_picture("--plot", arguments.plot);
        check_output(session, arguments.plot, inputs);
    }
    if (!arguments.expected.path.empty() && !arguments.corrected.path.empty())
        check_different("--corrected", arguments.corrected.path, "--expected",
                        arguments.expected.path);
}

/// A collection that goes in passes; --corrected makes every mesh, of all of them.
std::optional<MeshStream> open_meshes(const Session& session, const Arguments& arguments)
{
    if (arguments.corrected.path.empty())
        return open_for_passes(session, arguments.input, arguments.space, arguments.memory);
    if (arguments.memory.bytes > 0)
        throw UsageError(
            "--corrected makes every mesh, which takes all of them in memory; give it "
            "without --memory");
    return std::nullopt;
}

/// Writes everything.
/// @param corrected  Of all meshes; not looked at without --corrected.
void report(const Session& session, const Arguments& arguments, const Findings& findings,
            const Topology& topology, const Points& reference,
            const std::vector<EmbeddingTarget>& corrected)
{
    const Table scores = score_table(arguments, findings);
    warn_of_extrapolation(session, arguments, findings);
    const std::vector<EmbeddingTarget> expected = expected_targets(arguments, findings);
    const auto expected_output = mesh_output(session, arguments, arguments.expected.path, expected);
    const auto corrected_output =
        mesh_output(session, arguments, arguments.corrected.path, corrected);
    Json figures{{"outputs", Json::array()}, {"embeddings", Json::array()}};
    const auto make = [&](const std::vector<EmbeddingTarget>& targets, MeshOutput& output) {
        const Json made =
            embed_and_write(session, arguments.embedding, topology, {reference}, targets, output);
        for (const char* list : {"outputs", "embeddings"})
            figures[list].insert(figures[list].end(), made[list].begin(), made[list].end());
    };
    if (expected_output)
        make(expected, *expected_output);
    if (corrected_output)
        make(corrected, *corrected_output);
    write_table(arguments.output, scores);
    figures["outputs"].push_back(arguments.output);
    if (!arguments.plot.empty()) {
        write_picture(arguments.plot, draw_scores(arguments.on.front(), findings));
        figures["outputs"].push_back(arguments.plot);
    }
    figures["meshes"] = findings.names.size();
    if (findings.passes > 0)
        figures["passes"] = findings.passes;
    figures.update(space_figures(findings.effect.space));
    figures["covariates"] = covariate_figures(arguments, findings);
    figures["together"] = test_figures(findings.together);
    if (!arguments.within.empty())
        figures["design"] = findings.effect.design == BlockDesign::Crossed ? "crossed" : "nested";
    session.message(summary(arguments, findings));
    session.print_figures(figures);
}

void run(const Session& session, const Arguments& arguments)
{
    check_space_options(arguments.space);
    for (auto name = arguments.on.begin(); name != arguments.on.end(); ++name)
        if (std::find(arguments.on.begin(), name, *name) != name)
            throw UsageError(join("--on ", *name, " is given twice; give it once"));
    check_outputs(session, arguments);
    if (!arguments.at.empty() && arguments.on.size() > 1)
        throw UsageError("--at takes values of one covariate; give --on once");
    (void)places(arguments); // before any work
    if (const auto meshes = open_meshes(session, arguments)) {
        warn_of_missing_codes(session, arguments.input, meshes->labels, arguments.on);
        Points reference;
        const Findings findings = find_in_passes(session, arguments, *meshes, reference);
        return report(session, arguments, findings, meshes->topology, reference, {});
    }
    const Collection collection = read_labelled(session, arguments.input);
    warn_of_missing_codes(session, arguments.input, collection.labels, arguments.on);
    const Findings findings = find(session, arguments, collection);
    report(session, arguments, findings, collection.topology, collection.points.front(),
           corrected_targets(collection, findings));
}

} // namespace

Run set_up_regress(CLI::App& command)
{
    command.description(
        "Regress shape on numbers such as age, or on size (allometry): how much of the variation\n"
        "they explain, whether that is more than chance (permutation test), what the expected\n"
        "shape is at given values, and the meshes without the effect, for further analysis.\n"
        "With --scale unit (default) the size of a mesh is not part of its shape.");
    command.footer(
        "Examples:\n"
        "  shape regress faces.h5 --on size -o allometry.csv --plot allometry.svg\n"
        "  shape regress arms/ --labels arms.csv --on elbow_deg -o bend.csv \\\n"
        "      --at 0,50,100 --expected bend/ --corrected straightened/");
    const auto arguments = std::make_shared<Arguments>();
    add_labelled_input(command, arguments->input);
    add_covariates(command, "--on", arguments->on,
                   "Label whose values are numbers, or `size` (sum of the edge lengths; centroid\n"
                   "size in Procrustes space); may be repeated");
    command.get_option("--on")->required()->option_text("LABEL|size REQUIRED");
    add_label(
        command, "--within", arguments->within,
        "Meshes with the same value of it are a block, such as all meshes of a subject. "
        "Covariates\n"
        "that differ inside blocks are tested there; if they are the same for all of a block (the\n"
        "age of a subject scanned several times), the means of the blocks are regressed");
    add_output_file(
        command, arguments->output,
        "CSV file to write: mesh, the covariates, and score, where the mesh lies along\n"
        "the slope of the first covariate, in its unit");
    command
        .add_option("--plot", arguments->plot,
                    "Draw the score of every mesh against its first covariate (.svg or .png)")
        ->option_text("FILE");
    add_permutations(command, arguments->permutations);
    CLI::Option* expected =
        command
            .add_option("--expected", arguments->expected.path,
                        "Make the meshes expected at --at in this directory (age_20.ply and so on)")
            ->option_text("DIR");
    CLI::Option* at = command
                          .add_option("--at", arguments->at,
                                      "Values of the covariate for --expected, in its unit")
                          ->option_text("v1,v2,...");
    expected->needs(at);
    at->needs(expected);
    command
        .add_option("--corrected", arguments->corrected.path,
                    "Make every mesh without the effect, moved to the mean of the covariates, in\n"
                    "this directory")
        ->option_text("DIR");
    add_mesh_format(command, arguments->expected);
    add_space_options(command, arguments->space);
    add_memory(command, arguments->memory);
    add_embedding_options(command, arguments->embedding);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
