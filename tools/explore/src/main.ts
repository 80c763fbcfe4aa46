// SPDX-License-Identifier: MIT

import { niceAbove, paint, signedScale, unsignedScale, cssGradient, type Scale } from "./colours";
import { Decoder, type Target } from "./decoder";
import { find, make, percent } from "./dom";
import { commandOf, csvOf, glbOf, objOf, plyOf, save, stemOf, withLegend } from "./exports";
import { bytesOf, readFacts, takeBytes } from "./model";
import { groupsOf, ScorePlot } from "./plot";
import { copied, displacement, type Quality, type Shape } from "./shape";
import { modeSlider, Slider } from "./sliders";
import { groupPlace, History, linkOf, meanPlace, placeOf, rounded, specimenPlace, tidied, totalScores, type Place } from "./state";
import { Viewer } from "./viewer";

const facts = readFacts();
const history = new History();
const linked = placeOf(location.hash, facts);
let place: Place = linked ?? meanPlace(facts);
let faces = new Uint32Array(0);
let shown: Shape | null = null;
const means: { preview: Shape | null; fine: Shape | null } = { preview: null, fine: null };
let pinned: Shape | null = null;
let failure = ""; // why there is no mesh of the place
let viewer: Viewer;
let decoder: Decoder;

const say = (text: string) => (find("#said").textContent = text);

// What cannot be shown, and what is shown instead.

function fallBack(reason: string) {
    find("main").hidden = true;
    find("#help").hidden = true;
    const section = find("#fallback");
    section.hidden = false;
    section.prepend(make("p", { class: "warning", role: "alert" }, `${reason} Here are pictures and figures of the model instead.`));
    find("#tables").toggleAttribute("open", true);
}

function missing(): string {
    if (typeof WebAssembly !== "object") return "This browser has no WebAssembly, which makes the meshes.";
    try {
        viewer = new Viewer(find<HTMLCanvasElement>("#canvas"), facts.view);
        return "";
    } catch {
        return "This browser has no WebGL, which draws the meshes.";
    }
}

// Where one is, and what it looks like.

const coordinates = (at: Place) => totalScores(facts, at).map((score, k) => score * facts.modes[k].deviation);

/// What is decoded for a place, which may change afterwards.
const targetOf = (at: Place): Target => {
    const copy = structuredClone(at);
    return { place: copy, scores: coordinates(copy), amounts: copy.amounts, size: facts.size };
};
const isSame = (a: Place, b: Place) => JSON.stringify(a) === JSON.stringify(b);

function show() {
    failure = ""; // of the place before; what is dimmed stays so until there is a mesh
    decoder.show(targetOf(place));
    const scores = totalScores(facts, place);
    if (specimen && !isSame(specimen, place)) forgetSpecimen();
    modeSliders.forEach((slider, k) => slider.show(place.scores[k]));
    amountSliders.forEach((slider, i) => slider.show(place.amounts[i]));
    valueSliders.forEach((slider, i) => slider.show(place.values[i]));
    plot?.show(scores);
    tellWhenCalm();
}

/// Ends a move: what undo goes back to, and what the address says.
function settle() {
    history.push(place);
    showHistory();
}

function showHistory() {
    find<HTMLButtonElement>("#undo").disabled = !history.canUndo && !playing;
    find<HTMLButtonElement>("#redo").disabled = !history.canRedo;
}

/// The address and the command follow when nothing has moved for a while: each change of them keeps the browser busy, and
/// browsers ignore more than some hundred of the address a minute.
let calm: ReturnType<typeof setTimeout> | undefined;

function tellWhenCalm() {
    clearTimeout(calm);
    calm = setTimeout(tellPlace, 200);
}

function tellPlace() {
    clearTimeout(calm);
    const link = linkOf(place, facts);
    window.history.replaceState(null, "", link ? `#${link}` : location.pathname + location.search);
    showCommand();
}

function goTo(to: Place, text = "") {
    stopPlaying();
    place = to;
    show();
    settle();
    say(text);
}

function showCommand() {
    const command = failure ? null : commandOf(facts, place, shown?.quality ?? "preview");
    find("#command").textContent = command ?? (failure ? "None: there is no mesh here." : "None: `shape generate` adds no differences. Save the mesh instead.");
    find<HTMLButtonElement>("#copy-command").disabled = command === null;
    const scores = find<HTMLButtonElement>("[data-save=csv]");
    const isDifference = place.amounts.some((amount) => amount !== 0);
    scores.disabled = isDifference;
    scores.title = isDifference ? "Scores hold no differences. Save the mesh instead." : "";
}

// The mesh and its certificate.

/// Three digits; what rounding leaves is nothing.
function digits(value: number): string {
    if (value < 1e-9) return "0";
    const text = value.toPrecision(3);
    return text.includes("e") ? String(Number(text)) : text;
}

function showCertificate({ certificate, quality, milliseconds }: Shape) {
    const status = find("#status");
    status.textContent = certificate.status;
    status.className = certificate.status;
    find("#quality").textContent = facts.space === "procrustes" ? "linear model" : quality;
    find("#edge-rms").textContent = `${digits(100 * certificate.edgeRms)} %`;
    find("#edge-max").textContent = `${digits(100 * certificate.edgeMax)} %`;
    find("#drift").textContent = `${digits(certificate.driftP99)}°`;
    find("#inverted").textContent = String(certificate.invertedFaces);
    const { crossings, newCrossings } = certificate;
    find("#crossings").textContent = crossings < 0 ? "…" : crossings === newCrossings ? String(crossings) : `${crossings}, ${newCrossings} of them new`;
    find("#time").textContent = `${milliseconds.toFixed(milliseconds < 10 ? 1 : 0)} ms`;
    giveReason(certificate.reason ? `${certificate.reason}; the nearest mesh is shown.` : "");
}

function giveReason(text: string) {
    find("#reason").textContent = find("#reason").title = text;
}

/// What stays on the screen is another mesh, which must not look like the one that was asked for.
function tellFailure(message: string) {
    failure = message;
    find("#status").textContent = "no mesh";
    find("#status").className = "infeasible";
    for (const id of ["quality", "edge-rms", "edge-max", "drift", "inverted", "crossings", "time"]) find(`#${id}`).textContent = "";
    giveReason(`There is no mesh here: ${message}.${shown ? " The last one that there was is shown, dimmed." : ""}`);
    find("#window").classList.add("stale");
    find("#waiting").textContent = "There is no mesh here; the mean is one.";
    showCommand();
}

const effects = facts.effects ? new Float32Array(bytesOf(facts.effects.values).buffer) : null;
const largest = { displacement: 0, edge: 0, drift: 0 }; // grows only while one drags, so that a scale stays

/// Values at vertices, their scale, and what they are called.
function colouring(shape: Shape): { values: Float32Array; scale: Scale; name: string; print: (value: number) => string } | null {
    const grown = (kind: keyof typeof largest, values: Float32Array) => {
        let most = 0;
        for (const value of values) most = Math.max(most, Math.abs(value));
        return (largest[kind] = Math.max(shape.quality === "fine" ? 0 : largest[kind], niceAbove(most)));
    };
    switch (find<HTMLSelectElement>("#colour").value) {
        case "displacement": {
            const mean = shape.quality === "fine" ? means.fine : means.preview; // made alike: the mean is nowhere from itself
            if (!mean) return null;
            const values = displacement(shape, mean);
            return { values, scale: signedScale(grown("displacement", values)), name: "from the mean, along its normal [unit of the meshes]", print: (v) => String(Number(v.toPrecision(3))) };
        }
        case "edge":
            return { values: shape.edgeError, scale: unsignedScale(grown("edge", shape.edgeError)), name: "worst relative error of the edges at a vertex", print: (v) => `${Number((100 * v).toPrecision(3))} %` };
        case "drift":
            return { values: shape.drift, scale: unsignedScale(grown("drift", shape.drift)), name: "largest dihedral drift at a vertex", print: (v) => `${Number(v.toPrecision(3))}°` };
        case "effects": {
            let most = 0;
            for (const value of effects!) most = Math.max(most, Math.abs(value));
            return { values: effects!, scale: signedScale(niceAbove(most)), name: facts.effects!.name, print: (v) => String(Number(v.toPrecision(3))) };
        }
        default:
            return null;
    }
}

let colours = new Float32Array(0);

function draw() {
    if (shown) drawShape(shown);
}

function drawShape(shape: Shape) {
    const colour = colouring(shape);
    find("#legend").hidden = !colour;
    if (colour) {
        if (colours.length !== 3 * colour.values.length) colours = new Float32Array(3 * colour.values.length);
        paint(colour.scale, colour.values, colours);
        find("#legend-low").textContent = colour.print(colour.scale.low);
        find("#legend-high").textContent = colour.print(colour.scale.high);
        find("#legend-name").textContent = colour.name;
        find("#legend i").style.background = cssGradient(colour.scale);
    }
    viewer.setShape(shape.points, shape.normals, shape.broken, colour ? colours : null);
}

let shapes = 0; // that came since the page was opened
const last: Record<Quality, Shape | null> = { draft: null, preview: null, fine: null };

function take(shape: Shape) {
    const isFirst = !shown;
    shown = shape;
    failure = "";
    find("#window").classList.remove("stale");
    last[shape.quality] = shape;
    ++shapes;
    showCertificate(shape);
    draw();
    if (shape.quality === "fine") showCommand();
    if (isFirst) {
        viewer.frame(shape.points);
        find<HTMLSelectElement>("#view").value = "front";
        find("#waiting").hidden = true;
    }
}

/// The fine mesh of a place, which stays that of the click whatever moves meanwhile: what is taken away is what the command makes.
async function fineShape(at: Place): Promise<Shape> {
    if (shown?.quality === "fine" && isSame(shown.place, at)) return shown;
    say("Waiting for the fine mesh …");
    return decoder.once(targetOf(at), "fine");
}

function showGhost() {
    const kind = find<HTMLSelectElement>("#ghost").value;
    viewer.setGhost(kind === "mean" ? (means.fine ?? means.preview) : kind === "pin" ? pinned : null);
}

/// A shape beside the one shown becomes the ghost.
function pin(shape: Shape | null, name: string) {
    if (!shape) return;
    pinned = copied(shape);
    find<HTMLSelectElement>("#ghost").value = "pin";
    const option = find<HTMLOptionElement>("#ghost option[value=pin]");
    option.disabled = false;
    option.textContent = name;
    showGhost();
}

// Sliders.

let playing: { slider: Slider; k: number; begin: number } | null = null;

function stopPlaying() {
    playing?.slider.play?.setAttribute("aria-pressed", "false");
    playing = null;
}

/// Back and forth along a mode, within its feasible range and two standard deviations.
function playAlong(k: number) {
    const was = playing?.k;
    stopPlaying();
    if (was === k) return settle();
    settle();
    say("");
    const mode = facts.modes[k];
    const [low, high] = facts.space === "edge" ? [Math.max(-2, mode.low), Math.min(2, mode.high)] : [-2, 2];
    const now = place.scores[k];
    const share = Math.max(-1, Math.min(1, now > 0 ? now / (high || 1) : -now / (low || 1)));
    const radians = 700; // [ms]
    playing = { slider: modeSliders[k], k, begin: performance.now() - radians * Math.asin(share) };
    playing.slider.play!.setAttribute("aria-pressed", "true");
    showHistory();
    const step = (now: number) => {
        if (playing?.k !== k) return;
        const phase = Math.sin((now - playing.begin) / radians);
        place.scores[k] = rounded(phase >= 0 ? phase * high : -phase * low);
        show();
        requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
}

const moved = (change: (value: number) => void) => (value: number) => {
    stopPlaying();
    say("");
    change(value);
    show();
};
const modeSliders = facts.modes.map((_, k) =>
    modeSlider(facts, k, { onInput: moved((value) => (place.scores[k] = value)), onChange: settle, onPlay: () => playAlong(k) }));
const amountSliders = facts.differences.map(
    ({ name, meaning }, i) => new Slider({
        name, note: meaning, low: -1, high: 2, rest: 0, unit: "times the difference", tidy: rounded,
        onInput: moved((value) => (place.amounts[i] = value)), onChange: settle,
    }));
const valueSliders = facts.regressions.map(
    ({ name, low, high, mean, meshes }, i) => new Slider({
        name, note: meshes < facts.specimens.length ? `of ${meshes} meshes` : "regression",
        marked: { from: low, to: high, beyond: "beyond the values of the meshes" }, low: low - 0.25 * (high - low), high: high + 0.25 * (high - low), rest: tidied(mean), unit: `units of ${name}`, tidy: tidied,
        onInput: moved((value) => (place.values[i] = value)), onChange: settle,
    }));
let plot: ScorePlot | null = null;

function setUpSliders() {
    const first = 10;
    const rows = modeSliders.map(({ row }) => row);
    find("#modes").append(...rows);
    rows.slice(first).forEach((row) => (row.hidden = true));
    const more = find<HTMLButtonElement>("#more");
    more.hidden = rows.length <= first;
    more.textContent = `all ${rows.length} modes`;
    more.onclick = () => {
        rows.forEach((row) => (row.hidden = false));
        more.hidden = true;
        rows[first].querySelector<HTMLInputElement>("input")!.focus();
    };
    const additions = [...valueSliders, ...amountSliders].map(({ row }) => row);
    if (additions.length > 0) find("#additions").append(make("h2", {}, "Differences and regressions"), ...additions);
    const typed = find<HTMLSelectElement>("#typed");
    typed.onchange = () => {
        modeSliders.forEach((slider, k) => slider.typeIn(typed.value === "scores" ? facts.modes[k].deviation : 1));
        modeSliders.forEach((slider, k) => slider.show(place.scores[k]));
    };
}

// Meshes, groups and the plane of their scores.

let specimen: Place | null = null; // while one is there

function goToSpecimen(i: number) {
    const { name, size } = facts.specimens[i];
    const to = specimenPlace(facts, i);
    specimen = structuredClone(to);
    goTo(to, `The model's shape of ${name}.`);
    plot?.mark(i);
    find<HTMLSelectElement>("#specimen").value = String(i);
    const labels = facts.labels.map(({ name, values }) => `${name}: ${values[i] || "none"}`);
    find("#specimen-ghost").hidden = false;
    find("#specimen-facts").textContent = [...labels, `size ${Number(size.toPrecision(5))}`].join(", ");
}

function forgetSpecimen() {
    specimen = null;
    plot?.mark(null);
    find<HTMLSelectElement>("#specimen").value = "";
    find("#specimen-ghost").hidden = true;
    find("#specimen-facts").textContent = "";
}

function setUpPlot() {
    if (facts.modes.length > 1) {
        plot = new ScorePlot(facts, (x, y, ended) => {
            stopPlaying();
            say("");
            const extra = totalScores(facts, { ...place, scores: facts.modes.map(() => 0) });
            place.scores[plot!.x] = rounded(x - extra[plot!.x]);
            place.scores[plot!.y] = rounded(y - extra[plot!.y]);
            show();
            if (ended) settle();
        }, goToSpecimen);
        const choose = (axis: "x" | "y", name: string) => {
            const select = make<HTMLSelectElement>("select", { id: `axis-${axis}`, onchange: () => {
                plot![axis] = Number(select.value);
                plot!.redraw();
                plot!.show(totalScores(facts, place));
            } }, ...facts.modes.map((_, k) => make("option", { value: k }, `mode ${k + 1}`)));
            select.value = String(plot![axis]);
            return make("label", {}, `${name} `, select);
        };
        const key = make("div", { class: "key" });
        const label = make<HTMLSelectElement>("select", { id: "plot-label", onchange: () => colourBy(Number(label.value)) },
            make("option", { value: -1 }, "one colour"), ...facts.labels.map(({ name }, i) => make("option", { value: i }, name)));
        const colourBy = (i: number) => {
            plot!.label = i;
            plot!.redraw();
            key.replaceChildren(...plot!.key().map(({ text, colour, mark }) =>
                make("span", {}, make("svg", { viewBox: "-4 -4 8 8", "aria-hidden": "true" }, make("path", { d: mark, fill: colour })), text)));
            setUpGroups(i);
        };
        find("#plot").append(make("div", { class: "bar" }, choose("x", "across"), choose("y", "up"),
            ...(facts.labels.length ? [make("label", {}, "by ", label)] : [])), plot.element, key);
        const initial = facts.labels.findIndex(({ name }) => name === facts.colorBy);
        label.value = String(initial);
        colourBy(initial);
    }
    const select = find<HTMLSelectElement>("#specimen");
    select.append(...facts.specimens.map(({ name }, i) => make("option", { value: i }, name)));
    select.onchange = () => select.value && goToSpecimen(Number(select.value));
}

/// The mean of every group as a button.
function setUpGroups(label: number) {
    const groups = find("#groups");
    const values = label < 0 ? [] : groupsOf(facts.labels[label]);
    groups.hidden = values.length === 0 || values.length > 30;
    groups.replaceChildren(`mean of ${facts.labels[label]?.name ?? ""}`, ...values.map((value) =>
        make("button", { type: "button", onclick: () => goTo(groupPlace(facts, label, value), `The mean of ${facts.labels[label].name} ${value}.`) }, value)));
}

// Buttons and keys.

/// A standard normal number (Box and Muller).
const normal = () => Math.sqrt(-2 * Math.log(1 - Math.random())) * Math.cos(2 * Math.PI * Math.random());

async function goToRandom() {
    const to = { ...meanPlace(facts), scores: facts.modes.map(() => normal()) };
    const share = await decoder.feasibleShare(targetOf(to));
    to.scores = to.scores.map((score) => rounded(share * score));
    goTo(to, share < 1 ? `A random shape, brought to ${percent(share, 0)} of its distance from the mean, where its edge lengths are feasible.` : "A random shape.");
}

function goBack(step: () => Place | null) {
    if (playing) {
        stopPlaying();
        settle();
    }
    const to = step();
    if (!to) return;
    place = to;
    show();
    say("");
    showHistory();
}

const views: Record<string, [number, number, number]> = {
    front: [0, 0, 1], back: [0, 0, -1], left: [-1, 0, 0], right: [1, 0, 0], top: [0, 1, 0.001], bottom: [0, -1, 0.001],
};

function showFrames(on: boolean) {
    const output = find("#frames");
    output.hidden = !on;
    let [lastShapes, last] = [shapes, performance.now()];
    const count = () => {
        if (output.hidden) return;
        const now = performance.now();
        output.textContent = `${viewer.framesASecond} frames/s, ${((1000 * (shapes - lastShapes)) / (now - last)).toFixed(0)} meshes/s`;
        [lastShapes, last] = [shapes, now];
        setTimeout(count, 500);
    };
    count();
}

function setUpButtons() {
    const on = (id: string, work: () => void) => find(id).addEventListener("click", work);
    on("#mean", () => goTo(meanPlace(facts), "The mean."));
    on("#random", goToRandom);
    on("#undo", () => goBack(() => history.undo()));
    on("#redo", () => goBack(() => history.redo()));
    on("#pin", () => {
        const isThere = shown && !failure;
        if (isThere) pin(shown, "pinned shape");
        say(isThere ? "The shape shown is the ghost now." : "There is no mesh to pin.");
    });
    find("#colour").addEventListener("change", draw);
    find("#ghost").addEventListener("change", showGhost);
    const view = find<HTMLSelectElement>("#view");
    view.onchange = () => viewer.lookFrom(views[view.value]);
    const wireframe = find<HTMLInputElement>("#wireframe");
    wireframe.onchange = () => viewer.setWireframe(wireframe.checked);
    const rate = find<HTMLInputElement>("#rate");
    rate.onchange = () => showFrames(rate.checked);
    for (const kind of ["pointerdown", "wheel"]) find("#canvas").addEventListener(kind, () => (view.value = ""));
    find("#canvas").addEventListener("webglcontextlost", () => say("The browser took the graphics away; the mesh comes back with them."));
    on("#specimen-ghost", async () => {
        const i = Number(find<HTMLSelectElement>("#specimen").value);
        pin(await decoder.once(targetOf(specimenPlace(facts, i)), "fine"), facts.specimens[i].name);
        say(`${facts.specimens[i].name} is the ghost now.`);
    });

    const copy = (text: string, what: string) =>
        navigator.clipboard.writeText(text).then(() => say(`${what} copied.`), () => say(`Copy it by hand: ${text}`));
    on("#copy-link", () => {
        settle();
        tellPlace();
        copy(location.href, "Link");
    });
    on("#copy-command", () => {
        tellPlace();
        copy(find("#command").textContent!, "Command");
    });
    document.querySelectorAll<HTMLElement>("[data-save]").forEach((button) =>
        button.addEventListener("click", () => saveAs(button.dataset.save!)));

    find("#canvas").addEventListener("keydown", (event) => {
        const { key, ctrlKey, altKey, metaKey } = event as KeyboardEvent;
        if (ctrlKey || altKey || metaKey) return; // the browser's
        const [x, y] = ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] } as Record<string, [number, number]>)[key] ?? [0, 0];
        const standard = Object.keys(views)["123456".indexOf(key)];
        if (x || y) {
            if ((event as KeyboardEvent).shiftKey) viewer.pan(-0.05 * x, 0.05 * y);
            else viewer.turn(0.12 * x, 0.12 * y);
        } else if (key === "+" || key === "=") viewer.turn(0, 0, 0.9);
        else if (key === "-") viewer.turn(0, 0, 1 / 0.9);
        else if (standard) viewer.lookFrom(views[standard]);
        else return;
        view.value = standard ?? "";
        event.preventDefault();
    });
    addEventListener("keydown", (event) => {
        const inField = event.target instanceof HTMLElement && event.target.matches("input[type=text], select");
        if (event.ctrlKey || event.metaKey) {
            if (inField) return;
            if (event.key === "z" && !event.shiftKey) goBack(() => history.undo());
            else if (event.key === "y" || event.key === "Z" || (event.key === "z" && event.shiftKey)) goBack(() => history.redo());
            else return;
            event.preventDefault();
        } else if (!inField && !event.altKey) {
            if (event.key === "m") find("#mean").click();
            else if (event.key === "r") find("#random").click();
            else if (event.key === "w") wireframe.click();
            else if (event.key === "f") rate.click();
            else if (event.key === "g") {
                const ghost = find<HTMLSelectElement>("#ghost");
                ghost.value = ghost.value === "mean" ? "none" : "mean";
                showGhost();
            }
        }
    });
    addEventListener("hashchange", () => {
        const to = placeOf(location.hash, facts);
        if (to) goTo(to);
        else {
            tellPlace();
            say("The address was no place in this model: nothing has changed.");
        }
    });
}

async function saveAs(kind: string) {
    if (kind === "svg" && plot) return saved(`${stemOf(facts, place)}_scores.svg`, plot.document(), "image/svg+xml");
    if (kind === "csv") return saved(`${stemOf(facts, place)}.csv`, csvOf(stemOf(facts, place), facts.size, coordinates(place)), "text/csv");
    const at = structuredClone(place);
    let shape: Shape;
    try {
        shape = await fineShape(at);
    } catch (error) {
        return say(`There is no mesh to save here: ${(error as Error).message}.`);
    }
    const stem = stemOf(facts, shape.place);
    const comment = `${facts.file}, ${linkOf(shape.place, facts) || "mean"}, ${facts.space === "edge" ? "fine, " : ""}by libshape ${facts.version}`;
    const { points, normals } = shape;
    if (kind === "ply") saved(`${stem}.ply`, plyOf(points, faces, comment), "application/octet-stream");
    else if (kind === "obj") saved(`${stem}.obj`, objOf(points, faces, comment), "model/obj");
    else if (kind === "glb") saved(`${stem}.glb`, glbOf(points, normals, faces, stem, `libshape ${facts.version}`), "model/gltf-binary");
    else if (kind === "png") {
        const { backgroundColor, color } = getComputedStyle(document.body);
        const colour = colouring(shape);
        drawShape(shape);
        const picture = await viewer.picture(backgroundColor);
        draw();
        saved(`${stem}.png`, colour ? await withLegend(picture, colour.scale, colour.print, colour.name, color) : picture, "image/png");
    }
}

function saved(name: string, content: BlobPart, type: string) {
    save(name, content, type);
    say(`Saved ${name}.`);
}

async function start() {
    document.title = facts.title;
    find("h1").textContent = facts.title;
    const failure = missing();
    if (failure) return fallBack(failure);
    if (facts.modes.length < 2) find("[data-save=svg]").hidden = true;
    if (facts.space === "procrustes") find("#colour option[value=edge]").remove(), find("#colour option[value=drift]").remove();
    if (facts.effects) find("#colour").append(make("option", { value: "effects" }, facts.effects.name));
    find("#subtitle").textContent = `${facts.specimens.length} meshes, ${facts.modes.length} ${facts.modes.length === 1 ? "mode" : "modes"}`;
    try {
        decoder = new Decoder(takeBytes("wasm"), takeBytes("block"), take, tellFailure);
        const ready = await decoder.ready;
        faces = ready.faces;
        viewer.setFaces(faces, ready.vertices);
    } catch (error) {
        return fallBack(`The decoder did not start (${(error as Error).message || "the browser allows it no worker"}).`);
    }
    setUpSliders();
    setUpPlot();
    setUpButtons();
    show();
    settle();
    if (!linked) say("The address was no place in this model: this is the mean.");
    for (const quality of ["preview", "fine"] as const) {
        means[quality] = await decoder.once(targetOf(meanPlace(facts)), quality);
        draw();
        showGhost();
    }
}

start();

/// For tests: what a person sees, as numbers.
Object.assign(window, {
    explore: {
        facts,
        get shown() {
            return shown;
        },
        get preview() {
            return last.preview;
        },
        get last() {
            return [last.draft, last.preview, last.fine];
        },
        means,
        get decoder() {
            return decoder;
        },
        get viewer() {
            return viewer;
        },
        get place() {
            return place;
        },
        get settled() {
            return shown?.quality === "fine" && decoder.isSettled;
        },
        get shapes() {
            return shapes;
        },
        goTo,
    },
});
