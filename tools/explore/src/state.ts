// SPDX-License-Identifier: MIT

import type { Facts } from "./model";

/// Where in the model one is, and nothing else: what undo goes back to and a link restores.
export interface Place {
    scores: number[]; // standard deviations, one a mode
    amounts: number[]; // of the differences
    values: number[]; // of the regressions
}

export const decimals = 4; // of scores and amounts, so that a command line makes the same mesh

export function rounded(value: number): number {
    return Number(value.toFixed(decimals)) || 0;
}

/// Of values in whatever unit: what decimal fractions leave behind, no more.
export function tidied(value: number): number {
    return Number(value.toPrecision(12));
}

export function meanPlace(facts: Facts): Place {
    return {
        scores: facts.modes.map(() => 0),
        amounts: facts.differences.map(() => 0),
        values: facts.regressions.map((regression) => tidied(regression.mean)),
    };
}

export function specimenPlace(facts: Facts, specimen: number): Place {
    const { scores } = facts.specimens[specimen];
    return { ...meanPlace(facts), scores: facts.modes.map((mode, k) => rounded(scores[k] / mode.deviation)) };
}

export function groupPlace(facts: Facts, label: number, value: string): Place {
    const members = facts.specimens.filter((_, i) => facts.labels[label].values[i] === value);
    const mean = (k: number) => members.reduce((sum, { scores }) => sum + scores[k], 0) / members.length;
    return { ...meanPlace(facts), scores: facts.modes.map((mode, k) => rounded(mean(k) / mode.deviation)) };
}

/// Standard deviations along the modes of a place, what regressions add included: nothing where a value is at rest, else what
/// the line says, which goes through the mean of the meshes that have a value.
export function totalScores(facts: Facts, place: Place): number[] {
    const moved = facts.regressions
        .map(({ slope, offset, mean }, r) => ({ slope, offset, by: place.values[r] - tidied(mean) }))
        .filter(({ by }) => by !== 0);
    return facts.modes.map((mode, k) =>
        rounded(moved.reduce((sum, { slope, offset, by }) => sum + (offset[k] + by * slope[k]) / mode.deviation, place.scores[k])));
}

const numbers = (values: number[]) => {
    const last = values.findLastIndex((value) => value !== 0);
    return values.slice(0, last + 1).join(",");
};

/// "s=1.2,0,-0.5&d=0.5&r=31": the text of a link behind its #.
export function linkOf(place: Place, facts: Facts): string {
    const mean = meanPlace(facts);
    const parts = [];
    if (place.scores.some((value) => value !== 0)) parts.push(`s=${numbers(place.scores)}`);
    if (place.amounts.some((value) => value !== 0)) parts.push(`d=${numbers(place.amounts)}`);
    if (place.values.some((value, r) => value !== mean.values[r])) parts.push(`r=${place.values.join(",")}`);
    return parts.join("&");
}

/// What mail programs and the like make of a link, undone.
function unescaped(link: string): string {
    const text = link.replace(/^#/, "").replaceAll("&amp;", "&");
    try {
        return decodeURIComponent(text);
    } catch {
        return text;
    }
}

/// The inverse; null if the text did not come from linkOf().
export function placeOf(link: string, facts: Facts): Place | null {
    const place = meanPlace(facts);
    const fields = new Map([["s", place.scores], ["d", place.amounts], ["r", place.values]]);
    for (const part of unescaped(link).split("&").filter(Boolean)) {
        const [name, text = ""] = part.split("=");
        const values = text.split(",");
        const field = fields.get(name);
        if (!field || values.length > field.length || !values.every((value) => /^-?[\d.]+(e[-+]?\d+)?$/i.test(value) && Number.isFinite(Number(value))))
            return null;
        values.forEach((value, i) => (field[i] = (name === "r" ? tidied : rounded)(Number(value))));
    }
    return place;
}

/// Places one has been at.
export class History {
    private places: string[] = [];
    private at = -1;

    /// Forgets what was undone.
    push(place: Place) {
        const text = JSON.stringify(place);
        if (this.places[this.at] === text) return;
        this.places = [...this.places.slice(0, this.at + 1), text].slice(-500);
        this.at = this.places.length - 1;
    }
    undo(): Place | null {
        return this.at > 0 ? JSON.parse(this.places[--this.at]) : null;
    }
    redo(): Place | null {
        return this.at + 1 < this.places.length ? JSON.parse(this.places[++this.at]) : null;
    }
    get canUndo() {
        return this.at > 0;
    }
    get canRedo() {
        return this.at + 1 < this.places.length;
    }
}
