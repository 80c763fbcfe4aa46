// SPDX-License-Identifier: MIT

#include "tools/output/frame_store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <utility>

#include "libshape/base/clean_up.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/json_depth.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr const char* manifest_name = "manifest.json";
constexpr const char* mesh_ending = ".mesh";
constexpr const char* unfinished_ending = ".tmp";

fs::path directory_beside(const std::string& output)
{
    const fs::path path = output;
    if (fs::is_directory(path))
        return path / "unfinished";
    const fs::path target = path.has_filename() ? path : path.parent_path();
    const std::string name = target.filename().string();
    const std::string ending = ".unfinished";
    constexpr std::size_t longest = 255; // of a name, on the usual file systems
    if (name.size() + ending.size() <= longest)
        return target.parent_path() / (name + ending);
    const std::string hash = hash_text(name.data(), name.size());
    return target.parent_path() /
           (name.substr(0, longest - ending.size() - hash.size() - 1) + "-" + hash + ending);
}

std::optional<std::string> content_of(const fs::path& path)
{
    constexpr std::uint64_t largest_file = std::uint64_t{2} << 30;
    if (!fs::exists(path))
        return std::nullopt;
    return read_file(path, largest_file);
}

/// An object, or none if the text is not one that this program has written.
std::optional<Json> parse_object(const std::string& text)
{
    if (!is_shallow_json(text))
        return std::nullopt;
    Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
    return json.is_object() ? std::optional(std::move(json)) : std::nullopt;
}

/// The text of a field; empty if it is missing or something else.
std::string text_of(const Json& object, const std::string& key)
{
    return object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : "";
}

/// Writes beside the place and renames, so that a process that is killed leaves no half of a file.
void put(const fs::path& path, const std::string& content)
{
    const fs::path temporary = path.string() + unfinished_ending;
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

/// Of all that is kept of a mesh.
std::string hash_of(const FinishedMesh& mesh)
{
    return hash_text(
        mesh.points.data(), to_size(mesh.points.size()) * sizeof(double),
        mesh.figures.dump(-1, ' ', false, Json::error_handler_t::replace) + mesh.reason);
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
    const std::optional<Json> found =
        parse_object(content_of(directory / manifest_name).value_or(""));
    if (!found)
        throw InvalidInput(
            join(directory.string(), ": no meshes of an interrupted run; remove the directory"));
    for (const auto& [key, value] : identity.items())
        if (!found->contains(key) || (*found)[key] != value)
            throw InvalidInput(
                join(directory.string(), ": the interrupted run differs in ", key, " (",
                     found->contains(key) ? (*found)[key].dump().substr(0, 80) : "none", " there, ",
                     value.dump(), " now); without --resume, --force discards it"));
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

DirectoryLock::DirectoryLock(const fs::path& directory)
{
    // Whoever ends removes the directory: then the lock is that of one which is gone, and not worth
    // anything.
    constexpr int attempts = 100;
    for (int i = 0; i < attempts; ++i) {
        fs::create_directory(directory);
        descriptor_ = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
        if (descriptor_ < 0 && errno == ENOENT)
            continue;
        if (descriptor_ < 0)
            throw FileError(join(directory.string(), ": ", std::strerror(errno)));
        const bool is_taken = ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
        struct stat held = {};
        struct stat there = {};
        if (!is_taken && ::fstat(descriptor_, &held) == 0 &&
            ::stat(directory.c_str(), &there) == 0 && held.st_ino == there.st_ino)
            return; // some file systems have no locks; that is not a reason to refuse
        ::close(std::exchange(descriptor_, -1));
        if (is_taken)
            break;
    }
    throw FileError(
        join(directory.string(),
             ": another run is at work there; wait until it has ended, or choose another -o"));
}

DirectoryLock::~DirectoryLock()
{
    ::close(descriptor_);
}

FrameStore::FrameStore(const Session& session, const std::string& output, const Json& identity,
                       bool resume)
    : directory_(directory_beside(output)), lock_(directory_), manifest_(identity)
{
    // Of a run that was killed before it had written anything else.
    fs::remove(directory_ / join(manifest_name, unfinished_ending));
    if (fs::is_empty(directory_))
        return;
    if (resume) {
        check_manifest(directory_, identity);
        count_ = count_meshes(directory_);
    } else if (session.force) {
        check_manifest(directory_, Json::object()); // whatever else it is stays
        for (const fs::directory_entry& entry : fs::directory_iterator(directory_))
            fs::remove_all(entry.path());
    } else {
        throw FileError(join(directory_.string(),
                             ": an interrupted run has left its meshes; --resume goes on with "
                             "them, --force discards them"));
    }
}

FrameStore::~FrameStore()
{
    if (keep_)
        return;
    clean_up([&] {
        std::error_code ignored; // The run has failed already; its error is the one to report.
        if (fs::exists(directory_ / manifest_name, ignored))
            fs::remove_all(directory_, ignored);
        else
            fs::remove(directory_, ignored); // where it is empty
    });
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
    const std::optional<Json> record = parse_object(content->substr(0, head));
    if (!record || head == std::string::npos)
        return std::nullopt;
    const std::size_t bytes = content->size() - head - 1;
    FinishedMesh mesh{Points(static_cast<Eigen::Index>(bytes / (3 * sizeof(double))), 3),
                      record->value("figures", Json()), text_of(*record, "reason")};
    std::copy_n(content->data() + head + 1, to_size(mesh.points.size()) * sizeof(double),
                reinterpret_cast<char*>(mesh.points.data()));
    if (text_of(*record, "hash") != hash_of(mesh))
        return std::nullopt;
    return mesh;
}

void FrameStore::write(std::size_t index, const FinishedMesh& mesh)
{
    if (count_ == 0) {
        put(directory_ / manifest_name, manifest_.dump(2) + "\n");
    }
    const Json record{{"hash", hash_of(mesh)}, {"figures", mesh.figures}, {"reason", mesh.reason}};
    std::string content = record.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    content.append(reinterpret_cast<const char*>(mesh.points.data()),
                   to_size(mesh.points.size()) * sizeof(double));
    put(file(index), content);
    ++count_;
}

bool FrameStore::keep()
{
    keep_ = count_ > 0;
    return keep_;
}

} // namespace shape::tools
