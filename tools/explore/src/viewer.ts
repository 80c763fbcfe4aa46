// SPDX-License-Identifier: MIT

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { make } from "./dom";
import { Rasterizer, type Solid } from "./rasterizer";

const skin = 0xd9ccbd;
const brokenColour = 0xb0006d;

/// Whether the processor draws, for want of a graphics card: then every pixel and every sample of it counts.
function isDrawnBySoftware(): boolean {
    const gl = document.createElement("canvas").getContext("webgl2");
    const info = gl?.getExtension("WEBGL_debug_renderer_info");
    const name = gl && info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
    gl?.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

/// Whether every side of a face is the side of another, the other way round.
function isClosed(faces: Uint32Array): boolean {
    const open = new Set<number>();
    const name = (a: number, b: number) => a * 2 ** 26 + b;
    for (let f = 0; f < faces.length; f += 3)
        for (let k = 0; k < 3; ++k) {
            const [a, b] = [faces[f + k], faces[f + ((k + 1) % 3)]];
            if (!open.delete(name(b, a))) open.add(name(a, b));
        }
    return open.size === 0;
}

/// Draws one mesh that changes, and a ghost of another, seen from anywhere. For want of a graphics card a mesh alone is drawn by
/// our own rasterizer while something moves, on a sheet before the canvas, with a quarter of the pixels; what else there is, and
/// every picture once nothing moves, by WebGL, then with four pixels for one. docs/explore.md says what each costs.
export class Viewer {
    private renderer: THREE.WebGLRenderer;
    private scene = new THREE.Scene();
    private camera = new THREE.PerspectiveCamera(24, 1, 0.01, 100);
    private controls: OrbitControls;
    private model = new THREE.Group();
    private geometry = new THREE.BufferGeometry();
    private isSoftware = isDrawnBySoftware();
    private softwareRatio = 0.5; // pixels drawn for one of the screen, along each side, while something moves
    private material = this.isSoftware
        ? new THREE.MeshLambertMaterial({ color: skin, side: THREE.DoubleSide })
        : new THREE.MeshStandardMaterial({ color: skin, roughness: 0.62, side: THREE.DoubleSide });
    private broken: THREE.Mesh;
    private brokenGeometry = new THREE.BufferGeometry();
    private ghost: THREE.Mesh;
    private ghostGeometry = new THREE.BufferGeometry();
    private wires: THREE.Mesh;
    private lamps = [new THREE.DirectionalLight(0xfff8ef, 2.1), new THREE.DirectionalLight(0xdfeaff, 0.5)];
    private air = new THREE.HemisphereLight(0xf4f8ff, 0x98908a, 1.15);
    private rasterizer = new Rasterizer();
    private sheet: HTMLCanvasElement | null = null; // what the rasterizer draws; hidden while WebGL's picture is seen
    private solid: Solid | null = null;
    private isClosed = false;
    private centre = new THREE.Vector3();
    private radius = 1;
    private wanted = false;
    private drawn: number[] = []; // moments of the last frames
    private smoothing: ReturnType<typeof setTimeout> | undefined;
    frames = 0;

    /// @throws if the browser has no WebGL.
    constructor(private canvas: HTMLCanvasElement, view: number[]) {
        this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !this.isSoftware, alpha: true });
        this.renderer.setPixelRatio(this.pixelRatio);
        this.lamps[0].position.set(-0.6, 0.7, 1);
        this.lamps[1].position.set(0.8, -0.2, 0.6);
        this.camera.add(...this.lamps);
        this.scene.add(this.camera, this.air, this.model);
        this.model.visible = false; // until there is a shape: what is drawn without normals stays faceted
        this.model.matrixAutoUpdate = false;
        const [a, b, c, d, e, f, g, h, i] = view;
        this.model.matrix.set(a, b, c, 0, d, e, f, 0, g, h, i, 0, 0, 0, 0, 1);

        const brokenMaterial = new THREE.MeshBasicMaterial({
            color: brokenColour, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2,
        });
        const wireMaterial = new THREE.MeshBasicMaterial({ color: 0x1d2733, wireframe: true, transparent: true, opacity: 0.35 });
        const ghostMaterial = new THREE.MeshStandardMaterial({
            color: 0x4f7fae, transparent: true, opacity: 0.32, side: THREE.DoubleSide, depthWrite: false,
        });
        this.broken = new THREE.Mesh(this.brokenGeometry, brokenMaterial);
        this.wires = new THREE.Mesh(this.geometry, wireMaterial);
        this.wires.visible = false;
        this.ghost = new THREE.Mesh(this.ghostGeometry, ghostMaterial);
        this.ghost.visible = false;
        this.ghost.renderOrder = 1;
        this.model.add(new THREE.Mesh(this.geometry, this.material), this.broken, this.wires, this.ghost);
        this.model.traverse((object) => (object.frustumCulled = false));

        this.controls = new OrbitControls(this.camera, canvas);
        this.controls.enableDamping = false;
        this.controls.addEventListener("change", () => this.draw());
        if (this.isSoftware) {
            this.sheet = make<HTMLCanvasElement>("canvas", { class: "sheet", "aria-hidden": "true" });
            this.sheet.hidden = true;
            canvas.after(this.sheet);
        }
        canvas.addEventListener("webglcontextrestored", () => this.draw());
        new ResizeObserver(() => this.resize()).observe(canvas);
    }

    setFaces(faces: Uint32Array, vertices: number) {
        const index = new THREE.BufferAttribute(faces, 1);
        const position = new THREE.BufferAttribute(new Float32Array(3 * vertices), 3).setUsage(THREE.DynamicDrawUsage);
        const normal = new THREE.BufferAttribute(new Float32Array(3 * vertices), 3).setUsage(THREE.DynamicDrawUsage);
        const color = new THREE.BufferAttribute(new Float32Array(3 * vertices).fill(1), 3);
        this.geometry.setIndex(index).setAttribute("position", position).setAttribute("normal", normal);
        this.geometry.setAttribute("color", color);
        this.brokenGeometry.setAttribute("position", position);
        this.brokenGeometry.setIndex([]);
        this.isClosed = isClosed(faces);
        if (this.isSoftware && this.isClosed) this.material.side = THREE.FrontSide;
        this.ghostGeometry.setIndex(index);
        this.ghostGeometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * vertices), 3));
        this.ghostGeometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(3 * vertices), 3));
    }

    /// @param colours  Three a vertex (colours.ts), or null for skin.
    setShape(points: Float64Array, normals: Float32Array, broken: Uint32Array, colours: Float32Array | null) {
        const { position, normal, color } = this.geometry.attributes as Record<string, THREE.BufferAttribute>;
        position.array.set(points);
        normal.array.set(normals);
        position.needsUpdate = normal.needsUpdate = true;
        if (colours) {
            color.array.set(colours);
            color.needsUpdate = true;
        }
        if (this.material.vertexColors !== !!colours) {
            this.material.vertexColors = !!colours;
            this.material.color.set(colours ? 0xffffff : skin);
            this.material.needsUpdate = true;
        }
        this.broken.visible = broken.length > 0;
        if (broken.length > 0) this.brokenGeometry.setIndex(new THREE.BufferAttribute(broken, 1));
        const faces = this.geometry.index!.array as Uint32Array;
        this.solid = { points, normals, faces, colours, broken, isClosed: this.isClosed };
        this.model.visible = true;
        this.draw();
    }

    setGhost(shape: { points: Float64Array; normals: Float32Array } | null) {
        this.ghost.visible = !!shape;
        if (shape) {
            const { position, normal } = this.ghostGeometry.attributes as Record<string, THREE.BufferAttribute>;
            position.array.set(shape.points);
            normal.array.set(shape.normals);
            position.needsUpdate = normal.needsUpdate = true;
        }
        this.draw();
    }

    setWireframe(on: boolean) {
        this.wires.visible = on;
        this.draw();
    }

    /// Makes a mesh fill the picture.
    frame(points: Float64Array) {
        const box = new THREE.Box3();
        const point = new THREE.Vector3();
        for (let i = 0; i < points.length; i += 3)
            box.expandByPoint(point.set(points[i], points[i + 1], points[i + 2]).applyMatrix4(this.model.matrix));
        box.getCenter(this.centre);
        this.radius = 0.5 * box.getSize(point).length() || 1;
        this.lookFrom([0, 0, 1]);
    }

    /// @param direction  From the mesh to the eye, x to the right and y up in the first view.
    lookFrom(direction: [number, number, number]) {
        const distance = (1.02 * this.radius) / Math.sin((0.5 * this.camera.fov * Math.PI) / 180) / Math.min(1, this.camera.aspect ** 0.7);
        this.camera.near = 0.02 * distance;
        this.camera.far = 10 * distance;
        this.controls.minDistance = 0.25 * distance; // not through the mesh
        this.controls.maxDistance = 8 * distance; // nor out of what is drawn
        this.camera.position.set(...direction).normalize().multiplyScalar(distance).add(this.centre);
        this.controls.target.copy(this.centre);
        this.camera.updateProjectionMatrix();
        this.controls.update();
        this.draw();
    }

    /// By the keyboard: angles [rad] and a factor of the distance.
    turn(right: number, up: number, nearer = 1) {
        const eye = this.camera.position.clone().sub(this.controls.target);
        const spherical = new THREE.Spherical().setFromVector3(eye);
        spherical.theta += right;
        spherical.phi += up;
        spherical.radius *= nearer;
        spherical.makeSafe();
        this.camera.position.setFromSpherical(spherical).add(this.controls.target);
        this.controls.update();
        this.draw();
    }

    pan(right: number, up: number) {
        const shift = new THREE.Vector3(right, up, 0).multiplyScalar(this.radius).applyQuaternion(this.camera.quaternion);
        this.camera.position.add(shift);
        this.controls.target.add(shift);
        this.controls.update();
        this.draw();
    }

    private resize() {
        const { clientWidth, clientHeight } = this.canvas;
        if (!clientWidth || !clientHeight) return;
        this.renderer.setSize(clientWidth, clientHeight, false);
        this.camera.aspect = clientWidth / clientHeight;
        this.camera.updateProjectionMatrix();
        this.draw();
    }

    private get pixelRatio() {
        return Math.min(devicePixelRatio, this.isSoftware ? this.softwareRatio : 2);
    }

    /// Draws once with four pixels for one, which the browser averages.
    private drawSmoothly() {
        this.renderer.setPixelRatio(2 * Math.min(devicePixelRatio, 1));
        this.renderer.render(this.scene, this.camera);
        this.showSheet(false);
    }

    /// In place of what WebGL drew, which the browser need not put together with the page meanwhile.
    private showSheet(on: boolean) {
        if (!this.sheet || this.sheet.hidden === !on) return;
        this.sheet.hidden = !on;
        this.canvas.style.opacity = on ? "0" : "";
    }

    /// The mesh alone, on the sheet.
    private drawOnSheet(sheet: HTMLCanvasElement, solid: Solid) {
        const ratio = Math.min(devicePixelRatio, 1);
        const width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
        const height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
        if (sheet.width !== width) sheet.width = width;
        if (sheet.height !== height) sheet.height = height;
        this.camera.updateMatrixWorld();
        const toModel = this.model.matrix.clone().invert();
        const toClip = this.camera.projectionMatrix.clone().multiply(this.camera.matrixWorldInverse).multiply(this.model.matrix);
        const lit = (light: THREE.Light) => light.color.clone().multiplyScalar(light.intensity);
        const picture = this.rasterizer.draw(solid, {
            colour: new THREE.Color(skin),
            broken: new THREE.Color(brokenColour),
            lamps: this.lamps.map((lamp) => ({
                direction: lamp.position.clone().applyMatrix4(this.camera.matrixWorld).transformDirection(toModel),
                light: lit(lamp),
            })),
            up: new THREE.Vector3(0, 1, 0).transformDirection(toModel),
            sky: lit(this.air),
            ground: this.air.groundColor.clone().multiplyScalar(this.air.intensity),
        }, toClip, width, height);
        sheet.getContext("2d", { willReadFrequently: true })!.putImageData(picture, 0, 0);
        this.showSheet(true);
    }

    private drawMoving() {
        if (this.sheet && this.solid && !this.ghost.visible && !this.wires.visible) return this.drawOnSheet(this.sheet, this.solid);
        if (this.renderer.getPixelRatio() !== this.pixelRatio) this.renderer.setPixelRatio(this.pixelRatio);
        this.renderer.render(this.scene, this.camera);
        this.showSheet(false);
    }

    /// With the next frame of the screen.
    draw() {
        if (this.wanted) return;
        this.wanted = true;
        if (this.isSoftware) {
            clearTimeout(this.smoothing);
            this.smoothing = setTimeout(() => this.drawSmoothly(), 400);
        }
        requestAnimationFrame(() => {
            this.wanted = false;
            this.drawMoving();
            ++this.frames;
            const now = performance.now();
            this.drawn = [...this.drawn.filter((moment) => moment > now - 1000), now];
        });
    }

    get framesASecond() {
        const now = performance.now();
        return this.drawn.filter((moment) => moment > now - 1000).length;
    }

    /// What is seen, as PNG.
    picture(background: string): Promise<Blob> {
        this.renderer.setClearColor(background, 1);
        if (this.isSoftware) this.drawSmoothly();
        else this.renderer.render(this.scene, this.camera);
        return new Promise((done, fail) =>
            this.canvas.toBlob((blob) => {
                this.renderer.setClearColor(0x000000, 0);
                this.draw();
                if (blob) done(blob);
                else fail(new Error("the browser made no picture"));
            }, "image/png"),
        );
    }
}
