"""Draws the README's picture of the models: python docs/pictures/make.py (needs matplotlib)."""

import runpy
from pathlib import Path

import matplotlib.image
import numpy as np

HERE = Path(__file__).parent
MODELS = HERE.parents[1] / "models"
NAMES = ["bearing_block", "hinge", "bracket", "pipe_tee", "knob", "die"]
SIZE, OVERSAMPLING = 300, 3
VIEW = np.array([-0.55, -0.75, 0.45])  # from the part to the eye
LIGHT = np.array([-0.1, -0.6, 0.8])
COLORS = [(0.42, 0.56, 0.72), (0.72, 0.55, 0.42), (0.48, 0.66, 0.50), (0.62, 0.50, 0.68),
          (0.70, 0.62, 0.38), (0.45, 0.64, 0.66)]  # fmt: skip


def camera() -> np.ndarray:
    """Rows: right, up, towards the eye."""
    toward = VIEW / np.linalg.norm(VIEW)
    right = np.cross([0, 0, 1], toward)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(toward, right), toward])


def draw(vertices: np.ndarray, faces: np.ndarray, color: tuple[float, ...]) -> np.ndarray:
    """Flat-shaded picture with a depth buffer, parallel projection."""
    n = SIZE * OVERSAMPLING
    axes = camera()
    p = vertices @ axes.T
    low, high = p[:, :2].min(axis=0), p[:, :2].max(axis=0)
    scale = 0.9 * n / (high - low).max()
    xy = (p[:, :2] - (low + high) / 2) * scale + n / 2
    depth = np.full((n, n), -np.inf)
    image = np.ones((n, n, 3))
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, where=length > 0, out=np.zeros_like(normals))
    shade = 0.30 + 0.70 * np.clip(normals @ (LIGHT / np.linalg.norm(LIGHT)), 0, 1)
    for f in np.nonzero(normals @ axes[2] > 0)[0]:
        triangle, z = xy[faces[f]], p[faces[f], 2]
        x0, y0 = np.maximum(np.floor(triangle.min(axis=0)).astype(int), 0)
        x1, y1 = np.minimum(np.ceil(triangle.max(axis=0)).astype(int) + 1, n)
        grid = np.stack(np.meshgrid(np.arange(x0, x1), np.arange(y0, y1)), axis=-1) + 0.5
        edges = np.array([triangle[1] - triangle[0], triangle[2] - triangle[0]]).T
        if abs(np.linalg.det(edges)) < 1e-12:
            continue
        uv = (grid - triangle[0]) @ np.linalg.inv(edges).T
        inside = (uv.min(axis=-1) >= -1e-9) & (uv.sum(axis=-1) <= 1 + 1e-9)
        height = z[0] + uv @ (z[1:] - z[0])
        window = (slice(y0, y1), slice(x0, x1))
        nearer = inside & (height > depth[window])
        depth[window][nearer] = height[nearer]
        image[window][nearer] = shade[f] * np.array(color)
    image = image[::-1].reshape(SIZE, OVERSAMPLING, SIZE, OVERSAMPLING, 3)
    return image.mean(axis=(1, 3))


def main() -> None:
    """All models in two rows."""
    tiles = []
    for name, color in zip(NAMES, COLORS, strict=True):
        solid = runpy.run_path(str(MODELS / f"{name}.py"))["part"]()
        size = np.linalg.norm(np.ptp(solid.bounds(), axis=0))
        mesh = solid.mesh(tolerance=size / 1500, measure=False)
        tiles.append(draw(mesh.vertices, mesh.faces, color))
        print(name, mesh)
    picture = np.vstack([np.hstack(tiles[:3]), np.hstack(tiles[3:])])
    matplotlib.image.imsave(HERE / "models.png", np.clip(picture, 0, 1))


if __name__ == "__main__":
    main()
