// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "libshape/base/progress.h"
#include "libshape/io/file/free_places.h"

namespace shape::tools {

/// JSON objects that keep the order in which their fields were added.
using Json = nlohmann::ordered_json;

/// The options that every subcommand has, and its ways to the terminal: stdout carries data, stderr
/// messages.
class Session
{
public:
    std::string command;      ///< Name of the subcommand.
    bool quiet = false;       ///< Nothing on stderr but errors.
    bool json = false;        ///< One JSON object on stdout instead of text.
    bool force = false;       ///< Existing outputs are overwritten.
    std::int64_t threads = 0; ///< 0: as many as there are processors.
    std::int64_t seed = 1;
    /// Outputs that did not exist when the run looked, without --force.
    std::shared_ptr<internal::FreePlaces> free_places = std::make_shared<internal::FreePlaces>();
    /// What people read instead of a text: `-` for standard streams (StandardStreams::readable()).
    std::function<std::string(const std::string&)> readable = [](const std::string& text) {
        return text;
    };

    /// Text on stderr, unless quiet or JSON is wanted.
    void message(const std::string& text) const;

    /// One line `shape: warning: ...` on stderr, unless quiet.
    void warn(const std::string& text) const;

    /// Text on stdout. A reader that has gone away (a closed pipe\) is not an error.
    /// @throws FileError if stdout cannot be written for another reason.
    void print(const std::string& text) const;

    /// The figures of the run on stdout, after the field `command`, if JSON is wanted.
    void print_figures(const Json& figures) const;

    /// Stops the work on an interrupt, and draws a bar with the time left if stderr is a terminal.
    [[nodiscard]] Progress progress() const;
};

/// One line `shape: error: ...` on stderr; control characters become spaces.
void report_error(const std::string& text);

} // namespace shape::tools
