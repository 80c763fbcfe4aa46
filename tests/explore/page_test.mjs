// SPDX-License-Identifier: MIT
//
// node page_test.mjs PROGRAM: makes models and their pages with the program and uses them in Chromium as a person
// would. Exit code 77 if playwright-core, axe-core or Chromium is missing.
//
// node page_test.mjs PROGRAM rates DATA: prints instead how fast drags of ten modes become meshes, for models of
// the real meshes in DATA and of made-up faces. Takes minutes.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [program, task, data] = process.argv.slice(2).map((word, i) => (i === 1 ? word : resolve(word)));
const require = createRequire(import.meta.url);
const chromiumPath = process.env.CHROMIUM || "/usr/bin/chromium";
let chromium, axeSource;
try {
    ({ chromium } = require("playwright-core"));
    axeSource = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
    if (!existsSync(chromiumPath)) throw new Error(`no ${chromiumPath}`);
} catch (error) {
    console.log(`skipped: ${error.message.split("\n")[0]}`);
    process.exit(77);
}

const patience = 300_000; // [ms]; machines that build and test are busy
const folder = mkdtempSync(join(tmpdir(), "shape_page_"));
const file = (name) => join(folder, name);
const shape = (...args) => JSON.parse(execFileSync(program, [...args, "--json", "--quiet", "--force"], { encoding: "utf8", cwd: folder }));

const browser = await chromium.launch({
    executablePath: chromiumPath,
    // WebGL by software, as in a browser that finds no graphics card. `--use-angle=swiftshader` would have it believe that there
    // is one: then the page itself is put together by WebGL too, 33 ms for each change of a word.
    args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-background-networking"],
});
const tests = [];
const test = (name, run) => tests.push({ name, run });

/// A page, opened from disk, that has said nothing wrong.
async function open(name, { width = 1280, height = 860, hash = "", colorScheme = "light", before } = {}) {
    const context = await browser.newContext({ viewport: { width, height }, acceptDownloads: true, colorScheme });
    const page = await context.newPage();
    page.setDefaultTimeout(patience);
    page.faults = [];
    page.on("pageerror", (error) => page.faults.push(error.message));
    page.on("console", (line) => line.type() === "error" && page.faults.push(line.text()));
    page.on("request", (request) => /^(https?|ftp):/.test(request.url()) && page.faults.push(`asked the network for ${request.url()}`));
    if (before) await page.addInitScript(before);
    await page.goto(pathToFileURL(file(name)).href + hash, { waitUntil: "commit", timeout: patience });
    return page;
}
const settled = (page) => page.waitForFunction(() => window.explore?.settled, null, { timeout: patience });
async function close(page) {
    assert.deepEqual(page.faults, []);
    await page.context().close();
}
/// Does something and waits for the fine mesh.
async function after(page, act) {
    const before = await page.evaluate(() => window.explore.shapes);
    await act();
    await page.waitForFunction((count) => window.explore.shapes > count && window.explore.settled, before, { timeout: patience });
}
const scores = (page) => page.evaluate(() => window.explore.place.scores);
const digits = (a, b, name) => assert.ok(Math.abs(a - b) <= 1e-3 * Math.abs(b) + 1e-12, `${name}: ${a} on the page, ${b} by the program`);

/// To three digits.
function compare(certificate, figures) {
    assert.equal(certificate.status, figures.status);
    digits(certificate.edgeRms, figures.edge_rms, "edge RMS");
    digits(certificate.edgeMax, figures.edge_max, "worst edge");
    digits(certificate.driftP99, figures.dihedral_p99_deg, "drift");
    assert.equal(certificate.invertedFaces, figures.inverted_faces);
    if (certificate.crossings < 0) return; // counted of the fine mesh alone
    assert.equal(certificate.crossings, figures.self_intersections);
    assert.equal(certificate.newCrossings, figures.new_self_intersections);
}

test("the certificate is that of the program", async () => {
    const page = await open("faces.html");
    await settled(page);
    const facts = await page.evaluate(() => window.explore.facts);
    const points = Array.from({ length: 20 }, (_, i) =>
        facts.modes.map((mode, k) => Number((1.2 * Math.sin(7.3 * i + 2.9 * k * k + 1)).toFixed(4))));
    const rows = points.map((point, i) => [`p${i}`, ...point.map((value, k) => value * facts.modes[k].deviation)].join(","));
    writeFileSync(file("points.csv"), [["mesh", ...facts.modes.map((_, k) => `pc${k + 1}`)].join(","), ...rows].join("\n") + "\n");
    const native = Object.fromEntries(["preview", "fine"].map((quality) =>
        [quality, shape("generate", "faces.h5", "--scores-file", "points.csv", "--quality", quality, "-o", `points_${quality}/`).embeddings]));
    let milliseconds = 0;
    for (const [i, point] of points.entries()) {
        await after(page, () => page.evaluate((to) => window.explore.goTo({ ...window.explore.place, scores: to }), point));
        const { preview, fine } = await page.evaluate(() => ({ preview: window.explore.preview, fine: window.explore.shown }));
        compare(preview.certificate, native.preview[i]);
        compare(fine.certificate, native.fine[i]);
        assert.ok(fine.certificate.crossings >= 0);
        milliseconds += preview.milliseconds / points.length;
        for (const [id, value] of [["#edge-rms", 100 * native.fine[i].edge_rms], ["#edge-max", 100 * native.fine[i].edge_max],
            ["#drift", native.fine[i].dihedral_p99_deg]])
            assert.equal(parseFloat(await page.locator(id).textContent()), Number(value.toPrecision(3)), `${id} as it is written`);
    }
    console.log(`  preview of ${native.preview[0].vertices} vertices: ${milliseconds.toFixed(1)} ms on the page, ` +
        `${(1000 * native.preview.reduce((sum, { seconds }) => sum + seconds, 0) / points.length).toFixed(1)} ms by the program`);
    await close(page);
});

test("every way to move moves, and undo goes back", async () => {
    const page = await open("faces.html");
    await settled(page);
    await after(page, () => page.locator("#modes input[type=range]").first().fill("1.5"));
    assert.equal((await scores(page))[0], 1.5);
    const field = page.locator("#modes input[type=text]").nth(1);
    await after(page, () => field.fill("-0.75").then(() => field.press("Enter")));
    assert.equal((await scores(page))[1], -0.75);
    await field.fill("a lot");
    await field.press("Enter");
    assert.equal(await field.getAttribute("aria-invalid"), "true");
    assert.equal((await scores(page))[1], -0.75);
    await page.locator("#typed").selectOption("scores");
    const deviation = await page.evaluate(() => window.explore.facts.modes[1].deviation);
    await after(page, () => field.fill(String(0.5 * deviation)).then(() => field.press("Enter")));
    assert.equal((await scores(page))[1], 0.5);
    await after(page, () => page.locator("#undo").click());
    assert.deepEqual((await scores(page)).slice(0, 2), [1.5, -0.75]);
    await after(page, () => page.locator("#redo").click());
    await after(page, () => page.keyboard.press("Control+z"));
    assert.equal((await scores(page))[1], -0.75);

    await after(page, () => page.locator("#mean").click());
    assert.ok((await scores(page)).every((score) => score === 0));
    await after(page, () => page.locator("#random").click());
    assert.ok((await scores(page)).some((score) => score !== 0));
    assert.notEqual(await page.evaluate(() => window.explore.shown.certificate.reason.includes("triangle")), true);

    // the plot: a mesh, the point by keys and by hand
    await after(page, () => page.locator(".specimen").nth(4).dispatchEvent("click"));
    assert.equal(await page.locator("#specimen").inputValue(), "4");
    assert.match(await page.locator("#specimen-facts").textContent(), /size/);
    const before = await scores(page);
    await page.locator(".point").focus();
    await after(page, () => page.keyboard.press("ArrowRight"));
    assert.ok(Math.abs((await scores(page))[0] - before[0] - 0.1) < 1e-3);
    const grip = await page.locator(".point .grip").boundingBox();
    await after(page, async () => {
        await page.mouse.move(grip.x + grip.width / 2, grip.y + grip.height / 2);
        await page.mouse.down();
        await page.mouse.move(grip.x + grip.width / 2 + 20, grip.y + grip.height / 2 - 15, { steps: 4 });
        await page.mouse.up();
    });
    assert.ok((await scores(page))[0] > before[0] + 0.1);
    // A click on the ring that moves nothing is for the mesh beneath, or nobody.
    await after(page, () => page.locator(".specimen").nth(4).dispatchEvent("click"));
    await after(page, () => page.locator("#modes input[type=range]").nth(3).fill("0.5"));
    assert.equal(await page.locator("#specimen").inputValue(), "");
    const ring = await page.locator(".point .grip").boundingBox();
    await after(page, () => page.mouse.click(ring.x + ring.width / 2, ring.y + ring.height / 2));
    assert.equal(await page.locator("#specimen").inputValue(), "4");
    const there = await scores(page);
    await page.mouse.click(ring.x + 2, ring.y + ring.height / 2, { button: "right" });
    assert.deepEqual(await scores(page), there);
    await page.locator("#axis-y").selectOption("2");

    await after(page, () => page.locator("#groups button").first().click());
    assert.match(await page.locator("#said").textContent(), /mean of/i);
    await after(page, () => page.locator("#additions input[type=range]").first().fill("1"));
    assert.equal(await page.evaluate(() => window.explore.place.values[0]), 1);
    await after(page, () => page.locator("#additions input[type=range]").nth(1).fill("0.5"));
    assert.equal(await page.evaluate(() => window.explore.place.amounts[0]), 0.5);
    assert.match(await page.locator("#command").textContent(), /^None/);
    const play = page.locator("#modes .play").first();
    const shapes = await page.evaluate(() => window.explore.shapes);
    await play.click();
    await page.waitForFunction((count) => window.explore.shapes > count + 3, shapes, { timeout: patience });
    await after(page, () => play.click());
    await close(page);
});

test("a link restores the place", async () => {
    const page = await open("faces.html", { hash: "#s=1,-0.5,0.25&d=0.5&r=0.4" });
    await settled(page);
    assert.deepEqual((await scores(page)).slice(0, 3), [1, -0.5, 0.25]);
    assert.deepEqual(await page.evaluate(() => [window.explore.place.amounts, window.explore.place.values]), [[0.5], [0.4]]);
    await after(page, () => page.locator("#mean").click());
    assert.equal(new URL(page.url()).hash, "");
    await after(page, () => page.locator("#undo").click());
    await after(page, () => page.locator("#random").click());
    const link = page.url();
    const wanted = await scores(page);
    await close(page);
    const other = await open("faces.html", { hash: new URL(link).hash });
    await settled(other);
    assert.deepEqual(await scores(other), wanted);
    await close(other);
});

test("a link that is none says so and changes nothing", async () => {
    for (const [hash, wanted] of [["#s=1%2C-0.5", [1, -0.5]], ["#s=1&amp;d=0.5", [1, 0]], ["#s=0,1", [0, 1]]]) {
        const page = await open("faces.html", { hash });
        await settled(page);
        assert.deepEqual((await scores(page)).slice(0, 2), wanted, hash);
        await close(page);
    }
    const page = await open("faces.html", { hash: "#s=1,x" });
    await settled(page);
    assert.match(await page.locator("#said").textContent(), /address/);
    for (const hash of ["#s=abc", "#s=,1", "#s=1,,2", "#__proto__=1", "#tables", "#s=1e400", "#s=" + "1,".repeat(50) + "1"]) {
        await page.evaluate((hash) => (location.hash = hash), hash);
        await page.waitForFunction(() => location.hash === "", null, { timeout: patience });
        assert.match(await page.locator("#said").textContent(), /address/, hash);
        assert.ok((await scores(page)).every((score) => score === 0), hash);
    }
    await close(page);
});

test("where there is no mesh none is shown as if there were", async () => {
    for (const hash of ["", "#s=1e300"]) {
        const page = await open("faces.html", { hash });
        if (!hash) {
            await settled(page);
            const field = page.locator("#modes input[type=text]").first();
            await field.fill("1e300");
            await field.press("Enter");
        }
        await page.waitForFunction(() => document.querySelector("#status").textContent === "no mesh", null, { timeout: patience });
        assert.match(await page.locator("#reason").textContent(), /There is no mesh here/);
        assert.equal(await page.locator("#edge-rms").textContent(), "");
        await page.locator("[data-save=ply]").click();
        await page.waitForFunction(() => /no mesh to save/.test(document.querySelector("#said").textContent), null, { timeout: patience });
        assert.match(await page.locator("#command").textContent(), /^None: there is no mesh/);
        const download = page.waitForEvent("download");
        await after(page, () => page.evaluate(() => (document.querySelector("#mean").click(), document.querySelector("[data-save=ply]").click())));
        assert.equal((await download).suggestedFilename(), "faces_mean.ply");
        assert.equal(await page.locator("#status").textContent(), "approximate");
        assert.ok(await page.locator("#waiting").isHidden());
        await close(page);
    }
});

test("a regression of some meshes goes through their mean", async () => {
    const page = await open("partial.html");
    await settled(page);
    assert.ok((await scores(page)).every((score) => score === 0));
    await after(page, () => page.locator("#additions input[type=range]").first().fill("1.25"));
    const { facts, value, shown, rest } = await page.evaluate(() => ({
        facts: window.explore.facts, value: window.explore.place.values[0],
        shown: Array.from(window.explore.shown.points), rest: document.querySelector("#command").textContent,
    }));
    const with_ = facts.specimens.filter((_, i) => facts.labels.find(({ name }) => name === "height").values[i]);
    const heights = facts.labels.find(({ name }) => name === "height").values.filter(Boolean).map(Number);
    const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
    const middle = mean(heights);
    const spread = heights.reduce((sum, height) => sum + (height - middle) ** 2, 0);
    const wanted = facts.modes.map(({ deviation }, k) => {
        const y = with_.map(({ scores }) => scores[k]);
        const slope = y.reduce((sum, score, i) => sum + score * (heights[i] - middle), 0) / spread;
        return (mean(y) + slope * (value - middle)) / deviation;
    });
    const told = rest.match(/--scores=([-\d.,]+)/)[1].split(",").map(Number);
    told.forEach((score, k) => assert.ok(Math.abs(score - wanted[k]) < 1e-3, `mode ${k + 1}: ${score}, wanted ${wanted[k]}`));
    assert.ok(shown.every(Number.isFinite));
    assert.match(await page.locator("#additions .name").first().textContent(), new RegExp(`of ${heights.length} meshes`));
    await close(page);
});

test("the mean is nowhere displaced from itself", async () => {
    const page = await open("faces.html");
    await settled(page);
    await page.locator("#colour").selectOption("displacement");
    await page.waitForFunction(() => !document.querySelector("#legend").hidden, null, { timeout: patience });
    await page.waitForFunction(() => window.explore.means.fine, null, { timeout: patience });
    await after(page, () => page.locator("#modes input[type=range]").first().fill("1"));
    const displaced = () => page.evaluate(() => Math.max(...window.explore.shown.points.map((value, i) => Math.abs(value - window.explore.means.fine.points[i]))));
    assert.ok(await displaced() > 0);
    await after(page, () => page.locator("#mean").click());
    assert.equal(await displaced(), 0);
    await close(page);
});

test("the key of many numbers says them", async () => {
    const page = await open("years.html");
    await settled(page);
    assert.deepEqual(await page.locator(".key span").allTextContents(), ["1990", "1992.8", "1995.5", "1998.3", "2001", "no value"]);
    await close(page);
});

test("nothing lies over what one clicks", async () => {
    for (const [width, height] of [[1280, 600], [1366, 768], [1920, 1080], [844, 390], [640, 360], [390, 844]]) {
        const page = await open("faces.html", { width, height, hash: "#s=-6" });
        await settled(page);
        for (const button of await page.locator("#take button, #controls button:visible").all()) {
            await button.evaluate((element) => element.scrollIntoView({ block: "center" }));
            const isFree = await button.evaluate((element) => {
                const { x, y, width, height } = element.getBoundingClientRect();
                const top = document.elementFromPoint(x + width / 2, y + height / 2);
                return element === top || element.contains(top);
            });
            assert.ok(isFree, `${width} x ${height}: ${await button.textContent()}`);
        }
        await close(page);
    }
});

test("what is taken away is what is shown", async () => {
    const page = await open("faces.html", { hash: "#s=1.2,-0.8" });
    await settled(page);
    const saved = {};
    for (const kind of ["ply", "obj", "glb", "png", "svg", "csv"]) {
        const [download] = await Promise.all([page.waitForEvent("download"), page.locator(`[data-save=${kind}]`).click()]);
        saved[kind] = file(`saved_${kind}.${kind}`);
        assert.match(download.suggestedFilename(), new RegExp(`^faces_pc1\\+1\\.20_pc2-0\\.80(_scores)?\\.${kind}$`));
        await download.saveAs(saved[kind]);
    }
    const vertices = await page.evaluate(() => window.explore.shown.points.length / 3);
    const farthest = (...meshes) => {
        shape("distance", ...meshes, "-o", "d.csv");
        const lines = readFileSync(file("d.csv"), "utf8").trim().split("\n").slice(1);
        return Math.max(...lines.flatMap((line) => line.split(",").slice(1).map(Number)));
    };
    assert.ok(farthest(saved.ply, saved.obj) < 1e-12);
    const glb = readFileSync(saved.glb);
    assert.equal(glb.readUInt32LE(0), 0x46546c67);
    assert.equal(JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)).toString()).accessors[0].count, vertices);
    assert.equal(readFileSync(saved.png).subarray(1, 4).toString(), "PNG");
    assert.match(readFileSync(saved.svg, "utf8"), /^<svg/);
    // While something moves the fine mesh of the place is waited for.
    const moved = await page.evaluate(() => {
        window.explore.goTo({ ...window.explore.place, scores: window.explore.place.scores.map((_, k) => (k === 0 ? -1 : 0)) });
        document.querySelector("[data-save=ply]").click();
        window.explore.goTo({ ...window.explore.place, scores: window.explore.place.scores.map((_, k) => (k === 1 ? 0.5 : 0)) });
        return window.explore.shown.quality;
    });
    assert.equal(moved, "fine"); // of the place before; then one moves on
    const late = await page.waitForEvent("download");
    assert.equal(late.suggestedFilename(), "faces_pc1-1.00.ply");
    await late.saveAs(file("late.ply"));
    assert.match(readFileSync(file("late.ply"), "latin1"), /comment faces.h5, s=-1, fine, by libshape/);
    shape("generate", "faces.h5", "--scores=-1", "-o", "late_again.ply");
    assert.ok(farthest("late.ply", "late_again.ply") < 1e-12);
    await after(page, () => page.locator("#additions input[type=range]").nth(1).fill("1"));
    assert.ok(await page.locator("[data-save=csv]").isDisabled()); // scores hold no differences
    await after(page, () => page.evaluate(() => window.explore.goTo({ ...window.explore.place, amounts: [0], scores: window.explore.place.scores.map((_, k) => [1.2, -0.8][k] ?? 0) })));
    // The scores and the command line make the same mesh.
    shape("generate", "faces.h5", "--scores-file", saved.csv, "-o", "again/");
    const command = await page.locator("#command").textContent();
    const args = command.replace(/^shape /, "").replace(/-o .*/, "-o command.ply").split(" ");
    shape(...args);
    assert.ok(farthest("command.ply", "again", saved.ply) < 1e-4);
    await close(page);
});

test("what one sees can be chosen", async () => {
    const page = await open("faces.html", { hash: "#s=-6" });
    await settled(page);
    assert.equal(await page.locator("#status").textContent(), "infeasible");
    assert.ok(await page.locator("#reason").isVisible());
    assert.ok(await page.evaluate(() => window.explore.shown.broken.length > 0));
    assert.ok(await page.locator("#modes .slider").first().evaluate((row) => row.classList.contains("outside")));
    for (const colour of ["displacement", "edge", "drift", "effects"]) {
        await page.locator("#colour").selectOption(colour);
        assert.ok(await page.locator("#legend").isVisible());
        assert.notEqual(await page.locator("#legend-high").textContent(), "");
    }
    assert.ok(await page.locator("#ghost option[value=pin]").isDisabled());
    await page.locator("#pin").click();
    for (const ghost of ["mean", "pin", "none"]) await page.locator("#ghost").selectOption(ghost);
    for (const view of ["back", "left", "right", "top", "bottom", "front"]) await page.locator("#view").selectOption(view);
    await page.locator("#wireframe").check();
    await page.locator("#canvas").focus();
    for (const key of ["ArrowLeft", "ArrowUp", "Shift+ArrowRight", "+", "-", "3", "1", "g", "w", "f"]) await page.keyboard.press(key);
    assert.equal(await page.locator("#ghost").inputValue(), "mean");
    await page.waitForFunction(() => /meshes\/s/.test(document.querySelector("#frames").textContent), null, { timeout: patience });
    await close(page);
});

test("while something moves the processor draws what WebGL draws at rest", async () => {
    // Light found at vertices is the same as at pixels where faces are small; of sixteen faces the places alone are.
    for (const [name, hash, colour, most] of [["faces.html", "#s=-6", "none", 4], ["faces.html", "#s=1,2", "displacement", 4], ["small.html", "", "none", 30]]) {
        const page = await open(name, { hash });
        await settled(page);
        await page.locator("#colour").selectOption(colour);
        for (const view of ["front", "left", "back"]) {
            await page.locator("#view").selectOption(view);
            const { filled, apart, off } = await page.evaluate(async () => {
                await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
                const sheet = document.querySelector("canvas.sheet");
                const { width, height } = sheet;
                const pixels = (...pictures) => {
                    const context = new OffscreenCanvas(width, height).getContext("2d");
                    for (const picture of pictures) context.drawImage(picture, 0, 0, width, height);
                    return context.getImageData(0, 0, width, height).data;
                };
                const ground = new OffscreenCanvas(width, height);
                Object.assign(ground.getContext("2d"), { fillStyle: "#00ff00" }).fillRect(0, 0, width, height);
                const own = pixels(ground, sheet);
                const theirs = pixels(await createImageBitmap(await window.explore.viewer.picture("#00ff00")));
                let [filled, apart, off] = [0, 0, 0];
                for (let i = 0; i < own.length; i += 4) {
                    if (own[i + 1] === 255 && own[i] === 0) continue;
                    const difference = Math.max(...[0, 1, 2].map((k) => Math.abs(own[i + k] - theirs[i + k])));
                    ++filled;
                    apart += difference;
                    if (difference > 40) ++off;
                }
                return { filled, apart: apart / filled, off: off / filled };
            });
            assert.ok(filled > 3000, `${name}, ${view}: ${filled} pixels`);
            assert.ok(apart < most, `${name}, ${view}: ${apart} of 255 apart on average`);
            assert.ok(off < 0.02, `${name}, ${view}: ${off} of the pixels are others`); // along the silhouette, that WebGL smooths
        }
        await close(page);
    }
});

test("anybody can read it", async () => {
    for (const [width, colorScheme] of [[1280, "light"], [390, "light"], [390, "dark"]]) {
        const page = await open("faces.html", { width, height: 844, colorScheme });
        await settled(page);
        await page.locator("#tables summary").click();
        await page.locator("#help summary").click();
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `it is wider than ${width} px`);
        await page.evaluate(axeSource);
        const { violations } = await page.evaluate(() => window.axe.run());
        const serious = violations.filter(({ impact }) => impact === "serious" || impact === "critical");
        assert.deepEqual(serious.map(({ id, nodes }) => `${id}: ${nodes[0].html}`), []);
        await close(page);
    }
});

test("a browser that cannot says so and shows what there is", async () => {
    for (const before of ["delete window.WebAssembly", "HTMLCanvasElement.prototype.getContext = () => null"]) {
        const page = await open("faces.html", { before });
        await page.locator("#fallback .warning").waitFor();
        assert.match(await page.locator("#fallback .warning").textContent(), /has no Web(Assembly|GL)/);
        assert.ok(await page.locator("#fallback svg").first().isVisible());
        assert.ok(await page.locator("#tables table").isVisible());
        page.faults = page.faults.filter((fault) => !/WebGL/.test(fault)); // three.js tells as well
        await close(page);
    }
});

test("models of every kind open", async () => {
    for (const [name, status] of [["procrustes.html", "exact"], ["one_mode.html", null], ["small.html", null]]) {
        const page = await open(name);
        await settled(page);
        await after(page, () => page.locator("#modes input[type=range]").first().fill("1"));
        const { certificate } = await page.evaluate(() => window.explore.shown);
        if (status) assert.equal(certificate.status, status);
        assert.ok(Number.isFinite(certificate.edgeRms));
        await close(page);
    }
});

test("drafts fill in where previews are slow, and say so", async () => {
    const page = await open("faces.html");
    await settled(page);
    const kinds = await page.evaluate(async () => {
        const kinds = [];
        const quality = document.querySelector("#quality");
        new MutationObserver(() => kinds.push(quality.textContent)).observe(quality, { childList: true });
        window.explore.decoder.frame = 0; // [ms]; as if no preview came in time
        window.explore.goTo({ ...window.explore.place, scores: window.explore.place.scores.map((_, k) => 0.8 * Math.cos(k)) });
        while (!window.explore.settled) await new Promise((next) => setTimeout(next, 5));
        return kinds;
    });
    assert.deepEqual(kinds, ["draft", "preview", "fine"]);
    const [draft, preview] = await page.evaluate(() => window.explore.last.map(({ certificate }) => certificate.edgeRms));
    assert.ok(draft > 0 && draft !== preview && draft < 3 * preview, `edge RMS of the draft ${draft}, of the preview ${preview}`);
    await close(page);
});

test("a pinned draft stays, and its place gives the same draft again", async () => {
    const page = await open("faces.html");
    await settled(page);
    const { first, again, ghost } = await page.evaluate(async () => {
        const { decoder, goTo } = window.explore;
        decoder.frame = 0; // [ms]; as if no preview came in time
        decoder.calmMilliseconds = 1e6; // and nothing followed
        const draftAt = async (t) => {
            const before = window.explore.shapes;
            goTo({ ...window.explore.place, scores: window.explore.place.scores.map((_, k) => 0.8 * Math.cos(t * k + t)) });
            while (window.explore.shapes === before) await new Promise((next) => setTimeout(next, 5));
            return Array.from(window.explore.shown.points);
        };
        const first = await draftAt(1);
        document.querySelector("#pin").click();
        for (const t of [2, 3, 4]) await draftAt(t);
        const kind = document.querySelector("#ghost");
        for (const value of ["none", "pin"]) (kind.value = value), kind.dispatchEvent(new Event("change"));
        const ghost = Array.from(window.explore.viewer.ghostGeometry.attributes.position.array);
        return { first, again: await draftAt(1), ghost };
    });
    assert.deepEqual(again, first);
    assert.deepEqual(ghost, Array.from(Float32Array.from(first)));
    await close(page);
});

test("two hundred modes and where they come from", async () => {
    const page = await open("many.html");
    await settled(page);
    assert.equal(await page.title(), "Many modes");
    const told = await page.locator("#tables").textContent();
    for (const text of ["Scanned on <Tuesdays> & at night", "many.h5", "204", "smoothness 0.005", "shape "]) assert.ok(told.includes(text), text);
    assert.equal(await page.locator("#modes .slider:visible").count(), 10);
    await page.locator("#more").click();
    assert.equal(await page.locator("#modes .slider:visible").count(), 201);
    await after(page, () => page.locator("#modes input[type=range]").nth(199).fill("1"));
    assert.equal((await scores(page))[199], 1);
    await close(page);
});

/// Two points above and below a polygon, as OBJ.
function bipyramid(corners, height, seed) {
    const rim = Array.from({ length: corners }, (_, i) => {
        const angle = (2 * Math.PI * i) / corners;
        const radius = 1 + 0.1 * Math.sin(3 * seed + 5 * i);
        return `v ${radius * Math.cos(angle)} ${radius * Math.sin(angle)} 0`;
    });
    const faces = rim.flatMap((_, i) => {
        const [a, b] = [i + 3, ((i + 1) % corners) + 3];
        return [`f 1 ${a} ${b}`, `f 2 ${b} ${a}`];
    });
    return [`v 0 0 ${height}`, `v 0 0 ${-height}`, ...rim, ...faces].join("\n") + "\n";
}

function prepare() {
    shape("synth", "faces", "--count", "8", "--vertices", "400", "--seed", "1", "-o", "faces");
    const labels = readFileSync(file("faces/labels.csv"), "utf8").trim().split("\n");
    writeFileSync(file("labels.csv"), labels.map((line, i) =>
        `${line},${i === 0 ? "age,height,year" : `${(i % 7) / 7},${/happy/.test(line) ? 1 + (i % 5) / 5 : ""},${i === 1 ? "" : 1990 + (i % 12)}`}`).join("\n") + "\n");
    shape("collect", "faces", "--labels", "labels.csv", "-o", "all.h5");
    shape("stats", "all.h5", "-o", "faces.h5", "--modes", "12");
    shape("difference", "all.h5", "--pair-by", "subject", "--from", "expression=neutral", "--to", "expression=happy", "-o", "smile.h5",
        "--effects", "effects.ply");
    shape("explore", "faces.h5", "-o", "faces.html", "--color-by", "expression", "--regress", "age", "--difference", "smile.h5",
        "--effects", "effects.ply", "--title", "Made-up faces");
    shape("explore", "faces.h5", "-o", "partial.html", "--regress", "height");
    shape("explore", "faces.h5", "-o", "years.html", "--color-by", "year");
    shape("synth", "faces", "--count", "68", "--vertices", "300", "--seed", "2", "-o", "many");
    shape("stats", "many", "-o", "many.h5", "--modes", "201");
    shape("explore", "many.h5", "-o", "many.html", "--modes", "201", "--title", "Many modes", "--about", "Scanned on <Tuesdays> & at night");
    shape("stats", "all.h5", "-o", "procrustes.h5", "--space", "procrustes", "--modes", "5");
    shape("explore", "procrustes.h5", "-o", "procrustes.html");
    shape("stats", "all.h5", "-o", "one_mode.h5", "--modes", "1");
    shape("explore", "one_mode.h5", "-o", "one_mode.html");
    const small = Array.from({ length: 4 }, (_, i) => {
        writeFileSync(file(`small${i}.obj`), bipyramid(8, 1 + 0.2 * i, i));
        return `small${i}.obj`;
    });
    shape("stats", ...small, "-o", "small.h5");
    shape("explore", "small.h5", "-o", "small.html");
}

const median = (values) => values.toSorted((a, b) => a - b)[values.length >> 1];

/// Ten modes set at random: 200 times, each as soon as the mesh before is there, which says how long one waits; then
/// with every frame of the screen, until 200 meshes are there, which says how many come. Beside the program's preview,
/// one thread.
async function printRates(name, model, command) {
    shape(...command);
    shape("explore", `${model}.h5`, "-o", `${model}.html`);
    const page = await open(`${model}.html`);
    await settled(page);
    const modes = await page.evaluate(() => window.explore.facts.modes);
    const points = Array.from({ length: 200 }, (_, i) => modes.map((_, k) => (k < 10 ? Number(Math.sin(7.3 * i + 2.9 * k * k + 1).toFixed(4)) : 0)));
    const { drags, gaps } = await page.evaluate(async (points) => {
        // A mesh that comes changes the certificate: timers would find out up to 4 ms later, or keep a processor busy.
        let heard = () => {};
        new MutationObserver(() => heard()).observe(document.querySelector("#time"), { childList: true });
        const arrival = () => new Promise((done) => (heard = done));
        const drags = [];
        for (const scores of points) {
            const next = arrival();
            const begin = performance.now();
            window.explore.goTo({ ...window.explore.place, scores });
            await next;
            drags.push({ milliseconds: performance.now() - begin, quality: window.explore.shown.quality, rms: window.explore.shown.certificate.edgeRms });
        }
        const gaps = [];
        let [came, i] = [performance.now(), 0];
        const move = () => window.explore.goTo({ ...window.explore.place, scores: points[i++ % points.length] });
        let isMoving = true;
        const follow = () => isMoving && (move(), requestAnimationFrame(follow)); // so browsers hand out a pointer's moves
        requestAnimationFrame(follow);
        while (gaps.length < points.length) {
            await arrival();
            const now = performance.now();
            gaps.push(now - came);
            came = now;
        }
        isMoving = false;
        return { drags, gaps };
    }, points);
    const previews = [];
    for (const scores of points.slice(0, 20)) {
        await after(page, () => page.evaluate((scores) => window.explore.goTo({ ...window.explore.place, scores }), scores));
        previews.push(await page.evaluate(() => window.explore.preview.milliseconds));
    }
    await close(page);
    const rows = points.slice(0, 20).map((point, i) => [`p${i}`, ...point.map((value, k) => value * modes[k].deviation)].join(","));
    writeFileSync(file("points.csv"), [["mesh", ...modes.map((_, k) => `pc${k + 1}`)].join(","), ...rows].join("\n") + "\n");
    const native = shape("generate", `${model}.h5`, "--scores-file", "points.csv", "--quality", "preview", "--threads", "1", "-o", `${model}_points/`).embeddings;
    const times = drags.map(({ milliseconds }) => milliseconds);
    const qualities = [...new Set(drags.map(({ quality }) => quality))].join(" and ");
    const rms = (values) => `${(100 * median(values)).toFixed(3)} %`;
    console.log(`| ${name} | ${native[0].vertices} | ${qualities} | ${median(times).toFixed(1)} | ${Math.max(...times).toFixed(0)} | ` +
        `${(1000 / median(gaps)).toFixed(0)} | ${rms(drags.map(({ rms }) => rms))} | ${median(previews).toFixed(1)} | ` +
        `${(1000 * median(native.map(({ seconds }) => seconds))).toFixed(1)} | ${rms(native.map(({ edge_rms }) => edge_rms))} |`);
}

async function rates() {
    console.log("| model | vertices | shown | waited, median [ms] | worst [ms] | a second | edge RMS | preview here [ms] | by the program [ms] | edge RMS |\n" +
        "|---|---|---|---|---|---|---|---|---|---|");
    await printRates("600 faces", "rate_faces", ["stats", join(data, "ict_faces600"), "-o", "rate_faces.h5", "--modes", "20"]);
    await printRates("10 vertebrae", "rate_vertebrae", ["stats", join(data, "vertebrae"), "-o", "rate_vertebrae.h5"]);
    await printRates("21 bodies", "rate_bodies", ["stats", join(data, "mh_body_poses"), "-o", "rate_bodies.h5"]);
    shape("synth", "faces", "--count", "8", "--vertices", "58000", "-o", "large");
    await printRates("24 made-up faces", "rate_large", ["stats", "large", "-o", "rate_large.h5", "--modes", "12"]);
}

let failures = 0;
try {
    if (task === "rates") await rates();
    else prepare();
    for (const { name, run } of task === "rates" ? [] : tests) {
        const begin = Date.now();
        try {
            await run();
            console.log(`passed: ${name} (${((Date.now() - begin) / 1000).toFixed(1)} s)`);
        } catch (error) {
            ++failures;
            console.log(`FAILED: ${name}\n${error.stack}`);
        }
    }
} finally {
    await browser.close();
    rmSync(folder, { recursive: true, force: true });
}
process.exitCode = failures > 0 ? 1 : 0;
