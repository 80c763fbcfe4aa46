// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/io/table_file.h"
#include "libshape/model/group_means.h"
#include "libshape/model/streamed_groups.h"
#include "libshape/statistics/group_comparison.h"
#include "libshape/statistics/group_fit.h"
#include "libshape/statistics/group_spread.h"
#include "tools/commands.h"
#include "tools/covariate_doubts.h"
#include "tools/doubts.h"
#include "tools/input/label_input.h"
#include "tools/input/mesh_stream_input.h"
#include "tools/input/repeated_rows.h"
#include "tools/input/space_arguments.h"
#include "tools/output/embedding_run.h"
#include "tools/output/output_rules.h"
#include "tools/output/test_tables.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    LabelledInput input;
    std::string by;
    std::string within;
    std::vector<std::string> covariates;
    std::string output;
    std::int64_t permutations = 999;
    std::int64_t replicates = 1000;
    MeshOutputArguments means;
    SpaceOptions space;
    EmbeddingArguments embedding;
    MemoryArgument memory;
};

/// What is known of the groups and of the differences between them.
struct Findings
{
    Grouping groups;
    Grouping blocks;
    std::vector<std::vector<int>> members;
    GroupedShapes shapes; ///< Without inner products.
    GroupComparison comparison;
    GroupSpread spread;
    LinearModelTest spread_test;
};

Json group_figures(const Arguments& arguments, const Findings& findings)
{
    Json groups = Json::array();
    for (std::size_t g = 0; g < findings.members.size(); ++g) {
        groups.push_back({{"name", findings.groups.names[g]},
                          {"meshes", findings.members[g].size()},
                          {"mean_size", findings.shapes.mean_sizes[static_cast<Eigen::Index>(g)]},
                          {"variance", findings.spread.variances[g]},
                          {"variance_low", findings.spread.variance_intervals[g].low},
                          {"variance_high", findings.spread.variance_intervals[g].high}});
        if (!arguments.within.empty())
            groups.back()["blocks"] = findings.spread.counts[g];
    }
    return groups;
}

/// Where adjusted means are.
Json adjustment_figures(const Arguments& arguments, const Findings& findings)
{
    Json covariates = Json::array();
    for (std::size_t c = 0; c < arguments.covariates.size(); ++c)
        covariates.push_back(
            {{"label", arguments.covariates[c]},
             {"at", findings.shapes.covariate_means[static_cast<Eigen::Index>(c)]}});
    return covariates;
}

bool is_within(const Findings& findings, const PairComparison& pair)
{
    return is_within_blocks(findings.groups, findings.blocks, pair.first, pair.second);
}

Json pair_figures(const Arguments& arguments, const Findings& findings)
{
    Json pairs = Json::array();
    for (const PairComparison& pair : findings.comparison.pairs) {
        Json figures{{"first", findings.groups.names[to_size(pair.first)]},
                     {"second", findings.groups.names[to_size(pair.second)]},
                     {"distance", pair.distance},
                     {"radius", findings.spread.distance_radii(pair.first, pair.second)}};
        if (!arguments.within.empty())
            figures["design"] = is_within(findings, pair) ? "crossed" : "nested";
        figures.update(test_figures(pair.test));
        figures["p_adjusted"] = std::isnan(pair.adjusted_p) ? Json() : Json(pair.adjusted_p);
        pairs.push_back(figures);
    }
    return pairs;
}

/// One row for all groups together and one for each pair.
Table comparison_table(const Findings& findings)
{
    Table table;
    table.columns = {"first", "second", "distance", "radius"};
    const std::vector<std::string> columns = test_columns();
    table.columns.insert(table.columns.end(), columns.begin(), columns.end());
    table.columns.emplace_back("p_adjusted");
    const auto add = [&](std::vector<std::string> cells, const LinearModelTest& test, double p) {
        for (const std::string& cell : test_cells(test))
            cells.push_back(cell);
        cells.push_back(std::isnan(p) ? "" : print_number(p));
        table.rows.push_back(cells);
    };
    const auto cell = [](double number) {
        return std::isnan(number) ? std::string() : print_number(number);
    };
    add({"", "", "", ""}, findings.comparison.overall, findings.comparison.overall.p_value);
    for (const PairComparison& pair : findings.comparison.pairs)
        add({findings.groups.names[to_size(pair.first)],
             findings.groups.names[to_size(pair.second)], cell(pair.distance),
             cell(findings.spread.distance_radii(pair.first, pair.second))},
            pair.test, pair.adjusted_p);
    return table;
}

/// Which meshes count, and how.
std::string described_counting(const Arguments& arguments, const Findings& findings)
{
    std::string text;
    const bool is_crossed = findings.comparison.design == BlockDesign::Crossed;
    if (!arguments.within.empty())
        text += is_crossed ? join("means and distances within each ", arguments.within,
                                  ", which counts once in each group\n")
                           : join("each ", arguments.within, " counts once, by its mean\n");
    if (findings.comparison.left_out > 0)
        text += join(counted(findings.comparison.left_out, "mesh is", "meshes are"),
                     " left out, whose ", arguments.within, " lies in one group\n");
    std::string places;
    for (std::size_t c = 0; c < arguments.covariates.size(); ++c)
        places += join(c > 0 ? ", " : "", arguments.covariates[c], " = ",
                       findings.shapes.covariate_means[static_cast<Eigen::Index>(c)]);
    if (!places.empty())
        text += join("means and distances at ", places, ", variances about the slopes\n");
    return text;
}

/// The variance of a group and its interval, as far as its members determine them.
std::string described_variance(const GroupSpread& spread, std::size_t group)
{
    if (std::isnan(spread.variances[group]))
        return "variance not determined";
    const auto [low, high] = spread.variance_intervals[group];
    return join("variance ", spread.variances[group],
                std::isnan(low) ? std::string(" (95 %: not determined)")
                                : join(" (95 %: ", low, " to ", high, ")"));
}

std::string described_distance(const Findings& findings, const PairComparison& pair)
{
    if (std::isnan(pair.distance))
        return "distance not determined, a covariate does not vary within the groups or blocks";
    const double radius = findings.spread.distance_radii(pair.first, pair.second);
    return join(
        "distance ", pair.distance,
        std::isnan(radius) ? std::string(" (radius not determined)") : join(" +- ", radius));
}

/// That a pair is not compared as the others are.
std::string described_design(const Arguments& arguments, const Findings& findings,
                             const PairComparison& pair)
{
    if (findings.comparison.design == BlockDesign::Nested || is_within(findings, pair))
        return {};
    return join(" (not within: no ", arguments.within, " has both, its means are tested)");
}

std::string summary(const Arguments& arguments, const Findings& findings)
{
    std::string text = described_counting(arguments, findings);
    text += join("all ", findings.groups.group_count(),
                 " groups: ", describe(findings.comparison.overall), "\n");
    text += join("spread of the groups: ", describe(findings.spread_test), "\n");
    constexpr std::size_t most_lines = 45; // ten groups
    if (findings.comparison.pairs.size() > most_lines)
        return text;
    for (std::size_t g = 0; g < findings.members.size(); ++g)
        text += join(findings.groups.names[g], ": ",
                     counted(findings.members[g].size(), "mesh", "meshes"),
                     arguments.within.empty()
                         ? std::string()
                         : join(", ", arguments.within, " counted: ", findings.spread.counts[g]),
                     ", ", described_variance(findings.spread, g), "\n");
    for (const PairComparison& pair : findings.comparison.pairs)
        text += join(
            findings.groups.names[to_size(pair.first)], " - ",
            findings.groups.names[to_size(pair.second)], ": ", described_distance(findings, pair),
            ", ", describe(pair.test), described_design(arguments, findings, pair),
            pair.test.permutations > 0 ? join(", adjusted p = ", pair.adjusted_p) : "", "\n");
    return text;
}

/// Embeds the means of the groups.
Json write_means(const Session& session, const Arguments& arguments, const Topology& topology,
                 const Points& reference, const Findings& findings, MeshOutput& output)
{
    std::vector<EmbeddingTarget> targets;
    for (int g = 0; g < findings.groups.group_count(); ++g)
        targets.push_back({findings.groups.names[to_size(g)],
                           [&findings, g] { return mean_shape(findings.shapes, g); }});
    return embed_and_write(session, arguments.embedding, topology, {reference}, targets, output);
}

PermutationOptions permutation_options(const Session& session, const Arguments& arguments)
{
    return {.permutations = static_cast<int>(arguments.permutations),
            .seed = static_cast<std::uint64_t>(session.seed)};
}

BootstrapOptions bootstrap_options(const Session& session, const Arguments& arguments)
{
    return {.replicates = static_cast<int>(arguments.replicates),
            .seed = static_cast<std::uint64_t>(session.seed)};
}

/// The groups, the blocks, and where the means go if they are asked for.
struct Setting
{
    Grouping groups = {};
    Grouping blocks = {};
    std::unique_ptr<MeshOutput> means = nullptr;
    RepetitionQuestion rows = {};
    bool are_rows_told = false; ///< Blocks are given, or labels have told that they are wanted.
};

Setting prepare(const Session& session, const Arguments& arguments, const MeshLabels& meshes,
                const std::vector<std::filesystem::path>& inputs)
{
    warn_of_missing_codes(session, arguments.input, meshes.labels, arguments.covariates);
    Setting setting{.groups = group_by_label(meshes, arguments.by),
                    .blocks = group_by_label_or_each(meshes, arguments.within)};
    if (!arguments.within.empty())
        if (const auto doubt = doubt_about_lost_meshes(setting.groups, setting.blocks, arguments.by,
                                                       arguments.within))
            session.warn(*doubt);
    if (const auto doubt = doubt_about_numeric_groups(setting.groups, arguments.by))
        session.warn(*doubt);
    if (const auto doubt = doubt_of_replicates(arguments.replicates))
        session.warn(join("--bootstrap: ", *doubt));
    if (!arguments.means.path.empty())
        setting.means =
            std::make_unique<MeshOutput>(session, arguments.means, setting.groups.names, inputs);
    setting.rows = rows_of_comparison(setting.groups, arguments.by);
    setting.are_rows_told =
        !arguments.within.empty() || warn_of_repeated_rows(session, meshes, setting.rows);
    return setting;
}

/// Whether a covariate is the same in all these meshes.
bool is_constant(const Eigen::VectorXd& covariate, const std::vector<int>& meshes)
{
    return std::ranges::all_of(meshes,
                               [&](int i) { return covariate[i] == covariate[meshes.front()]; });
}

/// The fewest of some columns that have a number as a combination of them, about the means of the blocks, of columns
/// that are left out one by one; nothing if all have not, or the number does not vary so, or it were no wonder: where
/// no two degrees of freedom are left.
std::vector<std::size_t> explaining(const Eigen::VectorXd& number, const Eigen::MatrixXd& columns,
                                    const Grouping& blocks)
{
    constexpr double rounding = 1e-9; // that of the tests
    const auto centred = [lists = members(blocks)](Eigen::MatrixXd matrix) {
        for (const std::vector<int>& block : lists) {
            const Eigen::RowVectorXd mean = matrix(block, Eigen::all).colwise().mean();
            matrix(block, Eigen::all).rowwise() -= mean;
        }
        return matrix;
    };
    const Eigen::VectorXd wanted = centred(number);
    if (wanted.norm() <= rounding * number.norm() ||
        number.size() < blocks.group_count() + columns.cols() + 2)
        return {};
    Eigen::MatrixXd given = centred(columns);
    for (Eigen::Index c = 0; c < given.cols(); ++c)
        given.col(c) /= std::max({given.col(c).norm(), rounding * columns.col(c).norm(),
                                  std::numeric_limits<double>::min()});
    const auto explain = [&](const std::vector<std::size_t>& some) {
        const Eigen::MatrixXd chosen = given(Eigen::all, some);
        Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(chosen);
        qr.setThreshold(rounding);
        return (chosen * qr.solve(wanted) - wanted).norm() <= rounding * wanted.norm();
    };
    std::vector<std::size_t> kept(to_size(given.cols()));
    std::iota(kept.begin(), kept.end(), std::size_t{0});
    if (kept.empty() || !explain(kept))
        return {};
    for (std::size_t c = kept.size(); c-- > 0 && kept.size() > 1;) {
        std::vector<std::size_t> fewer = kept;
        fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(c));
        if (explain(fewer))
            kept = std::move(fewer);
    }
    return kept;
}

/// "a", "a and b", "a, b and c".
std::string listed(const std::vector<std::string>& names, const std::vector<std::size_t>& chosen)
{
    std::string text;
    for (std::size_t i = 0; i < chosen.size(); ++i)
        text += join(i == 0 ? "" : i + 1 == chosen.size() ? " and " : ", ", names[chosen[i]]);
    return text;
}

/// The observations that two groups are compared by, as compare_groups() does: the means of blocks, or of blocks that
/// have both in each.
struct ComparedRows
{
    Eigen::VectorXd is_second;
    Eigen::MatrixXd covariates;
    Grouping blocks;
};

ComparedRows compared_rows(const Grouping& groups, const Grouping& blocks,
                           const Eigen::MatrixXd& covariates, int first, int second)
{
    std::vector<int> both;
    for (std::size_t i = 0; i < groups.group_of.size(); ++i)
        if (groups.group_of[i] == first || groups.group_of[i] == second)
            both.push_back(static_cast<int>(i));
    const Grouping pair = subset(groups, both);
    const Grouping own_blocks = subset(blocks, both);
    const Eigen::MatrixXd own = covariates(both, Eigen::all);
    if (block_design(pair, own_blocks) == BlockDesign::Nested) {
        const GroupRows rows = rows_of_groups(pair, own_blocks, own);
        return {codes(rows.groups), rows.covariates, one_group(rows.groups.size())};
    }
    std::vector<int> kept;
    for (const std::vector<int>& block : members(own_blocks))
        if (subset(pair, block).group_count() > 1)
            kept.insert(kept.end(), block.begin(), block.end());
    const GroupRows rows =
        rows_of_groups(subset(pair, kept), subset(own_blocks, kept), own(kept, Eigen::all));
    return {codes(rows.groups), rows.covariates, rows.blocks};
}

/// The covariates.
/// @throws InvalidInput if some of them tell two groups apart, alone or together, and so nothing tells what either does:
///     where these are compared, what is tested would not vary beyond the covariates, whose names the test does not know.
Eigen::MatrixXd checked_covariates(const Arguments& arguments, const MeshLabels& meshes,
                                   const Grouping& groups, const Grouping& blocks,
                                   const Eigen::VectorXd& sizes)
{
    Eigen::MatrixXd covariates =
        covariates_of(meshes, sizes, arguments.covariates, arguments.input.meshes.labels);
    if (covariates.cols() == 0)
        return covariates;
    const std::vector<std::vector<int>> lists = members(groups);
    for (std::size_t g = 0; g < lists.size(); ++g)
        for (std::size_t h = g + 1; h < lists.size(); ++h) {
            const ComparedRows rows =
                compared_rows(groups, blocks, covariates, static_cast<int>(g), static_cast<int>(h));
            const std::vector<std::size_t> found =
                explaining(rows.is_second, rows.covariates, rows.blocks);
            if (found.empty())
                continue;
            const std::string names = listed(arguments.covariates, found);
            const Eigen::VectorXd column = covariates.col(static_cast<Eigen::Index>(found.front()));
            if (found.size() == 1 && is_constant(column, lists[g]) && is_constant(column, lists[h]))
                throw InvalidInput(join(
                    "--adjust-for ", names, ": it is ", column[lists[g].front()],
                    " in all meshes of ", arguments.by, " = ", groups.names[g], " and ",
                    column[lists[h].front()], " in all of ", groups.names[h],
                    ", so that nothing tells what ", names, " does from what ", arguments.by,
                    " does; leave --adjust-for ", names, " out, or one of these groups (--only)"));
            throw InvalidInput(join(
                "--adjust-for ", names, ": ", found.size() == 1 ? "it tells" : "together they tell",
                " ", arguments.by, " = ", groups.names[g], " from ", groups.names[h],
                " where these are compared",
                arguments.within.empty() ? "" : join(" (--within ", arguments.within, ")"),
                ", so that nothing tells what ", names, found.size() == 1 ? " does" : " do",
                " from what ", arguments.by, " does; leave ",
                found.size() == 1 ? "it" : "one of them", " out, or one of these groups (--only)"));
        }
    return covariates;
}

/// Of covariates that explain nothing: the same for all, or because the blocks or others do.
void warn_of_idle_covariates(const Session& session, const Arguments& arguments,
                             const Findings& findings, const Eigen::MatrixXd& covariates)
{
    const bool is_crossed = findings.comparison.design == BlockDesign::Crossed;
    const GroupRows means = rows_of_groups(findings.groups, findings.blocks, covariates);
    const std::vector<std::vector<int>> blocks = members(means.blocks);
    const bool are_all_within =
        std::ranges::all_of(findings.comparison.pairs,
                            [&](const PairComparison& pair) { return is_within(findings, pair); });
    const Grouping about = is_crossed ? findings.blocks : one_group(findings.groups.size());
    for (std::size_t c = 0; c < arguments.covariates.size(); ++c) {
        const Eigen::VectorXd column = covariates.col(static_cast<Eigen::Index>(c));
        const auto first = arguments.covariates.begin();
        const auto own = first + static_cast<std::ptrdiff_t>(c);
        const std::string changes = join("--adjust-for ", *own, " changes nothing");
        if (std::find(first, own, *own) != own)
            session.warn(join(changes, " the second time: it is given already"));
        else if ((column.array() == column[0]).all())
            session.warn(join(changes, ": it is ", column[0], " in all meshes"));
        else if (is_crossed && std::ranges::all_of(blocks, [&](const std::vector<int>& block) {
                     return is_constant(means.covariates.col(static_cast<Eigen::Index>(c)), block);
                 }))
            session.warn(join(changes, are_all_within ? "" : " of what is compared within them",
                              ": it is the same in all meshes of each ", arguments.within,
                              ", whose own effect accounts for it"));
        else if (const auto others =
                     explaining(column, covariates.leftCols(static_cast<Eigen::Index>(c)), about);
                 !others.empty())
            session.warn(join(changes, " beside ", listed(arguments.covariates, others),
                              others.size() == 1 ? ", of which it is a multiple"
                                                 : ", of which it is a combination",
                              " but for a constant"));
    }
}

/// Of covariates whose slopes few blocks, or one mesh, determine.
void warn_of_slopes_of_few(const Session& session, const Arguments& arguments,
                           const Findings& findings, const Eigen::MatrixXd& covariates,
                           const std::vector<std::string>& meshes)
{
    const GroupFit fit(findings.groups, findings.blocks, covariates);
    const bool is_crossed = findings.comparison.design == BlockDesign::Crossed;
    const Eigen::MatrixXd shares = fit.slope_shares();
    const GroupRows& rows = fit.rows();
    Grouping carriers = rows.blocks;
    if (arguments.within.empty())
        carriers.names = meshes;
    for (std::size_t c = 0; c < arguments.covariates.size(); ++c) {
        const auto column = static_cast<Eigen::Index>(c);
        const std::string option = join("--adjust-for ", arguments.covariates[c]);
        auto doubt = is_crossed ? doubt_about_varying_blocks(rows.covariates.col(column),
                                                             rows.blocks, option, arguments.within)
                                : std::nullopt;
        if (!doubt)
            doubt = doubt_about_slope(
                rows.covariates.col(column), carriers,
                is_crossed ? Eigen::VectorXd(shares.col(column))
                           : shares_beyond_means(shares.col(column), rows.blocks, rows.groups),
                option, arguments.within);
        if (doubt)
            session.warn(join(*doubt, fit.has_slope_of_one_block()
                                          ? "; variances and spread are not determined"
                                          : ""));
    }
}

void report(const Session& session, const Arguments& arguments, const Findings& findings,
            Json figures)
{
    write_table(arguments.output, comparison_table(findings));
    figures["outputs"].push_back(arguments.output);
    figures["meshes"] = findings.groups.size();
    figures.update(space_figures(findings.shapes.space));
    figures["design"] = findings.comparison.design == BlockDesign::Crossed ? "crossed" : "nested";
    if (!arguments.within.empty())
        figures["left_out"] = findings.comparison.left_out;
    if (!arguments.covariates.empty())
        figures["adjusted_for"] = adjustment_figures(arguments, findings);
    figures["groups"] = group_figures(arguments, findings);
    figures["overall"] = test_figures(findings.comparison.overall);
    figures["spread"] = test_figures(findings.spread_test);
    figures["pairs"] = pair_figures(arguments, findings);
    session.message(summary(arguments, findings));
    session.print_figures(figures);
}

void compare_in_memory(const Session& session, const Arguments& arguments,
                       const std::vector<std::filesystem::path>& inputs)
{
    const Collection collection = read_labelled(session, arguments.input);
    const Setting setting = prepare(session, arguments, collection, inputs);
    const Grouping& groups = setting.groups;
    const auto covariates_at = [&](const Eigen::VectorXd& sizes) {
        return checked_covariates(arguments, collection, groups, setting.blocks, sizes);
    };
    Findings findings{
        groups,
        setting.blocks,
        members(groups),
        group_shapes(collection, groups, arguments.space, setting.blocks, covariates_at),
        {},
        {},
        {}};
    const Eigen::MatrixXd covariates = covariates_at(findings.shapes.sizes);
    const Eigen::MatrixXd products = std::move(findings.shapes.products);
    warn_of_alignment(session, findings.shapes.space);
    if (!setting.are_rows_told)
        warn_of_close_rows(session, collection, setting.rows, products);
    throw_if_stop_requested();
    const PermutationOptions permutations = permutation_options(session, arguments);
    findings.comparison =
        compare_groups(products, groups, setting.blocks, covariates, permutations);
    warn_of_idle_covariates(session, arguments, findings, covariates);
    warn_of_slopes_of_few(session, arguments, findings, covariates, collection.names);
    throw_if_stop_requested();
    findings.spread = group_spread(products, groups, setting.blocks, covariates,
                                   bootstrap_options(session, arguments));
    findings.spread_test = test_spread(products, groups, setting.blocks, covariates, permutations);
    throw_if_stop_requested();
    Json figures{{"outputs", Json::array()}};
    if (setting.means)
        figures = write_means(session, arguments, collection.topology, collection.points.front(),
                              findings, *setting.means);
    report(session, arguments, findings, std::move(figures));
}

void compare_in_passes(const Session& session, const Arguments& arguments,
                       const std::vector<std::filesystem::path>& inputs, const MeshStream& meshes)
{
    const Setting setting = prepare(session, arguments, meshes, inputs);
    const auto covariates_at = [&](const Eigen::VectorXd& sizes) {
        return checked_covariates(arguments, meshes, setting.groups, setting.blocks, sizes);
    };
    StreamedGroups found = compare_groups(meshes, setting.groups, setting.blocks,
                                          {.space = arguments.space,
                                           .permutations = permutation_options(session, arguments),
                                           .bootstrap = bootstrap_options(session, arguments),
                                           .covariates = covariates_at,
                                           .with_companions = setting.means != nullptr,
                                           .memory = arguments.memory.bytes,
                                           .progress = session.progress()});
    const Findings findings{setting.groups,
                            setting.blocks,
                            members(setting.groups),
                            std::move(found.shapes),
                            std::move(found.comparison),
                            std::move(found.spread),
                            found.spread_test};
    const Eigen::MatrixXd covariates = covariates_at(findings.shapes.sizes);
    warn_of_idle_covariates(session, arguments, findings, covariates);
    warn_of_slopes_of_few(session, arguments, findings, covariates, meshes.names);
    throw_if_stop_requested();
    Json figures{{"outputs", Json::array()}};
    if (setting.means)
        figures = write_means(session, arguments, meshes.topology, found.reference_points, findings,
                              *setting.means);
    figures["passes"] = found.passes;
    report(session, arguments, findings, std::move(figures));
}

void run(const Session& session, const Arguments& arguments)
{
    check_space_options(arguments.space);
    check_ending("-o", arguments.output, ".csv");
    const std::vector<std::filesystem::path> inputs = input_files(arguments.input.meshes);
    check_output(session, arguments.output, inputs);
    if (const auto meshes =
            open_for_passes(session, arguments.input, arguments.space, arguments.memory))
        compare_in_passes(session, arguments, inputs, *meshes);
    else
        compare_in_memory(session, arguments, inputs);
}

} // namespace

Run set_up_groups(CLI::App& command)
{
    command.description(
        "Compare groups of meshes: do their mean shapes differ, all at once and two at a time, by\n"
        "how much, and do their members spread equally far (distances from the mean of the group,\n"
        "Anderson 2006)? Labels are permuted to see what chance alone would do (Procrustes ANOVA,\n"
        "PERMANOVA). With --within, labels that differ inside a block (a subject in several\n"
        "states) are permuted inside it; if every block lies in one group (repeated scans of a\n"
        "subject), the means of the blocks are compared instead. Means, distances and spread are\n"
        "those of what is tested.");
    command.footer(
        "Example:\n"
        "  shape groups faces.h5 --by expression --within subject -o groups.csv --means means/");
    const auto arguments = std::make_shared<Arguments>();
    add_labelled_input(command, arguments->input);
    add_label(command, "--by", arguments->by, "Meshes with the same value of it are a group")
        ->required()
        ->option_text("LABEL REQUIRED");
    add_label(command, "--within", arguments->within,
              "Meshes with the same value of it are a block, such as all meshes of a subject");
    add_covariates(command, "--adjust-for", arguments->covariates,
                   "Compare the groups beyond what this label of numbers, or `size`, explains:\n"
                   "tests, means (at the mean of the label), distances, spread; may be repeated");
    add_output_file(command, arguments->output,
                    "CSV file to write. One row for all groups, one for each pair: first, second,\n"
                    "distance of the means and the radius of its 95 % confidence ball (if that is\n"
                    "larger, there may be no difference), sums of squares, share r_squared, F,\n"
                    "p_value, and p_adjusted for all pairs at once (Holm)");
    add_permutations(command, arguments->permutations);
    add_integer(command, "--bootstrap", arguments->replicates,
                "Replicates for the confidence intervals, [1, 1000000] (default: 1000); it takes\n"
                "39 at the least",
                1, 1000000);
    command
        .add_option("--means", arguments->means.path,
                    "Make the mean mesh of every group in this directory, named by its value")
        ->option_text("DIR");
    add_mesh_format(command, arguments->means);
    add_space_options(command, arguments->space);
    add_memory(command, arguments->memory);
    add_embedding_options(command, arguments->embedding);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
