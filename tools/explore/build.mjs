// SPDX-License-Identifier: MIT
//
// node build.mjs DECODER.wasm OUT.html: the page as one file with the decoder in it. What the program puts
// in has marks of its own: <!--shape:title-->, <!--shape:tables-->, <!--shape:pictures--> and <!--shape:data-->.

import { createRequire } from "node:module";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const { build } = createRequire(import.meta.url)("esbuild"); // found by NODE_PATH
const [wasm, out] = process.argv.slice(2);
const source = join(dirname(fileURLToPath(import.meta.url)), "src");

async function bundled(file, define = {}) {
    const result = await build({
        entryPoints: [join(source, file)], bundle: true, minify: true, write: false, format: "iife", target: "es2022",
        legalComments: "none", define, nodePaths: process.env.NODE_PATH ? [process.env.NODE_PATH] : [],
    });
    return result.outputFiles[0].text.replaceAll("</script", "<\\/script").trim();
}

const worker = await bundled("worker.ts");
const script = await bundled("main.ts", { WORKER_SOURCE: JSON.stringify(worker) });
const decoder = readFileSync(wasm).toString("base64");
const parts = {
    "/*shape:style*/": readFileSync(join(source, "style.css"), "utf8"),
    "/*shape:script*/": script,
    "<!--shape:data-->": `<!--shape:data-->\n<script type="text/plain" id="wasm">${decoder}</script>`,
};
let page = readFileSync(join(source, "page.html"), "utf8");
for (const [mark, text] of Object.entries(parts)) page = page.replace(mark, () => text);
const licences = "<!-- libshape: MIT licence. Contains three.js, MIT licence, Copyright 2010-2026 three.js authors. -->";
writeFileSync(out, page.replace("<head>", () => `<head>\n${licences}`));
