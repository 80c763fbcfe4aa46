# SPDX-License-Identifier: MIT
"""Blender add-on: collections, models and animations of libshape as objects with shape keys.

Install it by Edit > Preferences > Add-ons > Install...; then File > Import > libshape. Or from a shell:

    blender --python import_libshape.py -- model.h5

A model comes with one slider a mode, in standard deviations, in the object's properties. Models and
collections need the Python package `libshape` in Blender's Python; animations (.glb) need nothing.
docs/blender.md says what is exact and what is not.
"""

import json
import os
import struct
import sys
from typing import Any, Dict, List, Optional, Sequence, Tuple

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper

bl_info = {
    "name": "libshape: shape models, collections and animations",
    "author": "libshape",
    "version": (0, 1, 0),
    "blender": (3, 0, 0),
    "location": "File > Import > libshape",
    "description": "Shape keys with sliders in standard deviations",
    "doc_url": "",
    "category": "Import-Export",
}

MODEL = "libshape model"  #: Custom property of an object: where its model lies.


class CannotImport(Exception):
    """What is said to the user."""


def package() -> Any:
    try:
        import libshape
    except ImportError:
        raise CannotImport(
            f"Blender's Python ({sys.executable}) has no package libshape; on Debian install "
            "python3-libshape, elsewhere its wheel by this Python's pip"
        ) from None
    return libshape


def add_object(name: str, points: Any, faces: Any) -> bpy.types.Object:
    """An object with a basis, active in the scene."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(points).tolist(), [], np.asarray(faces).tolist())
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    thing.shape_key_add(name="Basis", from_mix=False)
    return thing


def add_key(thing: bpy.types.Object, name: str, points: Any) -> bpy.types.ShapeKey:
    key = thing.shape_key_add(name=name, from_mix=False)
    key.data.foreach_set("co", np.ascontiguousarray(points, dtype=np.float32).ravel())
    key.value = 0.0
    return key


def add_slider(thing: bpy.types.Object, name: str, reach: float, description: str) -> None:
    thing[name] = 0.0
    thing.id_properties_ui(name).update(min=-reach, max=reach, step=0.1, description=description)


def drive(key: bpy.types.ShapeKey, thing: bpy.types.Object, slider: str, expression: str) -> None:
    """The key's value is this expression of the slider `v`; of min, max and abs alone, so that Blender
    computes it without leave to run scripts."""
    driver = key.driver_add("value").driver
    driver.type = "SCRIPTED"
    variable = driver.variables.new()
    variable.name = "v"
    variable.targets[0].id = thing
    variable.targets[0].data_path = f'["{slider}"]'
    driver.expression = expression


def moved_onto(moving: Any, fixed: Any) -> Any:
    """Rigidly, in least squares (Kabsch)."""
    middle, place = moving.mean(axis=0), fixed.mean(axis=0)
    u, _, v = np.linalg.svd((moving - middle).T @ (fixed - place))
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v
    return (moving - middle) @ turn + place


def import_model(path: str, modes: int = 5, reach: float = 3.0, steps: int = 3) -> bpy.types.Object:
    """The mean, and for each mode 2 * steps keys up to +-reach standard deviations, blended piecewise
    linearly by one slider: at the keys the mesh is that of `shape generate`, to single precision."""
    model = package().read_model(path)
    mean, _ = model.decode([])
    thing = add_object(os.path.splitext(os.path.basename(path))[0], mean.V, mean.F)
    thing[MODEL] = os.path.abspath(path)
    share = model.variances / model.total_variance
    knots = [reach * i / steps for i in range(-steps, steps + 1) if i != 0]
    for mode in range(min(modes, model.mode_count)):
        slider = f"mode {mode + 1}"
        add_slider(thing, slider, reach,
                   f"Standard deviations; {100 * share[mode]:.3g} % of the variance")
        scores = np.zeros((len(knots), mode + 1))
        scores[:, mode] = knots
        meshes, _ = model.decode_all(scores)
        for knot, mesh in zip(knots, meshes):
            key = add_key(thing, f"{slider}: {knot:+.2f} sd", moved_onto(mesh.V, mean.V))
            drive(key, thing, slider, f"max(0, 1 - abs(v - ({knot!r})) / {reach / steps!r})")
    return thing


def import_collection(path: Any, align: bool = True) -> bpy.types.Object:
    """The first mesh, and a key for each other one, moved onto it if `align`."""
    meshes = package().read(path)
    first = meshes[0].V
    name = path if isinstance(path, str) else os.path.dirname(path[0])
    thing = add_object(os.path.splitext(os.path.basename(name.rstrip("/\\")))[0], first, meshes.F)
    thing.data.shape_keys.key_blocks["Basis"].name = meshes.names[0]
    for mesh in list(meshes)[1:]:
        add_key(thing, mesh.name, moved_onto(mesh.V, first) if align else mesh.V)
    return thing


def read_glb(path: str) -> Tuple[Dict[str, Any], bytes]:
    """(document, binary chunk)"""
    with open(path, "rb") as file:
        data = file.read()
    if len(data) < 20 or data[:4] != b"glTF":
        raise CannotImport(f"{path}: is not a .glb file")
    chunks: Dict[bytes, bytes] = {}
    at = 12
    while at + 8 <= len(data):
        (size,) = struct.unpack_from("<I", data, at)
        chunks.setdefault(data[at + 4 : at + 8], data[at + 8 : at + 8 + size])
        at += 8 + size
    if b"JSON" not in chunks:
        raise CannotImport(f"{path}: has no description")
    return json.loads(chunks[b"JSON"]), chunks.get(b"BIN\0", b"")


def read_accessor(document: Dict[str, Any], data: bytes, index: int) -> Any:
    """Rows of numbers; zeros where an accessor has no view."""
    accessor = document["accessors"][index]
    kind = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}.get(accessor["componentType"])
    width = {"SCALAR": 1, "VEC3": 3}.get(accessor["type"])
    if kind is None or width is None:
        raise CannotImport("accessors of such kinds are not libshape's")

    def rows(view: int, offset: int, count: int, form: str, columns: int) -> Any:
        place = document["bufferViews"][view]
        size = np.dtype(form).itemsize * columns
        stride = place.get("byteStride", size)
        start = place.get("byteOffset", 0) + offset
        return np.ndarray((count, columns), form, data, start, (stride, np.dtype(form).itemsize))

    count = accessor["count"]
    if "bufferView" in accessor:
        values = rows(accessor["bufferView"], accessor.get("byteOffset", 0), count, kind, width).copy()
    else:
        values = np.zeros((count, width), kind)
    if "sparse" in accessor:
        sparse = accessor["sparse"]
        form = {5121: "<u1", 5123: "<u2", 5125: "<u4"}[sparse["indices"]["componentType"]]
        places = rows(sparse["indices"]["bufferView"], sparse["indices"].get("byteOffset", 0),
                      sparse["count"], form, 1)[:, 0]
        values[places] = rows(sparse["values"]["bufferView"], sparse["values"].get("byteOffset", 0),
                              sparse["count"], kind, width)
    return values


def import_animation(path: str) -> bpy.types.Object:
    """The morph targets of an animation as keys, keyed at its times; the scene gets its length."""
    document, data = read_glb(path)
    try:
        primitive = document["meshes"][0]["primitives"][0]
        base = read_accessor(document, data, primitive["attributes"]["POSITION"])
        faces = read_accessor(document, data, primitive["indices"]).reshape(-1, 3)
        names = document["meshes"][0].get("extras", {}).get("targetNames", [])
        moves = [read_accessor(document, data, t["POSITION"]) for t in primitive.get("targets", [])]
        animations = document.get("animations", [])
        samplers = animations[0]["samplers"] if animations else []
        channels = animations[0]["channels"] if animations else []
        weights = [c for c in channels if c["target"]["path"] == "weights"]
    except (KeyError, IndexError) as error:
        raise CannotImport(f"{path}: has no mesh of triangles ({error})") from None
    thing = add_object(os.path.splitext(os.path.basename(path))[0], base, faces)
    for node in document.get("nodes", []):
        if node.get("mesh") == 0:
            thing.location = node.get("translation", (0.0, 0.0, 0.0))
    names += [f"target {i}" for i in range(len(names), len(moves))]
    keys = [add_key(thing, name, base + move) for name, move in zip(names, moves)]
    if not weights:
        return thing
    sampler = samplers[weights[0]["sampler"]]
    times = read_accessor(document, data, sampler["input"])[:, 0]
    values = read_accessor(document, data, sampler["output"]).reshape(len(times), len(keys))
    scene = bpy.context.scene
    rate = scene.render.fps / scene.render.fps_base
    action = bpy.data.actions.new(thing.name)
    thing.data.shape_keys.animation_data_create().action = action
    for i, key in enumerate(keys):
        curve = action.fcurves.new(f'key_blocks["{key.name}"].value')
        curve.keyframe_points.add(len(times))
        for point, time, value in zip(curve.keyframe_points, times, values[:, i]):
            point.co = (1.0 + float(time) * rate, float(value))
            point.interpolation = "LINEAR"
        curve.update()
    scene.frame_start = 1
    scene.frame_end = int(np.ceil(1.0 + float(times[-1]) * rate))
    return thing


def import_any(paths: Sequence[str], modes: int = 5, reach: float = 3.0, steps: int = 3,
               align: bool = True) -> bpy.types.Object:
    """What the files are: an animation (.glb), a model, or anything that `shape collect` takes."""
    path = paths[0]
    if len(paths) == 1 and path.lower().endswith(".glb"):
        try:
            return import_animation(path)
        except OSError as error:
            raise CannotImport(f"{path}: {error.strerror}") from None
    ls = package()
    try:
        if len(paths) == 1 and path.lower().endswith(".h5"):
            try:
                return import_model(path, modes, reach, steps)
            except ls.InvalidInput as error:
                if "collection" not in str(error):
                    raise
        return import_collection(path if len(paths) == 1 else list(paths), align)
    except ls.Error as error:
        raise CannotImport(str(error)) from None


def decode_here(thing: bpy.types.Object) -> bpy.types.Object:
    """The mesh that the sliders name, not a blend of keys: a new object beside it."""
    model = package().read_model(thing[MODEL])
    scores: List[float] = []
    while f"mode {len(scores) + 1}" in thing:
        scores.append(float(thing[f"mode {len(scores) + 1}"]))
    mesh, report = model.decode(scores)
    mean, _ = model.decode([])
    made = add_object(f"{thing.name} decoded", moved_onto(mesh.V, mean.V), mesh.F)
    made.matrix_world = thing.matrix_world
    made["libshape report"] = repr(report)
    return made


class ImportLibshape(bpy.types.Operator, ImportHelper):
    """Import a model, a collection or an animation of libshape as shape keys"""

    bl_idname = "import_scene.libshape"
    bl_label = "Import libshape"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: bpy.props.StringProperty(
        default="*.h5;*.glb;*.ply;*.obj;*.off;*.stl;*.vtk;*.vtp", options={"HIDDEN"}
    )
    files: bpy.props.CollectionProperty(
        type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"}
    )
    directory: bpy.props.StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    modes: bpy.props.IntProperty(name="Modes", description="Of a model", default=5, min=1, max=100)
    reach: bpy.props.FloatProperty(
        name="Reach", description="Standard deviations to either side", default=3.0, min=0.1, max=10.0
    )
    steps: bpy.props.IntProperty(
        name="Keys a side", description="More follow bent modes better", default=3, min=1, max=20
    )
    align: bpy.props.BoolProperty(
        name="Align", description="Move meshes of a collection onto the first", default=True
    )

    def execute(self, _context: bpy.types.Context) -> Any:
        names = [file.name for file in self.files if file.name]
        paths = [os.path.join(self.directory, name) for name in names] or [self.filepath]
        try:
            import_any(paths, self.modes, self.reach, self.steps, self.align)
        except CannotImport as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class DecodeHere(bpy.types.Operator):
    """Make the mesh of the model at the sliders' place, exactly, as an object of its own"""

    bl_idname = "object.libshape_decode"
    bl_label = "Decode here"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object is not None and MODEL in context.object

    def execute(self, context: bpy.types.Context) -> Any:
        try:
            made = decode_here(context.object)
        except CannotImport as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except Exception as error:  # of the package: the model has moved, or is not a model any more
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, made["libshape report"])
        return {"FINISHED"}


class ModelPanel(bpy.types.Panel):
    """The sliders of a model"""

    bl_idname = "OBJECT_PT_libshape"
    bl_label = "Shape model"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "object"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object is not None and MODEL in context.object

    def draw(self, context: bpy.types.Context) -> None:
        mode = 1
        while f"mode {mode}" in context.object:
            self.layout.prop(context.object, f'["mode {mode}"]', text=f"Mode {mode} [sd]", slider=True)
            mode += 1
        self.layout.operator(DecodeHere.bl_idname)


CLASSES = (ImportLibshape, DecodeHere, ModelPanel)


def menu_entry(menu: Any, _context: bpy.types.Context) -> None:
    menu.layout.operator(ImportLibshape.bl_idname, text="libshape (.h5, .glb, meshes)")


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.TOPBAR_MT_file_import.append(menu_entry)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_import.remove(menu_entry)
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)


def main(arguments: Optional[Sequence[str]] = None) -> None:
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    paths = list(arguments if arguments is not None else words)
    register()
    if paths:
        made = import_any(paths)
        print(f"{made.name}: {len(made.data.vertices)} vertices, "
              f"{len(made.data.shape_keys.key_blocks)} shape keys")


if __name__ == "__main__":
    main()
