// SPDX-License-Identifier: MIT

import type { Place } from "./state";
import { vertexNormals, type Answer, type Decoded, type Quality, type Ready, type Returned, type Shape, type Start, type Wanted } from "./shape";

declare const WORKER_SOURCE: string; // worker.ts, bundled; put in by build.mjs

type Request = Omit<Wanted, "ticket" | "mustBeDone">;

/// What the decoder is to show.
export interface Target {
    place: Place; // of whoever asks: comes back with the mesh
    scores: number[];
    amounts: number[];
    size: number;
}

const requestOf = ({ scores, amounts, size }: Target, quality: Quality): Request => ({ kind: "decode", scores, amounts, size, quality });

interface Errand {
    done: (answer: Answer) => void;
    mustBeDone: boolean;
}

/// One worker with the model in it, which is told of every request at once: asked for the next one when it is done, it would
/// wait while this thread draws. Of requests that come while it works only the last one is met, but for those that must be.
class Channel {
    private worker: Worker;
    private errands = new Map<number, Errand>(); // by ticket
    private ticket = 0;
    readonly ready: Promise<Ready>;

    constructor(wasm: Uint8Array<ArrayBuffer>, block: Uint8Array<ArrayBuffer>) {
        const source = URL.createObjectURL(new Blob([WORKER_SOURCE], { type: "text/javascript" }));
        this.worker = new Worker(source);
        this.ready = new Promise((done, fail) => {
            this.worker.onerror = (event) => fail(new Error(event.message));
            this.worker.onmessage = ({ data }: MessageEvent<Answer>) => {
                if (data.kind === "ready") return done(data);
                if (data.kind === "failure" && data.ticket < 0) return fail(new Error(data.message));
                this.take(data);
            };
        });
        const start: Start = { kind: "start", wasm: wasm.slice().buffer, block: block.slice().buffer };
        this.worker.postMessage(start, [start.wasm, start.block]);
    }

    private take(answer: Exclude<Answer, Ready>) {
        const { done } = this.errands.get(answer.ticket)!;
        for (const [ticket, { mustBeDone }] of this.errands)
            if (ticket === answer.ticket || (ticket < answer.ticket && !mustBeDone)) this.errands.delete(ticket);
        done(answer);
    }

    ask(request: Request, done: (answer: Answer) => void, mustBeDone = false) {
        this.errands.set(++this.ticket, { done, mustBeDone });
        const wanted: Wanted = { ...request, ticket: this.ticket, mustBeDone };
        this.worker.postMessage(wanted);
    }

    giveBack(buffers: ArrayBuffer[]) {
        const returned: Returned = { kind: "returned", buffers };
        this.worker.postMessage(returned, buffers);
    }
}

/// A mesh as fast as they come, the preview when nothing has moved for a moment, and the fine one a while later. Two
/// workers: a mesh that nobody waits for any more must not hold up the next. Between two moves of a hand lie
/// milliseconds: previews begun there would be for nothing, and take a processor from the drafts.
export class Decoder {
    private quick: Channel;
    private slow: Channel | null = null;
    private rest: ReturnType<typeof setTimeout> | undefined;
    private moves = 0;
    private settled = true;
    private faces = new Uint32Array(0);
    private hasPractised = false;
    private draft: Shape | null = null; // the last one
    private spareNormals: Float32Array<ArrayBuffer> | undefined; // of the one before
    frame = 16; // [ms]; of most screens. Where a preview takes longer, drafts are shown while something moves
    private previewTime = Infinity; // [ms]; the shortest there was, as code is slow at first
    readonly ready: Promise<Ready>;

    constructor(
        private wasm: Uint8Array<ArrayBuffer>,
        private block: Uint8Array<ArrayBuffer>,
        private onShape: (shape: Shape) => void,
        private onFailure: (message: string) => void,
        private calmMilliseconds = 80,
        private restMilliseconds = 250,
    ) {
        this.quick = new Channel(wasm, block);
        this.ready = this.quick.ready.then((ready) => {
            this.faces = ready.faces;
            return ready;
        });
    }

    /// Whether the fine mesh of the last place is there.
    get isSettled() {
        return this.settled;
    }

    show(target: Target) {
        const move = ++this.moves;
        this.settled = false;
        clearTimeout(this.rest);
        const quality = this.previewTime > this.frame && this.previewTime < Infinity ? "draft" : "preview";
        this.quick.ask(requestOf(target, quality), (answer) => {
            if (answer.kind === "failure" && move !== this.moves) return; // nobody is there any more
            const isThere = this.deliver(answer, target);
            if (move !== this.moves || !isThere) return;
            this.practise(target);
            if (quality === "draft") this.waitBefore(move, target, "preview", this.calmMilliseconds);
            else this.waitBefore(move, target, "fine", this.restMilliseconds);
        });
    }

    /// @return whether there is a mesh.
    private deliver(answer: Answer, { place }: Target): boolean {
        if (answer.kind === "failure") this.onFailure(answer.message);
        if (answer.kind !== "shape") return false;
        if (answer.quality === "preview") this.previewTime = Math.min(this.previewTime, answer.milliseconds);
        if (answer.quality === "draft") this.deliverDraft(answer, place);
        else this.onShape(this.completed(answer, place));
        return true;
    }

    private deliverDraft(answer: Decoded, place: Place) {
        const before = this.draft;
        this.draft = this.completed(answer, place, this.spareNormals);
        this.onShape(this.draft);
        if (!before) return;
        this.spareNormals = before.normals;
        this.quick.giveBack([before.points.buffer, before.edgeError.buffer, before.drift.buffer]);
    }

    private completed(decoded: Decoded, place: Place, normals?: Float32Array<ArrayBuffer>): Shape {
        return { ...decoded, place, normals: vertexNormals(decoded.points, this.faces, normals) };
    }

    /// Drafts that nobody sees, where they will be wanted with the first move: a browser translates at once, but well only
    /// what has run for a while, and the first draft took half as long again as later ones.
    private practise(target: Target) {
        if (this.hasPractised || this.previewTime <= this.frame) return;
        this.hasPractised = true;
        const again = (times: number, move = this.moves) => {
            if (times > 0 && move === this.moves) this.quick.ask(requestOf(target, "draft"), () => again(times - 1, move));
        };
        again(5);
    }

    private waitBefore(move: number, target: Target, quality: Quality, milliseconds: number) {
        this.rest = setTimeout(() => this.improve(move, target, quality), milliseconds);
    }

    private improve(move: number, target: Target, quality: Quality) {
        this.slowChannel().ask(requestOf(target, quality), (answer) => {
            if (move !== this.moves) return; // somebody moved on
            this.settled = quality === "fine";
            if (this.deliver(answer, target) && !this.settled) this.waitBefore(move, target, "fine", this.restMilliseconds);
        });
    }

    private slowChannel(): Channel {
        return (this.slow ??= new Channel(this.wasm, this.block));
    }

    /// A mesh beside what is shown, for ghosts and to compare with.
    once(target: Target, quality: Quality): Promise<Shape> {
        return new Promise((done, fail) =>
            this.slowChannel().ask(requestOf(target, quality), (answer) =>
                answer.kind === "shape" ? done(this.completed(answer, target.place)) : fail(new Error((answer as { message: string }).message)),
                true),
        );
    }

    feasibleShare({ scores, amounts, size }: Target): Promise<number> {
        return new Promise((done) =>
            this.quick.ask({ kind: "feasible", scores, amounts, size, quality: "draft" }, (answer) =>
                done(answer.kind === "feasible" ? answer.share : 1),
                true),
        );
    }
}
