// SPDX-License-Identifier: MIT

/// Colour scales that people with any kind of colour vision can read.

export interface Scale {
    stops: [number, number, number][]; // sRGB in [0, 255], evenly spaced
    low: number;
    high: number;
}

const diverging: Scale["stops"] = [[0, 80, 160], [90, 155, 205], [240, 240, 240], [235, 160, 80], [170, 75, 0]];
const sequential: Scale["stops"] = [[235, 235, 225], [205, 195, 130], [130, 150, 120], [70, 100, 115], [20, 40, 90]];

/// A number with at most two leading digits, not below value, that people like: 1, 2 or 5 times a power of 10.
export function niceAbove(value: number): number {
    if (!(value > 0)) return 1;
    const power = 10 ** Math.floor(Math.log10(value));
    return [1, 2, 5, 10].find((factor) => factor * power >= value * (1 - 1e-9))! * power;
}

export const signedScale = (largest: number): Scale => ({ stops: diverging, low: -largest, high: largest });
export const unsignedScale = (largest: number): Scale => ({ stops: sequential, low: 0, high: largest });

/// Of values from low to high, dark enough for marks on white.
export const rampScale = (low: number, high: number): Scale => ({ stops: sequential.slice(1), low, high });

export function colourOf({ stops, low, high }: Scale, value: number): [number, number, number] {
    const place = Math.min(Math.max((value - low) / (high - low || 1), 0), 1) * (stops.length - 1);
    const i = Math.min(Math.floor(place), stops.length - 2);
    const mix = (k: number) => stops[i][k] + (place - i) * (stops[i + 1][k] - stops[i][k]);
    return [mix(0), mix(1), mix(2)];
}

/// Linear RGB in [0, 1], three a value, as WebGL wants it.
export function paint(scale: Scale, values: Float32Array, to: Float32Array) {
    const table = new Float32Array(3 * 256);
    for (let i = 0; i < 256; ++i)
        colourOf(scale, scale.low + (i / 255) * (scale.high - scale.low)).forEach((c, k) => {
            const s = c / 255;
            table[3 * i + k] = s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
        });
    const factor = 255 / (scale.high - scale.low || 1);
    for (let v = 0; v < values.length; ++v) {
        const i = 3 * Math.max(0, Math.min(255, Math.round((values[v] - scale.low) * factor)));
        to[3 * v] = table[i];
        to[3 * v + 1] = table[i + 1];
        to[3 * v + 2] = table[i + 2];
    }
}

export const cssGradient = (scale: Scale) =>
    `linear-gradient(to right, ${scale.stops.map((stop) => `rgb(${stop.join(",")})`).join(", ")})`;

/// Of groups in the score plot (Okabe and Ito).
export const groupColours = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d1f", "#777777"];
/// With them come these, so that nobody needs the colours.
export const groupMarks = ["circle", "square", "triangle", "diamond", "cross", "down", "plus", "bar"];
