// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "tools/output/embedding_run.h"

namespace shape::tools {

/// Makes a directory if it is missing, and has it for itself. The lock ends with the process, however that ends.
class DirectoryLock
{
public:
    /// @throws FileError if another process has it, or it is not a directory.
    explicit DirectoryLock(const std::filesystem::path& directory);
    ~DirectoryLock();
    DirectoryLock(const DirectoryLock&) = delete;
    DirectoryLock& operator=(const DirectoryLock&) = delete;

private:
    int descriptor_ = -1;
};

/// The finished meshes of a run, kept in a directory until the run ends, so that an interrupted one
/// can be resumed: OUTPUT.unfinished beside the output, or `unfinished` in it if it is a directory
/// that exists. Its manifest says what run it belongs to.
class FrameStore
{
public:
    /// @param identity  What the meshes depend on: an object of texts.
    /// @param resume  Goes on with what an interrupted run has left, if there is anything.
    /// @throws FileError  if an interrupted run has left something and neither resume nor --force is
    ///     given (--force alone discards it), or if another run is at work there.
    /// @throws InvalidInput  if it was another run; names what differs.
    FrameStore(const Session& session, const std::string& output, const Json& identity,
               bool resume);

    /// Removes the directory unless keep() was called.
    ~FrameStore();
    FrameStore(const FrameStore&) = delete;
    FrameStore& operator=(const FrameStore&) = delete;

    /// The mesh to the bit; none if it was not finished or its file is damaged.
    [[nodiscard]] std::optional<FinishedMesh> read(std::size_t index) const;

    /// @throws FileError if it cannot be written.
    void write(std::size_t index, const FinishedMesh& mesh);

    /// Leaves the directory when the run ends; false if it holds no mesh.
    bool keep();

    [[nodiscard]] std::size_t count() const { return count_; } ///< Meshes in the directory.
    [[nodiscard]] std::string directory() const { return directory_.string(); }

private:
    [[nodiscard]] std::filesystem::path file(std::size_t index) const;

    std::filesystem::path directory_;
    DirectoryLock lock_;
    Json manifest_;
    std::size_t count_ = 0;
    bool keep_ = false;
};

/// A text that two values share only if they are equal to the bit, for all practical purposes:
/// 64-bit hash of the bytes, going on from `before`.
[[nodiscard]] std::string hash_text(const void* data, std::size_t bytes,
                                    const std::string& before = {});

} // namespace shape::tools
