// SPDX-License-Identifier: MIT

#include "tools/output/shard.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/output_file.h"
#include "tools/output/frame_store.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"
#include "tools/program/ranks.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr const char* manifest_name = "shard.json";
constexpr const char* report_name = "fit.json"; ///< Of `fit`, see merged_report().
/// What `fit` writes beside its meshes; of these the report alone is merged.
constexpr std::array<const char*, 4> files_of_fit{report_name, "fit.csv", "fit.svg", "scores.csv"};
constexpr int most_shards = 100000;

fs::path without_slash(const fs::path& path)
{
    return path.has_filename() ? path : path.parent_path();
}

Shard read_shard(const std::string& text)
{
    if (ranks().count > 1)
        throw UsageError(
            "--shard: the processes of mpirun have a shard each already; give one of both");
    const std::vector<std::string> parts = split(text, '/');
    const auto number = [&](const std::string& part) {
        const double value = read_number(part, "--shard");
        return value == std::floor(value) && value >= 1.0 && value <= most_shards
                   ? static_cast<int>(value)
                   : 0;
    };
    const Shard shard = parts.size() == 2 ? Shard{number(parts[0]), number(parts[1])} : Shard{0, 0};
    if (shard.number < 1 || shard.number > shard.count)
        throw UsageError(join("--shard: '", text, "' must be I/N with I in [1, N] and N in [1, ",
                              most_shards, "], such as 2/8"));
    return shard;
}

/// A number of a manifest as it stands there; of a larger one the type would keep a part.
/// @throws Json::exception if it is not in [1, most].
int small_integer(const Json& number, int most)
{
    if (!number.is_number_unsigned() || number.get<std::uint64_t>() < 1 ||
        number.get<std::uint64_t>() > static_cast<std::uint64_t>(most))
        throw Json::other_error::create(501, "out of range", nullptr);
    return number.get<int>();
}

void check_is_new(const fs::path& target)
{
    if (fs::exists(fs::symlink_status(target)))
        throw FileError(
            join(target.string(), ": exists already; shards are merged into a new one"));
}

/// The directory that shards are merged into is new or, with --force, written into.
void check_target(const fs::path& target, bool force)
{
    if (!fs::exists(fs::symlink_status(target)))
        return;
    if (!fs::is_directory(target))
        throw FileError(join(target.string(), ": exists and is not a directory"));
    if (!force)
        throw FileError(join(target.string(),
                             ": exists already; --force writes into it, over files of the same "
                             "names"));
}

/// Size and hash of a file, by which it is known again.
struct Fingerprint
{
    std::uint64_t bytes = 0;
    std::string hash = {};
    bool operator==(const Fingerprint&) const = default;
};

Fingerprint fingerprint(const fs::path& path)
{
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    std::vector<char> piece(std::size_t{1} << 20);
    Fingerprint found;
    while (file) {
        file.read(piece.data(), std::ssize(piece));
        const auto size = to_size(file.gcount());
        found.bytes += size;
        found.hash = hash_text(piece.data(), size, found.hash);
    }
    if (!file.eof())
        throw FileError(join("cannot read ", path.string(), ": ", std::strerror(errno)));
    return found;
}

Json fingerprints(const fs::path& directory, const std::vector<std::string>& files)
{
    Json all = Json::array();
    for (const std::string& file : files) {
        const Fingerprint found = fingerprint(directory / file);
        all.push_back({{"name", file}, {"bytes", found.bytes}, {"hash", found.hash}});
    }
    return all;
}

/// A directory of a shard and what its manifest says.
struct Part
{
    fs::path directory;
    Json manifest;

    /// Of the files of its directory that are merged ("files"), or that lie beside them ("beside").
    [[nodiscard]] std::vector<std::string> names(const char* which) const
    {
        std::vector<std::string> all;
        for (const Json& file : manifest.at(which))
            all.push_back(file.at("name").get<std::string>());
        return all;
    }
    [[nodiscard]] bool is_of_fit() const
    {
        return std::ranges::count(names("beside"), report_name) > 0;
    }
};

[[noreturn]] void fail(const Part& part, const std::string& rule)
{
    throw InvalidInput(join(part.directory.string(), ": ", rule));
}

/// The shards beside the output, by their numbers.
std::map<int, Part> find_parts(const fs::path& output)
{
    const fs::path folder = output.has_parent_path() ? output.parent_path() : fs::path(".");
    const std::string stem = output.filename().string() + ".shard-";
    std::map<int, Part> parts;
    int count = 0;
    if (fs::is_directory(folder))
        for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
            const std::string name = entry.path().filename().string();
            if (!name.starts_with(stem) || !entry.is_directory())
                continue;
            Part part{entry.path(), {}};
            if (!fs::exists(part.directory / manifest_name))
                fail(part, "the shard is not finished; run it to its end, with --resume if it can");
            try {
                part.manifest =
                    Json::parse(read_file(part.directory / manifest_name, std::uint64_t{1} << 30));
                const int shards = small_integer(part.manifest.at("shards"), most_shards);
                const int number = small_integer(part.manifest.at("shard"), shards);
                if (count != 0 && shards != count)
                    fail(part, join("is one of ", shards, " shards, another is one of ", count,
                                    "; remove those of the earlier run"));
                count = shards;
                parts.emplace(number, std::move(part));
            } catch (const Json::exception&) {
                fail(part, join(manifest_name, " is not one that this program has written"));
            }
        }
    if (parts.empty())
        throw InvalidInput(join("there are no shards ", stem, "I-of-N in ", folder.string()));
    std::string missing;
    for (int number = 1; number <= count; ++number)
        if (!parts.contains(number))
            missing += join(missing.empty() ? "" : ", ", number);
    if (!missing.empty())
        throw InvalidInput(join(output.string(), ": of ", count,
                                " shards these are missing: ", missing, "; run them first"));
    return parts;
}

/// @param file  Of its manifest.
void check_file(const Part& part, const Json& file)
{
    const auto name = file.at("name").get<std::string>();
    const fs::path place = fs::path(name).lexically_normal();
    if (place.is_absolute() || place.empty() || *place.begin() == "..")
        fail(part, "its manifest names a file outside of it");
    if (!fs::is_regular_file(part.directory / name))
        fail(part, join("the file ", name, " is missing; run the shard again with --force"));
    const Fingerprint written{file.at("bytes").get<std::uint64_t>(),
                              file.at("hash").get<std::string>()};
    if (fs::file_size(part.directory / name) != written.bytes ||
        fingerprint(part.directory / name) != written)
        fail(part, join("the file ", name,
                        " is not as the shard wrote it; run the shard again with --force"));
}

void check_parts(const std::map<int, Part>& parts)
{
    const Json& first = parts.begin()->second.manifest;
    const auto total = first.at("total").get<std::size_t>();
    std::set<std::string> names;
    for (const auto& [number, part] : parts) {
        const Shard shard{number, static_cast<int>(parts.size())};
        if (part.manifest.at("total") != total ||
            part.manifest.at("settings") != first.at("settings"))
            fail(part, join("was made with other options or of other inputs than ",
                            parts.begin()->second.directory.string(), "; run it again"));
        if (part.manifest.at("own") != shard.own(total).size())
            fail(part, "its manifest is of another run");
        if (!part.manifest.contains("beside"))
            fail(part,
                 "was made by an earlier version, which did not note what its files hold; run the "
                 "shard again with --force");
        for (const std::string& file : part.names("files"))
            if (!names.insert(file).second)
                fail(part, join("the file ", file, " is in another shard too"));
        for (const char* which : {"files", "beside"})
            for (const Json& file : part.manifest.at(which))
                check_file(part, file);
    }
}

/// What lies in the directory of a shard, and is removed with it.
struct Contents
{
    std::vector<fs::path> own;   ///< Files and, before what is in them, directories.
    std::vector<fs::path> other; ///< What the shard has not written.
};

/// What this program leaves behind where it is killed.
bool is_left_behind(const fs::path& name)
{
    const std::string text = name.string();
    return text.starts_with(".shape") && text.ends_with(".tmp");
}

Contents contents(const Part& part)
{
    std::set<fs::path> known{manifest_name};
    for (const char* which : {"files", "beside"})
        for (const std::string& file : part.names(which))
            for (fs::path path = fs::path(file).lexically_normal(); !path.empty();
                 path = path.parent_path())
                known.insert(path);
    Contents found;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(part.directory)) {
        const fs::path path = entry.path().lexically_relative(part.directory);
        const bool is_own = known.contains(path) || is_left_behind(*path.begin());
        (is_own ? found.own : found.other).push_back(entry.path());
    }
    return found;
}

/// Refuses to remove what no shard has written; returns what is to be removed.
std::vector<fs::path> removable(const std::map<int, Part>& parts, const fs::path& output)
{
    std::vector<fs::path> own;
    std::vector<std::string> others;
    for (const auto& [number, part] : parts) {
        const Contents found = contents(part);
        own.push_back(part.directory);
        own.insert(own.end(), found.own.begin(), found.own.end());
        for (const fs::path& path : found.other)
            others.push_back(path.string());
    }
    if (others.empty())
        return own;
    std::ranges::sort(others);
    constexpr std::size_t most_named = 10;
    std::string named;
    for (std::size_t i = 0; i < std::min(others.size(), most_named); ++i)
        named += join(i == 0 ? "" : ", ", others[i]);
    if (others.size() > most_named)
        named += join(" and ", others.size() - most_named, " more");
    throw InvalidInput(join(output.string(),
                            ": not written by the shards, with whose directories it would be "
                            "removed: ",
                            named, "; move it elsewhere, then merge again"));
}

/// What is in a directory that shards are merged into, and is replaced, must be files without write protection.
void check_replaced(const std::map<int, Part>& parts, const fs::path& target)
{
    for (const auto& [number, part] : parts)
        for (const char* which : {"files", "beside"})
            for (const std::string& file : part.names(which)) {
                const fs::file_status status = fs::symlink_status(target / file);
                if (fs::exists(status) && !fs::is_regular_file(status))
                    throw FileError(
                        join((target / file).string(), ": exists and is not a regular file"));
                check_not_protected(target / file);
            }
}

/// Meshes, of the kind of those that were merged, that were in the directory before.
std::vector<std::string> other_meshes(const fs::path& target, const std::vector<std::string>& files)
{
    std::vector<std::string> others;
    for (const fs::directory_entry& entry : fs::directory_iterator(target)) {
        const fs::path name = entry.path().filename();
        if (!files.empty() && name.extension() == fs::path(files.front()).extension() &&
            std::ranges::count(files, name.string()) == 0)
            others.push_back(name.string());
    }
    std::ranges::sort(others);
    return others;
}

/// The report of `fit` over all scans in their order, with which `fit --resume` draws its table and sheet.
Json merged_report(const std::map<int, Part>& parts)
{
    std::vector<Json> reports;
    for (const auto& [number, part] : parts)
        reports.push_back(
            Json::parse(read_file(part.directory / report_name, std::uint64_t{256} << 20)));
    Json scans = Json::array();
    const auto total = parts.begin()->second.manifest.at("total").get<std::size_t>();
    for (std::size_t i = 0; i < total; ++i)
        scans.push_back(reports[i % reports.size()].at("scans").at(i / reports.size()));
    return {
        {"settings", reports.front().at("settings")}, {"scans", scans}, {"rounds", Json::array()}};
}

/// A second name of the file, or a copy where the file system has none.
void put(const fs::path& from, const fs::path& to)
{
    fs::create_directories(to.parent_path());
    std::error_code refused;
    fs::create_hard_link(from, to, refused);
    if (refused)
        fs::copy_file(from, to);
}

} // namespace

std::vector<std::size_t> Shard::own(std::size_t total) const
{
    const std::size_t step = is_given() ? to_size(count) : 1;
    if (is_given() && total < step)
        throw InvalidInput(join("--shard: ", counted(total, "mesh", "meshes"),
                                " to make are fewer than the ", count, " shards"));
    std::vector<std::size_t> numbers;
    for (std::size_t i = to_size(number - 1); i < total; i += step)
        numbers.push_back(i);
    return numbers;
}

fs::path Shard::directory(const fs::path& output) const
{
    fs::path path = without_slash(output);
    path += join(".shard-", number, "-of-", count);
    return path;
}

void add_shard(CLI::App& command, Shard& shard)
{
    if (ranks().count > 1)
        shard = {ranks().number + 1, ranks().count};
    command
        .add_option_function<std::string>(
            "--shard", [&shard](const std::string& text) { shard = read_shard(text); },
            "Make only every N-th mesh, from the I-th on, into OUT.shard-I-of-N/: for N runs that\n"
            "share the work, such as an array of jobs. `shape merge OUT` puts them together")
        ->option_text("I/N");
}

void check_merged_output(const Shard& shard, const fs::path& output)
{
    if (shard.is_given() && ranks().count > 1)
        check_is_new(without_slash(output));
}

void merge_shards_of_ranks(const Session& session, const fs::path& output)
{
    if (ranks().count == 1)
        return;
    wait_for_ranks();
    if (!ranks().is_root())
        return;
    const MergedShards merged = merge_shards(session, output);
    session.message(join(output.string(), ": ", counted(merged.things, "mesh", "meshes"), " by ",
                         ranks().count, " processes"));
}

std::vector<std::string> relative_to(const fs::path& directory,
                                     const std::vector<std::string>& paths)
{
    std::vector<std::string> result;
    for (const std::string& path : paths)
        result.push_back(fs::path(path)
                             .lexically_normal()
                             .lexically_relative(directory.lexically_normal())
                             .string());
    return result;
}

void write_shard_manifest(const fs::path& directory, const Shard& shard, std::size_t total,
                          const Json& settings, const std::vector<std::string>& files)
{
    std::vector<std::string> beside;
    if (fs::exists(directory / report_name))
        for (const char* name : files_of_fit)
            if (fs::exists(directory / name))
                beside.emplace_back(name);
    write_file_atomically(directory / manifest_name,
                          Json{{"shard", shard.number},
                               {"shards", shard.count},
                               {"total", total},
                               {"own", shard.own(total).size()},
                               {"settings", settings},
                               {"files", fingerprints(directory, files)},
                               {"beside", fingerprints(directory, beside)}}
                                  .dump(1, ' ', false, Json::error_handler_t::replace) +
                              "\n");
}

MergedShards merge_shards(const Session& session, const fs::path& output)
{
    const fs::path target = without_slash(output);
    check_target(target, session.force);
    const std::map<int, Part> parts = find_parts(target);
    const bool is_new = !fs::exists(target);
    if (is_new && !session.force)
        session.free_places->add(target);
    MergedShards merged{static_cast<int>(parts.size()), 0, {}};
    const fs::path staging =
        is_new ? target.parent_path() / join(".", target.filename().string(), ".", getpid(), ".tmp")
               : target / join(".shape.", getpid(), ".tmp");
    std::vector<fs::path> removed;
    try {
        check_parts(parts);
        removed = removable(parts, target);
        check_replaced(parts, target);
        merged.things = parts.begin()->second.manifest.at("total").get<std::size_t>();
        fs::create_directory(staging);
        for (const auto& [number, part] : parts)
            for (const std::string& file : part.names("files")) {
                put(part.directory / file, staging / file);
                merged.files.push_back(file);
            }
        if (parts.begin()->second.is_of_fit()) {
            write_file_atomically(staging / report_name, merged_report(parts).dump(1) + "\n");
            merged.files.emplace_back(report_name);
        }
        if (is_new) {
            move_into_place(staging, target);
        } else {
            for (const std::string& file : merged.files) {
                fs::create_directories((target / file).parent_path());
                move_into_place(staging / file, target / file);
            }
            fs::remove_all(staging);
            const std::vector<std::string> others = other_meshes(target, merged.files);
            if (!others.empty())
                session.warn(join(target.string(), ": holds ",
                                  counted(others.size(), "other mesh", "other meshes"),
                                  ", such as ", others.front(),
                                  "; who reads the directory takes them too"));
        }
    } catch (const Json::exception&) {
        fs::remove_all(staging);
        throw InvalidInput(join(output.string(),
                                ": a shard has a file in it that this program has "
                                "not written; run the shards again"));
    } catch (const fs::filesystem_error& error) {
        std::error_code ignored;
        fs::remove_all(staging, ignored);
        throw FileError(join("cannot write ", target.string(), ": ", error.code().message()));
    } catch (...) {
        std::error_code ignored;
        fs::remove_all(staging, ignored);
        throw;
    }
    // One by one, and directories when they are empty: what came meanwhile stays.
    for (auto path = removed.rbegin(); path != removed.rend(); ++path) {
        std::error_code ignored;
        fs::remove(*path, ignored);
    }
    return merged;
}

} // namespace shape::tools
