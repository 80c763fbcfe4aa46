// SPDX-License-Identifier: MIT

#include "libshape/io/statismo_file.h"

#include <array>
#include <deque>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/base/to_size.h"
#include "libshape/base/version.h"
#include "libshape/io/hdf5/writer.h"

namespace shape {
using namespace internal;
namespace {

using FloatMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using IntegerMatrix = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

template <class Matrix>
auto span_of(const Matrix& matrix)
{
    return std::span(matrix.data(), to_size(matrix.size()));
}

} // namespace

void write_statismo(const std::filesystem::path& path, const Topology& topology,
                    const LinearisedModel& model, const std::vector<std::string>& names)
{
    if (lower_case(path.extension().string()) != ".h5")
        throw InvalidInput(join(path.string(), ": a model for Statismo must end in .h5"));
    const Eigen::Index modes = model.variances.size();
    if (model.mean.rows() != topology.vertex_count() || model.basis.rows() != model.mean.size() ||
        model.basis.cols() != modes || model.scores.cols() != modes ||
        model.scores.rows() != static_cast<Eigen::Index>(names.size()))
        throw InvalidInput("the parts of the linearised model have sizes that do not fit");
    const FloatMatrix mean = model.mean.cast<float>();
    const FloatMatrix points = mean.transpose();
    const FloatMatrix basis = model.basis.cast<float>();
    const Eigen::VectorXf variances = model.variances.cast<float>();
    // Coefficients of the basis times standard deviations, as Statismo computes them of its samples.
    const FloatMatrix scores =
        (model.variances.cwiseSqrt().cwiseInverse().asDiagonal() * model.scores.transpose())
            .cast<float>();
    const IntegerMatrix cells = topology.faces().transpose();
    if (!mean.allFinite() || !variances.allFinite() || !scores.allFinite())
        throw InvalidInput("the linearised model is beyond single precision");
    const int major = 0;
    const int minor = 9;
    const float no_noise = 0.0F;
    std::deque<std::string> texts; // what datasets look into
    const auto text = [&](std::string value) {
        return std::span<const std::string>(&texts.emplace_back(std::move(value)), 1);
    };
    const std::string maker = join("libshape ", version());
    const std::string builder = "/modelinfo/modelBuilder-0";
    Hdf5Content content{
        .attributes = {},
        .datasets = {{"/version/majorVersion", {}, std::span(&major, 1)},
                     {"/version/minorVersion", {}, std::span(&minor, 1)},
                     {"/model/mean", {mean.size()}, span_of(mean)},
                     {"/model/pcaBasis", {basis.rows(), modes}, span_of(basis)},
                     {"/model/pcaVariance", {modes}, span_of(variances)},
                     {"/model/noiseVariance", {}, std::span(&no_noise, 1)},
                     {"/representer/points", {3, points.cols()}, span_of(points)},
                     {"/representer/cells", {3, cells.cols()}, span_of(cells)},
                     {"/modelinfo/build-time", {}, text(maker)}, // a time would change the bytes
                     {"/modelinfo/scores", {modes, scores.cols()}, span_of(scores)},
                     {builder + "/builderName", {}, text("libshape")},
                     {builder + "/buildTime", {}, text(maker)},
                     {builder + "/parameters/basis",
                      {},
                      text(model.is_exact
                               ? "positions of a model of Procrustes space"
                               : "positions linearised at the mean of a model of edge "
                                 "lengths, from its modes at -1 and 1 standard deviation")}},
        .group_attributes = {{"/representer", {"name", "itkStandardMeshRepresenter"}},
                             {"/representer", {"version", "0.1"}},
                             {"/representer", {"datasetType", "POLYGON_MESH"}}},
        .plain = true};
    for (std::size_t i = 0; i < names.size(); ++i)
        content.datasets.push_back({join(builder, "/dataInfo/URI_", i), {}, text(names[i])});
    write_hdf5(path, content);
}

} // namespace shape
