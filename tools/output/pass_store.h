// SPDX-License-Identifier: MIT

#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "libshape/statistics/pass_state.h"
#include "tools/program/session.h"

namespace shape::tools {

/// Where a run may keep what it has measured until it ends: beside its output.
[[nodiscard]] std::filesystem::path scratch_folder(const std::filesystem::path& output);

/// What a run that goes over its data in passes has found so far, kept beside the output as
/// OUTPUT.unfinished until the run ends, so that one that was killed can be resumed.
class PassStore
{
public:
    /// @param identity  What the passes depend on: an object of texts and numbers.
    /// @param seconds  At least this much time lies between two states that are kept.
    /// @throws FileError  if an interrupted run has left a state and neither resume nor --force is
    ///     given (--force alone discards it).
    /// @throws InvalidInput  if it was another run, or the file is damaged.
    PassStore(const Session& session, const std::filesystem::path& output, const Json& identity,
              bool resume, double seconds);

    /// Of the interrupted run; none if it has left nothing.
    [[nodiscard]] const std::optional<PassState>& state() const { return state_; }

    /// Keeps a state if it is time; warns once if it cannot be written.
    void save(const PassState& state);

    /// What to say when the run is stopped: where it can go on, if something was kept.
    [[nodiscard]] std::string on_interrupt() const;

    /// Removes what was kept: the run has ended well.
    void finish();

private:
    void write(const PassState& state) const;

    const Session& session_;
    std::filesystem::path file_;
    std::string identity_;
    double seconds_;
    bool has_warned_ = false;
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
    std::optional<PassState> state_;
};

} // namespace shape::tools
