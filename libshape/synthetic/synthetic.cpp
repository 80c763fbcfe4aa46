// SPDX-License-Identifier: MIT

#include "libshape/synthetic/synthetic.h"

#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/synthetic/generators.h"

namespace shape {
using namespace internal;
namespace {

struct Entry
{
    SyntheticDataset dataset;
    Collection (*make)(const SyntheticOptions&);
};

const std::vector<Entry>& entries()
{
    using namespace synthetic;
    constexpr int most = 4'000'000;
    static const std::vector<Entry> list{
        {{"arm",
          "a straight arm and the same arm bent by 90 degrees (Rojas 2014, Fig. 3)",
          "poses from straight to bent",
          {2, 2, 1000},
          {2500, 200, most}},
         make_arm},
        {{"barbells",
          "two kinds of ends on a short and a long bar (Rojas 2014, Fig. 7), or on bars of "
          "lengths from 1 to 12",
          "barbells, an even number",
          {4, 4, 100},
          {1500, 300, most}},
         make_barbells},
        {{"faces",
          "people, each neutral, happy and angry (after Rojas 2014, Fig. 9 and 10)",
          "people, three meshes each",
          {40, 1, 10'000},
          {2500, 300, most}},
         make_faces},
        {{"femurs",
          "thigh bones with a short and a long shaft between equal ends (Rojas 2014, "
          "Fig. 8), of two kinds, and individuals",
          "bones",
          {12, 2, 10'000},
          {1500, 300, most}},
         make_femurs},
        {{"heads",
          "the faces with the back of the head closed off (after Rojas 2014, Fig. 11)",
          "people, three meshes each",
          {1, 1, 10'000},
          {5000, 600, most}},
         make_heads},
        {{"helix",
          "a straight cylinder and the same cylinder wound up (Winkler 2010, Fig. 6)",
          "turns of the helix",
          {4, 1, 100},
          {1200, 200, most}},
         make_helix},
        {{"icosahedron",
          "the regular icosahedron and the one with its top vertex pushed in: "
          "equal edge lengths (Rojas 2014, Fig. 1)",
          "meshes",
          {2, 2, 2},
          {12, 12, 12}},
         make_icosahedron},
        {{"noisy_helix",
          "the helix set with independent noise on every vertex (after Winkler "
          "2010, Fig. 13)",
          "turns of the helix",
          {4, 1, 100},
          {1200, 200, most}},
         make_noisy_helix},
        {{"thin_cylinder",
          "a straight and a bent cylinder of long and thin triangles (after "
          "Winkler 2010, Fig. 14)",
          "poses from straight to bent",
          {2, 2, 1000},
          {600, 200, most}},
         make_thin_cylinder},
        {{"torus",
          "a torus of quads split along random diagonals, and the tall barrel it is "
          "stretched to (Rojas 2014, section 6)",
          "meshes from torus to barrel",
          {2, 2, 1000},
          {1152, 50, most}},
         make_torus},
    };
    return list;
}

int chosen(int value, const SyntheticRange& range, std::string_view dataset, const char* option)
{
    if (value == 0)
        return range.standard;
    if (value >= range.low && value <= range.high)
        return value;
    throw InvalidInput(range.low == range.high
                           ? join("dataset '", dataset, "': ", option, " is ", value,
                                  ", but is always ", range.low)
                           : join("dataset '", dataset, "': ", option, " is ", value,
                                  ", must be in [", range.low, ", ", range.high, "]"));
}

} // namespace

const std::vector<SyntheticDataset>& synthetic_datasets()
{
    static const std::vector<SyntheticDataset> list = [] {
        std::vector<SyntheticDataset> datasets;
        for (const Entry& entry : entries())
            datasets.push_back(entry.dataset);
        return datasets;
    }();
    return list;
}

void check(const SyntheticOptions& options)
{
    require_at_least(0, options.count, "SyntheticOptions.count");
    require_at_least(0, options.vertices, "SyntheticOptions.vertices");
}

Collection make_synthetic(std::string_view name, const SyntheticOptions& options)
{
    const auto found = std::find_if(entries().begin(), entries().end(),
                                    [&](const Entry& e) { return e.dataset.name == name; });
    if (found == entries().end()) {
        std::string known;
        for (const Entry& entry : entries())
            known += (known.empty() ? "" : ", ") + entry.dataset.name;
        throw InvalidInput(join("no synthetic dataset '", name, "'; there are ", known));
    }
    check(options);
    const SyntheticDataset& dataset = found->dataset;
    return found->make({.count = chosen(options.count, dataset.count, name, "count"),
                        .vertices = chosen(options.vertices, dataset.vertices, name, "vertices"),
                        .seed = options.seed});
}

namespace internal::synthetic {

Members::Members(Faces faces, std::vector<std::string> label_names) : faces_(std::move(faces))
{
    for (std::string& name : label_names)
        labels_.push_back({std::move(name), {}});
}

void Members::add(std::string name, Points points, const std::vector<std::string>& labels)
{
    throw_if_stop_requested();
    for (std::size_t i = 0; i < labels_.size(); ++i)
        labels_[i].values.push_back(labels.at(i));
    const std::string path = "synthetic mesh '" + name + "'";
    meshes_.push_back({std::move(name), path, std::move(points), faces_});
}

Collection Members::take()
{
    Collection collection = collect(std::move(meshes_));
    collection.labels = std::move(labels_);
    return collection;
}

std::string padded(int number, int width)
{
    const std::string digits = std::to_string(number);
    const auto wanted = to_size(width);
    return std::string(wanted > digits.size() ? wanted - digits.size() : 0, '0') + digits;
}

} // namespace internal::synthetic
} // namespace shape
