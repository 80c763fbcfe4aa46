# SPDX-License-Identifier: MIT
"""Runs inside Blender, in a folder that blender_test.py has filled; says "Blender: all done"."""
import sys

sys.path.insert(0, sys.argv[-1])
import bpy  # noqa: E402

try:
    import numpy as np
    import libshape as ls
except ImportError as error:
    print(f"SKIP Blender's Python has no {error.name}")
    sys.exit(0)
import import_libshape as addon  # noqa: E402


def evaluated(thing):
    """Vertices as Blender draws them, in the world."""
    graph = bpy.context.evaluated_depsgraph_get()
    made = thing.evaluated_get(graph).to_mesh()
    points = np.empty(3 * len(made.vertices), dtype=np.float32)
    made.vertices.foreach_get("co", points)
    world = np.array(thing.matrix_world)
    return points.reshape(-1, 3).astype(float) @ world[:3, :3].T + world[:3, 3]


def triangles(thing):
    return np.array([list(polygon.vertices) for polygon in thing.data.polygons])


def error_of(thing, wanted):
    """Largest error of a coordinate, relative to the extent."""
    return np.abs(evaluated(thing) - wanted).max() / np.ptp(wanted, axis=0).max()


def at_frame(thing, sliders, frame):
    """Sliders keyed at a frame, which is then shown."""
    for name, value in sliders.items():
        thing[name] = float(value)
        thing.keyframe_insert(f'["{name}"]', frame=frame)
    bpy.context.scene.frame_set(frame)


addon.register()

# A model: at the keys, between them, and several modes together.
bpy.ops.import_scene.libshape(filepath="model.h5", modes=2, reach=3.0, steps=3)
thing = bpy.context.object
model = ls.read_model("model.h5")
mean = model.decode([])[0]
assert np.array_equal(triangles(thing), model.F) and thing.name.startswith("model")
assert len(thing.data.shape_keys.key_blocks) == 1 + 2 * 6
limits = thing.id_properties_ui("mode 1").as_dict()
assert limits["min"] == -3 and limits["max"] == 3, limits
assert error_of(thing, mean.V) < 1e-6
frame = 1
for mode in (1, 2):
    for value in (-3, -2, -1, 0, 1, 2, 3):
        frame += 1
        at_frame(thing, {"mode 1": 0, "mode 2": 0, f"mode {mode}": value}, frame)
        wanted = model.decode([value] if mode == 1 else [0, value])[0].V
        error = error_of(thing, addon.moved_onto(wanted, mean.V))
        print(f"Blender: mode {mode} at {value:+} sd, frame {frame}: {error:.1e} of the extent")
        assert error < 1e-6, error
at_frame(thing, {"mode 1": 1.5, "mode 2": 0}, frame + 1)
halfway = error_of(thing, addon.moved_onto(model.decode([1.5])[0].V, mean.V))
at_frame(thing, {"mode 1": 1, "mode 2": -2}, frame + 2)
both = error_of(thing, addon.moved_onto(model.decode([1, -2])[0].V, mean.V))
print(f"Blender: between keys {halfway:.1e}, two modes together {both:.1e} of the extent from exact")
assert halfway < 0.01 and both < 0.03
assert bpy.ops.object.libshape_decode() == {"FINISHED"}
exact = bpy.context.object
assert error_of(exact, addon.moved_onto(model.decode([1, -2])[0].V, mean.V)) < 1e-6
# Going back to an earlier frame shows what stood there.
bpy.context.scene.frame_set(2)
assert error_of(thing, addon.moved_onto(model.decode([-3])[0].V, mean.V)) < 1e-6

# A collection: one key for each mesh.
bpy.ops.import_scene.libshape(filepath="faces.h5")
thing = bpy.context.object
faces = ls.read("faces.h5")
keys = thing.data.shape_keys.key_blocks
assert [key.name for key in keys] == list(faces.names)
for i in (0, 3, len(faces) - 1):
    for key in keys[1:]:
        key.value = float(key.name == faces.names[i])
    error = error_of(thing, addon.moved_onto(faces[i].V, faces[0].V))
    assert error < 1e-6, (i, error)
print(f"Blender: {len(faces)} meshes of a collection as shape keys")

# An animation, by the add-on and by Blender's own importer: at every frame, and in between by its own
# interpolation, it is as near as --glb-tolerance promises.
np.bool = bool  # the importer of Debian's Blender 3.4 needs what numpy 1.24 has no more
bpy.ops.import_scene.libshape(filepath="morph.glb")
ours = bpy.context.object
bpy.ops.import_scene.gltf(filepath="morph.glb")
theirs = bpy.context.object
scene = bpy.context.scene
rate = scene.render.fps
assert rate == 24 and scene.frame_end == 26, (rate, scene.frame_end)
upright = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # glTF's y is up, Blender's z
for i in range(26):
    wanted = ls.read_mesh(f"frames/frame_{i:04}.ply").V
    scene.frame_set(1 + i)
    error = error_of(ours, wanted)
    assert error < 2e-4, (i, error)
    if i in (0, 12, 25):
        print(f"Blender: morph.glb at frame {1 + i}: {error:.1e} of the extent")
start = [strip.action_frame_start for track in theirs.data.shape_keys.animation_data.nla_tracks
         for strip in track.strips]
action = theirs.data.shape_keys.animation_data.action
first = int(round(action.frame_range[0] if action else start[0]))
assert len(theirs.data.vertices) == len(wanted)
worst = 0.0
for i in range(0, 26, 5):
    wanted = ls.read_mesh(f"frames/frame_{i:04}.ply").V
    scene.frame_set(first + i)
    worst = max(worst, np.abs(evaluated(theirs) @ upright - wanted).max() / np.ptp(wanted, axis=0).max())
print(f"Blender: by its own glTF importer, at six frames: {worst:.1e} of the extent")
assert worst < 2e-4, worst

# Mesh files, by Blender's own importers.
wanted = ls.read_mesh("ply/frame_0001.ply")
bpy.ops.import_mesh.ply(filepath="ply/frame_0001.ply")
assert error_of(bpy.context.object, wanted.V) < 1e-6
assert np.array_equal(triangles(bpy.context.object), wanted.F)
bpy.ops.import_scene.obj(filepath="obj/frame_0001.obj", split_mode="OFF", axis_forward="Y", axis_up="Z")
thing = bpy.context.selected_objects[0]
assert error_of(thing, wanted.V) < 1e-6 and np.array_equal(triangles(thing), wanted.F)
bpy.ops.import_mesh.stl(filepath="stl/frame_0001.stl")
assert len(bpy.context.object.data.polygons) == len(wanted.F)
print("Blender: PLY, OBJ and STL by its own importers")

# What cannot be imported is said, and nothing is left behind.
count = len(bpy.data.objects)
for path, word in (("missing.h5", "missing.h5"), ("faces/labels.csv", "labels.csv"), ("ply/frame_0001.glb", "")):
    try:
        bpy.ops.import_scene.libshape(filepath=path)
        raise AssertionError(f"{path} was imported")
    except (RuntimeError, FileNotFoundError) as error:
        assert word in str(error), error
assert len(bpy.data.objects) == count
addon.unregister()
print("Blender: all done")
