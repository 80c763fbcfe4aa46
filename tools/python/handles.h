// SPDX-License-Identifier: MIT

#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "libshape/embedding/embedder.h"
#include "libshape/mesh/collection.h"
#include "libshape/model/difference.h"
#include "libshape/model/shape_model.h"
#include "tools/python/arrays.h"

// What Python objects hold on to. Each is shared with the work that still runs on it, and may end with it:
// so none holds a Python object.

namespace shape::python {

/// Embedders of one topology and reference, made once for each set of options.
class Embedders
{
public:
    Embedders(Topology topology, Points reference)
        : topology_(std::move(topology)), reference_(std::move(reference))
    {
    }
    [[nodiscard]] std::shared_ptr<const Embedder> get(const EmbeddingOptions& options) const;

private:
    Topology topology_;
    Points reference_;
    mutable std::mutex mutex_;
    mutable std::map<std::string, std::shared_ptr<const Embedder>> made_;
};

struct CollectionHandle
{
    Collection collection;
};

struct ModelHandle
{
    explicit ModelHandle(ShapeModel fitted)
        : model(std::move(fitted)), embedders(model.topology, model.reference_points)
    {
    }
    ShapeModel model;
    Embedders embedders;
};

struct DifferenceHandle
{
    explicit DifferenceHandle(DifferenceVector found)
        : difference(std::move(found)), embedders(difference.topology, difference.reference_points)
    {
    }
    DifferenceVector difference;
    Embedders embedders;
};

/// @param method, quality  As the program's options name them; quality empty: not given.
/// @param smoothness  NaN: not given.
[[nodiscard]] EmbeddingOptions embedding_options(const std::string& method,
                                                 const std::string& quality, double smoothness,
                                                 std::uint64_t seed, bool avoid_contact);

[[nodiscard]] SpaceOptions space_options(const std::string& space, const std::string& scale,
                                         const std::string& coordinates, bool area_weighted,
                                         double with_dihedrals, double with_positions);

/// (positions, report as a dictionary)
[[nodiscard]] py::tuple to_python(Embedding embedding);

[[nodiscard]] py::dict to_python(const Labels& labels);

void add_collections(py::module_& module);
void add_models(py::module_& module);

} // namespace shape::python
