// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/program/session.h"

namespace CLI {
class App;
}

namespace shape::tools {

/// One of several runs that share the meshes of a command: the 2nd of 8 makes meshes 1, 9, 17, ... of
/// 0, 1, 2, ... into a directory of its own, OUT.shard-2-of-8; `shape merge OUT` puts them together.
struct Shard
{
    int number = 1; ///< In [1, count].
    int count = 0;  ///< 0: the run makes everything.

    [[nodiscard]] bool is_given() const { return count > 0; }

    /// Those of `total` things that are the shard's, ascending; all without a shard.
    /// @throws InvalidInput if there are fewer things than shards.
    [[nodiscard]] std::vector<std::size_t> own(std::size_t total) const;

    /// Where its files go.
    [[nodiscard]] std::filesystem::path directory(const std::filesystem::path& output) const;
};

/// Adds --shard I/N. Processes that mpirun has started have a shard each without it.
/// @throws UsageError  when parsed, if both are given.
void add_shard(CLI::App& command, Shard& shard);

/// Before a shard is made: whether what the shards of mpirun are merged into is there already.
/// @throws FileError if it is.
void check_merged_output(const Shard& shard, const std::filesystem::path& output);

/// When a shard is made: the first of several processes waits for the others and puts all shards together.
/// A shard of --shard stays as it is.
void merge_shards_of_ranks(const Session& session, const std::filesystem::path& output);

/// The same paths as they are in a directory.
[[nodiscard]] std::vector<std::string> relative_to(const std::filesystem::path& directory,
                                                   const std::vector<std::string>& paths);

/// Writes shard.json into the directory of the shard, last of all its files: what it has made, of what,
/// with size and hash of each file.
/// @param settings  What all shards of the run must have in common.
/// @param files  Of its directory: those that must be there.
void write_shard_manifest(const std::filesystem::path& directory, const Shard& shard,
                          std::size_t total, const Json& settings,
                          const std::vector<std::string>& files);

/// What merge_shards() has put together.
struct MergedShards
{
    int shards = 0;
    std::size_t things = 0;         ///< Meshes or scans that the shards had between them.
    std::vector<std::string> files; ///< In the new directory.
};

/// Puts the files of all shards of a directory into it and removes theirs. Nothing is changed before all
/// of them are known to be there, of one run, complete, and as they were written. The directory appears
/// as a whole; one that exists is, with --force, written into, over files of the same names.
/// @throws InvalidInput naming the shards that are missing, differ, or lack a file, or have one that is
///     not as it was written; or files in their directories that are not theirs.
/// @throws FileError if the directory exists already and --force is not given, or the system refuses.
[[nodiscard]] MergedShards merge_shards(const Session& session,
                                        const std::filesystem::path& output);

} // namespace shape::tools
