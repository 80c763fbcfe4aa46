// SPDX-License-Identifier: MIT
//
// embedding_benchmark A B [--methods fine,preview,...] [--repeat N] [--frames N] [--threads N]
//                         [--smoothness MU] [--anchor NU] [--measure MESH] [--truth MESH]
//
// Embeds the half-way blend of two meshes, or N blends along the way, and prints per method, as JSON,
// what set-up and a mesh cost and how far the meshes are from what was wanted; and what one
// back-substitution with the factor of the scalar vertex Laplacian costs on the same machine. MESH
// is another program's half-way blend, measured alike. The truth is a mesh that should lie half-way: how far
// meshes are from it, root mean square after rigid alignment, over the diagonal of its bounding box.

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "libshape/base/threads.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/embedder.h"
#include "libshape/io/mesh_file.h"
#include "libshape/linalg/sparse_cholesky.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/collection.h"
#include "libshape/mesh/dihedral_angles.h"

namespace {

using namespace shape;
using namespace shape::internal;
using Eigen::Vector3d;
using Eigen::VectorXd;

double milliseconds(const std::function<void()>& work)
{
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

/// Median of one solve for three right-hand sides, in double precision, with the factor of the
/// graph Laplacian held at vertex 0.
double back_substitution_ms(const Topology& topology, const Points& rhs)
{
    std::vector<Eigen::Triplet<double>> entries{{0, 0, 1.0}};
    for (int e = 0; e < topology.edge_count(); ++e) {
        const int a = topology.edges()(e, 0);
        const int b = topology.edges()(e, 1);
        entries.insert(entries.end(),
                       {{a, a, 1.0}, {b, b, 1.0}, {std::max(a, b), std::min(a, b), -1.0}});
    }
    SparseMatrix laplacian(topology.vertex_count(), topology.vertex_count());
    laplacian.setFromTriplets(entries.begin(), entries.end());
    const SparseCholesky factor(laplacian);
    std::vector<double> times;
    for (int i = 0; i < 9; ++i)
        times.push_back(milliseconds([&] { (void)factor.solve(rhs); }));
    return median(times);
}

/// Per face of a mesh, whether it is folded onto a neighbour: an edge bends by more than 150 degrees; or has no
/// area: a height below a thousandth of its longest edge.
std::vector<bool> bad_faces(const Topology& topology, const Points& points)
{
    std::vector<bool> bad;
    const VectorXd angles = dihedral_angles(topology, points);
    for (int f = 0; f < topology.face_count(); ++f) {
        const auto corner = [&](int c) { return Vector3d(points.row(topology.faces()(f, c))); };
        const Vector3d u = corner(1) - corner(0);
        const Vector3d v = corner(2) - corner(0);
        const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (u - v).squaredNorm()});
        double sharpest = 0.0;
        for (int c = 0; c < 3; ++c)
            sharpest = std::max(sharpest, std::abs(angles[topology.face_edges()(f, c)]));
        bad.push_back(u.cross(v).norm() < 1e-3 * longest ||
                      sharpest > 150.0 * std::numbers::pi / 180.0);
    }
    return bad;
}

const std::map<std::string, EmbeddingOptions> methods{
    {"fine", {}},
    {"preview", {.quality = EmbeddingQuality::Preview}},
    {"multiscale", {.method = EmbeddingMethod::Multiscale}},
    {"closure", {.method = EmbeddingMethod::Closure}}};

class Benchmark
{
public:
    Benchmark(const std::string& a, const std::string& b, Points truth)
        : meshes_(collect({read_mesh(a), read_mesh(b)})),
          vectors_(shape_vectors(meshes_, Scale::None)),
          bad_(bad_faces(meshes_.topology, meshes_.points[0])),
          truth_(std::move(truth))
    {
        const std::vector<bool> bad = bad_faces(meshes_.topology, meshes_.points[1]);
        std::transform(bad_.begin(), bad_.end(), bad.begin(), bad_.begin(), std::logical_or<>());
    }

    /// Errors of a half-way blend.
    nlohmann::json measure(const Points& points) const
    {
        const EmbeddingReport report = measure_embedding(meshes_.topology, points, between(0.5));
        const std::vector<bool> bad = bad_faces(meshes_.topology, points);
        int new_bad = 0;
        for (std::size_t f = 0; f < bad.size(); ++f)
            new_bad += bad[f] && !bad_[f];
        nlohmann::json figures{{"status", name(report.status)},
                               {"edge_rms", report.edge_rms},
                               {"edge_max", report.edge_max},
                               {"dihedral_rms_deg", report.dihedral_rms_deg},
                               {"bad_faces", new_bad}};
        if (truth_.rows() > 0) {
            const Points aligned = best_rigid_motion(points, truth_)(points);
            figures["distance"] =
                std::sqrt((aligned - truth_).rowwise().squaredNorm().mean()) /
                (truth_.colwise().maxCoeff() - truth_.colwise().minCoeff()).norm();
        }
        return figures;
    }

    nlohmann::json run(const EmbeddingOptions& options, int repeats, int frames) const
    {
        const Embedder embedder(meshes_.topology, meshes_.points, options);
        std::vector<double> seconds;
        Embedding half;
        for (int i = 0; i < repeats; ++i) {
            half = embedder.embed(between(0.5));
            seconds.push_back(half.report.seconds);
        }
        nlohmann::json figures = measure(half.points);
        figures["setup_ms"] = 1e3 * half.report.setup_seconds;
        figures["self_intersections"] = half.report.self_intersections.value();
        figures["new_self_intersections"] = half.report.new_self_intersections.value();
        figures["companion_rms"] = half.report.companion_rms;
        figures["ms"] = 1e3 * median(seconds);
        figures["iterations"] = half.report.iterations;
        figures["converged"] = half.report.converged;
        if (frames > 1)
            figures["frames_per_second"] = frames_per_second(embedder, frames);
        return figures;
    }

    const Collection& meshes() const { return meshes_; }

private:
    ShapePoint between(double t) const { return blend(vectors_, Eigen::Vector2d(1.0 - t, t)); }

    /// Everything counts that a mesh costs, its report as well; targets are made before.
    double frames_per_second(const Embedder& embedder, int frames) const
    {
        std::vector<ShapePoint> targets;
        for (int i = 0; i < frames; ++i)
            targets.push_back(between(static_cast<double>(i) / (frames - 1)));
        const double total = milliseconds([&] {
            for (const ShapePoint& target : targets)
                (void)embedder.embed(target);
        });
        return 1e3 * frames / total;
    }

    Collection meshes_;
    ShapeVectors vectors_;
    std::vector<bool> bad_; ///< Bad in either mesh already.
    Points truth_;          ///< What should lie half-way; may be empty.
};

} // namespace

int main(int argc, char** argv)
{
    CLI::App app("Times and errors of the embeddings half-way between two meshes");
    std::vector<std::string> files;
    std::vector<std::string> names{"fine", "preview", "multiscale"};
    std::string measured;
    std::string truth;
    int repeats = 9;
    int frames = 0;
    int threads = 2;
    double smoothness = default_smoothness;
    double anchor = default_anchor;
    app.add_option("meshes", files, "Two meshes in correspondence")->required()->expected(2);
    app.add_option("--methods", names, "Of fine, preview, multiscale, closure")
        ->delimiter(',')
        ->check(CLI::IsMember(&methods));
    app.add_option("--repeat", repeats, "Meshes per method")->check(CLI::PositiveNumber);
    app.add_option("--frames", frames, "Measure the rate of this many blends");
    app.add_option("--threads", threads, "Threads");
    app.add_option("--smoothness", smoothness, "Weight of the angles");
    app.add_option("--anchor", anchor, "Weight of the companion");
    app.add_option("--truth", truth, "What should lie half-way");
    app.add_option("--measure", measured, "A mesh to be measured as well");
    CLI11_PARSE(app, argc, argv);
    try {
        set_thread_count(threads);
        const Benchmark benchmark(files[0], files[1],
                                  truth.empty() ? Points() : read_mesh(truth).points);
        const Collection& meshes = benchmark.meshes();
        nlohmann::json report{
            {"vertices", meshes.topology.vertex_count()},
            {"threads", threads},
            {"back_substitution_ms", back_substitution_ms(meshes.topology, meshes.points[0])}};
        for (const std::string& name : names) {
            EmbeddingOptions options = methods.at(name);
            if (options.method == EmbeddingMethod::Dihedral) {
                options.smoothness = smoothness;
                options.anchor = anchor;
            }
            report["methods"][name] = benchmark.run(options, repeats, frames);
        }
        if (!measured.empty())
            report["measured"] = benchmark.measure(read_mesh(measured).points);
        std::cout << report.dump(1) << '\n';
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
}
