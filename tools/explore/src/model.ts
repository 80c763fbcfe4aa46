// SPDX-License-Identifier: MIT

/// What the program wrote into the page about the model. docs/formats.md tells the fields.

export interface Mode {
    share: number; // of the total variance
    deviation: number; // score of one standard deviation
    low: number; // feasible range [standard deviations]
    high: number;
}

export interface Specimen {
    name: string;
    size: number;
    scores: number[];
}

export interface Label {
    name: string;
    values: string[]; // one a specimen
}

export interface Difference {
    name: string;
    meaning: string; // "from ... to ..."
}

export interface Regression {
    name: string;
    low: number; // of the meshes' values
    high: number;
    mean: number;
    slope: number[]; // score per unit
    offset: number[]; // mean scores of the meshes that have a value, from those of all
    meshes: number; // that have one
}

export interface Facts {
    title: string;
    file: string;
    version: string;
    space: "edge" | "procrustes";
    size: number;
    sizeIsFree: boolean;
    smoothness: number;
    view: number[]; // 3 by 3, by rows: model to screen
    modes: Mode[];
    specimens: Specimen[];
    labels: Label[];
    colorBy: string;
    differences: Difference[];
    regressions: Regression[];
    effects: { name: string; values: string } | null; // base64 of a float a vertex
}

export function readFacts(): Facts {
    return JSON.parse(document.getElementById("facts")!.textContent!);
}

export function bytesOf(base64: string): Uint8Array<ArrayBuffer> {
    const text = atob(base64);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
    return bytes;
}

/// Bytes out of an element of the page, which is emptied: models are large.
export function takeBytes(id: string): Uint8Array<ArrayBuffer> {
    const element = document.getElementById(id)!;
    const chunks = (element.textContent ?? "").trim().split("\n").map(bytesOf);
    element.textContent = "";
    const bytes = new Uint8Array(chunks.reduce((sum, chunk) => sum + chunk.length, 0));
    let place = 0;
    for (const chunk of chunks) {
        bytes.set(chunk, place);
        place += chunk.length;
    }
    return bytes;
}
