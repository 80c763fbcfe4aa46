// SPDX-License-Identifier: MIT

#include "libshape/report/page.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <string_view>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/report/base64.h"
#include "libshape/report/render.h"
#include "libshape/report/svg.h"

namespace shape {
using namespace internal;
namespace {

constexpr std::string_view style = R"css(
body { margin: 2em auto; max-width: 1000px; padding: 0 1em; color: #333;
       font-family: Helvetica, Arial, sans-serif; }
h1 { font-size: 1.4em; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 0.2em 1.5em; }
dt { color: #666; }
dd { margin: 0; }
canvas { width: 100%; height: 480px; touch-action: none; cursor: grab; }
.controls { display: flex; gap: 1em; align-items: center; }
.controls input { flex: 1; }
output { width: 5em; text-align: right; }
.drawings { display: flex; flex-wrap: wrap; }
svg { max-width: 100%; height: auto; }
table { border-collapse: collapse; }
th, td { padding: 0.2em 1em; text-align: right; }
th { border-bottom: 1px solid #999; }
)css";

/// Reads the shapes out of the page and draws the blend that track and slider ask for.
constexpr std::string_view viewer = R"js(
const data = JSON.parse(document.getElementById("shapes").textContent);
const decoded = (text, Type) =>
    new Type(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
const faces = decoded(data.faces, Uint32Array);
const tracks = data.tracks.map(({ low, high, shapes }) =>
    ({ low, high, shapes: shapes.map((shape) => decoded(shape, Float32Array)) }));
const points = new Float32Array(tracks[0].shapes[0].length);
const normals = new Float32Array(points.length);
const [canvas, track, slider, value] =
    ["canvas", "#track", "#slider", "output"].map((name) => document.querySelector(name));
const gl = canvas.getContext("webgl2", { antialias: true });
let turn = data.view; // by rows
let zoom = 1;

function blend() {
    const { low, high, shapes } = tracks[track.value];
    const place = high > low ? (slider.value - low) / (high - low) * (shapes.length - 1) : 0;
    const i = Math.min(Math.floor(place), Math.max(0, shapes.length - 2));
    const [a, b] = [shapes[i], shapes[Math.min(i + 1, shapes.length - 1)]];
    for (let k = 0; k < points.length; ++k) points[k] = a[k] + (place - i) * (b[k] - a[k]);
    normals.fill(0);
    for (let f = 0; f < faces.length; f += 3) {
        const [p, q, r] = [3 * faces[f], 3 * faces[f + 1], 3 * faces[f + 2]];
        const u = [0, 1, 2].map((k) => points[q + k] - points[p + k]);
        const v = [0, 1, 2].map((k) => points[r + k] - points[p + k]);
        for (let k = 0; k < 3; ++k) {
            const [m, n] = [(k + 1) % 3, (k + 2) % 3];
            const area = u[m] * v[n] - u[n] * v[m];
            normals[p + k] += area;
            normals[q + k] += area;
            normals[r + k] += area;
        }
    }
    value.textContent = Number(slider.value).toFixed(2);
}

const program = gl?.createProgram();
if (gl) {
    const add = (type, source) => {
        const shader = gl.createShader(type);
        gl.shaderSource(shader, "#version 300 es\nprecision highp float;\n" + source);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
    };
    add(gl.VERTEX_SHADER, `
        in vec3 point, normal;
        uniform mat3 turn;
        uniform vec2 scale;
        out vec3 n;
        void main() {
            vec3 p = turn * point;
            n = turn * normal;
            gl_Position = vec4(scale * p.xy, -0.1 * p.z, 1.0);
        }`);
    add(gl.FRAGMENT_SHADER, `
        in vec3 n;
        out vec4 colour;
        void main() {
            vec3 m = normalize(gl_FrontFacing ? n : -n);
            float light = 0.55 * max(0.0, dot(m, normalize(vec3(-0.58, 0.48, 0.66))));
            float dome = 0.32 + 0.12 * m.y + 0.15 * m.z;
            vec3 sum = light * vec3(1.0, 0.97, 0.92) + dome * vec3(0.95, 0.98, 1.0);
            colour = vec4((gl_FrontFacing ? 1.0 : 0.6) * sum * vec3(0.92, 0.86, 0.80), 1.0);
        }`);
    gl.linkProgram(program);
    gl.useProgram(program);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(1, 1, 1, 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
} else {
    canvas.replaceWith("This browser has no WebGL 2, which the viewer needs.");
}
const buffers = { point: gl?.createBuffer(), normal: gl?.createBuffer() };

function draw() {
    if (!gl) return;
    canvas.width = canvas.clientWidth * devicePixelRatio;
    canvas.height = canvas.clientHeight * devicePixelRatio;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    for (const [name, values] of Object.entries({ point: points, normal: normals })) {
        const place = gl.getAttribLocation(program, name);
        gl.bindBuffer(gl.ARRAY_BUFFER, buffers[name]);
        gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
    }
    const side = zoom * Math.min(canvas.width, canvas.height);
    gl.uniformMatrix3fv(gl.getUniformLocation(program, "turn"), true, turn);
    gl.uniform2f(gl.getUniformLocation(program, "scale"), side / canvas.width, side / canvas.height);
    gl.drawElements(gl.TRIANGLES, faces.length, gl.UNSIGNED_INT, 0);
}

/// Turns what is seen by angles about the vertical and the horizontal of the screen.
function drag(x, y) {
    const [a, b, c, d] = [Math.cos(x), Math.sin(x), Math.cos(y), Math.sin(y)];
    const by = [a, 0, b, b * d, c, -a * d, -b * c, d, a * c];
    turn = by.map((_, i) => [0, 1, 2].reduce(
        (sum, k) => sum + by[3 * Math.floor(i / 3) + k] * turn[3 * k + i % 3], 0));
}

const show = () => { blend(); draw(); };
const choose = () => {
    const { low, high } = tracks[track.value];
    [slider.min, slider.max, slider.step] = [low, high, (high - low) / 200 || 1];
    slider.value = Math.max(low, Math.min(high, 0));
    show();
};
track.addEventListener("change", choose);
slider.addEventListener("input", show);
addEventListener("resize", draw);
canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
canvas.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    drag(0.01 * event.movementX, 0.01 * event.movementY);
    draw();
});
canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom *= Math.exp(-0.001 * event.deltaY);
    draw();
}, { passive: false });
choose();
)js";

/// Base64 of numbers as little-endian words of 32 bits.
template <class Matrix>
std::string encoded(const Matrix& rows)
{
    std::string bytes;
    bytes.reserve(4 * static_cast<std::size_t>(rows.size()));
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
        for (Eigen::Index k = 0; k < rows.cols(); ++k) {
            const auto word = std::bit_cast<std::uint32_t>(rows(i, k));
            for (unsigned shift = 0; shift < 32; shift += 8)
                bytes += static_cast<char>(word >> shift & 255U);
        }
    return base64(bytes);
}

void check(const Page& page)
{
    for (const ShapeTrack& track : page.tracks) {
        if (track.shapes.empty())
            throw InvalidInput(join("page: track '", track.name, "' has no shape"));
        const Eigen::Index vertices = page.tracks.front().shapes.front().rows();
        for (const Points& shape : track.shapes)
            if (shape.rows() != vertices || !shape.allFinite())
                throw InvalidInput(join("page: a shape of track '", track.name, "' has ",
                                        shape.rows(), " vertices, must have ", vertices,
                                        ", all finite"));
    }
}

/// The shapes as JSON, moved and scaled together so that they fit a ball of radius 1 about 0.
std::string shapes_json(const Page& page)
{
    Eigen::RowVector3d low = Eigen::RowVector3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::RowVector3d high = -low;
    for (const ShapeTrack& track : page.tracks)
        for (const Points& shape : track.shapes) {
            low = low.cwiseMin(shape.colwise().minCoeff());
            high = high.cwiseMax(shape.colwise().maxCoeff());
        }
    const Eigen::RowVector3d centre = 0.5 * (low + high);
    const double radius = std::max(0.5 * (high - low).norm(), std::numeric_limits<double>::min());
    const ShapeTrack& first = page.tracks.front();
    const Eigen::Matrix3d view = automatic_view(page.faces, first.shapes[first.shapes.size() / 2]);
    std::string json = join("{\"faces\": \"", encoded(page.faces), "\", \"view\": [");
    for (int i = 0; i < 9; ++i)
        json += join(i > 0 ? ", " : "", view(i / 3, i % 3));
    json += "], \"tracks\": [";
    for (const ShapeTrack& track : page.tracks) {
        json += join(&track == &first ? "" : ",", "\n{\"low\": ", track.low,
                     ", \"high\": ", track.high, ", \"shapes\": [");
        for (const Points& shape : track.shapes) {
            const Points moved = (shape.rowwise() - centre) / radius;
            json += join(&shape == &track.shapes.front() ? "" : ", ", "\"",
                         encoded(moved.cast<float>().eval()), "\"");
        }
        json += "]}";
    }
    return json + "]}";
}

std::string viewer_html(const Page& page)
{
    std::string html =
        "<canvas></canvas>\n<div class=\"controls\">\n<select id=\"track\" aria-label=\"Shown\">\n";
    for (std::size_t i = 0; i < page.tracks.size(); ++i)
        html += join("<option value=\"", i, "\">", escape_xml(page.tracks[i].name), "</option>\n");
    html += join("</select>\n<input id=\"slider\" type=\"range\" aria-label=\"",
                 escape_xml(page.unit), "\"/>\n<output for=\"slider\"></output>\n<span>",
                 escape_xml(page.unit), "</span>\n</div>\n");
    return join(html, "<p>Drag to turn, scroll to zoom.</p>\n",
                "<script type=\"application/json\" id=\"shapes\">", shapes_json(page),
                "</script>\n");
}

std::string table_html(const std::vector<std::vector<std::string>>& table)
{
    std::string html = "<table>\n";
    for (std::size_t r = 0; r < table.size(); ++r) {
        const std::string tag = r == 0 ? "th" : "td";
        html += "<tr>";
        for (const std::string& cell : table[r])
            html += join("<", tag, ">", escape_xml(cell), "</", tag, ">");
        html += "</tr>\n";
    }
    return html + "</table>\n";
}

} // namespace

std::string page_html(const Page& page)
{
    check(page);
    const std::string title = escape_xml(page.title);
    std::string html = join(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<title>", title,
        "</title>\n<style>", style, "</style>\n</head>\n<body>\n<h1>", title, "</h1>\n<dl>\n");
    for (const auto& [name, value] : page.facts)
        html += join("<dt>", escape_xml(name), "</dt><dd>", escape_xml(value), "</dd>\n");
    html += "</dl>\n";
    if (!page.tracks.empty())
        html += viewer_html(page);
    html += "<div class=\"drawings\">\n";
    for (const std::string& drawing : page.drawings)
        html += drawing;
    html += "</div>\n";
    if (!page.table.empty())
        html += table_html(page.table);
    if (!page.tracks.empty())
        html += join("<script>", viewer, "</script>\n");
    return html + "</body>\n</html>\n";
}

} // namespace shape
