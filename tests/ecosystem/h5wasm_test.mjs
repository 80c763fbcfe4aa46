// SPDX-License-Identifier: MIT
//
// h5wasm, which reads HDF5 in browsers and in node, reads collections and models.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";

import { inFolder, needs, shape } from "./ecosystem.mjs";

const { default: h5wasm } = await needs("Ecosystem.H5wasm", "h5wasm/dist/node/hdf5_hl.js");
await h5wasm.ready;
await inFolder(async (path) => {
    shape(path, "synth", "faces", "-o", "faces", "--count", "3", "--vertices", "400");
    const labels = ["--labels", "faces/labels.csv"];
    const made = shape(path, "collect", "faces", ...labels, "-o", "faces.h5");
    shape(path, "collect", "faces", ...labels, "--compress", "-o", "packed.h5");
    const fitted = shape(path, "stats", "faces", ...labels, "-o", "model.h5");
    shape(path, "generate", "model.h5", "--mean", "--ascii", "-o", "mean.ply");
    const [plain, packed] = ["faces.h5", "packed.h5"].map((name) => {
        const file = new h5wasm.File(`${path}/${name}`, "r");
        const points = file.get("points");
        assert.deepEqual(points.shape, [made.meshes, made.vertices, 3]);
        assert.deepEqual(file.get("topology/faces").shape, [made.faces, 3]);
        const values = [...points.value];
        const names = file.get("names").value;
        const expressions = file.get("labels/expression").value;
        file.close();
        return { values, names, expressions };
    });
    assert.deepEqual(packed, plain);
    // The first mesh is that of its file.
    const first = readFileSync(`${path}/faces/${plain.names[0]}.ply`);
    const start = first.indexOf("end_header\n") + "end_header\n".length;
    for (let i = 0; i < 3 * made.vertices; ++i) assert.equal(plain.values[i], first.readDoubleLE(start + 8 * i));
    assert.deepEqual(new Set(plain.expressions), new Set(["neutral", "happy", "angry"]));
    const model = new h5wasm.File(`${path}/model.h5`, "r");
    const variances = [...model.get("variances").value];
    model.close();
    assert.deepEqual(variances, fitted.modes.map((mode) => mode.variance));
    console.log(`h5wasm: ${made.meshes} meshes, plain and packed, and a model of ${variances.length} modes`);
});
