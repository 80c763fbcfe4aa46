// SPDX-License-Identifier: MIT

#include "tests/support/glb.h"

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "tests/support/files.h"

namespace shape::test {
using namespace internal;
namespace {

template <class Value>
Value value_at(const std::string& bytes, std::size_t offset)
{
    Value value;
    std::memcpy(&value, bytes.substr(offset, sizeof value).data(), sizeof value);
    return value;
}

Eigen::Index components(const std::string& type)
{
    return type == "SCALAR" ? 1 : type.back() - '0';
}

/// Runs node with the packages of the build; its exit code.
int run_node(const std::string& program, const std::string& rest)
{
    const char* path = std::getenv("NODE_PATH");
    return std::system(join("NODE_PATH='", SHAPE_NODE_MODULES, ":", path != nullptr ? path : "",
                            "' node -e \"", program, "\" ", rest)
                           .c_str());
}

} // namespace

Glb::Glb(const std::filesystem::path& path)
{
    const std::string bytes = read_bytes(path);
    const auto word = [&](std::size_t offset) { return value_at<std::uint32_t>(bytes, offset); };
    if (bytes.size() < 28 || bytes.substr(0, 4) != "glTF" || word(4) != 2 ||
        word(8) != bytes.size() || bytes.substr(16, 4) != "JSON")
        throw std::runtime_error("no GLB file");
    const std::size_t length = word(12);
    const std::size_t second = 20 + length;
    if (length % 4 != 0 || word(second) % 4 != 0 || second + 8 + word(second) != bytes.size() ||
        bytes.substr(second + 4, 4) != std::string("BIN\0", 4))
        throw std::runtime_error("not one JSON and one BIN chunk");
    description_ = nlohmann::json::parse(bytes.substr(20, length));
    buffer_ = bytes.substr(second + 8);
    if (description_.at("buffers").at(0).at("byteLength") != buffer_.size())
        throw std::runtime_error("the buffer has another length");
}

const nlohmann::json& Glb::primitive() const
{
    return description_.at("meshes").at(0).at("primitives").at(0);
}

Eigen::MatrixXd Glb::numbers(std::size_t accessor) const
{
    const nlohmann::json& array = description_.at("accessors").at(accessor);
    const nlohmann::json& view =
        description_.at("bufferViews").at(array.at("bufferView").get<std::size_t>());
    const std::size_t offset = view.at("byteOffset");
    const bool is_float = array.at("componentType") == 5126;
    Eigen::MatrixXd result(array.at("count").get<Eigen::Index>(), components(array.at("type")));
    if (view.at("byteLength") != 4 * result.size())
        throw std::runtime_error("a buffer view has another length than its accessor");
    for (Eigen::Index i = 0; i < result.rows(); ++i)
        for (Eigen::Index c = 0; c < result.cols(); ++c) {
            const auto place = offset + to_size(4 * (i * result.cols() + c));
            result(i, c) = is_float ? static_cast<double>(value_at<float>(buffer_, place))
                                    : value_at<std::uint32_t>(buffer_, place);
        }
    return result;
}

Faces Glb::faces() const
{
    const Eigen::MatrixXd corners = numbers(primitive().at("indices"));
    return corners.reshaped<Eigen::RowMajor>(corners.size() / 3, 3).cast<int>();
}

Eigen::VectorXd Glb::weights(double seconds) const
{
    const nlohmann::json& sampler = description_.at("animations").at(0).at("samplers").at(0);
    const Eigen::VectorXd times = numbers(sampler.at("input"));
    const Eigen::MatrixXd all = numbers(sampler.at("output"));
    const Eigen::Index targets = all.size() / times.size();
    const auto at = [&](Eigen::Index k) { return all.col(0).segment(k * targets, targets); };
    Eigen::Index k = 0;
    while (k + 2 < times.size() && times[k + 1] < seconds)
        ++k;
    const double t = std::clamp((seconds - times[k]) / (times[k + 1] - times[k]), 0.0, 1.0);
    return (1.0 - t) * at(k) + t * at(k + 1);
}

Points Glb::morphed(const char* attribute, double seconds) const
{
    Points result = numbers(primitive().at("attributes").at(attribute));
    if (!description_.contains("animations"))
        return result;
    const Eigen::VectorXd share = weights(seconds);
    for (Eigen::Index i = 0; i < share.size(); ++i)
        result += share[i] * numbers(primitive().at("targets").at(to_size(i)).at(attribute));
    return result;
}

Points Glb::positions(double seconds) const
{
    const nlohmann::json& place = description_.at("nodes").at(0).at("translation");
    return morphed("POSITION", seconds).rowwise() +
           Eigen::RowVector3d(place.at(0), place.at(1), place.at(2));
}

Points Glb::normals(double seconds) const
{
    return morphed("NORMAL", seconds);
}

bool has_gltf_validator()
{
    static const bool found = run_node("require('gltf-validator')", "2>/dev/null") == 0;
    return found;
}

std::string gltf_issues(const std::filesystem::path& file)
{
    const TemporaryDirectory directory;
    const std::filesystem::path output = directory / "issues.txt";
    const int code = run_node(
        "require('gltf-validator').validateBytes(new Uint8Array(require('fs').readFileSync("
        "process.argv[1]))).then(report => report.issues.messages.forEach(issue => "
        "console.log(issue.code, issue.message, issue.pointer)))",
        join("'", file.string(), "' >'", output.string(), "' 2>&1"));
    return read_bytes(output) + (code == 0 ? "" : "node failed");
}

} // namespace shape::test
