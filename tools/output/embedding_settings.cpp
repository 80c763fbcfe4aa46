// SPDX-License-Identifier: MIT

#include "tools/output/embedding_settings.h"

#include "libshape/base/format.h"
#include "libshape/base/version.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/table_file.h"
#include "tools/output/frame_store.h"

namespace shape::tools {
using namespace internal;

Json embedding_settings(const Session& session, const EmbeddingOptions& options)
{
    Json settings{
        {"program", version()},
        {"--method", name(options.method)},
        {"--quality", options.quality == EmbeddingQuality::Preview ? "preview" : "fine"},
        {"--smoothness", print_number(options.smoothness.value_or(default_smoothness))},
        {"--anchor", print_number(options.anchor.value_or(default_anchor))},
        {"--init",
         options.registration_start == RegistrationStart::Identity ? "identity" : "incremental"},
        {"--seed", join(session.seed)}};
    if (options.avoid_contact) // else settings are those of runs that knew no such option
        settings["--avoid-contact"] = "yes";
    return settings;
}

Json file_settings(const Session& session, const EmbeddingArguments& embedding,
                   const MeshOutputArguments& output)
{
    Json settings = embedding_settings(session, embedding.options);
    settings.update({{"--residuals", embedding.residuals},
                     {"--format", output.format.empty() ? "ply" : output.format},
                     {"--ascii", output.ascii},
                     {"--float", output.single_precision},
                     {"--colors", output.colours},
                     {"--template", ""}});
    if (!output.template_file.empty()) { // wherever it lies
        const std::string content = read_file(output.template_file, std::uint64_t{1} << 40);
        settings["--template"] = hash_text(content.data(), content.size());
    }
    return settings;
}

} // namespace shape::tools
