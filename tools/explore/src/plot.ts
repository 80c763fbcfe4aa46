// SPDX-License-Identifier: MIT

import { colourOf, groupColours, groupMarks, rampScale } from "./colours";
import { make } from "./dom";
import type { Facts, Label } from "./model";

const width = 360, height = 300, left = 38, right = 8, top = 8, bottom = 34;

/// The different values of a label, missing ones left out, in the order of their colours.
export const groupsOf = ({ values }: Label): string[] =>
    [...new Set(values)].filter(Boolean).sort((a, b) => a.localeCompare(b, "en", { numeric: true }));

interface Look {
    colour: string;
    mark: string; // about 0, as a path
}

const marks: Record<string, string> = {
    circle: "M-3.2,0a3.2,3.2 0 1,0 6.4,0a3.2,3.2 0 1,0 -6.4,0",
    square: "M-2.8,-2.8h5.6v5.6h-5.6z",
    triangle: "M0,-3.6L3.4,2.6H-3.4z",
    diamond: "M0,-3.8L3.4,0L0,3.8L-3.4,0z",
    cross: "M-3,-2L-2,-3L0,-1L2,-3L3,-2L1,0L3,2L2,3L0,1L-2,3L-3,2L-1,0z",
    down: "M0,3.6L3.4,-2.6H-3.4z",
    plus: "M-1,-3.4h2v2.4h2.4v2h-2.4v2.4h-2v-2.4h-2.4v-2h2.4z",
    bar: "M-3.6,-1.3h7.2v2.6h-7.2z",
};

const cssOf = (rgb: [number, number, number]) => `rgb(${rgb.map(Math.round).join(",")})`;
const lookOf = (group: number): Look =>
    ({ colour: groupColours[group % groupColours.length], mark: marks[groupMarks[group % groupMarks.length]] });
const withoutValue: Look = { colour: "#9a9a9a", mark: "M-2.6,-0.7h5.2v1.4h-5.2z" };

/// The plane of two modes: specimens to click, and the point where one is, to drag. The point lies on a sheet of its own,
/// so that hundreds of specimens are not painted again with every move.
export class ScorePlot {
    readonly element: HTMLElement;
    private svg: SVGSVGElement;
    private specimens: SVGGElement;
    private axes: SVGGElement;
    private point: SVGGElement;
    private xReach = 1;
    private yReach = 1;
    x = 0; // modes
    y = 1;
    label = -1; // whose values get colours

    constructor(
        private facts: Facts,
        private onMove: (x: number, y: number, ended: boolean) => void, // standard deviations
        private onChoose: (specimen: number) => void,
    ) {
        this.y = Math.min(1, facts.modes.length - 1);
        this.axes = make("g", { class: "axes" });
        this.specimens = make("g");
        this.point = make<SVGGElement>("g", { class: "point", tabindex: 0, role: "slider", "aria-label": "Shape shown, in the plane of two modes: arrow keys move it",
                                 "aria-valuemin": -10, "aria-valuemax": 10, "aria-valuenow": 0 },
            make("circle", { r: 16, class: "grip" }), make("circle", { r: 7 }));
        const viewBox = `0 0 ${width} ${height}`;
        this.svg = make<SVGSVGElement>("svg", { viewBox }, this.axes, this.specimens);
        this.element = make("div", { class: "scores", role: "group", "aria-label": "Score plot" },
            this.svg, make("svg", { viewBox, class: "sheet" }, this.point));
        // The ring keeps its distance from the pointer that took it, and stays where it is until that has moved. Where it has not,
        // the click was for the specimen beneath.
        const slack = 4; // of the view box
        let grip: { x: number; y: number; dx: number; dy: number; moved: boolean } | null = null;
        const placeOf = (event: PointerEvent) => new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM()!.inverse());
        this.point.addEventListener("pointerdown", (event) => {
            if (event.button !== 0) return;
            const { x, y } = placeOf(event);
            const [px, py] = this.pointPlace();
            grip = { x, y, dx: px - x, dy: py - y, moved: false };
            this.point.setPointerCapture(event.pointerId);
            this.point.focus();
            event.preventDefault();
        });
        const drag = (event: PointerEvent, ended: boolean) => {
            if (!grip) return;
            const { x, y } = placeOf(event);
            grip.moved ||= Math.hypot(x - grip.x, y - grip.y) > slack;
            if (grip.moved) this.onMove(this.valueOfX(x + grip.dx), this.valueOfY(y + grip.dy), ended);
            else if (ended && event.type === "pointerup") this.chooseBeneath(event);
            if (ended) grip = null;
        };
        this.point.addEventListener("pointermove", (event) => drag(event, false));
        for (const end of ["pointerup", "pointercancel"] as const) this.point.addEventListener(end, (event) => drag(event, true));
        this.point.addEventListener("keydown", (event) => {
            const step = event.shiftKey ? 0.5 : 0.1;
            const [dx, dy] = ({ ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] } as
                Record<string, [number, number]>)[event.key] ?? [0, 0];
            if (!dx && !dy) return;
            event.preventDefault();
            event.stopPropagation();
            this.onMove(this.at[0] + dx, this.at[1] + dy, true);
        });
        this.redraw();
    }

    private chooseBeneath({ clientX, clientY }: PointerEvent) {
        const distance = (element: Element) => {
            const { x, y, width, height } = element.getBoundingClientRect();
            return Math.hypot(x + width / 2 - clientX, y + height / 2 - clientY);
        };
        const beneath = document.elementsFromPoint(clientX, clientY).filter((element) => element.matches(".specimen"));
        const nearest = beneath.sort((a, b) => distance(a) - distance(b))[0];
        if (nearest && !beneath.some((element) => element.matches(".chosen"))) this.onChoose(Number(nearest.getAttribute("data-specimen")));
    }

    private at: [number, number] = [0, 0];
    private chosen: number | null = null;

    private placeOfX = (value: number) => left + ((value / this.xReach + 1) / 2) * (width - left - right);
    private placeOfY = (value: number) => height - bottom - ((value / this.yReach + 1) / 2) * (height - top - bottom);
    private valueOfX = (place: number) => this.clamp(((place - left) / (width - left - right)) * 2 - 1) * this.xReach;
    private valueOfY = (place: number) => this.clamp(((height - bottom - place) / (height - top - bottom)) * 2 - 1) * this.yReach;
    private clamp = (value: number) => Math.min(1, Math.max(-1, value));

    private inDeviations(specimen: number, mode: number) {
        return this.facts.specimens[specimen].scores[mode] / this.facts.modes[mode].deviation;
    }

    /// After a change of modes or label.
    redraw() {
        const { facts } = this;
        const reach = (mode: number) =>
            Math.ceil(1.08 * Math.max(2, ...facts.specimens.map((_, i) => Math.abs(this.inDeviations(i, mode)))) * 2) / 2;
        this.xReach = reach(this.x);
        this.yReach = reach(this.y);
        const ticks = (most: number) => {
            const step = most > 6 ? 2 : 1;
            return Array.from({ length: 2 * Math.floor(most / step) + 1 }, (_, i) => (i - Math.floor(most / step)) * step);
        };
        const bottomLine = height - bottom;
        this.axes.replaceChildren(
            ...ticks(this.xReach).flatMap((t) => [
                make("line", { x1: this.placeOfX(t), x2: this.placeOfX(t), y1: top, y2: bottomLine, class: t ? "grid" : "zero" }),
                make("text", { x: this.placeOfX(t), y: bottomLine + 14, "text-anchor": "middle" }, String(t)),
            ]),
            ...ticks(this.yReach).flatMap((t) => [
                make("line", { y1: this.placeOfY(t), y2: this.placeOfY(t), x1: left, x2: width - right, class: t ? "grid" : "zero" }),
                make("text", { x: left - 6, y: this.placeOfY(t) + 4, "text-anchor": "end" }, String(t)),
            ]),
            make("text", { x: (left + width - right) / 2, y: height - 4, "text-anchor": "middle" },
                `mode ${this.x + 1}, standard deviations (${(100 * facts.modes[this.x].share).toFixed(1)} %)`),
            make("text", { transform: `translate(11 ${(top + bottomLine) / 2}) rotate(-90)`, "text-anchor": "middle" },
                `mode ${this.y + 1} (${(100 * facts.modes[this.y].share).toFixed(1)} %)`),
        );
        const look = this.looks();
        this.specimens.replaceChildren(
            ...facts.specimens.map(({ name }, i) => {
                const { colour, mark } = look(i);
                return make("path", {
                    d: mark,
                    fill: colour,
                    transform: `translate(${this.placeOfX(this.inDeviations(i, this.x))} ${this.placeOfY(this.inDeviations(i, this.y))})`,
                    class: "specimen",
                    "data-specimen": i,
                    onclick: () => this.onChoose(i),
                }, make("title", {}, [name, ...facts.labels.map(({ name, values }) => `${name} ${values[i] || "none"}`)].join(", ")));
            }),
        );
        this.mark(this.chosen);
        this.showPoint(...this.at);
    }

    /// Many numbers have a scale of colours, other values a colour and a mark each.
    private numbers(): { low: number; high: number } | null {
        const groups = this.label < 0 ? [] : groupsOf(this.facts.labels[this.label]);
        const values = groups.map(Number);
        if (groups.length <= groupColours.length || !values.every(Number.isFinite)) return null;
        return { low: Math.min(...values), high: Math.max(...values) };
    }

    private looks(): (specimen: number) => Look {
        if (this.label < 0) return () => lookOf(0);
        const { values } = this.facts.labels[this.label];
        const range = this.numbers();
        if (range) {
            const scale = rampScale(range.low, range.high);
            return (i) => (values[i] ? { colour: cssOf(colourOf(scale, Number(values[i]))), mark: marks.circle } : withoutValue);
        }
        const groups = groupsOf(this.facts.labels[this.label]);
        return (i) => (values[i] ? lookOf(groups.indexOf(values[i])) : withoutValue);
    }

    /// What colours and marks mean.
    key(): (Look & { text: string })[] {
        if (this.label < 0) return [];
        const label = this.facts.labels[this.label];
        const missing = label.values.some((value) => !value) ? [{ ...withoutValue, text: "no value" }] : [];
        const range = this.numbers();
        if (range) {
            const quarter = (range.high - range.low) / 4;
            const steps = [0, 1, 2, 3, 4].map((k) => range.low + k * quarter);
            const decimals = Math.min(20, Math.max(0, 1 - Math.floor(Math.log10(quarter))));
            const scale = rampScale(range.low, range.high);
            return [...steps.map((value) => ({ colour: cssOf(colourOf(scale, value)), mark: marks.circle, text: String(Number(value.toFixed(decimals))) })), ...missing];
        }
        const groups = groupsOf(label);
        const first = groups.slice(0, groupColours.length).map((text, group) => ({ ...lookOf(group), text }));
        const more = groups.length - first.length;
        const rest = more > 0 ? [{ colour: "none", mark: "", text: `and ${more} more, in the same colours again` }] : [];
        return [...first, ...rest, ...missing];
    }

    /// @param specimen  Null: none.
    mark(specimen: number | null) {
        this.chosen = specimen;
        this.specimens.querySelectorAll(".chosen").forEach((element) => element.classList.remove("chosen"));
        if (specimen !== null) this.specimens.children[specimen]?.classList.add("chosen");
    }

    show(scores: number[]) {
        this.showPoint(scores[this.x], scores[this.y]);
    }
    /// Where the ring is: at the border, where the shape lies beyond it.
    private pointPlace(): [number, number] {
        const [x, y] = this.at;
        return [this.placeOfX(this.clamp(x / this.xReach) * this.xReach), this.placeOfY(this.clamp(y / this.yReach) * this.yReach)];
    }
    private showPoint(x: number, y: number) {
        this.at = [x, y];
        this.point.setAttribute("transform", `translate(${this.pointPlace().join(" ")})`);
        this.point.setAttribute("aria-valuenow", x.toFixed(2));
        this.point.setAttribute("aria-valuetext", `mode ${this.x + 1} ${x.toFixed(2)}, mode ${this.y + 1} ${y.toFixed(2)} standard deviations`);
    }

    /// As a file that needs no style sheet.
    document(): string {
        const copy = this.svg.cloneNode(true) as SVGSVGElement;
        copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
        const most = 54; // letters in the width of the plot
        const cut = (text: string) => (text.length > most ? `${text.slice(0, most - 1)}…` : text);
        const name = this.label < 0 ? [] : [{ colour: "none", mark: "", text: `${this.facts.labels[this.label].name}:` }];
        const key = [...name, ...this.key()].map((entry) => ({ ...entry, text: cut(entry.text) }));
        const columns = Math.max(1, Math.min(3, Math.floor(most / (3 + Math.max(...key.map(({ text }) => text.length))))));
        const line = 16;
        const tall = height + line * Math.ceil(key.length / columns) + (key.length ? 4 : 0);
        copy.setAttribute("viewBox", `0 0 ${width} ${tall}`);
        copy.setAttribute("width", String(2 * width));
        copy.setAttribute("height", String(2 * tall));
        copy.append(this.point.cloneNode(true), ...key.map(({ colour, mark, text }, i) =>
            make("g", { transform: `translate(${left + (i % columns) * ((width - left) / columns)} ${height + line * (Math.floor(i / columns) + 0.5)})` },
                make("path", { d: mark, fill: colour }), make("text", { x: 8, y: 4 }, text))));
        copy.querySelector(".grip")?.remove();
        copy.querySelectorAll("[tabindex]").forEach((element) => element.removeAttribute("tabindex"));
        copy.prepend(make("rect", { width, height: tall, fill: "white" }), make<SVGElement>("g"));
        const style = document.createElementNS("http://www.w3.org/2000/svg", "style");
        style.textContent = "text{font:11px Helvetica,Arial,sans-serif;fill:#333}.grid{stroke:#e4e4e4}.zero{stroke:#999}" +
            ".specimen{fill-opacity:.75}.chosen{stroke:#000}.point circle{fill:none;stroke:#000;stroke-width:2}";
        copy.prepend(style);
        return new XMLSerializer().serializeToString(copy);
    }
}
