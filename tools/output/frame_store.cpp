// SPDX-License-Identifier: MIT

#include "tools/output/frame_store.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr const char* manifest_name = "manifest.json";
constexpr const char* mesh_ending = ".mesh";

fs::path directory_beside(const std::string& output)
{
    const fs::path path = output;
    if (fs::is_directory(path))
        return path / "unfinished";
    const fs::path target = path.has_filename() ? path : path.parent_path();
    return target.parent_path() / (target.filename().string() + ".unfinished");
}

std::optional<std::string> content_of(const fs::path& path)
{
    std::ifstream in(path, std::ios::binary);
    if (!in)
        return std::nullopt;
    return std::string(std::istreambuf_iterator<char>(in), {});
}

/// Writes beside the place and renames, so that a process that is killed leaves no half of a file.
void put(const fs::path& path, const std::string& content)
{
    const fs::path temporary = path.string() + ".tmp";
    errno = 0;
    std::ofstream out(temporary, std::ios::binary);
    out << content;
    out.close();
    if (!out) {
        const int cause = errno;
        std::error_code ignored; // the error of writing is the one to report
        fs::remove(temporary, ignored);
        throw FileError(join("cannot write ", path.string(), ": ", std::strerror(cause)));
    }
    fs::rename(temporary, path);
}

std::string hash_of(const Points& points)
{
    return hash_text(points.data(), static_cast<std::size_t>(points.size()) * sizeof(double));
}

std::size_t count_meshes(const fs::path& directory)
{
    std::size_t count = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(directory))
        count += entry.path().extension() == mesh_ending ? 1 : 0;
    return count;
}

void check_manifest(const fs::path& directory, const Json& identity)
{
    const Json found = Json::parse(content_of(directory / manifest_name).value_or(""), nullptr,
                                   /*allow_exceptions=*/false);
    if (!found.is_object())
        throw InvalidInput(
            join(directory.string(), ": no meshes of an interrupted run; remove the directory"));
    for (const auto& [key, value] : identity.items())
        if (!found.contains(key) || found[key] != value)
            throw InvalidInput(join(directory.string(), ": the interrupted run differs in ", key,
                                    " (", found.value(key, "none"), " there, ",
                                    value.get<std::string>(),
                                    " now); without --resume, --force discards it"));
}

} // namespace

std::string hash_text(const void* data, std::size_t bytes, const std::string& before)
{
    // Multiply and xorshift per eight bytes, constants of SplitMix64 (Steele, Lea, Flood 2014).
    const auto mixed = [](std::uint64_t z) {
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
        return z ^ (z >> 31);
    };
    std::uint64_t hash = mixed(bytes + 0x9e3779b97f4a7c15U);
    const auto add = [&](const void* part, std::size_t size) {
        std::uint64_t word = 0;
        std::memcpy(&word, part, size);
        hash = mixed(hash ^ word) + 0x9e3779b97f4a7c15U;
    };
    for (std::size_t i = 0; i < before.size(); i += 8)
        add(before.data() + i, std::min<std::size_t>(8, before.size() - i));
    for (std::size_t i = 0; i < bytes; i += 8)
        add(static_cast<const char*>(data) + i, std::min<std::size_t>(8, bytes - i));
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

FrameStore::FrameStore(const Session& session, const std::string& output, const Json& identity,
                       bool resume)
    : directory_(directory_beside(output)), manifest_(identity)
{
    if (!fs::exists(fs::symlink_status(directory_)))
        return;
    if (resume) {
        check_manifest(directory_, identity);
        count_ = count_meshes(directory_);
    } else if (session.force) {
        check_manifest(directory_, Json::object()); // whatever else it is stays
        fs::remove_all(directory_);
    } else {
        throw FileError(join(directory_.string(),
                             ": an interrupted run has left its meshes; --resume goes on with "
                             "them, --force discards them"));
    }
}

FrameStore::~FrameStore()
{
    std::error_code ignored; // The run has failed already; its error is the one to report.
    if (!keep_ && fs::exists(directory_ / manifest_name, ignored))
        fs::remove_all(directory_, ignored);
}

fs::path FrameStore::file(std::size_t index) const
{
    return directory_ / (std::to_string(index) + mesh_ending);
}

std::optional<FinishedMesh> FrameStore::read(std::size_t index) const
{
    const std::optional<std::string> content = content_of(file(index));
    if (!content)
        return std::nullopt;
    const std::size_t head = content->find('\n');
    const Json record = Json::parse(content->substr(0, head), nullptr, /*allow_exceptions=*/false);
    if (!record.is_object() || head == std::string::npos)
        return std::nullopt;
    const std::size_t bytes = content->size() - head - 1;
    FinishedMesh mesh{Points(static_cast<Eigen::Index>(bytes / (3 * sizeof(double))), 3),
                      record.value("figures", Json()), record.value("reason", "")};
    std::memcpy(mesh.points.data(), content->data() + head + 1,
                static_cast<std::size_t>(mesh.points.size()) * sizeof(double));
    if (record.value("hash", "") != hash_of(mesh.points))
        return std::nullopt;
    return mesh;
}

void FrameStore::write(std::size_t index, const FinishedMesh& mesh)
{
    if (count_ == 0) {
        fs::create_directory(directory_);
        put(directory_ / manifest_name, manifest_.dump(2) + "\n");
    }
    const Json record{
        {"hash", hash_of(mesh.points)}, {"figures", mesh.figures}, {"reason", mesh.reason}};
    std::string content = record.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    content.append(reinterpret_cast<const char*>(mesh.points.data()),
                   static_cast<std::size_t>(mesh.points.size()) * sizeof(double));
    put(file(index), content);
    ++count_;
}

bool FrameStore::keep()
{
    keep_ = count_ > 0;
    return keep_;
}

} // namespace shape::tools
