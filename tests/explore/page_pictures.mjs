// SPDX-License-Identifier: MIT
//
// node page_pictures.mjs PROGRAM DATA FOLDER: the pictures of docs/explore.md, of pages that the program makes of the real meshes
// in DATA, photographed in Chromium. Needs playwright-core by NODE_PATH.

import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [program, data, target] = process.argv.slice(2).map((word) => resolve(word));
const { chromium } = createRequire(import.meta.url)("playwright-core");
const folder = mkdtempSync(join(tmpdir(), "shape_pictures_"));
const shape = (...args) => execFileSync(program, [...args, "--quiet"], { cwd: folder });
const desktop = { viewport: { width: 1280, height: 860 } };
const phone = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2 };

const pictures = [
    { name: "explore_faces", collection: "ict_faces600", modes: 40, title: "600 faces, three expressions", colour: "displacement",
        hash: "s=1.5,-1.2,0.8,1", context: desktop, options: ["--color-by", "expression"] },
    { name: "explore_vertebrae", collection: "vertebrae", modes: 9, title: "L1 vertebrae of ten people", colour: "displacement",
        hash: "s=1.1,-0.6", context: desktop, options: [] },
    { name: "explore_phone", collection: "ict_faces600", modes: 40, title: "600 faces, three expressions", colour: "none",
        hash: "s=1.5,-1.2,0.8,1", context: phone, options: ["--color-by", "expression"] },
    { name: "explore_bodies_phone", collection: "mh_body_poses", modes: 20, title: "One body in 21 poses", colour: "edge",
        hash: "s=0.4,0.3", context: { ...phone, colorScheme: "dark" }, options: [] },
];

const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM || "/usr/bin/chromium",
    args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-background-networking"],
});
try {
    for (const { name, collection, modes, title, colour, hash, context, options } of pictures) {
        const labels = join(data, collection, "labels.csv");
        shape("stats", join(data, collection), ...(existsSync(labels) ? ["--labels", labels] : []), "-o", `${collection}.h5`, "--modes", String(modes), "--force");
        shape("explore", `${collection}.h5`, "-o", `${name}.html`, "--title", title, ...options);
        const page = await (await browser.newContext(context)).newPage();
        page.setDefaultTimeout(300_000);
        await page.goto(`${pathToFileURL(join(folder, `${name}.html`)).href}#${hash}`);
        await page.locator("#colour").selectOption(colour);
        await page.waitForFunction(() => window.explore?.settled && window.explore.means.fine);
        await page.waitForTimeout(1500); // until it is drawn smoothly
        await page.screenshot({ path: join(target, `${name}.png`) });
        await page.context().close();
    }
} finally {
    await browser.close();
    rmSync(folder, { recursive: true, force: true });
}
