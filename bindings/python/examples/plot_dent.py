"""A sheet of metal, one example of a dent in its middle, and a hit somewhere else: python plot_dent.py PICTURE.png"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import crumple

# The base mesh, 1 m by 1 m, and the same mesh after a collision: 5 cm deep in the middle.
side = 61
x, y = np.meshgrid(np.linspace(-0.5, 0.5, side), np.linspace(-0.5, 0.5, side), indexing="ij")
flat = np.stack([x, y, 0 * x], -1).reshape(-1, 3).astype(np.float32)
dented = flat.copy()
dented[:, 2] = -0.05 * np.maximum(0, 1 - (x**2 + y**2).ravel() / 0.04) ** 2
corner = np.arange(side * side).reshape(side, side)[:-1, :-1].reshape(-1, 1)
triangles = np.concatenate([corner + [0, side, side + 1], corner + [0, side + 1, 1]])

with crumple.Context() as context:
    options = crumple.SetOptions(vertex_mass=0.5)
    metal = context.example_set(flat, triangles, [crumple.Example(dented)], options=options)
    body = metal.instance()
    # A contact from a physics engine: 2 N s downwards in 10 ms, off the middle.
    told = body.hit(point=(0.25, 0.1, 0), impulse=(0, 0, -2), duration=0.01)
    print(f"vertex {told.contact_vertex} is dented by {1000 * np.linalg.norm(told.achieved):.1f} mm")
    body.hit(point=(-0.2, -0.2, 0), impulse=(0, 0, -1), duration=0.01)
    mesh = body.deformed()

    axes = plt.figure(figsize=(7, 4.5)).add_subplot(projection="3d")
    surface = axes.plot_trisurf(*mesh.positions.T, triangles=mesh.triangles, cmap="viridis", linewidth=0, antialiased=False)
    surface.set_array(1000 * np.linalg.norm(mesh.positions - flat, axis=1)[mesh.triangles].mean(1))
    surface.autoscale()
    plt.colorbar(surface, label="displacement, mm", shrink=0.6, pad=0.12)
    axes.set(zlim=(-0.05, 0.05), box_aspect=(1, 1, 0.25), xlabel="x, m", ylabel="y, m", zticks=(-0.05, 0))
    axes.view_init(40, -60)
    plt.savefig(sys.argv[1] if len(sys.argv) > 1 else "dent.png", dpi=110, bbox_inches="tight")
