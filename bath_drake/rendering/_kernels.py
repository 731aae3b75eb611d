"""The hot loops of the rasteriser."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bath_drake.notation import BoolArray, ByteArray, FloatArray, IntArray

# A shared edge is nobody's gap: in double precision a pixel on it may come out just
# beside both of its triangles.
_ON_EDGE = -1e-12
# Of a dielectric, seen straight on.
_REFLECTED = 0.04


@njit(cache=True)
def place(
    vertices: FloatArray,
    normals: FloatArray,
    owner: IntArray,
    X_CG: FloatArray,
    roughness: FloatArray,
    lights_C: FloatArray,
    lens: FloatArray,
    points_C: FloatArray,
    pixels: FloatArray,
    lit: FloatArray,
) -> None:
    """Puts vertices before the camera and lights them.

    Args:
        vertices: (n, 3) m, each in its own surface's frame G.
        normals: (n, 3) unit, likewise.
        owner: (n,) index of that surface.
        X_CG: (k, 3, 4) poses.
        roughness: (k,) 0 to 1.
        lights_C: (l, 4) unit direction towards each light, and its intensity.
        lens: fx, fy, cx, cy, pixels.
        points_C: (n, 3) m, is written.
        pixels: (n, 2) column and row, whole at centres, is written; of no account
            behind the camera.
        lit: (n, 2) is written: what multiplies the colour, and what is added to it.
    """
    for n in range(len(vertices)):
        k = owner[n]
        x, y, z = vertices[n, 0], vertices[n, 1], vertices[n, 2]
        a, b, c = normals[n, 0], normals[n, 1], normals[n, 2]
        X = X_CG[k]
        px = X[0, 0] * x + X[0, 1] * y + X[0, 2] * z + X[0, 3]
        py = X[1, 0] * x + X[1, 1] * y + X[1, 2] * z + X[1, 3]
        pz = X[2, 0] * x + X[2, 1] * y + X[2, 2] * z + X[2, 3]
        points_C[n, 0], points_C[n, 1], points_C[n, 2] = px, py, pz
        ahead = max(pz, 1e-12)
        pixels[n, 0] = lens[0] * px / ahead + lens[2] - 0.5
        pixels[n, 1] = lens[1] * py / ahead + lens[3] - 0.5
        nx = X[0, 0] * a + X[0, 1] * b + X[0, 2] * c
        ny = X[1, 0] * a + X[1, 1] * b + X[1, 2] * c
        nz = X[2, 0] * a + X[2, 1] * b + X[2, 2] * c
        away = max(np.sqrt(px * px + py * py + pz * pz), 1e-12)
        ex, ey, ez = -px / away, -py / away, -pz / away
        diffuse, specular = 0.0, 0.0
        wide = roughness[k] ** 4
        n_v = min(max(nx * ex + ny * ey + nz * ez, 1e-5), 1.0)
        for light in range(len(lights_C)):
            lx, ly, lz = lights_C[light, 0], lights_C[light, 1], lights_C[light, 2]
            hx, hy, hz = ex + lx, ey + ly, ez + lz
            between = max(np.sqrt(hx * hx + hy * hy + hz * hz), 1e-12)
            n_l = min(max(nx * lx + ny * ly + nz * lz, 1e-5), 1.0)
            h_l = min(max((hx * lx + hy * ly + hz * lz) / between, 1e-5), 1.0)
            n_h = min(max((nx * hx + ny * hy + nz * hz) / between, 1e-5), 1.0)
            grazing = (1.0 - h_l) * (1.0 - h_l)
            fresnel = _REFLECTED + (1.0 - _REFLECTED) * grazing * grazing * (1.0 - h_l)
            lobe = n_h * n_h * (wide - 1.0) + 1.0
            spread = wide / (np.pi * lobe * lobe)
            shadowed = 0.5 / (
                n_l * np.sqrt(n_v * n_v * (1.0 - wide) + wide)
                + n_v * np.sqrt(n_l * n_l * (1.0 - wide) + wide)
            )
            radiance = lights_C[light, 3] * n_l
            diffuse += radiance * (1.0 - fresnel) / np.pi
            specular += radiance * spread * shadowed * fresnel
        lit[n, 0], lit[n, 1] = diffuse, specular


@njit(cache=True)
def _edges(
    points_C: FloatArray, triangles: IntArray, face: int, edges: FloatArray
) -> float:
    """Writes (3, 3): by ray (x, y, 1), each corner's share in 1 / depth.

    Homogeneous: a triangle that reaches behind the camera needs no cutting. Returns
    what is negative of one that is seen from before, zero from its edge.
    """
    for k in range(3):
        a, b = triangles[face, (k + 1) % 3], triangles[face, (k + 2) % 3]
        ax, ay, az = points_C[a, 0], points_C[a, 1], points_C[a, 2]
        bx, by, bz = points_C[b, 0], points_C[b, 1], points_C[b, 2]
        edges[k, 0] = ay * bz - az * by
        edges[k, 1] = az * bx - ax * bz
        edges[k, 2] = ax * by - ay * bx
    first, volume = triangles[face, 0], 0.0
    for i in range(3):
        volume += points_C[first, i] * edges[0, i]
    if abs(volume) < 1e-15:
        return 0.0
    scale = 1.0 / volume
    for k in range(3):
        for i in range(3):
            edges[k, i] *= scale
    return volume


@njit(cache=True)
def find_nearest(
    points_C: FloatArray,
    pixels: FloatArray,
    triangles: IntArray,
    one_sided: BoolArray,
    lens: FloatArray,
    nearest: float,
    inverse_depth: FloatArray,
    faces: NDArray[np.int32],
) -> None:
    """Finds the triangle nearest to the camera along each pixel's ray.

    Args:
        points_C: (n, 3) m.
        pixels: (n, 2) as `place` writes them.
        triangles: (m, 3) indices.
        one_sided: (m,) whether a triangle is not seen from behind.
        lens: fx, fy, cx, cy, pixels.
        nearest: Depth before which nothing is seen, m.
        inverse_depth: (H, W) 1/m of what is there already; is brought up to date.
        faces: (H, W) is given the triangle where one is nearer.
    """
    height, width = inverse_depth.shape
    fx, fy, cx, cy = lens[0], lens[1], lens[2], lens[3]
    edges, greatest = np.empty((3, 3)), 1.0 / nearest
    for face in range(len(triangles)):
        left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
        before, behind = 0, 0
        for k in range(3):
            corner = triangles[face, k]
            if points_C[corner, 2] <= nearest:
                behind += 1
                continue
            before += 1
            u, v = pixels[corner, 0], pixels[corner, 1]
            left, right = min(left, u), max(right, u)
            top, bottom = min(top, v), max(bottom, v)
        if before == 0:
            continue
        if behind > 0:
            left, right, top, bottom = 0.0, width - 1.0, 0.0, height - 1.0
        if right < 0.0 or bottom < 0.0 or left > width - 1.0 or top > height - 1.0:
            continue
        u0, u1 = max(0, int(np.ceil(left - 1e-9))), min(width - 1, int(right + 1e-9))
        v0, v1 = max(0, int(np.ceil(top - 1e-9))), min(height - 1, int(bottom + 1e-9))
        if u0 > u1 or v0 > v1:
            continue
        volume = _edges(points_C, triangles, face, edges)
        if volume == 0.0 or (one_sided[face] and volume > 0.0):
            continue
        x = (u0 + 0.5 - cx) / fx
        step0, step1, step2 = edges[0, 0] / fx, edges[1, 0] / fx, edges[2, 0] / fx
        for v in range(v0, v1 + 1):
            y = (v + 0.5 - cy) / fy
            b0 = edges[0, 0] * x + edges[0, 1] * y + edges[0, 2]
            b1 = edges[1, 0] * x + edges[1, 1] * y + edges[1, 2]
            b2 = edges[2, 0] * x + edges[2, 1] * y + edges[2, 2]
            for u in range(u0, u1 + 1):
                if b0 >= _ON_EDGE and b1 >= _ON_EDGE and b2 >= _ON_EDGE:
                    inverse = b0 + b1 + b2
                    if inverse_depth[v, u] < inverse < greatest:
                        inverse_depth[v, u] = inverse
                        faces[v, u] = face
                b0 += step0
                b1 += step1
                b2 += step2


@njit(cache=True)
def colour_in(
    points_C: FloatArray,
    lit: FloatArray,
    triangles: IntArray,
    owner: IntArray,
    rgb: FloatArray,
    labels: IntArray,
    lens: FloatArray,
    shades: ByteArray,
    faces: NDArray[np.int32],
    colour: ByteArray,
    depth: NDArray[np.float32],
    label: NDArray[np.int16],
    told: tuple[float, float],
) -> None:
    """Writes colour, depth and label of each pixel that shows a triangle.

    Args:
        points_C: (n, 3) m.
        lit: (n, 2) as `place` writes it.
        triangles: (m, 3) indices.
        owner: (n,) index of each vertex's surface.
        rgb: (k, 3) colour of each surface, 0 to 1.
        labels: (k,) of each surface.
        lens: fx, fy, cx, cy, pixels.
        shades: (s,) what is shown, by the square root of the light, 0 to 1.
        faces: (H, W) triangle seen at each pixel, or negative.
        colour: (H, W, 4) is written.
        depth: (H, W) m, is written.
        label: (H, W) is written.
        told: The nearest and farthest depth that is told, m; 0 and inf beyond.
    """
    height, width = faces.shape
    near, far = told
    edges, before = np.empty((3, 3)), -1
    top = len(shades) - 1
    for v in range(height):
        for u in range(width):
            face = faces[v, u]
            if face < 0:
                continue
            if face != before:
                _edges(points_C, triangles, face, edges)
                before = face
            x, y = (u + 0.5 - lens[2]) / lens[0], (v + 0.5 - lens[3]) / lens[1]
            total, diffuse, specular = 0.0, 0.0, 0.0
            for k in range(3):
                share = edges[k, 0] * x + edges[k, 1] * y + edges[k, 2]
                corner = triangles[face, k]
                total += share
                diffuse += share * lit[corner, 0]
                specular += share * lit[corner, 1]
            diffuse, specular = diffuse / total, specular / total
            surface = owner[triangles[face, 0]]
            for c in range(3):
                light = min(max(rgb[surface, c] * diffuse + specular, 0.0), 1.0)
                colour[v, u, c] = shades[int(np.sqrt(light) * top + 0.5)]
            colour[v, u, 3] = 255
            z = 1.0 / total
            depth[v, u] = 0.0 if z < near else (np.inf if z > far else z)
            label[v, u] = labels[surface]
