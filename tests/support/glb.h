// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "libshape/mesh/points.h"

namespace shape::test {

/// A GLB file of one mesh, read by the letter of the glTF 2.0 specification: what a viewer shows.
class Glb
{
public:
    /// @throws std::runtime_error if the file is not made of a JSON and a BIN chunk.
    explicit Glb(const std::filesystem::path& path);

    [[nodiscard]] const nlohmann::json& description() const { return description_; }
    [[nodiscard]] const nlohmann::json& primitive() const;

    [[nodiscard]] Faces faces() const;

    /// Numbers of an accessor: count by its number of components.
    [[nodiscard]] Eigen::MatrixXd numbers(std::size_t accessor) const;

    /// Positions in the scene, or unscaled normals, at a time of the animation [s].
    [[nodiscard]] Points positions(double seconds = 0.0) const;
    [[nodiscard]] Points normals(double seconds = 0.0) const;

private:
    [[nodiscard]] Points morphed(const char* attribute, double seconds) const;
    [[nodiscard]] Eigen::VectorXd weights(double seconds) const;

    nlohmann::json description_;
    std::string buffer_;
};

/// Whether node and the package gltf-validator are there.
[[nodiscard]] bool has_gltf_validator();

/// What the Khronos glTF validator finds, one line an issue of any severity; empty if the file is
/// flawless.
[[nodiscard]] std::string gltf_issues(const std::filesystem::path& file);

} // namespace shape::test
