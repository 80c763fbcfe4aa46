// SPDX-License-Identifier: MIT

#include <iostream>

#include "libshape/base/version.h"
#include "libshape/mesh/edge_lengths.h"

int main()
{
    const shape::Faces faces{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    const shape::Points points{{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
    const shape::Topology tetrahedron(faces, 4);
    std::cout << "shape " << shape::version() << ", "
              << shape::edge_lengths(tetrahedron, points).squaredNorm() << "\n"; // 6 edges, sqrt(8)
}
