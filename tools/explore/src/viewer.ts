// SPDX-License-Identifier: MIT

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const skin = 0xd9ccbd;

/// Draws one mesh that changes, and a ghost of another, seen from anywhere.
export class Viewer {
    private renderer: THREE.WebGLRenderer;
    private scene = new THREE.Scene();
    private camera = new THREE.PerspectiveCamera(24, 1, 0.01, 100);
    private controls: OrbitControls;
    private model = new THREE.Group();
    private geometry = new THREE.BufferGeometry();
    private material = new THREE.MeshStandardMaterial({ color: skin, roughness: 0.62, side: THREE.DoubleSide });
    private broken: THREE.Mesh;
    private brokenGeometry = new THREE.BufferGeometry();
    private ghost: THREE.Mesh;
    private ghostGeometry = new THREE.BufferGeometry();
    private wires: THREE.Mesh;
    private centre = new THREE.Vector3();
    private radius = 1;
    private wanted = false;
    private drawn: number[] = []; // moments of the last frames
    frames = 0;

    /// @throws if the browser has no WebGL.
    constructor(private canvas: HTMLCanvasElement, view: number[]) {
        this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
        this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
        const lamp = new THREE.DirectionalLight(0xfff8ef, 2.1);
        lamp.position.set(-0.6, 0.7, 1);
        const back = new THREE.DirectionalLight(0xdfeaff, 0.5);
        back.position.set(0.8, -0.2, 0.6);
        this.camera.add(lamp, back);
        this.scene.add(this.camera, new THREE.HemisphereLight(0xf4f8ff, 0x98908a, 1.15), this.model);
        this.model.matrixAutoUpdate = false;
        const [a, b, c, d, e, f, g, h, i] = view;
        this.model.matrix.set(a, b, c, 0, d, e, f, 0, g, h, i, 0, 0, 0, 0, 1);

        const brokenMaterial = new THREE.MeshBasicMaterial({
            color: 0xb0006d, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2,
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

    /// With the next frame of the screen.
    draw() {
        if (this.wanted) return;
        this.wanted = true;
        requestAnimationFrame(() => {
            this.wanted = false;
            this.renderer.render(this.scene, this.camera);
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
        this.renderer.render(this.scene, this.camera);
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
