// SPDX-License-Identifier: MIT

#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "libshape/base/progress.h"

namespace shape::python {

/// Runs work in a thread of its own while this one, without the GIL, waits for it and looks for signals
/// 25 times a second: Ctrl-C ends the wait at once, whatever the work is at. The work then stops at its
/// next call of Progress or chunk of a loop (base/stop.h), and what it makes is dropped; so it may hold no
/// reference to what Python owns.
/// @param callback  None, or called in this thread with (stage, done, total), at most 25 times a second
///     and at the end. What it raises ends the wait likewise.
void run_job(const std::function<void(const Progress&)>& work, const pybind11::object& callback);

/// The same for work with a result.
template <class Work>
auto run(Work work, const pybind11::object& callback = pybind11::none())
{
    using Result = decltype(work(std::declval<const Progress&>()));
    auto result = std::make_shared<std::optional<Result>>();
    auto kept = std::make_shared<Work>(std::move(work));
    run_job([result, kept](const Progress& progress) { *result = (*kept)(progress); }, callback);
    return std::move(**result);
}

/// Stops what still runs, and waits for it: before the interpreter ends.
void end_jobs();

} // namespace shape::python
