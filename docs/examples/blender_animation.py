# SPDX-License-Identifier: MIT
"""A morph as an animation: made anywhere, and inside Blender at once an object with shape keys.

Anywhere:  python3 blender_animation.py            writes morph.glb
Blender:   blender --python blender_animation.py   shows the object; its shape keys are keyed
"""
# %% An arm bends: every frame has the edge lengths of the blend, so it keeps its volume
import libshape as ls

arm = ls.synthetic("arm", vertices=500)
frames = ls.interpolate(arm[0], arm[1], frames=25)
print(frames)
frames.write("morph.glb", frames_per_second=25)

# %% In Blender: one shape key for each frame, 1 at its own time and 0 at its neighbours'
try:
    import bpy
except ImportError:
    print("morph.glb written; run this script in Blender to have it as an object with shape keys")
else:
    mesh = bpy.data.meshes.new("arm")
    mesh.from_pydata(frames[0].V.tolist(), [], frames[0].F.tolist())
    thing = bpy.data.objects.new("arm", mesh)
    bpy.context.collection.objects.link(thing)
    thing.shape_key_add(name="Basis")
    for i, frame in enumerate(frames):
        key = thing.shape_key_add(name=frame.name)
        key.data.foreach_set("co", frame.V.ravel())
        for time, value in ((i, 0.0), (i + 1, 1.0), (i + 2, 0.0)):
            key.value = value
            key.keyframe_insert("value", frame=time)
    bpy.context.scene.frame_end = len(frames)
    print("shape keys:", len(mesh.shape_keys.key_blocks))
