// SPDX-License-Identifier: MIT
//
// closure_benchmark A.obj B.obj [LENGTHS.obj]: embeds the mean of two meshes (or the lengths of a
// third) by Rojas 2014 with one thread and prints what it cost and reached, as JSON.

#include <cmath>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>

#include "libshape/base/threads.h"
#include "libshape/embedding/closure/closure_embedding.h"
#include "libshape/io/mesh_file.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace {

double cpu_seconds()
{
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc < 3) {
        std::cerr << "usage: closure_benchmark A.obj B.obj [LENGTHS.obj]\n";
        return 1;
    }
    shape::set_thread_count(1);
    const shape::NamedMesh a = shape::read_mesh(argv[1]);
    const shape::NamedMesh b = shape::read_mesh(argv[2]);
    const shape::Topology topology(a.faces, static_cast<int>(a.points.rows()));
    shape::ShapePoint target{
        (edge_lengths(topology, a.points) + edge_lengths(topology, b.points)) / 2,
        (dihedral_angles(topology, a.points) + dihedral_angles(topology, b.points)) / 2};
    if (argc > 3)
        target.edge_lengths = shape::edge_lengths(topology, shape::read_mesh(argv[3]).points);

    const double start = cpu_seconds();
    const shape::internal::ClosureEmbedding result =
        shape::internal::embed_by_closure(topology, target);
    const double seconds = cpu_seconds() - start;

    const Eigen::ArrayXd wanted = target.edge_lengths.array();
    const Eigen::ArrayXd error = edge_lengths(topology, result.points).array() - wanted;
    std::cout << nlohmann::json{{"vertices", topology.vertex_count()},
                                {"E", result.solution.energy},
                                {"grad_inf", result.solution.gradient_maximum},
                                {"iterations", result.solution.iterations},
                                {"evaluations", result.solution.evaluations},
                                {"converged", result.solution.converged},
                                {"rms_over_mean", std::sqrt(error.square().mean()) / wanted.mean()},
                                {"max_rel", (error / wanted).abs().maxCoeff()},
                                {"cpu_seconds_total", seconds}}
              << '\n';
}
