// SPDX-License-Identifier: MIT

#pragma once

#include <nlohmann/json.hpp>

#include "libshape/embedding/embedder.h"
#include "tools/program/session.h"

namespace shape::tools {

/// What the mesh of a target depends on beside the target, as a run that goes on, or is put together of
/// several, compares it: the program, the seed and the options of the embedding.
[[nodiscard]] Json embedding_settings(const Session& session, const EmbeddingOptions& options);

} // namespace shape::tools
