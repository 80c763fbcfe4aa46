// SPDX-License-Identifier: MIT

import type { Place } from "./state";

/// What the page and its workers send each other.

export interface Start {
    kind: "start";
    wasm: ArrayBuffer;
    block: ArrayBuffer;
}

/// How much is done for a mesh: vertices to first order and one sweep; what the program calls preview and fine.
export type Quality = "draft" | "preview" | "fine";
export const qualities: Quality[] = ["draft", "preview", "fine"]; // as the decoder numbers them

export interface Wanted {
    kind: "decode" | "feasible";
    ticket: number;
    scores: number[]; // coordinates along the modes
    amounts: number[];
    size: number;
    quality: Quality;
    mustBeDone: boolean; // not passed over for a later one
}

/// Memory of drafts that the page has done with. Where every mesh asked for its own, megabytes a second of zeroed pages and
/// of garbage would come between the moves of a hand.
export interface Returned {
    kind: "returned";
    buffers: ArrayBuffer[];
}

export interface Certificate {
    status: "exact" | "approximate" | "infeasible";
    reason: string;
    edgeRms: number;
    edgeMax: number;
    edgeP999: number;
    edgeP99: number;
    driftRms: number; // [deg]
    driftP99: number;
    driftMax: number;
    closureEnergy: number;
    invertedFaces: number;
    crossings: number; // pairs of faces that pass through each other; -1: not counted
    newCrossings: number; // of them those that do not in the reference mesh
    iterations: number;
    converged: boolean;
}

/// What a worker makes. The arrays of a draft are lent: they hold until the next draft has been shown.
export interface Decoded {
    kind: "shape";
    ticket: number;
    quality: Quality;
    points: Float64Array<ArrayBuffer>; // x y z of one vertex after the other
    edgeError: Float32Array<ArrayBuffer>; // #V
    drift: Float32Array<ArrayBuffer>; // #V [deg]
    broken: Uint32Array<ArrayBuffer>; // corners of faces that break the triangle inequality
    certificate: Certificate;
    milliseconds: number;
}

/// With what the page adds, while the worker goes on with the next.
export interface Shape extends Decoded {
    place: Place; // where in the model it is
    normals: Float32Array<ArrayBuffer>;
}

export interface Ready {
    kind: "ready";
    faces: Uint32Array<ArrayBuffer>;
    vertices: number;
}

export interface Failure {
    kind: "failure";
    ticket: number; // -1: of the start
    message: string;
}

export interface Feasible {
    kind: "feasible";
    ticket: number;
    share: number; // what the scores are to be multiplied with
}

export type Answer = Decoded | Ready | Failure | Feasible;

/// With arrays of its own.
export function copied(shape: Shape): Shape {
    const { points, edgeError, drift, normals } = shape;
    return { ...shape, points: points.slice(), edgeError: edgeError.slice(), drift: drift.slice(), normals: normals.slice() };
}

/// Unit normals of vertices, faces weighted by their area.
/// @param normals  Where they are put.
export function vertexNormals(points: Float64Array, faces: Uint32Array, normals = new Float32Array(points.length)): Float32Array<ArrayBuffer> {
    normals.fill(0);
    for (let f = 0; f < faces.length; f += 3) {
        const p = 3 * faces[f], q = 3 * faces[f + 1], r = 3 * faces[f + 2];
        const ux = points[q] - points[p], uy = points[q + 1] - points[p + 1], uz = points[q + 2] - points[p + 2];
        const vx = points[r] - points[p], vy = points[r + 1] - points[p + 1], vz = points[r + 2] - points[p + 2];
        const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
        normals[p] += x; normals[p + 1] += y; normals[p + 2] += z;
        normals[q] += x; normals[q + 1] += y; normals[q + 2] += z;
        normals[r] += x; normals[r + 1] += y; normals[r + 2] += z;
    }
    for (let v = 0; v < normals.length; v += 3) {
        const length = Math.sqrt(normals[v] ** 2 + normals[v + 1] ** 2 + normals[v + 2] ** 2) || 1;
        normals[v] /= length; normals[v + 1] /= length; normals[v + 2] /= length;
    }
    return normals;
}

/// How far every vertex is from where it is in another shape, along the other's normal.
export function displacement(shape: Shape, from: Shape): Float32Array<ArrayBuffer> {
    const result = new Float32Array(shape.points.length / 3);
    for (let v = 0; v < result.length; ++v)
        for (let k = 3 * v; k < 3 * v + 3; ++k)
            result[v] += (shape.points[k] - from.points[k]) * from.normals[k];
    return result;
}
