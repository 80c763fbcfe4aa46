// SPDX-License-Identifier: MIT

#include <libshape/shape.h>

#include <iostream>

// A morph between two meshes as an animation that any glTF viewer plays.
int main()
{
    const shape::Collection poses = shape::make_synthetic("arm", {.vertices = 500});
    const shape::Collection ends = shape::subset(poses, {0, poses.size() - 1});
    const shape::ShapeVectors vectors = shape::shape_vectors(ends, shape::Scale::None);

    const shape::Embedder embedder(ends.topology, ends.points);
    std::vector<shape::Points> frames;
    for (int k = 0; k <= 10; ++k) {
        const Eigen::VectorXd weights{{1.0 - 0.1 * k, 0.1 * k}};
        frames.push_back(embedder.embed(shape::blend(vectors, weights)).points);
    }
    const shape::GlbAnimation animation =
        shape::write_glb_animation("morph.glb", frames, ends.topology.faces());
    std::cout << "morph.glb plays for " << animation.seconds << " s\n";
}
