// SPDX-License-Identifier: MIT

#include <libshape/shape.h>

#include <iostream>

// What a smile does to a face: the mean difference between the same people neutral and happy, added
// one and a half times to the mean neutral face (Rojas 2014, Fig. 10).
int main()
{
    const shape::Collection faces = shape::make_synthetic("faces", {.count = 6, .vertices = 500});
    const shape::DifferenceVector smile = shape::mean_difference(faces, {.pair_by = "subject",
                                                                         .from_label = "expression",
                                                                         .from_value = "neutral",
                                                                         .to_label = "expression",
                                                                         .to_value = "happy"});

    const shape::ShapePoint neutral = shape::start_of(smile, smile.from_size);
    const shape::Embedder embedder(smile.topology, {smile.reference_points});
    const shape::Embedding happy =
        embedder.embed(shape::apply_differences(neutral, {smile}, {1.5}));
    shape::write_mesh("happy.ply", happy.points, smile.topology.faces());
    std::cout << smile.pairs.size() << " pairs; edges of happy.ply are off by "
              << 100.0 * happy.report.edge_rms << " % (RMS)\n";
}
