"""Blender's path tracer, Cycles, as a peer on the CPU: bench/README.md has the conversation.

    blender -b -noaudio --factory-startup -P bench/peers/cycles_peer.py -- THREADS

A white diffuse surface in the dark with one point lamp, by paths alone: neither denoised nor
adaptive. What Blender itself prints goes to standard error.
"""

import array
import math
import os
import sys
import time

import bpy
import mathutils

# A scene of some tens of units suits Blender better than one of hundreds.
UNITS_A_MM = 0.01
ALBEDO = 0.8


def mesh_from_file(path):
    """As src/isolux/bench/mesh_file.h describes it; Blender finds smooth normals itself."""
    def read(kind, count):
        numbers = array.array(kind)
        numbers.fromfile(file, count)
        return numbers

    with open(path, "rb") as file:
        vertices, triangles = read("Q", 2)
        positions = read("f", 3 * vertices)
        read("f", 3 * vertices)
        corners = read("i", 3 * triangles)
    mesh = bpy.data.meshes.new("surface")
    mesh.vertices.add(vertices)
    mesh.vertices.foreach_set("co", positions)
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", corners)
    mesh.polygons.add(triangles)
    mesh.polygons.foreach_set("loop_start", range(0, len(corners), 3))
    mesh.polygons.foreach_set("loop_total", [3] * triangles)
    mesh.polygons.foreach_set("use_smooth", [True] * triangles)
    mesh.update(calc_edges=True)
    return mesh


def diffuse_white():
    material = bpy.data.materials.new("white")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    diffuse, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (ALBEDO, ALBEDO, ALBEDO, 1)
    material.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    return material


def units(words):
    return mathutils.Vector(map(float, words)) * UNITS_A_MM


class Peer:
    def __init__(self, threads):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = bpy.context.scene
        self.white = diffuse_white()
        render, cycles = self.scene.render, self.scene.cycles
        render.engine, cycles.device = "CYCLES", "CPU"
        render.threads_mode, render.threads = "FIXED", threads
        render.use_persistent_data = True  # the tree stays from frame to frame
        render.use_compositing = render.use_sequencer = False
        render.resolution_x = render.resolution_y = 1024
        render.image_settings.file_format, render.image_settings.color_mode = "PNG", "RGB"
        self.scene.view_settings.view_transform = "Standard"
        cycles.use_adaptive_sampling = cycles.use_denoising = False
        cycles.glossy_bounces = cycles.transmission_bounces = 0
        lamp = bpy.data.lights.new("lamp", "POINT")
        lamp.shadow_soft_size = 0
        self.lamp_object = self.added("lamp", lamp)
        camera = bpy.data.cameras.new("camera")
        camera.clip_end = 1000
        self.scene.camera = self.added("camera", camera)

    def added(self, name, data):
        made = bpy.data.objects.new(name, data)
        self.scene.collection.objects.link(made)
        return made

    def size(self, width, height):
        self.scene.render.resolution_x, self.scene.render.resolution_y = int(width), int(height)
        return ""

    def read_mesh(self, path):
        surface = self.added("surface", mesh_from_file(path))
        surface.scale = [UNITS_A_MM] * 3
        surface.data.materials.append(self.white)
        return "0"

    def lamp(self, *at):
        self.lamp_object.location = units(at)
        return ""

    def paths(self, spp, bounces):
        cycles = self.scene.cycles
        cycles.samples = int(spp)
        cycles.max_bounces = cycles.diffuse_bounces = int(bounces)
        self.scene.update_tag()  # or what persists keeps the old ones
        return ""

    def frame(self, *words):
        eye, target, fov = units(words[:3]), units(words[3:6]), float(words[6])
        lamp, camera = self.lamp_object, self.scene.camera
        lamp.data.energy = 25 * (lamp.location - target).length_squared  # as bright from anywhere
        camera.location = eye
        camera.rotation_euler = (eye - target).to_track_quat("Z", "Y").to_euler()
        camera.data.sensor_fit = "VERTICAL"
        camera.data.angle = math.radians(fov)
        begin = time.perf_counter()
        bpy.ops.render.render()
        return f"{1000 * (time.perf_counter() - begin):.3f}"

    def picture(self, path):
        bpy.data.images["Render Result"].save_render(path)
        return ""


def main():
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    peer = Peer(int(sys.argv[sys.argv.index("--") + 1]))
    requests = {"size": peer.size, "read-mesh": peer.read_mesh, "lamp": peer.lamp,
                "paths": peer.paths, "frame": peer.frame, "picture": peer.picture}
    print("ready Cycles", bpy.app.version_string, file=answers)
    for line in sys.stdin:
        name, *words = line.split()
        try:
            print("ok", requests[name](*words), file=answers)
        except Exception as error:  # whatever it is, the other side is told
            print("error", " ".join(f"{type(error).__name__} {error}".split()), file=answers)


main()
