// SPDX-License-Identifier: MIT

#pragma once

#include <nlohmann/json.hpp>

#include "libshape/embedding/embedder.h"
#include "tools/output/embedding_run.h"
#include "tools/output/mesh_output.h"
#include "tools/program/session.h"

namespace shape::tools {

/// What the mesh of a target depends on beside the target, as a run that goes on, or is put together of
/// several, compares it: the program, the seed and the options of the embedding.
[[nodiscard]] Json embedding_settings(const Session& session, const EmbeddingOptions& options);

/// What the files of a run depend on beside its targets, all shards of it alike: those settings, how meshes are written, and
/// what goes beside them.
[[nodiscard]] Json file_settings(const Session& session, const EmbeddingArguments& embedding,
                                 const MeshOutputArguments& output);

} // namespace shape::tools
