// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/conformal/conformal_morph.h"
#include "libshape/embedding/path/path_follower.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"
#include "tools/commands.h"
#include "tools/input/mesh_input.h"
#include "tools/output/embedding_run.h"
#include "tools/output/mesh_output.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    MeshInput mesh;
    MeshOutputArguments output;
    std::int64_t steps = 0; ///< 0: the sphere alone.
    std::string factors;
    bool end_gap = false;
    EmbeddingArguments embedding;
};

/// The lengths are the conformal map itself; the angles only choose between meshes.
constexpr double morph_smoothness = 1e-3;

/// Columns vertex, u: one row a vertex, in their order.
Table factor_table(const Eigen::VectorXd& factors)
{
    Table table{{"vertex", "u"}, {}};
    for (Eigen::Index v = 0; v < factors.size(); ++v)
        table.rows.push_back({join(v), print_number(factors[v])});
    return table;
}

/// Columns mesh, u0, u1, ...: one row a mesh, for statistics.
Table factor_table(const std::vector<std::string>& meshes, const std::vector<SphereMap>& maps)
{
    Table table{{"mesh"}, {}};
    for (Eigen::Index v = 0; v < maps.front().factors.size(); ++v)
        table.columns.push_back(join("u", v));
    for (std::size_t i = 0; i < maps.size(); ++i) {
        std::vector<std::string>& row = table.rows.emplace_back();
        row.push_back(meshes[i]);
        for (const double u : maps[i].factors)
            row.push_back(print_number(u));
    }
    return table;
}

Json certificate_figures(const Topology& topology, const SphereMap& map)
{
    const auto flipped = map.edges.flipped.size();
    return {{"certificate", name(map.certificate)},
            {"flipped_edges", flipped},
            {"kept_share",
             1.0 - static_cast<double>(flipped) / static_cast<double>(topology.edge_count())},
            {"reversed_faces", map.reversed_faces.size()},
            {"residual", map.edges.worst},
            {"angle_residual", map.angle_residual},
            {"balance_residual", map.balance_residual},
            {"newton_steps", map.newton_steps},
            {"repair_rounds", map.repair_rounds},
            {"radius", map.radius},
            {"factor_min", map.factors.minCoeff()},
            {"factor_max", map.factors.maxCoeff()}};
}

/// The sphere, placed where the mesh is and turned towards it.
Points placed_sphere(const SphereMap& map, const Points& mesh)
{
    const Points sphere = map.radius * map.sphere.points;
    return best_rigid_motion(sphere, mesh)(sphere);
}

void tell(const Session& session, const std::string& mesh, const SphereMap& map)
{
    session.message(join(mesh, ": certificate: ", name(map.certificate), ", ",
                         counted(map.edges.flipped.size(), "edge"), " flipped, ",
                         counted(map.reversed_faces.size(), "face"),
                         " reversed; residual of eq. (13) ", map.edges.worst));
}

/// Makes the frames of the morph: the mesh, meshes that follow from it, and the sphere.
class MorphMaker
{
public:
    MorphMaker(const Topology& topology, const Points& points, const Points& sphere,
               const ConformalMorph& morph, double smoothness)
        : topology_(topology),
          sphere_(sphere),
          morph_(morph),
          follower_(topology, points,
                    [&morph](double s) {
                        return morph_frame(morph, morph_parameter(s)).point.edge_lengths;
                    },
                    morph.dihedral_angles.row(1).transpose(), {.smoothness = smoothness})
    {
    }

    [[nodiscard]] Embedding embed(double k)
    {
        const auto start = std::chrono::steady_clock::now();
        const PathMesh made = k < 1.0
                                  ? follower_.at(inverse_morph_parameter(k))
                                  : PathMesh{morph_frame(morph_, k).point, {sphere_, 0.0, 0, true}};
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        Embedding embedding{made.mesh.points,
                            measure_embedding(topology_, made.mesh.points, made.target)};
        embedding.report.iterations = made.mesh.iterations;
        embedding.report.converged = made.mesh.converged;
        embedding.report.seconds = seconds.count();
        return embedding;
    }

    /// Largest distance of a vertex between the last mesh that followed and the sphere.
    [[nodiscard]] double gap()
    {
        const Points last = follower_.at(1.0).mesh.points;
        return (best_rigid_motion(last, sphere_)(last) - sphere_).rowwise().norm().maxCoeff();
    }

private:
    const Topology& topology_;
    const Points& sphere_;
    const ConformalMorph& morph_;
    PathFollower follower_;
};

/// Embeds and writes the frames of the morph; returns their figures.
Json write_morph(const Session& session, const Arguments& arguments, const Topology& topology,
                 const Points& points, const SphereMap& map)
{
    const ConformalMorph morph = make_conformal_morph(topology, points, map);
    const auto parameter = [&](std::size_t i) {
        return static_cast<double>(i) / static_cast<double>(arguments.steps - 1);
    };
    std::vector<EmbeddingTarget> targets;
    Json frames = Json::array();
    for (std::size_t i = 0; i < to_size(arguments.steps); ++i) {
        const double k = parameter(i);
        const MorphFrame frame = morph_frame(morph, k);
        const std::string frame_name = numbered_name("frame", i);
        if (!frame.corrected_faces.empty())
            session.warn(join(frame_name, ": the factors break ",
                              counted(frame.corrected_faces.size(), "face"), ", first face ",
                              frame.corrected_faces.front(), "; edges changed by up to ",
                              100.0 * frame.largest_correction, " %"));
        frames.push_back({{"name", frame_name},
                          {"k", k},
                          {"corrected_faces", frame.corrected_faces.size()},
                          {"largest_correction", frame.largest_correction}});
        targets.push_back({frame_name, [&morph, k] { return morph_frame(morph, k).point; }});
    }
    MeshOutput output(session, arguments.output, names(targets), input_files(arguments.mesh));
    const Points sphere = placed_sphere(map, points);
    EmbeddingArguments embedding = arguments.embedding;
    const EmbeddingOptions& options = embedding.options;
    check_methods(options, {options.method});
    if (options.method == EmbeddingMethod::Dihedral)
        embedding.options.smoothness = options.smoothness.value_or(morph_smoothness);
    Json figures;
    if (options.method == EmbeddingMethod::Dihedral &&
        options.quality != EmbeddingQuality::Preview) {
        prepare_output(embedding, topology, targets, output);
        MorphMaker maker(topology, points, sphere, morph, *options.smoothness);
        const auto make = [&](std::size_t i, const auto&) {
            return finish(targets[i].name, name(options.method),
                          [&] { return maker.embed(parameter(i)); });
        };
        figures = make_and_write(session, embedding, topology, targets, make, output,
                                 TargetOrder::Sequence);
        if (arguments.end_gap) {
            figures["end_gap"] = maker.gap() / map.radius;
            session.message(join("the path from the mesh ends within ",
                                 100.0 * figures["end_gap"].get<double>(),
                                 " % of the radius from the sphere"));
        }
    } else {
        if (arguments.end_gap)
            throw UsageError(
                "--end-gap: only --method dihedral with --quality fine follows a path");
        figures = embed_and_write(session, embedding, topology, {points, sphere}, targets, output,
                                  TargetOrder::Sequence);
    }
    figures["frames"] = frames;
    return figures;
}

/// Writes one sphere a mesh.
Json write_spheres(const Session& session, const Arguments& arguments, const Collection& collection,
                   const std::vector<SphereMap>& maps)
{
    const std::vector<std::string> names =
        maps.size() == 1 ? std::vector<std::string>{"sphere"} : collection.names;
    MeshOutput output(session, arguments.output, names, input_files(arguments.mesh));
    for (std::size_t i = 0; i < maps.size(); ++i)
        output.write(i, placed_sphere(maps[i], collection.points[i]), collection.topology.faces());
    output.commit();
    return {{"outputs", output.paths()}};
}

SphereMap map_mesh(const Topology& topology, const Points& points, const std::string& mesh)
{
    if (const std::string reason = why_not_spherical(topology); !reason.empty())
        throw InvalidInput(join(mesh, ": ", reason));
    SphereMap map = map_to_sphere(topology, edge_lengths(topology, points));
    if (map.certificate == ConformalCertificate::Unsolved)
        throw NumericalError(join(mesh, ": no conformal map was found: residual of eq. (13) ",
                                  map.edges.worst, ", of angle sums ", map.angle_residual,
                                  "; remesh the worst triangles"));
    return map;
}

void run(const Session& session, const Arguments& arguments)
{
    const Collection collection = read_meshes(session, arguments.mesh);
    const std::size_t count = collection.size();
    if (count > 1 && arguments.steps > 0)
        throw InvalidInput(join("--steps: a morph is made of one mesh, not ", count));
    if (arguments.embedding.residuals && arguments.steps == 0)
        throw UsageError("--residuals needs --steps: the sphere alone is not embedded");
    if (arguments.end_gap && arguments.steps == 0)
        throw UsageError("--end-gap needs --steps: without a morph there is no path");
    if (!arguments.factors.empty())
        check_output(session, arguments.factors, input_files(arguments.mesh));
    const Topology& topology = collection.topology;
    const Progress progress = session.progress();
    std::vector<SphereMap> maps;
    for (std::size_t i = 0; i < count; ++i) {
        progress("mapping", i, count);
        maps.push_back(map_mesh(topology, collection.points[i], collection.names[i]));
        tell(session, collection.names[i], maps.back());
    }
    progress("mapping", count, count);
    Json figures = arguments.steps > 0 ? write_morph(session, arguments, topology,
                                                     collection.points.front(), maps.front())
                                       : write_spheres(session, arguments, collection, maps);
    if (!arguments.factors.empty()) {
        write_table(arguments.factors, count == 1 ? factor_table(maps.front().factors)
                                                  : factor_table(collection.names, maps));
        figures["outputs"].push_back(arguments.factors);
    }
    Json certificates = Json::array();
    for (std::size_t i = 0; i < count; ++i) {
        certificates.push_back(certificate_figures(topology, maps[i]));
        certificates.back()["name"] = collection.names[i];
    }
    figures["conformal"] = count == 1 ? certificates.front() : certificates;
    session.print_figures(figures);
}

} // namespace

Run set_up_conformal(CLI::App& command)
{
    command.description(
        "Map a closed mesh of genus 0 conformally to the sphere of the same area: on every edge,\n"
        "the new length is exp((u_i + u_j) / 2) times the old one (Rojas 2014, section 5). Writes\n"
        "the sphere, or with --steps the morph from the mesh (k = 0) to the sphere (k = 1), whose\n"
        "lengths follow from the factors k u (frame_0000.ply, ...). Of several meshes in\n"
        "correspondence, it writes one sphere each.");
    command.footer(
        "Examples:\n"
        "  shape conformal head.ply -o sphere.ply --factors u.csv\n"
        "  shape conformal head.ply -o morph/ --steps 5\n"
        "  shape conformal heads/ -o spheres/ --factors u.csv");
    const auto arguments = std::make_shared<Arguments>();
    add_mesh_input(command, arguments->mesh);
    add_mesh_output(command, arguments->output);
    add_animation_options(command, arguments->output);
    add_integer(command, "--steps", arguments->steps,
                "N frames of the morph, equally spaced, both ends included, [2, 1000000]", 2,
                1'000'000);
    command
        .add_option(
            "--factors", arguments->factors,
            "CSV file for the log factors: columns vertex,u; of several meshes mesh,u0,u1,...,\n"
            "one row a mesh")
        ->option_text("FILE");
    command.add_flag(
        "--end-gap", arguments->end_gap,
        "With --steps: walk the path of the morph to its end and report how far from the\n"
        "sphere it arrives. Takes most of the time where the last frame asked for is early.");
    add_embedding_options(command, arguments->embedding, morph_smoothness);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
