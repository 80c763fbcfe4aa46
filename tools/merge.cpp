// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "tools/commands.h"
#include "tools/output/shard.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;

Run set_up_merge(CLI::App& command)
{
    command.description(
        "Put the shards of a command together, OUT.shard-1-of-N to OUT.shard-N-of-N as --shard "
        "has\n"
        "made them, once all of them are there, complete, of one run and as they were written:\n"
        "their files go into OUT, and they are removed. Nothing is changed before that is known.\n"
        "An OUT that exists is, with --force, written into, over files of the same names.");
    command.footer(
        "Example:\n"
        "  shape generate model.h5 -o many/ --sample 1000 --shard 1/2\n"
        "  shape generate model.h5 -o many/ --sample 1000 --shard 2/2\n"
        "  shape merge many/");
    const auto output = std::make_shared<std::string>();
    command.add_option("OUT", *output, "The directory that the commands named as -o")
        ->required()
        ->option_text("REQUIRED");
    return [output](const Session& session) {
        const MergedShards merged = merge_shards(session, *output);
        session.message(join(*output, ": ", counted(merged.files.size(), "file"), " of ",
                             counted(to_size(merged.shards), "shard")));
        session.print_figures({{"outputs", {*output}},
                               {"shards", merged.shards},
                               {"meshes", merged.things},
                               {"files", merged.files}});
    };
}

} // namespace shape::tools
