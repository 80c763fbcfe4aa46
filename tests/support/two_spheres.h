// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/face_crossings.h"
#include "libshape/mesh/topology.h"
#include "tests/support/meshes.h"

namespace shape::test {

/// Two spheres of radius 1 beside each other along x, and all pairs of their faces that cross. They lack a face each, far from each
/// other, where a prism joins them to one surface.
struct TwoSpheres
{
    Topology topology;
    Eigen::VectorXd points;
    std::vector<internal::FacePair> pairs;

    explicit TwoSpheres(double distance) : topology(joined_spheres())
    {
        const Points sphere = icosphere(2).points;
        Points both(2 * sphere.rows(), 3);
        // Not quite beside: where edges meet edges, no edge crosses a face.
        both << sphere, sphere.rowwise() + Eigen::RowVector3d(distance, 0.03, 0.05);
        points = both.reshaped<Eigen::RowMajor>();
        pairs = internal::FaceTree(topology, both).crossings(both);
        const int prism = topology.face_count() - 6;
        std::erase_if(pairs, [&](const internal::FacePair& pair) { return pair[1] >= prism; });
    }

    static Topology joined_spheres()
    {
        const TestMesh sphere = icosphere(2);
        const Faces& faces = sphere.topology.faces();
        const int count = sphere.topology.vertex_count();
        const auto last = faces.rows() - 1;
        int left = 0, right = 0;
        const auto place = [&](Eigen::Index f) { return sphere.points(faces.row(f), 0).sum(); };
        for (int f = 0; f <= last; ++f) {
            left = place(f) < place(left) ? f : left;
            right = place(f) > place(right) ? f : right;
        }
        Faces both(2 * faces.rows() + 4, 3);
        int row = 0;
        for (int f = 0; f <= last; ++f)
            if (f != left)
                both.row(row++) = faces.row(f);
        for (int f = 0; f <= last; ++f)
            if (f != right)
                both.row(row++) = faces.row(f).array() + count;
        for (int k = 0; k < 3; ++k) {
            const int a = faces(left, k), next_a = faces(left, (k + 1) % 3);
            const int b = faces(right, (3 - k) % 3) + count, next_b = faces(right, 2 - k) + count;
            both.row(row++) << a, next_a, next_b;
            both.row(row++) << a, next_b, b;
        }
        return {both, 2 * count};
    }
};

} // namespace shape::test
