// SPDX-License-Identifier: MIT
//
// conformal_benchmark MESH|LEVELS...: maps meshes, or bumpy spheres of 10 * 4^LEVELS + 2 vertices,
// conformally to the sphere and prints what each cost and reached, as one JSON object a line.

#include <algorithm>
#include <chrono>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "libshape/conformal/sphere_map.h"
#include "libshape/io/mesh_file.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace {

shape::test::TestMesh read(const std::string& argument)
{
    if (std::all_of(argument.begin(), argument.end(), [](char c) { return c >= '0' && c <= '9'; }))
        return shape::test::bumpy_sphere(std::stoi(argument), 0.5, 3);
    const shape::NamedMesh mesh = shape::read_mesh(argument);
    return {mesh.name, shape::Topology(mesh.faces, static_cast<int>(mesh.points.rows())),
            mesh.points};
}

} // namespace

int main(int argc, char** argv)
{
    for (int i = 1; i < argc; ++i) {
        const shape::test::TestMesh mesh = read(argv[i]);
        const Eigen::VectorXd lengths = shape::edge_lengths(mesh.topology, mesh.points);
        const std::clock_t cpu = std::clock();
        const auto wall = std::chrono::steady_clock::now();
        const shape::SphereMap map = shape::map_to_sphere(mesh.topology, lengths);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - wall;
        std::cout << nlohmann::json{{"name", mesh.name},
                                    {"vertices", mesh.topology.vertex_count()},
                                    {"certificate", shape::name(map.certificate)},
                                    {"flipped_edges", map.edges.flipped.size()},
                                    {"residual", map.edges.worst},
                                    {"newton_steps", map.newton_steps},
                                    {"seconds", seconds.count()},
                                    {"cpu_seconds",
                                     static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC}}
                  << std::endl;
    }
}
