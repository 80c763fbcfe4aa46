// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/mesh/collection.h"
#include "libshape/synthetic/synthetic.h"

/// The makers behind make_synthetic(), one a file. Options are complete and in range here.
namespace shape::internal::synthetic {

[[nodiscard]] Collection make_arm(const SyntheticOptions& options);
[[nodiscard]] Collection make_barbells(const SyntheticOptions& options);
[[nodiscard]] Collection make_faces(const SyntheticOptions& options);
[[nodiscard]] Collection make_femurs(const SyntheticOptions& options);
[[nodiscard]] Collection make_heads(const SyntheticOptions& options);
[[nodiscard]] Collection make_helix(const SyntheticOptions& options);
[[nodiscard]] Collection make_icosahedron(const SyntheticOptions& options);
[[nodiscard]] Collection make_noisy_helix(const SyntheticOptions& options);
[[nodiscard]] Collection make_thin_cylinder(const SyntheticOptions& options);
[[nodiscard]] Collection make_torus(const SyntheticOptions& options);

/// Gathers the members of a set over one triangulation.
class Members
{
public:
    Members(Faces faces, std::vector<std::string> label_names);

    /// @param labels  One value per label name.
    void add(std::string name, Points points, const std::vector<std::string>& labels);

    /// The checked collection (see collect()).
    [[nodiscard]] Collection take();

private:
    Faces faces_;
    std::vector<NamedMesh> meshes_;
    Labels labels_;
};

/// A whole number with leading zeros.
[[nodiscard]] std::string padded(int number, int width);

} // namespace shape::internal::synthetic
