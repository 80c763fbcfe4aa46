// SPDX-License-Identifier: MIT
//
// What the tests in JavaScript share.

import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

/// Ends the test as skipped, in the words that tests/list_skipped reads.
export function skip(test, reason) {
    console.log(`${test}: Skipped\n${reason}\n`);
    process.exit(77);
}

/// A package by its file below NODE_PATH; the test ends as skipped if it is not there.
export async function needs(test, file) {
    const path = join(process.env.NODE_PATH, file);
    if (!existsSync(path)) skip(test, `node has no ${file.split("/")[0]} (tools/install_node_packages)`);
    return import(pathToFileURL(path).href);
}

/// The figures of a run.
export function shape(folder, ...words) {
    const output = execFileSync(process.env.SHAPE_PROGRAM, [...words, "--json", "--quiet"], { cwd: folder, encoding: "utf8" });
    return JSON.parse(output);
}

/// Calls `work` with a new folder, which goes afterwards.
export async function inFolder(work) {
    const folder = mkdtempSync(join(tmpdir(), "shape_client_"));
    try {
        await work(folder);
    } finally {
        rmSync(folder, { recursive: true });
    }
}
