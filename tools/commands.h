// SPDX-License-Identifier: MIT

#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace shape::tools {

class Session;

/// What a subcommand does once its arguments are read. Failures are exceptions (see main.cpp).
using Run = std::function<void(const Session&)>;

// Each function describes one subcommand (its options, help and example) and returns what it does.
// A new one needs its file, its line here and its row in the table of main.cpp.
[[nodiscard]] Run set_up_check(CLI::App& command);
[[nodiscard]] Run set_up_classify(CLI::App& command);
[[nodiscard]] Run set_up_collect(CLI::App& command);
[[nodiscard]] Run set_up_conformal(CLI::App& command);
[[nodiscard]] Run set_up_difference(CLI::App& command);
[[nodiscard]] Run set_up_distance(CLI::App& command);
[[nodiscard]] Run set_up_draw(CLI::App& command);
[[nodiscard]] Run set_up_explore(CLI::App& command); // `report` too
[[nodiscard]] Run set_up_export(CLI::App& command);
[[nodiscard]] Run set_up_fit(CLI::App& command);
[[nodiscard]] Run set_up_generate(CLI::App& command);
[[nodiscard]] Run set_up_groups(CLI::App& command);
[[nodiscard]] Run set_up_info(CLI::App& command);
[[nodiscard]] Run set_up_interpolate(CLI::App& command);
[[nodiscard]] Run set_up_merge(CLI::App& command);
[[nodiscard]] Run set_up_project(CLI::App& command);
[[nodiscard]] Run set_up_quality(CLI::App& command);
[[nodiscard]] Run set_up_reconstruct(CLI::App& command);
[[nodiscard]] Run set_up_regress(CLI::App& command);
[[nodiscard]] Run set_up_remove(CLI::App& command);
[[nodiscard]] Run set_up_stats(CLI::App& command);
[[nodiscard]] Run set_up_synth(CLI::App& command);

} // namespace shape::tools
