// SPDX-License-Identifier: MIT
//
// multiscale_benchmark A B [--seeds N] [--repeat N] [--threads N] [--start incremental|identity]
//
// Interpolates two meshes half-way by Winkler 2010, for seeds 1 to N, and prints as JSON, per seed,
// times of set-up and pose [ms] and the errors of lengths and angles; and how well the inputs come
// back (largest distance over the bounding box's diagonal).

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/multiscale/multiscale_embedding.h"
#include "libshape/io/mesh_file.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace {

using namespace shape;

double cpu_ms()
{
    return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Quantiles of the values' sizes.
nlohmann::json quantiles(Eigen::ArrayXd values)
{
    values = values.abs();
    const double rms = std::sqrt(values.square().mean());
    std::sort(values.begin(), values.end());
    const auto quantile = [&](double q) {
        return values[static_cast<Eigen::Index>(q * static_cast<double>(values.size() - 1))];
    };
    return {{"rms", rms},
            {"q50", quantile(0.5)},
            {"q99", quantile(0.99)},
            {"q999", quantile(0.999)},
            {"max", quantile(1.0)}};
}

nlohmann::json run(const Topology& topology, const std::vector<Points>& meshes,
                   const MultiscaleOptions& options, int repeats)
{
    const auto own = [&](const Points& points) {
        return ShapePoint{edge_lengths(topology, points), dihedral_angles(topology, points)};
    };
    const ShapePoint a = own(meshes[0]);
    const ShapePoint b = own(meshes[1]);
    const ShapePoint target{(a.edge_lengths + b.edge_lengths) / 2.0,
                            (a.dihedral_angles + b.dihedral_angles) / 2.0};
    const double setup_start = cpu_ms();
    const MultiscaleEmbedder embedder(topology, meshes[0], options);
    const double pose_start = cpu_ms();
    std::vector<MultiscalePoseTimes> times;
    Points points;
    for (int i = 0; i < repeats; ++i) {
        MultiscaleEmbedding result = embedder.embed(target);
        times.push_back(result.times);
        points = std::move(result.points);
    }
    const double pose_end = cpu_ms();
    std::sort(times.begin(), times.end(),
              [](const auto& x, const auto& y) { return x.total < y.total; });
    const MultiscalePoseTimes& median = times[times.size() / 2];

    Eigen::ArrayXd drift = dihedral_angles(topology, points) - target.dihedral_angles;
    for (double& angle : drift)
        angle = wrapped_angle(angle) * 180.0 / std::numbers::pi;
    nlohmann::json ends;
    for (int k = 0; k < 2; ++k) {
        const Points& input = meshes[shape::internal::to_size(k)];
        const Points found = embedder.embed(k == 0 ? a : b).points;
        const Points moved = best_rigid_motion(found, input)(found);
        ends.push_back((moved - input).rowwise().norm().maxCoeff() / bounding_box_diagonal(input));
    }
    return {{"seed", options.seed},
            {"splitting_ms", 1e3 * embedder.setup_times().splitting},
            {"factorizing_ms", 1e3 * embedder.setup_times().factorising},
            {"setup_cpu_ms", pose_start - setup_start},
            {"interpolation_ms", 1e3 * median.interpolation},
            {"registration_ms", 1e3 * median.registration},
            {"blending_ms", 1e3 * median.blending},
            {"total_ms", 1e3 * median.total},
            {"fastest_total_ms", 1e3 * times.front().total},
            {"pose_cpu_ms", (pose_end - pose_start) / repeats},
            {"edge_rel_error",
             quantiles(edge_lengths(topology, points).array() / target.edge_lengths.array() - 1.0)},
            {"dihedral_dev_deg", quantiles(drift)},
            {"ends", ends}};
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app("Times and errors of the multi-scale embedding");
    std::vector<std::string> files;
    int seeds = 5;
    int repeats = 15;
    int threads = 1;
    std::string start = "incremental";
    app.add_option("meshes", files, "Two meshes in correspondence")->required()->expected(2);
    app.add_option("--seeds", seeds, "Seeds 1 to N")->check(CLI::PositiveNumber);
    app.add_option("--repeat", repeats, "Poses per seed")->check(CLI::PositiveNumber);
    app.add_option("--threads", threads, "Threads");
    app.add_option("--start", start, "Start of the registration")
        ->check(CLI::IsMember({"incremental", "identity"}));
    CLI11_PARSE(app, argc, argv);
    try {
        set_thread_count(threads);
        std::vector<Points> meshes;
        Faces faces;
        for (const std::string& file : files) {
            NamedMesh mesh = read_mesh(file);
            faces = mesh.faces;
            meshes.push_back(std::move(mesh.points));
        }
        const Topology topology(faces, static_cast<int>(meshes.front().rows()));
        nlohmann::json report{{"vertices", topology.vertex_count()},
                              {"faces", topology.face_count()},
                              {"threads", threads},
                              {"start", start}};
        for (int seed = 1; seed <= seeds; ++seed) {
            MultiscaleOptions options{.seed = static_cast<std::uint64_t>(seed)};
            if (start == "identity")
                options.registration.start = RegistrationStart::Identity;
            report["runs"].push_back(run(topology, meshes, options, repeats));
        }
        std::cout << report.dump(1) << '\n';
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
}
