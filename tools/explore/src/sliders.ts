// SPDX-License-Identifier: MIT

import { make, percent } from "./dom";
import type { Facts } from "./model";
import { niceAbove } from "./colours";
import { rounded } from "./state";

export interface SliderOptions {
    name: string;
    note: string; // beside the name
    low: number;
    high: number;
    rest: number; // the value of the mean shape
    unit: string; // for assistive technology
    marked?: { from: number; to: number; beyond: string }; // hatched beyond, with what that means
    tidy: (value: number) => number; // what is set, of what was wanted
    onInput: (value: number) => void;
    onChange: () => void;
    onPlay?: () => void;
}

/// A slider with its name, a field for exact values, and a range marked.
export class Slider {
    readonly row: HTMLElement;
    private range: HTMLInputElement;
    private field: HTMLInputElement;
    readonly play: HTMLButtonElement | null = null;
    private shown = NaN;
    private factor = 1; // of the field: typed units a unit of the value

    constructor(private options: SliderOptions) {
        const { name, unit } = options;
        // Numbers that people like are on the way.
        const step = niceAbove((options.high - options.low) / 1000);
        const low = options.tidy(step * Math.floor(options.low / step));
        const high = options.tidy(step * Math.ceil(options.high / step));
        this.range = make<HTMLInputElement>("input", {
            type: "range", min: low, max: high, step, value: options.rest, "aria-label": `${name}, ${unit}`,
            oninput: () => this.take(Number(this.range.value)),
            onchange: () => options.onChange(),
            ondblclick: () => {
                this.take(options.rest);
                options.onChange();
            },
        });
        this.field = make<HTMLInputElement>("input", {
            type: "text", inputmode: "decimal", value: "0", "aria-label": `${name}, exact value`, autocomplete: "off",
            onchange: () => this.typed(),
        });
        if (options.onPlay)
            this.play = make<HTMLButtonElement>("button", { type: "button", class: "play", "aria-label": `Play along ${name}`, "aria-pressed": "false",
                                         onclick: options.onPlay }, "▶");
        const track = make("div", { class: "track" }, this.range);
        if (options.marked) {
            const share = (value: number) => (100 * Math.min(Math.max((value - low) / (high - low), 0), 1)).toFixed(2);
            const { from, to, beyond } = options.marked;
            track.title = `Hatched: ${beyond}`;
            track.prepend(make("span", { class: "beyond", style: `left:0;width:${share(from)}%` }),
                make("span", { class: "beyond", style: `left:${share(to)}%;right:0` }));
        }
        this.row = make("div", { class: "slider" },
            make("span", { class: "name", title: `${name}, ${options.note}` }, make("b", {}, name), ` ${options.note}`), track, this.field, ...(this.play ? [this.play] : []));
    }

    private take(value: number) {
        this.options.onInput(this.options.tidy(value));
    }

    private typed() {
        const text = this.field.value.trim().replace(",", ".").replace("\u2212", "-"); // as texts print minus
        const wrong = !/^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(text) || !Number.isFinite(Number(text));
        this.field.setAttribute("aria-invalid", String(wrong));
        this.field.title = wrong ? "This is no number" : "";
        if (wrong) return;
        const value = Number(text) / this.factor;
        this.take(value);
        this.options.onChange();
    }

    show(value: number) {
        if (value === this.shown && this.field.getAttribute("aria-invalid") !== "true") return;
        this.shown = value;
        this.range.value = String(value);
        this.range.setAttribute("aria-valuetext", `${value.toFixed(2)} ${this.options.unit}`);
        if (document.activeElement !== this.field || this.field.getAttribute("aria-invalid") !== "true") {
            this.field.value = String(Number((value * this.factor).toPrecision(this.factor === 1 ? 7 : 4)));
            this.field.setAttribute("aria-invalid", "false");
        }
        const marked = this.options.marked;
        this.row.classList.toggle("outside", !!marked && (value < marked.from || value > marked.to));
    }

    typeIn(factor: number) {
        this.factor = factor;
        this.shown = NaN;
    }
}

export const sliderReach = 3; // standard deviations to either side

export function modeSlider(facts: Facts, k: number, to: Pick<SliderOptions, "onInput" | "onChange" | "onPlay">): Slider {
    const mode = facts.modes[k];
    const most = Math.max(sliderReach, ...facts.specimens.map(({ scores }) => Math.abs(scores[k] / mode.deviation)));
    const reach = Math.ceil(2 * most) / 2;
    return new Slider({
        name: `mode ${k + 1}`, note: percent(mode.share), low: -reach, high: reach, rest: 0, unit: "standard deviations", tidy: rounded,
        marked: facts.space === "edge" ? { from: mode.low, to: mode.high, beyond: "with the other modes at 0, no mesh has these edge lengths" } : undefined,
        ...to,
    });
}
