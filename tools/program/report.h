// SPDX-License-Identifier: MIT

#pragma once

#include "tools/program/session.h"

namespace shape::tools {

/// Of the keys of --json: a new number where a key goes or comes to mean something else; further keys may
/// come without one.
constexpr int json_schema = 1;

/// If JSON is wanted: one object on stdout with `command`, `schema`, the figures that
/// Session::print_figures() was given and, of a run that failed, `error`. docs/json.md lists its keys.
/// @param error  Null, or the value of `error`.
/// @throws FileError as Session::print().
void print_report(const Session& session, const Json& error);

} // namespace shape::tools
