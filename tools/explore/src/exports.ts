// SPDX-License-Identifier: MIT

import type { Scale } from "./colours";
import { make } from "./dom";
import type { Facts } from "./model";
import type { Quality } from "./shape";
import { decimals, totalScores, type Place } from "./state";

/// Offers bytes under a name, as a download.
export function save(name: string, content: BlobPart, type: string) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([content], { type }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

/// A picture with what its colours mean beneath.
export async function withLegend(picture: Blob, scale: Scale, print: (value: number) => string, name: string, ink: string): Promise<Blob> {
    const image = await createImageBitmap(picture);
    const size = Math.max(12, Math.round(image.width / 60)); // [px] of letters
    const canvas = make<HTMLCanvasElement>("canvas", { width: image.width, height: image.height });
    const context = canvas.getContext("2d")!;
    context.drawImage(image, 0, 0);
    context.font = `${size}px Helvetica, Arial, sans-serif`;
    context.textBaseline = "middle";
    context.fillStyle = ink;
    const y = image.height - 1.2 * size;
    let x = size;
    const write = (text: string) => {
        context.fillText(text, x, y);
        x += context.measureText(text).width + 0.6 * size;
    };
    write(print(scale.low));
    const ramp = context.createLinearGradient(x, 0, x + 10 * size, 0);
    scale.stops.forEach((stop, i) => ramp.addColorStop(i / (scale.stops.length - 1), `rgb(${stop.join(",")})`));
    context.fillStyle = ramp;
    context.fillRect(x, y - 0.5 * size, 10 * size, size);
    context.fillStyle = ink;
    x += 10.6 * size;
    write(print(scale.high));
    write(name);
    return new Promise((done, fail) => canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error("the browser made no picture"))), "image/png"));
}

/// Binary, little-endian, double precision, as the program writes it.
export function plyOf(points: Float64Array, faces: Uint32Array, comment: string): Uint8Array<ArrayBuffer> {
    const [vertices, triangles] = [points.length / 3, faces.length / 3];
    const head = new TextEncoder().encode(
        `ply\nformat binary_little_endian 1.0\ncomment ${comment.replace(/[^\x20-\x7e]/g, "?")}\n` +
            `element vertex ${vertices}\nproperty double x\nproperty double y\nproperty double z\n` +
            `element face ${triangles}\nproperty list uchar int vertex_indices\nend_header\n`,
    );
    const bytes = new Uint8Array(head.length + 24 * vertices + 13 * triangles);
    bytes.set(head);
    const view = new DataView(bytes.buffer);
    let place = head.length;
    for (const value of points) {
        view.setFloat64(place, value, true);
        place += 8;
    }
    for (let f = 0; f < faces.length; f += 3) {
        view.setUint8(place++, 3);
        for (let c = 0; c < 3; ++c, place += 4) view.setInt32(place, faces[f + c], true);
    }
    return bytes;
}

/// Every number with all its digits.
export function objOf(points: Float64Array, faces: Uint32Array, comment: string): string {
    const lines = [`# ${comment}`];
    for (let i = 0; i < points.length; i += 3) lines.push(`v ${points[i]} ${points[i + 1]} ${points[i + 2]}`);
    for (let f = 0; f < faces.length; f += 3) lines.push(`f ${faces[f] + 1} ${faces[f + 1] + 1} ${faces[f + 2] + 1}`);
    return lines.join("\n") + "\n";
}

/// Binary glTF 2.0, which knows single precision alone.
export function glbOf(points: Float64Array, normals: Float32Array, faces: Uint32Array, name: string, generator: string): Uint8Array<ArrayBuffer> {
    const position = new Float32Array(points);
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    position.forEach((value, i) => {
        low[i % 3] = Math.min(low[i % 3], value);
        high[i % 3] = Math.max(high[i % 3], value);
    });
    const vertices = position.length / 3;
    const parts = [position, normals, faces];
    const offsets = parts.map((_, i) => parts.slice(0, i).reduce((sum, part) => sum + part.byteLength, 0));
    const json = {
        asset: { version: "2.0", generator },
        scene: 0,
        scenes: [{ nodes: [0] }],
        nodes: [{ mesh: 0, name }],
        meshes: [{ name, primitives: [{ attributes: { POSITION: 0, NORMAL: 1 }, indices: 2, material: 0 }] }],
        materials: [{ doubleSided: true, pbrMetallicRoughness: { baseColorFactor: [0.7, 0.6, 0.51, 1], metallicFactor: 0, roughnessFactor: 0.6 } }],
        accessors: [
            { bufferView: 0, componentType: 5126, count: vertices, type: "VEC3", min: low, max: high },
            { bufferView: 1, componentType: 5126, count: vertices, type: "VEC3" },
            { bufferView: 2, componentType: 5125, count: faces.length, type: "SCALAR" },
        ],
        bufferViews: parts.map((part, i) => ({
            buffer: 0, byteOffset: offsets[i], byteLength: part.byteLength, target: i < 2 ? 34962 : 34963,
        })),
        buffers: [{ byteLength: parts.reduce((sum, part) => sum + part.byteLength, 0) }],
    };
    const text = new TextEncoder().encode(JSON.stringify(json));
    const jsonLength = 4 * Math.ceil(text.length / 4);
    const binaryLength = json.buffers[0].byteLength;
    const bytes = new Uint8Array(28 + jsonLength + binaryLength).fill(0x20, 20, 20 + jsonLength);
    const view = new DataView(bytes.buffer);
    [0x46546c67, 2, bytes.length, jsonLength, 0x4e4f534a].forEach((word, i) => view.setUint32(4 * i, word, true));
    bytes.set(text, 20);
    view.setUint32(20 + jsonLength, binaryLength, true);
    view.setUint32(24 + jsonLength, 0x004e4942, true);
    parts.forEach((part, i) => bytes.set(new Uint8Array(part.buffer, part.byteOffset, part.byteLength), 28 + jsonLength + offsets[i]));
    return bytes;
}

/// As `shape generate --scores-file` reads it: coordinates along the modes.
export function csvOf(name: string, size: number, scores: number[]): string {
    const head = ["mesh", "size", ...scores.map((_, k) => `pc${k + 1}`)];
    const quoted = /[",\n]/.test(name) ? `"${name.replaceAll('"', '""')}"` : name;
    return `${head.join(",")}\n${[quoted, size, ...scores].join(",")}\n`;
}

/// A name for files that tells the place: "faces_pc1+1.20_pc3-0.50", "faces_mean".
export function stemOf(facts: Facts, place: Place): string {
    const stem = facts.file.replace(/^.*[/\\]/, "").replace(/\.h5$/, "").replace(/[^\w.-]+/g, "_") || "model";
    const signed = (value: number) => (value < 0 ? "" : "+") + value.toFixed(2);
    const parts = totalScores(facts, place)
        .map((score, k) => ({ score, text: `pc${k + 1}${signed(score)}` }))
        .filter(({ score }) => score !== 0)
        .sort((a, b) => Math.abs(b.score) - Math.abs(a.score))
        .slice(0, 4)
        .map(({ text }) => text);
    place.amounts.forEach((amount, i) => {
        if (amount !== 0) parts.push(facts.differences[i].name.replace(/[^\w.-]+/g, "_") + signed(amount));
    });
    return [stem, ...(parts.length ? parts : ["mean"])].join("_");
}

/// What makes the same mesh on the command line; null where differences are added.
export function commandOf(facts: Facts, place: Place, quality: Quality): string | null {
    if (place.amounts.some((amount) => amount !== 0)) return null;
    const quoted = (text: string) => (/^[\w./+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);
    const scores = totalScores(facts, place);
    const last = scores.findLastIndex((score) => score !== 0);
    const point = last < 0 ? "--mean" : `--scores=${scores.slice(0, last + 1).map((s) => Number(s.toFixed(decimals))).join(",")}`;
    const options = [facts.space === "edge" && quality !== "fine" ? " --quality preview" : "",
                     facts.space === "edge" && facts.smoothness !== 0.005 ? ` --smoothness ${facts.smoothness}` : ""];
    return `shape generate ${quoted(facts.file)} ${point}${options.join("")} -o ${quoted(`${stemOf(facts, place)}.ply`)}`;
}
