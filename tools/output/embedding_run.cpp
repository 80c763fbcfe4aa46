// SPDX-License-Identifier: MIT

#include "tools/output/embedding_run.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/residual_field.h"
#include "libshape/embedding/resized.h"
#include "libshape/embedding/sequence_jumps.h"
#include "libshape/io/vertex_scalars.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;
namespace {

Json times_of(const MultiscaleTimes& times)
{
    return {{"splitting", times.setup.splitting},        {"factorising", times.setup.factorising},
            {"interpolation", times.pose.interpolation}, {"registration", times.pose.registration},
            {"blending", times.pose.blending},           {"pose", times.pose.total}};
}

Json or_null(const std::optional<int>& count)
{
    return count ? Json(*count) : Json();
}

Json figures_of(const std::string& mesh, const std::string& method, const Embedding& embedding)
{
    const EmbeddingReport& report = embedding.report;
    Json figures{
        {"name", mesh},
        {"method", embedding.instead ? tools::name(*embedding.instead) : method.c_str()},
        {"vertices", embedding.points.rows()},
        {"status", name(report.status)},
        {"edge_rms", report.edge_rms},
        {"edge_max", report.edge_max},
        {"edge_p999", report.edge_p999},
        {"edge_p99", report.edge_p99},
        {"dihedral_rms_deg", report.dihedral_rms_deg},
        {"dihedral_p99_deg", report.dihedral_p99_deg},
        {"dihedral_max_deg", report.dihedral_max_deg},
        {"inverted_faces", report.inverted_faces},
        {"self_intersections", or_null(report.self_intersections)},
        {"new_self_intersections", or_null(report.new_self_intersections)},
        {"companion_rms", std::isnan(report.companion_rms) ? Json() : Json(report.companion_rms)},
        {"closure_energy", report.closure_energy},
        {"iterations", report.iterations},
        {"converged", report.converged},
        {"seconds", report.seconds},
        {"setup_seconds", report.setup_seconds}};
    if (report.avoidable_self_intersections)
        figures["avoidable_self_intersections"] = *report.avoidable_self_intersections;
    if (embedding.multiscale)
        figures["multiscale_seconds"] = times_of(*embedding.multiscale);
    return figures;
}

template <class... Values>
std::string print_row(const char* format, Values... values)
{
    char row[256];
    std::snprintf(row, sizeof row, format, values...);
    return row;
}

std::string table_head()
{
    return print_row("%-24s %-12s %10s %10s %12s %9s", "mesh", "status", "edge RMS", "edge max",
                     "dihedral RMS", "time");
}

std::string table_row(const Json& figures)
{
    const auto number = [&](const char* field) { return figures.at(field).get<double>(); };
    const auto text = [&](const char* field) { return figures.at(field).get<std::string>(); };
    return print_row("%-24s %-12s %9.4f%% %9.4f%% %8.3f deg %7.3f s", text("name").c_str(),
                     text("status").c_str(), 100.0 * number("edge_rms"), 100.0 * number("edge_max"),
                     number("dihedral_rms_deg"), number("seconds"));
}

void refuse_infeasible(const Topology& topology, const std::vector<EmbeddingTarget>& targets)
{
    for (const EmbeddingTarget& target : targets) {
        const DecodedShape shape = target.shape();
        const ShapePoint* point = std::get_if<ShapePoint>(&shape);
        if (point == nullptr)
            continue;
        const Admissibility found = check_admissibility(topology, point->edge_lengths);
        if (!found.admissible())
            throw NumericalError(join(target.name, ": infeasible target, ",
                                      describe(found, topology, point->edge_lengths),
                                      " (--strict)"));
    }
}

/// The targets of a run that no mesh can have; said in one line, however many they are.
class InfeasibleTargets
{
public:
    explicit InfeasibleTargets(const Topology& topology) : topology_(topology) {}

    void add(const std::string& name, const DecodedShape& target, FinishedMesh& mesh)
    {
        if (mesh.reason.empty())
            return;
        mesh.figures["reason"] = mesh.reason;
        reasons_.push_back(join(name, ": infeasible target, ", mesh.reason));
        if (const ShapePoint* point = std::get_if<ShapePoint>(&target))
            most_faces_ = std::max(
                most_faces_, check_admissibility(topology_, point->edge_lengths).triangles.size());
        const double error = mesh.figures.at("edge_rms").get<double>();
        if (worst_.empty() || error > worst_rms_) {
            worst_ = name;
            worst_rms_ = error;
        }
        worst_edge_ = std::max(worst_edge_, mesh.figures.at("edge_max").get<double>());
    }

    void warn(const Session& session, std::size_t meshes, bool verbose) const
    {
        if (reasons_.empty())
            return;
        if (reasons_.size() == 1 || verbose)
            for (const std::string& reason : reasons_)
                session.warn(reason + "; the nearest mesh is written" +
                             (reasons_.size() == 1 ? "; " + severity() : ""));
        if (reasons_.size() > 1)
            session.warn(
                join(reasons_.size(), " of ", meshes,
                     " targets are infeasible (no mesh has their lengths; usual in samples "
                     "and beyond about one standard deviation); the nearest meshes are "
                     "written. At most ",
                     most_faces_, " of ", counted(topology_.face_count(), "face"),
                     " break a triangle inequality; ", severity(), " (worst: ", worst_, "). ",
                     verbose ? "" : "--verbose lists them, ", "--strict refuses them"));
    }

private:
    static std::string percent(double share)
    {
        return print_row(share < 0.995 ? "%.2g %%" : "%.0f %%", 100.0 * share);
    }

    [[nodiscard]] std::string severity() const
    {
        const char* const shows = worst_rms_ < 1e-3   ? "which does not show"
                                  : worst_rms_ < 1e-2 ? "which hardly shows"
                                  : worst_rms_ < 5e-2 ? "which shows in places"
                                                      : "another shape than was asked for: the "
                                                        "target lies far outside the data";
        // Over different lengths: of long edges that are missed by much the first may be larger than the second.
        return join("edge errors: RMS ", percent(worst_rms_), " of the mean length, largest ",
                    percent(worst_edge_), " of the edge's own, ", shows);
    }

    const Topology& topology_;
    std::vector<std::string> reasons_;
    std::size_t most_faces_ = 0;
    std::string worst_;
    double worst_rms_ = 0.0;
    double worst_edge_ = 0.0;
};

/// Says what became of faces that cross in no input; nothing if nobody asked.
void tell_contacts(const Session& session, const Json& embeddings)
{
    std::size_t had = 0, have = 0;
    int most = 0;
    std::string worst;
    for (const Json& figures : embeddings) {
        if (!figures.contains("avoidable_self_intersections"))
            return;
        had += figures.at("avoidable_self_intersections").get<int>() > 0 ? 1 : 0;
        const int left = figures.at("new_self_intersections").get<int>();
        have += left > 0 ? 1 : 0;
        if (left > most) {
            most = left;
            worst =
                join(figures.at("name").get<std::string>(), ": ", counted(to_size(left), "pair"),
                     " of ", figures.at("avoidable_self_intersections").get<int>());
        }
    }
    if (have > 0)
        session.warn(join("contact: in ", have, " of ",
                          counted(embeddings.size(), "mesh", "meshes"),
                          " faces still cross that cross in no input (worst: ", worst,
                          "); no small bend was found that moves them apart"));
    if (had > 0)
        session.message(join("contact: faces that cross in no input were moved apart in ",
                             had - have, " of ", counted(had, "mesh", "meshes"), " that had some"));
}

void write_residuals(const MeshOutput& output, const std::filesystem::path& path,
                     const Topology& topology, const Points& points, const DecodedShape& target)
{
    const ShapePoint* const point = std::get_if<ShapePoint>(&target);
    const ResidualField field = residual_field(
        topology, points,
        point ? *point
              : ShapePoint{edge_lengths(topology, points), dihedral_angles(topology, points)});
    output.write_scalars(
        path, points, topology.faces(),
        {{"edge_error", field.edge_error}, {"dihedral_drift", field.dihedral_drift}});
}

/// Warns of jumps; returns them as figures.
Json jump_figures(const Session& session, const std::vector<EmbeddingTarget>& targets,
                  const std::vector<SequenceStep>& steps)
{
    Json jumps = Json::array();
    for (const SequenceJump& jump : find_jumps(steps)) {
        const std::string& from = targets[jump.from].name;
        const std::string& to = targets[jump.from + 1].name;
        session.warn(join("the sequence jumps from ", from, " to ", to, ", ",
                          print_row("%.1f", jump.ratio), " times as far as nearby"));
        jumps.push_back({{"from", from}, {"to", to}, {"ratio", jump.ratio}});
    }
    return jumps;
}

Json animation_figures(const Session& session, const GlbAnimation& animation, std::size_t frames)
{
    session.message(
        print_row("animation: %zu of %zu frames kept, %.2f s; the others within %.2g of"
                  " the bounding box diagonal",
                  animation.keyframes.size(), frames, animation.seconds, animation.error));
    return {{"frames", frames},
            {"keyframes", animation.keyframes},
            {"error", animation.error},
            {"seconds", animation.seconds}};
}

} // namespace

void add_embedder_options(CLI::App& command, EmbeddingOptions& options, double smoothness)
{
    add_choice(command, "--method", options.method,
               "dihedral: lengths and dihedral angles together (default); closure: as in Rojas\n"
               "2014, section 2; multiscale: as in Winkler 2010, section 3. Where a target breaks\n"
               "a triangle inequality, these two cannot start, and dihedral makes the nearest mesh",
               {{"dihedral", EmbeddingMethod::Dihedral},
                {"closure", EmbeddingMethod::Closure},
                {"multiscale", EmbeddingMethod::Multiscale}})
        ->group("Embedding");
    add_choice(command, "--quality", options.quality,
               "Effort of the method dihedral: preview takes a few steps, fine (default) runs to\n"
               "convergence",
               {{"preview", EmbeddingQuality::Preview}, {"fine", EmbeddingQuality::Fine}})
        ->group("Embedding");
    add_number(command, "--smoothness", options.smoothness,
               join("Weight of the dihedral angles [rad] against the relative lengths, > 0\n"
                    "(default: ",
                    smoothness, "); of the method dihedral"),
               Sign::Positive)
        ->group("Embedding");
    add_number(
        command, "--anchor", options.anchor,
        join(
            "How firmly a mesh is held near its companion, the mesh that the blended turns of\n"
            "patches lead to, so that it does not bend a little everywhere; less where lengths\n"
            "and angles resist; >= 0, 0: not at all; along paths whose frames agree with each\n"
            "other at most 0.01 (default: ",
            default_anchor,
            ").\nOf models with positions: how firmly near these, up to a hundred times as firmly\n"
            "where lengths and angles hardly resist (default: ",
            default_position_anchor, ").\nOf the method dihedral"))
        ->check([](const std::string& text) {
            return std::strtod(text.c_str(), nullptr) < 0.0 ? text + " must be >= 0" : "";
        })
        ->group("Embedding");
    add_choice(
        command, "--init", options.registration_start,
        "Where the method multiscale starts to register patches: incremental, each from the\n"
        "best fit to those before it (default); identity, as in the paper",
        {{"incremental", RegistrationStart::Incremental},
         {"identity", RegistrationStart::Identity}})
        ->group("Embedding");
    command
        .add_flag(
            "--avoid-contact", options.avoid_contact,
            "Bend meshes a little where faces cross that cross in no input, until they no longer\n"
            "do; says where some still cross. What inputs have of this stays")
        ->group("Embedding");
}

void add_embedding_options(CLI::App& command, EmbeddingArguments& arguments, double smoothness)
{
    add_embedder_options(command, arguments.options, smoothness);
    command
        .add_flag("--strict", arguments.strict,
                  "An infeasible target ends the run with exit code 4 before anything is\n"
                  "written (default: the nearest mesh is written, with a warning)")
        ->group("Embedding");
    command
        .add_flag("--verbose", arguments.verbose,
                  "Say of every infeasible target what is wrong with it (default: one line on all\n"
                  "of them; --json has the reasons)")
        ->group("Embedding");
    command
        .add_flag(
            "--residuals", arguments.residuals,
            "Write residuals/NAME_residuals.ply (.vtk, .vtp) beside each mesh: with the values\n"
            "edge_error (largest relative error of the edges at a vertex) and\n"
            "dihedral_drift (largest of their angles [deg]); `shape draw --color-by` shows\n"
            "them")
        ->group("Embedding");
}

Json embed_and_write(const Session& session, const EmbeddingArguments& arguments,
                     const Topology& topology, std::vector<Points> references,
                     const std::vector<EmbeddingTarget>& targets, MeshOutput& output,
                     TargetOrder order, std::optional<FramePath> along)
{
    const EmbeddingOptions options = embedding_options(session, arguments.options);
    prepare_output(arguments, topology, targets, output);
    const auto made = [&](std::size_t i, const char* method, const DecodedShape& shape,
                          const auto& embed) {
        return finish(targets[i].name, method,
                      [&] { return resized(embed(), topology, shape, targets[i].resized); });
    };
    if (along) {
        const FrameEmbedder frames(topology, references, options, std::move(along),
                                   session.progress());
        const auto make = [&](std::size_t i, const DecodedShape& shape) {
            return made(i, name(options.method), shape, [&] {
                return frames.embed(targets[i].frame, std::get<ShapePoint>(shape));
            });
        };
        return make_and_write(session, arguments, topology, targets, make, output, order);
    }
    const Embedder embedder(topology, std::move(references), options);
    const auto make = [&](std::size_t i, const DecodedShape& shape) {
        const char* const method =
            std::holds_alternative<Points>(shape) ? "procrustes" : name(options.method);
        return made(i, method, shape, [&] { return embedder.embed(shape); });
    };
    return make_and_write(session, arguments, topology, targets, make, output, order);
}

void prepare_output(const EmbeddingArguments& arguments, const Topology& topology,
                    const std::vector<EmbeddingTarget>& targets, MeshOutput& output)
{
    if (arguments.residuals)
        output.add_companions("residuals", "_residuals" + output.scalar_ending());
    if (arguments.strict)
        refuse_infeasible(topology, targets);
}

Json make_and_write(const Session& session, const EmbeddingArguments& arguments,
                    const Topology& topology, const std::vector<EmbeddingTarget>& targets,
                    const MeshMaker& make, MeshOutput& output, TargetOrder order)
{
    const Progress progress = session.progress();
    Json embeddings = Json::array();
    std::vector<std::string> rows{table_head()};
    std::vector<SequenceStep> steps;
    InfeasibleTargets infeasible(topology);
    Points previous;
    for (std::size_t i = 0; i < targets.size(); ++i) {
        progress("embedding", i, targets.size());
        const DecodedShape shape = targets[i].shape();
        FinishedMesh mesh = make(i, shape);
        if (targets[i].place)
            mesh.points = best_rigid_motion(mesh.points, *targets[i].place)(mesh.points);
        infeasible.add(targets[i].name, shape, mesh);
        output.write(i, mesh.points, topology.faces());
        if (arguments.residuals)
            write_residuals(output, output.staged_companion(i), topology, mesh.points,
                            resized(shape, targets[i].resized));
        if (order == TargetOrder::Sequence && i > 0)
            steps.push_back(measure_step(topology, previous, mesh.points));
        rows.push_back(table_row(mesh.figures));
        embeddings.push_back(std::move(mesh.figures));
        previous = std::move(mesh.points);
    }
    progress("embedding", targets.size(), targets.size());
    output.commit();
    infeasible.warn(session, targets.size(), arguments.verbose);
    tell_contacts(session, embeddings);
    for (const std::string& row : rows)
        session.message(row);
    Json result{{"outputs", output.paths()}, {"embeddings", embeddings}};
    if (order == TargetOrder::Sequence)
        result["jumps"] = jump_figures(session, targets, steps);
    if (output.animation())
        result["animation"] = animation_figures(session, *output.animation(), targets.size());
    return result;
}

FinishedMesh finish(const std::string& target, const std::string& method,
                    const std::function<Embedding()>& embed)
{
    try {
        Embedding embedding = embed();
        Json figures = figures_of(target, method, embedding);
        return {std::move(embedding.points), std::move(figures),
                std::move(embedding.report.reason)};
    } catch (const InvalidInput& error) {
        throw InvalidInput(join(target, ": ", error.what()));
    } catch (const NumericalError& error) {
        throw NumericalError(join(target, ": ", error.what()));
    }
}

void warn_if_infeasible(const Session& session, const std::string& target, const FinishedMesh& mesh)
{
    if (!mesh.reason.empty())
        session.warn(
            join(target, ": infeasible target, ", mesh.reason, "; the nearest mesh is written"));
}

const char* name(EmbeddingMethod method)
{
    switch (method) {
        case EmbeddingMethod::Dihedral:
            return "dihedral";
        case EmbeddingMethod::Closure:
            return "closure";
        case EmbeddingMethod::Multiscale:
            return "multiscale";
    }
    return "";
}

void check_methods(const EmbeddingOptions& given, const std::vector<EmbeddingMethod>& used)
{
    const auto belongs_to = [&](EmbeddingMethod method, const char* option, bool is_given) {
        if (is_given && std::find(used.begin(), used.end(), method) == used.end())
            throw UsageError(join(option, " is an option of --method ", name(method),
                                  ", not of --method ", name(given.method)));
    };
    belongs_to(EmbeddingMethod::Dihedral, "--quality", given.quality.has_value());
    belongs_to(EmbeddingMethod::Dihedral, "--smoothness", given.smoothness.has_value());
    belongs_to(EmbeddingMethod::Dihedral, "--anchor", given.anchor.has_value());
    belongs_to(EmbeddingMethod::Multiscale, "--init", given.registration_start.has_value());
}

EmbeddingOptions options_of(const Session& session, EmbeddingMethod method,
                            const EmbeddingOptions& given)
{
    EmbeddingOptions options{.method = method, .avoid_contact = given.avoid_contact};
    if (method == EmbeddingMethod::Dihedral) {
        options.quality = given.quality;
        options.smoothness = given.smoothness;
        options.anchor = given.anchor;
    }
    if (method == EmbeddingMethod::Multiscale) {
        options.registration_start = given.registration_start;
        options.seed = static_cast<std::uint64_t>(session.seed);
    }
    return options;
}

EmbeddingOptions embedding_options(const Session& session, const EmbeddingOptions& given)
{
    check_methods(given, {given.method});
    return options_of(session, given.method, given);
}

std::string numbered_name(const std::string& stem, std::size_t number)
{
    return print_row("%s_%04zu", stem.c_str(), number);
}

std::vector<std::string> names(const std::vector<EmbeddingTarget>& targets)
{
    std::vector<std::string> result;
    for (const EmbeddingTarget& target : targets)
        result.push_back(target.name);
    return result;
}

} // namespace shape::tools
