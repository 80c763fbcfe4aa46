// SPDX-License-Identifier: MIT

/// Decodes in the background: the library, compiled to WebAssembly, and the model.

import { qualities, type Answer, type Certificate, type Decoded, type Returned, type Start, type Wanted } from "./shape";

interface Module {
    memory: WebAssembly.Memory;
    _initialize?: () => void;
    malloc(size: number): number;
    free(address: number): void;
    open_model(block: number, size: number): number;
    decode(scores: number, count: number, amounts: number, amountCount: number, size: number, quality: number): number;
    feasible_share(scores: number, count: number, amounts: number, amountCount: number, size: number): number;
    vertex_count(): number;
    face_count(): number;
    faces(): number;
    shown_positions(): number;
    shown_edge_error(): number;
    shown_dihedral_drift(): number;
    shown_broken_faces(): number;
    shown_figures(): number;
    last_message(): number;
}

let module: Module;
let faces: Uint32Array<ArrayBuffer>;

const answer = (message: Answer, transfer: Transferable[] = []) =>
    (self as unknown as Worker).postMessage(message, transfer);

function text(address: number): string {
    const bytes = new Uint8Array(module.memory.buffer, address);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
}

let spare: ArrayBuffer[] = []; // that the page gave back

/// A copy of numbers in the module's memory.
function copied<T extends Float64Array | Float32Array | Uint32Array>(
    Type: { readonly BYTES_PER_ELEMENT: number; new (buffer: ArrayBufferLike, at: number, count: number): T },
    address: number,
    count: number,
): T {
    const bytes = count * Type.BYTES_PER_ELEMENT;
    const known = spare.findIndex(({ byteLength }) => byteLength === bytes);
    const copy = new Type(known < 0 ? new ArrayBuffer(bytes) : spare.splice(known, 1)[0], 0, count);
    copy.set(new Type(module.memory.buffer, address, count));
    return copy;
}

function placed(values: number[]): number {
    const address = module.malloc(8 * Math.max(values.length, 1));
    new Float64Array(module.memory.buffer, address, values.length).set(values);
    return address;
}

/// What little of a system the C++ library asks for; nothing is printed, read or timed.
function systemCalls(wanted: WebAssembly.ModuleImportDescriptor[]): WebAssembly.Imports {
    const imports: Record<string, Record<string, WebAssembly.ImportValue>> = {};
    for (const { module: from, name, kind } of wanted)
        if (kind === "function")
            (imports[from] ??= {})[name] =
                name === "proc_exit" || name === "abort"
                    ? () => {
                          throw new Error("the decoder ended");
                      }
                    : () => (name.startsWith("emscripten_notify") ? undefined : 0);
    return imports;
}

async function start({ wasm, block }: Start) {
    const compiled = await WebAssembly.compile(wasm);
    const instance = await WebAssembly.instantiate(compiled, systemCalls(WebAssembly.Module.imports(compiled)));
    module = instance.exports as unknown as Module;
    module._initialize?.();
    const address = module.malloc(block.byteLength);
    new Uint8Array(module.memory.buffer, address, block.byteLength).set(new Uint8Array(block));
    const opened = module.open_model(address, block.byteLength);
    module.free(address);
    if (!opened) throw new Error(text(module.last_message()));
    faces = copied(Uint32Array, module.faces(), 3 * module.face_count());
    answer({ kind: "ready", faces, vertices: module.vertex_count() });
}

function findFeasible({ ticket, scores, amounts, size }: Wanted) {
    const [s, a] = [placed(scores), placed(amounts)];
    const share = module.feasible_share(s, scores.length, a, amounts.length, size);
    module.free(s);
    module.free(a);
    if (share < 0) throw new Error(text(module.last_message()));
    answer({ kind: "feasible", ticket, share });
}

function decode({ ticket, scores, amounts, size, quality }: Wanted) {
    const begin = performance.now();
    const [s, a] = [placed(scores), placed(amounts)];
    const decoded = module.decode(s, scores.length, a, amounts.length, size, qualities.indexOf(quality));
    module.free(s);
    module.free(a);
    if (!decoded) throw new Error(text(module.last_message()));
    const vertices = module.vertex_count();
    const points = copied(Float64Array, module.shown_positions(), 3 * vertices) as Float64Array<ArrayBuffer>;
    const isBroken = new Uint8Array(module.memory.buffer, module.shown_broken_faces(), module.face_count());
    const corners: number[] = [];
    for (let f = isBroken.indexOf(1); f >= 0; f = isBroken.indexOf(1, f + 1))
        corners.push(...faces.subarray(3 * f, 3 * f + 3));
    const figures = new Float64Array(module.memory.buffer, module.shown_figures(), 14);
    const certificate: Certificate = {
        status: (["exact", "approximate", "infeasible"] as const)[figures[0]],
        reason: text(module.last_message()),
        edgeRms: figures[1],
        edgeMax: figures[2],
        edgeP999: figures[3],
        edgeP99: figures[4],
        driftRms: figures[5],
        driftP99: figures[6],
        driftMax: figures[7],
        closureEnergy: figures[8],
        invertedFaces: figures[9],
        iterations: figures[10],
        converged: figures[11] !== 0,
        crossings: figures[12],
        newCrossings: figures[13],
    };
    const shape: Decoded = {
        kind: "shape",
        ticket,
        quality,
        points,
        edgeError: copied(Float32Array, module.shown_edge_error(), vertices) as Float32Array<ArrayBuffer>,
        drift: copied(Float32Array, module.shown_dihedral_drift(), vertices) as Float32Array<ArrayBuffer>,
        broken: new Uint32Array(corners),
        certificate,
        milliseconds: performance.now() - begin,
    };
    answer(shape, [
        shape.points.buffer,
        shape.edgeError.buffer,
        shape.drift.buffer,
        shape.broken.buffer,
    ]);
}

let opened: Promise<void>;
let waiting: Wanted[] = [];

/// Rings once all messages that came meanwhile have been heard.
const bell = new MessageChannel();
bell.port1.onmessage = async () => {
    await opened.catch(() => {});
    const next = waiting.shift();
    if (!next) return; // passed over
    try {
        await opened;
        if (next.kind === "feasible") findFeasible(next);
        else decode(next);
    } catch (error) {
        tellFailure(next.ticket, error);
    }
};

function tellFailure(ticket: number, error: unknown) {
    answer({ kind: "failure", ticket, message: error instanceof Error ? error.message : String(error) });
}

self.onmessage = ({ data }: MessageEvent<Start | Wanted | Returned>) => {
    if (data.kind === "returned") {
        spare = data.buffers;
        return;
    }
    if (data.kind === "start") {
        opened = start(data);
        opened.catch((error) => tellFailure(-1, error));
        return;
    }
    if (!data.mustBeDone) waiting = waiting.filter(({ mustBeDone }) => mustBeDone);
    waiting.push(data);
    bell.port2.postMessage(null);
};
