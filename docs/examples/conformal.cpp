// SPDX-License-Identifier: MIT

#include <libshape/shape.h>

#include <iostream>

// Maps a closed surface conformally to the sphere and says what the map is worth.
int main()
{
    const shape::Collection barbells = shape::make_synthetic("barbells", {.vertices = 500});
    const shape::Points& mesh = barbells.points.front();
    const shape::SphereMap map =
        shape::map_to_sphere(barbells.topology, shape::edge_lengths(barbells.topology, mesh));
    std::cout << "certificate: " << shape::name(map.certificate) << ", worst edge "
              << map.edges.worst << "\n";
    shape::write_mesh("sphere.ply", map.radius * map.sphere.points, barbells.topology.faces());
}
