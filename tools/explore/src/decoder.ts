// SPDX-License-Identifier: MIT

import type { Answer, Ready, Shape, Wanted } from "./shape";

declare const WORKER_SOURCE: string; // worker.ts, bundled; put in by build.mjs

type Request = Omit<Wanted, "ticket">;

/// One worker with the model in it. Of requests that come while it works, only the last one is met.
class Channel {
    private worker: Worker;
    private busy: { request: Request; done: (answer: Answer) => void } | null = null;
    private next: { request: Request; done: (answer: Answer) => void } | null = null;
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
                const answered = this.busy!;
                this.busy = null;
                const next = this.next;
                this.next = null;
                if (next) this.send(next.request, next.done);
                answered.done(data);
            };
        });
        this.worker.postMessage({ kind: "start", wasm: wasm.slice().buffer, block: block.slice().buffer });
    }

    ask(request: Request, done: (answer: Answer) => void) {
        if (this.busy) this.next = { request, done };
        else this.send(request, done);
    }
    private send(request: Request, done: (answer: Answer) => void) {
        this.busy = { request, done };
        this.worker.postMessage({ ...request, ticket: ++this.ticket });
    }
}

/// Previews as fast as they come, and fine meshes once nothing moves. Two workers: a fine mesh that
/// nobody waits for any more must not hold up a preview.
export class Decoder {
    private preview: Channel;
    private fine: Channel | null = null;
    private rest: ReturnType<typeof setTimeout> | undefined;
    private moves = 0;
    private settled = true;
    readonly ready: Promise<Ready>;

    constructor(
        private wasm: Uint8Array<ArrayBuffer>,
        private block: Uint8Array<ArrayBuffer>,
        private onShape: (shape: Shape) => void,
        private onFailure: (message: string) => void,
        private restMilliseconds = 250,
    ) {
        this.preview = new Channel(wasm, block);
        this.ready = this.preview.ready;
    }

    /// Whether the fine mesh of the last place is there.
    get isSettled() {
        return this.settled;
    }

    show(scores: number[], amounts: number[], size: number) {
        const move = ++this.moves;
        this.settled = false;
        clearTimeout(this.rest);
        this.preview.ask({ kind: "decode", scores, amounts, size, fine: false }, (answer) => {
            if (answer.kind === "failure") this.onFailure(answer.message);
            else if (answer.kind === "shape") this.onShape(answer);
            if (move !== this.moves) return;
            this.rest = setTimeout(() => this.refine(move, { kind: "decode", scores, amounts, size, fine: true }),
                this.restMilliseconds);
        });
    }

    private refine(move: number, request: Request) {
        this.fine ??= new Channel(this.wasm, this.block);
        this.fine.ask(request, (answer) => {
            if (move !== this.moves) return; // somebody moved on
            this.settled = true;
            if (answer.kind === "failure") this.onFailure(answer.message);
            else if (answer.kind === "shape") this.onShape(answer);
        });
    }

    /// A preview beside what is shown, for ghosts.
    once(scores: number[], amounts: number[], size: number): Promise<Shape> {
        this.fine ??= new Channel(this.wasm, this.block);
        return new Promise((done, fail) =>
            this.fine!.ask({ kind: "decode", scores, amounts, size, fine: false }, (answer) =>
                answer.kind === "shape" ? done(answer) : fail(new Error((answer as { message: string }).message)),
            ),
        );
    }

    feasibleShare(scores: number[], amounts: number[], size: number): Promise<number> {
        return new Promise((done) =>
            this.preview.ask({ kind: "feasible", scores, amounts, size, fine: false }, (answer) =>
                done(answer.kind === "feasible" ? answer.share : 1),
            ),
        );
    }
}
