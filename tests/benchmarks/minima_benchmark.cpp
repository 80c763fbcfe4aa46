// SPDX-License-Identifier: MIT
//
// minima_benchmark A B [--smoothness MU] [--threads N]
//
// What energy the methods that were measured before reach beside that of libshape, at equal mu, half-way between
// two meshes: Gauss-Newton from the preview and from the fine result, and walks from either mesh in
// five steps of t, each Gauss-Newton from the result before. Prints the energies as JSON. Each
// Gauss-Newton step factors a matrix of three rows a vertex: minutes at 10,000 vertices.

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "libshape/base/threads.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/embedder.h"
#include "libshape/embedding/energy/gauss_newton.h"
#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/io/mesh_file.h"
#include "libshape/mesh/collection.h"
#include "libshape/mesh/edge_lengths.h"

namespace {

using namespace shape;
using namespace shape::internal;
using Eigen::VectorXd;

constexpr GaussNewtonOptions on_the_way{.max_iterations = 5, .decrease_tolerance = 1e-2};
constexpr GaussNewtonOptions to_the_end{.max_iterations = 60, .decrease_tolerance = 1e-5};

VectorXd unknowns(const Points& points)
{
    return points.reshaped<Eigen::RowMajor>();
}

class Minima
{
public:
    Minima(const Collection& meshes, double smoothness)
        : meshes_(meshes),
          vectors_(shape_vectors(meshes, Scale::None)),
          smoothness_(smoothness),
          half_(energy(0.5)),
          solver_(meshes.topology,
                  graded_unknowns(meshes.topology, edge_lengths(meshes.topology, meshes.points[0])))
    {
    }

    Points embedding(EmbeddingQuality quality) const
    {
        return Embedder(meshes_.topology, meshes_.points,
                        {.quality = quality, .smoothness = smoothness_})
            .embed(half_.target())
            .points;
    }

    /// E of a mesh.
    double at(const VectorXd& points) const
    {
        LengthDihedralEnergy energy = half_; // works in memory of its own
        VectorXd gradient;
        return energy.evaluate(points, gradient);
    }

    /// E at the end of a descent.
    double from(const Points& points) const
    {
        return solver_.minimize(half_, unknowns(points), to_the_end).value;
    }

    /// E at the end of a walk from a mesh.
    double walk(std::size_t mesh) const
    {
        constexpr int steps = 5;
        VectorXd points = unknowns(meshes_.points[mesh]);
        for (int step = 1; step <= steps; ++step) {
            const double way = 0.5 * step / steps;
            points = solver_
                         .minimize(energy(mesh == 0 ? way : 1.0 - way), std::move(points),
                                   step < steps ? on_the_way : to_the_end)
                         .points;
        }
        return at(points);
    }

private:
    LengthDihedralEnergy energy(double t) const
    {
        return {meshes_.topology, blend(vectors_, Eigen::Vector2d(1.0 - t, t)), smoothness_};
    }

    const Collection& meshes_;
    ShapeVectors vectors_;
    double smoothness_;
    LengthDihedralEnergy half_;
    GaussNewton solver_;
};

} // namespace

int main(int argc, char** argv)
{
    CLI::App app("Energies that several methods reach half-way between two meshes");
    std::vector<std::string> files;
    int threads = 2;
    double smoothness = default_smoothness;
    app.add_option("meshes", files, "Two meshes in correspondence")->required()->expected(2);
    app.add_option("--threads", threads, "Threads");
    app.add_option("--smoothness", smoothness, "Weight of the angles");
    CLI11_PARSE(app, argc, argv);
    try {
        set_thread_count(threads);
        const Collection meshes = collect({read_mesh(files[0]), read_mesh(files[1])});
        const Minima minima(meshes, smoothness);
        const Points preview = minima.embedding(EmbeddingQuality::Preview);
        const Points fine = minima.embedding(EmbeddingQuality::Fine);
        std::cout << nlohmann::json{{"vertices", meshes.topology.vertex_count()},
                                    {"preview", minima.at(unknowns(preview))},
                                    {"fine", minima.at(unknowns(fine))},
                                    {"from_preview", minima.from(preview)},
                                    {"from_fine", minima.from(fine)},
                                    {"walk_from_a", minima.walk(0)},
                                    {"walk_from_b", minima.walk(1)}}
                         .dump(1)
                  << '\n';
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
}
