// SPDX-License-Identifier: MIT

#include "tools/output/shard.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/output_file.h"
#include "tools/program/arguments.h"
#include "tools/program/ranks.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr const char* manifest_name = "shard.json";
constexpr const char* report_name = "fit.json"; ///< Of `fit`, see merged_report().
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

void check_is_new(const fs::path& target)
{
    if (fs::exists(fs::symlink_status(target)))
        throw FileError(
            join(target.string(), ": exists already; shards are merged into a new one"));
}

/// A directory of a shard and what its manifest says.
struct Part
{
    fs::path directory;
    Json manifest;
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
                const int number = part.manifest.at("shard").get<int>();
                const int shards = part.manifest.at("shards").get<int>();
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
        for (const std::string file : part.manifest.at("files")) {
            const fs::path place = fs::path(file).lexically_normal();
            if (place.is_absolute() || place.empty() || *place.begin() == "..")
                fail(part, "its manifest names a file outside of it");
            if (!fs::is_regular_file(part.directory / file))
                fail(part, join("the file ", file, " is missing; run the shard again"));
            if (!names.insert(file).second)
                fail(part, join("the file ", file, " is in another shard too"));
        }
    }
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
        throw InvalidInput(join("--shard: there are ", total, " meshes to make, fewer than the ",
                                count, " shards"));
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
    if (!ranks().speaks())
        return;
    const MergedShards merged = merge_shards(output);
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
    write_file_atomically(directory / manifest_name,
                          Json{{"shard", shard.number},
                               {"shards", shard.count},
                               {"total", total},
                               {"own", shard.own(total).size()},
                               {"settings", settings},
                               {"files", files}}
                                  .dump(1, ' ', false, Json::error_handler_t::replace) +
                              "\n");
}

MergedShards merge_shards(const fs::path& output)
{
    const fs::path target = without_slash(output);
    check_is_new(target);
    const std::map<int, Part> parts = find_parts(target);
    MergedShards merged{static_cast<int>(parts.size()), 0, {}};
    const fs::path staging =
        target.parent_path() / join(".", target.filename().string(), ".", getpid(), ".tmp");
    try {
        check_parts(parts);
        merged.things = parts.begin()->second.manifest.at("total").get<std::size_t>();
        fs::create_directory(staging);
        for (const auto& [number, part] : parts)
            for (const std::string file : part.manifest.at("files")) {
                put(part.directory / file, staging / file);
                merged.files.push_back(file);
            }
        if (fs::exists(parts.begin()->second.directory / report_name)) {
            write_file_atomically(staging / report_name, merged_report(parts).dump(1) + "\n");
            merged.files.emplace_back(report_name);
        }
        fs::rename(staging, target);
    } catch (const Json::exception&) {
        fs::remove_all(staging);
        throw InvalidInput(join(output.string(),
                                ": a shard has a file in it that this program has "
                                "not written; run the shards again"));
    } catch (const fs::filesystem_error& error) {
        std::error_code ignored;
        fs::remove_all(staging, ignored);
        throw FileError(join("cannot write ", target.string(), ": ", error.code().message()));
    }
    for (const auto& [number, part] : parts)
        fs::remove_all(part.directory);
    return merged;
}

} // namespace shape::tools
