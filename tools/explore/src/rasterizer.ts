// SPDX-License-Identifier: MIT

/// Draws a mesh on the processor. WebGL in software (SwiftShader, llvmpipe) compiles, copies and waits for every picture, whatever
/// is in it; a loop over the triangles of a mesh of some thousand vertices takes a fraction of that.

import * as THREE from "three";

/// What is drawn.
export interface Solid {
    points: ArrayLike<number>; // x y z of one vertex after the other
    normals: Float32Array;
    faces: Uint32Array;
    colours: Float32Array | null; // linear RGB of every vertex, or null for one colour
    broken: Uint32Array; // corners of faces drawn over the others in one colour
    isClosed: boolean; // no face is seen from behind
}

/// Everything in linear RGB; directions point to the light, in the space of the points.
export interface Lighting {
    colour: THREE.Color;
    broken: THREE.Color;
    lamps: { direction: THREE.Vector3; light: THREE.Color }[];
    up: THREE.Vector3;
    sky: THREE.Color;
    ground: THREE.Color;
}

const tones = 2048;
/// Of linear light in [0, 1] times tones: sRGB in [0, 255].
const encoded = Uint8Array.from({ length: tones + 1 }, (_, i) => {
    const light = i / tones;
    return Math.round(255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055));
});
const encode = (light: number) => encoded[light < 1 ? (light * tones) | 0 : tones];
const opaque = 0xff000000;
const nearer = 2e-4; // of the depth from near to far: by how much broken faces stand out

/// Keeps what a picture needs from one to the next.
export class Rasterizer {
    private image = new ImageData(1, 1);
    private pixels = new Uint32Array(this.image.data.buffer);
    private depth = new Float32Array(1);
    private screen = new Float32Array(0); // x, y [pixels], depth in [-1, 1]; NaN behind the eye
    private shade = new Float32Array(0); // sRGB of the front of every vertex, then of its back

    /// The picture of one sample a pixel, transparent where nothing is.
    /// @param toClip  From the space of the points to clip coordinates.
    draw(solid: Solid, lighting: Lighting, toClip: THREE.Matrix4, width: number, height: number): ImageData {
        if (this.image.width !== width || this.image.height !== height) {
            this.image = new ImageData(width, height);
            this.pixels = new Uint32Array(this.image.data.buffer);
            this.depth = new Float32Array(width * height);
        }
        this.pixels.fill(0);
        this.depth.fill(1);
        this.project(solid.points, toClip, width, height);
        this.light(solid, lighting);
        this.fill(solid.faces, solid.isClosed);
        if (solid.broken.length > 0) this.fillPlain(solid.broken, lighting.broken);
        return this.image;
    }

    private project(points: ArrayLike<number>, { elements: m }: THREE.Matrix4, width: number, height: number) {
        if (this.screen.length !== points.length) this.screen = new Float32Array(points.length);
        const screen = this.screen;
        for (let i = 0; i < points.length; i += 3) {
            const x = points[i], y = points[i + 1], z = points[i + 2];
            const w = m[3] * x + m[7] * y + m[11] * z + m[15];
            const share = w > 0 ? 1 / w : NaN;
            screen[i] = 0.5 * width * (1 + share * (m[0] * x + m[4] * y + m[8] * z + m[12]));
            screen[i + 1] = 0.5 * height * (1 - share * (m[1] * x + m[5] * y + m[9] * z + m[13]));
            screen[i + 2] = share * (m[2] * x + m[6] * y + m[10] * z + m[14]);
        }
    }

    /// Lambert's law: colour / pi times the light that falls on a vertex.
    private light({ normals, colours, isClosed }: Solid, { colour, lamps, up, sky, ground }: Lighting) {
        const count = normals.length;
        if (this.shade.length !== 2 * count) this.shade = new Float32Array(2 * count);
        const shade = this.shade;
        const [a, b] = lamps;
        for (const side of isClosed ? [1] : [1, -1]) {
            const first = side > 0 ? 0 : count;
            for (let i = 0; i < count; i += 3) {
                const x = side * normals[i], y = side * normals[i + 1], z = side * normals[i + 2];
                const fromA = Math.max(0, a.direction.x * x + a.direction.y * y + a.direction.z * z);
                const fromB = Math.max(0, b.direction.x * x + b.direction.y * y + b.direction.z * z);
                const above = 0.5 + 0.5 * (up.x * x + up.y * y + up.z * z);
                const red = a.light.r * fromA + b.light.r * fromB + ground.r + above * (sky.r - ground.r);
                const green = a.light.g * fromA + b.light.g * fromB + ground.g + above * (sky.g - ground.g);
                const blue = a.light.b * fromA + b.light.b * fromB + ground.b + above * (sky.b - ground.b);
                shade[first + i] = encode((red / Math.PI) * (colours ? colours[i] : colour.r));
                shade[first + i + 1] = encode((green / Math.PI) * (colours ? colours[i + 1] : colour.g));
                shade[first + i + 2] = encode((blue / Math.PI) * (colours ? colours[i + 2] : colour.b));
            }
        }
    }

    /// Every pixel whose centre lies in a triangle, p + u (q - p) + v (r - p) with u, v, 1 - u - v >= 0, takes colour and depth
    /// at (u, v), if that is the nearest so far. u and v are affine in x and y: along a row each grows by a constant.
    private fill(faces: Uint32Array, isClosed: boolean) {
        const { screen, shade, depth, pixels } = this;
        const { width, height } = this.image;
        const back = shade.length / 2;
        for (let f = 0; f < faces.length; f += 3) {
            const p = 3 * faces[f], q = 3 * faces[f + 1], r = 3 * faces[f + 2];
            const px = screen[p], py = screen[p + 1];
            const ux = screen[q] - px, uy = screen[q + 1] - py, vx = screen[r] - px, vy = screen[r + 1] - py;
            const area = vx * uy - ux * vy; // positive if seen from its front: y goes down
            if (!(isClosed ? area > 0 : area !== 0)) continue; // nor where a corner is NaN
            const left = Math.max(0, Math.ceil(px + Math.min(0, ux, vx) - 0.5));
            const right = Math.min(width - 1, Math.floor(px + Math.max(0, ux, vx) - 0.5));
            if (left > right) continue;
            const top = Math.max(0, Math.ceil(py + Math.min(0, uy, vy) - 0.5));
            const bottom = Math.min(height - 1, Math.floor(py + Math.max(0, uy, vy) - 0.5));
            const uByX = -vy / area, uByY = vx / area, vByX = uy / area, vByY = -ux / area;
            const pz = screen[p + 2], uz = screen[q + 2] - pz, vz = screen[r + 2] - pz;
            const s = area > 0 ? 0 : back;
            const p0 = shade[s + p], p1 = shade[s + p + 1], p2 = shade[s + p + 2];
            const u0 = shade[s + q] - p0, u1 = shade[s + q + 1] - p1, u2 = shade[s + q + 2] - p2;
            const v0 = shade[s + r] - p0, v1 = shade[s + r + 1] - p1, v2 = shade[s + r + 2] - p2;
            for (let y = top; y <= bottom; ++y) {
                const dx = left + 0.5 - px, dy = y + 0.5 - py;
                let u = uByX * dx + uByY * dy, v = vByX * dx + vByY * dy;
                for (let x = left, at = y * width + left; x <= right; ++x, ++at, u += uByX, v += vByX) {
                    if (u < 0 || v < 0 || u + v > 1) continue;
                    const z = pz + u * uz + v * vz;
                    if (!(z < depth[at])) continue;
                    depth[at] = z;
                    pixels[at] = opaque | ((p2 + u * u2 + v * v2) << 16) | ((p1 + u * u1 + v * v1) << 8) | (p0 + u * u0 + v * v0);
                }
            }
        }
    }

    /// The same in one colour, from both sides, before what lies at the same place.
    private fillPlain(faces: Uint32Array, colour: THREE.Color) {
        const { screen, shade } = this;
        const plain = [encode(colour.r), encode(colour.g), encode(colour.b)];
        for (const v of faces)
            for (let k = 0; k < 3; ++k) shade[3 * v + k] = shade[shade.length / 2 + 3 * v + k] = plain[k];
        for (const v of new Set(faces)) screen[3 * v + 2] -= nearer;
        this.fill(faces, false);
    }
}
