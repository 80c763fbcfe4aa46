// SPDX-License-Identifier: MIT
//
// three.js in Chromium plays our GLB animation: the vertices that it shows at each frame's time are ours, and so
// are those of the PLY, OBJ and STL files that its loaders read.

import assert from "node:assert/strict";
import { existsSync, readFileSync, readdirSync, writeFileSync } from "node:fs";

import { inFolder, needs, shape, skip } from "./ecosystem.mjs";

const name = "Ecosystem.Three";
const { build } = await needs(name, "esbuild/lib/main.js");
await needs(name, "three/build/three.module.js");
const { chromium } = await needs(name, "playwright-core/index.mjs");
const executablePath = process.env.CHROMIUM || "/usr/bin/chromium";
if (!existsSync(executablePath)) skip(name, `there is no ${executablePath}`);

const script = `
import { AnimationMixer, Vector3 } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { OBJLoader } from "three/addons/loaders/OBJLoader.js";
import { PLYLoader } from "three/addons/loaders/PLYLoader.js";
import { STLLoader } from "three/addons/loaders/STLLoader.js";
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const loaded = (buffer) => new Promise((done, failed) => new GLTFLoader().parse(buffer, "", done, failed));
window.play = async (text, times) => {
    const file = await loaded(bytes(text));
    let mesh;
    file.scene.traverse((part) => { if (part.isMesh) mesh = part; });
    file.scene.updateMatrixWorld(true);
    const mixer = new AnimationMixer(file.scene);
    mixer.clipAction(file.animations[0]).play();
    const at = new Vector3();
    const frames = times.map((time) => {
        mixer.setTime(time);
        const points = [];
        for (let i = 0; i < mesh.geometry.attributes.position.count; ++i)
            points.push(...mesh.localToWorld(mesh.getVertexPosition(i, at)).toArray());
        return points;
    });
    return { frames, faces: [...mesh.geometry.index.array], duration: file.animations[0].duration };
};
window.read = (ending, text) => {
    const geometry = ending === "ply" ? new PLYLoader().parse(bytes(text))
        : ending === "stl" ? new STLLoader().parse(bytes(text))
        : new OBJLoader().parse(atob(text)).children[0].geometry;
    return { points: [...geometry.attributes.position.array], faces: geometry.index ? [...geometry.index.array] : null };
};
`;

/// Vertices and faces of a PLY file of libshape, binary with doubles.
function readPly(path) {
    const data = readFileSync(path);
    const head = data.subarray(0, data.indexOf("end_header\n")).toString();
    const [, vertices] = head.match(/element vertex (\d+)/).map(Number);
    const [, faceCount] = head.match(/element face (\d+)/).map(Number);
    let at = data.indexOf("end_header\n") + "end_header\n".length;
    const points = Array.from({ length: 3 * vertices }, (_, i) => data.readDoubleLE(at + 8 * i));
    at += 24 * vertices;
    const faces = [];
    for (let i = 0; i < faceCount; ++i, at += 13)
        for (let j = 0; j < 3; ++j) faces.push(data.readInt32LE(at + 1 + 4 * j));
    return { points, faces };
}

const extent = (points) => Math.max(...points) - Math.min(...points);
const error = (found, wanted) => Math.max(...found.map((value, i) => Math.abs(value - wanted[i]))) / extent(wanted);

await inFolder(async (path) => {
    const bundle = await build({
        stdin: { contents: script, resolveDir: path }, bundle: true, write: false, format: "iife",
        nodePaths: [process.env.NODE_PATH],
    });
    shape(path, "synth", "arm", "--vertices", "300", "-o", "arm");
    const common = ["interpolate", ...readdirSync(`${path}/arm`).filter((file) => file.endsWith(".ply")).sort().slice(0, 2)
        .map((file) => `arm/${file}`), "--frames", "11"];
    shape(path, ...common, "-o", "frames");
    shape(path, ...common, "-o", "morph.glb", "--glb-tolerance", "1e-4", "--fps", "20");
    for (const ending of ["obj", "stl"]) shape(path, ...common, "-o", ending, "--format", ending);
    const text = (file) => readFileSync(`${path}/${file}`).toString("base64");

    const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--disable-background-networking"] });
    try {
        const page = await browser.newPage();
        writeFileSync(`${path}/page.html`, "<!doctype html><title>three</title>");
        await page.goto(`file://${path}/page.html`);
        await page.addScriptTag({ content: bundle.outputFiles[0].text });
        const times = Array.from({ length: 11 }, (_, i) => Math.min(i / 20, 0.5 - 1e-9)); // 0.5 s would start anew
        const played = await page.evaluate(([file, at]) => window.play(file, at), [text("morph.glb"), times]);
        let worst = 0;
        for (let i = 0; i < 11; ++i) {
            const wanted = readPly(`${path}/frames/frame_${String(i).padStart(4, "0")}.ply`);
            assert.deepEqual(played.faces, wanted.faces);
            worst = Math.max(worst, error(played.frames[i], wanted.points));
        }
        console.log(`three.js in Chromium: 11 frames of morph.glb, at most ${worst.toExponential(1)} of the extent off`);
        assert.ok(worst < 2e-4 && Math.abs(played.duration - 0.5) < 1e-6, `${worst}, ${played.duration} s`);
        const { points, faces } = readPly(`${path}/frames/frame_0010.ply`);
        const corners = faces.flatMap((v) => points.slice(3 * v, 3 * v + 3));
        for (const [ending, file] of [["ply", "frames/frame_0010.ply"], ["obj", "obj/frame_0010.obj"],
                                      ["stl", "stl/frame_0010.stl"]]) {
            const read = await page.evaluate(([kind, data]) => window.read(kind, data), [ending, text(file)]);
            if (read.faces) assert.deepEqual(read.faces, faces);
            assert.ok(error(read.points, read.faces ? points : corners) < 1e-6, ending);
        }
        console.log("three.js in Chromium: PLY, OBJ and STL by its loaders");
    } finally {
        await browser.close();
    }
});
