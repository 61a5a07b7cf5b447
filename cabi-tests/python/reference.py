"""A projector in plain NumPy and float64, written from the formulas and not from the library: what the library is held to.

Areal density of material m along a ray: A_m = sum over samples of weight x partial density of m, where only voxels of that
material have one. The methods differ in where samples are and what they weigh. Then I = sum over energies k of
N_k exp(-sum over m of (mu/rho)_m(E_k) A_m), and p = -ln(I / sum N_k). Points are in units of voxels: voxel (i, j, k) has its
centre there and is hu[k, j, i]; the volume is the box from -1/2 to n - 1/2, and nothing is outside.
"""

import csv
import pathlib

import numpy as np

TABLES = pathlib.Path(__file__).parents[2] / "src/physics/tables"
MATERIALS = ["air", "lung", "soft_tissue", "bone_cortical"]
#: Rays that are worked on at once.
CHUNK = 512


def table(name):
    """Rows of a table, by column."""
    with open(TABLES / name, encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def spectrum(tube="W120_2p5Al"):
    """Relative photons per energy."""
    photons = np.array([float(row[tube]) for row in table("spectra.csv")])
    return photons / photons.sum()


def mass_attenuation():
    """cm^2/g, [material, energy]."""
    rows = table("mu_rho_total.csv")
    return np.array([[float(row[name]) for row in rows] for name in MATERIALS])


def partial_densities():
    """g/cm^3 of every material, [HU + 32768, material], for every int16: the curve `water_anchored`, four classes."""
    hu = np.arange(-32768, 32768)
    clamped = np.clip(hu, -1000, 3071)
    density = np.zeros(hu.size)
    for row in table("hu_density_segments.csv"):
        if row["curve"] == "water_anchored":
            inside = (clamped >= float(row["hu_lo"])) & (clamped < float(row["hu_hi"]))
            density[inside] = float(row["a"]) + float(row["b"]) * clamped[inside]
    # Padding outside the scan.
    density[hu < -1024] = 0.0
    partial = np.zeros((hu.size, len(MATERIALS)))
    for row in table("hu_material_thresholds.csv"):
        if row["scheme"] == "four_class_mcgpu_like":
            inside = (hu >= int(row["hu_lo"])) & (hu < int(row["hu_hi"]))
            partial[inside, MATERIALS.index(row["material"])] = density[inside]
    return partial


DENSITY = partial_densities()


def c_arm(centre, angle_degrees, source_axis_mm, source_detector_mm, pixel_mm, size):
    """Source, first pixel, column step, row step: at 0 degrees the source is at -y, columns along +x, rows along +z."""
    angle = np.radians(angle_degrees)
    column = np.array([np.cos(angle), np.sin(angle), 0.0])
    along = np.array([-np.sin(angle), np.cos(angle), 0.0])
    row = np.array([0.0, 0.0, 1.0])
    source = np.asarray(centre) - source_axis_mm * along
    middle = source + source_detector_mm * along
    first = middle - pixel_mm * ((size[0] - 1) / 2 * column + (size[1] - 1) / 2 * row)
    return np.array([source, first, pixel_mm * column, pixel_mm * row])


def pixels(pose, size):
    """Centres of all pixels, world mm, [row, column, axis]."""
    _, first, column, row = np.asarray(pose)
    return first + np.arange(size[0])[None, :, None] * column + np.arange(size[1])[:, None, None] * row


class Rays:
    """Segments from start to end, in voxels, as point(t) = start + t (end - start), and where they are in the box."""

    def __init__(self, start, end, shape):
        self.start, self.way, self.shape = start, end - start, np.array(shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            sides = (np.array([np.full(3, -0.5), self.shape - 0.5])[:, None] - start) / self.way
        beside = (self.way == 0) & ((start < -0.5) | (start > self.shape - 0.5))
        sides = np.where(self.way == 0, np.array([-np.inf, np.inf])[:, None, None], np.sort(sides, axis=0))
        self.first = np.maximum(sides[0].max(axis=1), 0.0)
        self.last = np.minimum(sides[1].min(axis=1), 1.0)
        self.last = np.where(beside.any(axis=1), self.first, np.maximum(self.last, self.first))

    def point(self, t):
        """[ray, sample, axis]."""
        return self.start[:, None] + t[..., None] * self.way[:, None]

    def pieces(self, shift):
        """Between the planes n + shift of all axes, clipped to the box: begins and ends, [ray, piece]."""
        cuts = [self.first[:, None], self.last[:, None]]
        for axis in range(3):
            planes = np.arange(self.shape[axis] + 1) + shift
            with np.errstate(divide="ignore", invalid="ignore"):
                t = (planes - self.start[:, axis, None]) / self.way[:, axis, None]
            cuts.append(np.where(np.isfinite(t), t, self.first[:, None]))
        cuts = np.sort(np.clip(np.concatenate(cuts, axis=1), self.first[:, None], self.last[:, None]), axis=1)
        return cuts[:, :-1], cuts[:, 1:]

    def cells(self, size):
        """Pieces of the driving axis, `size` voxels long from -1/2 on, clipped to the box, and where their middles are."""
        driving = np.abs(self.way).argmax(axis=1)
        x, way = (np.take_along_axis(values, driving[:, None], axis=1) for values in (self.start, self.way))
        edges = np.arange(np.ceil(self.shape.max() / size) + 1) * size - 0.5
        t = (edges - x) / way
        begin, end = np.minimum(t[:, :-1], t[:, 1:]), np.maximum(t[:, :-1], t[:, 1:])
        inside = [np.clip(side, self.first[:, None], self.last[:, None]) for side in (begin, end)]
        return inside[0], inside[1], (begin + end) / 2


def samples(method, rays, step):
    """Where a method looks, in units of t, and what each sample weighs, in the same units."""
    if method == "SIDDON":
        begin, end = rays.pieces(-0.5)
        return (begin + end) / 2, end - begin
    if method == "EXACT":
        # Between planes through voxel centres the field is cubic along a ray: two nodes of Gauss and Legendre.
        begin, end = rays.pieces(0.0)
        middle, half = (begin + end) / 2, (end - begin) / 2
        return np.concatenate([middle - half / 3**0.5, middle + half / 3**0.5], axis=1), np.tile(half, 2)
    if method == "JOSEPH":
        # At the slice's centre, whatever part of the slice is inside.
        begin, end, slices = rays.cells(1.0)
        return slices, end - begin
    begin, end, _ = rays.cells(step)
    return (begin + end) / 2, end - begin


def nearest(hu, point):
    """Partial densities of the voxels that points are in, [..., material]."""
    i, j, k = (np.clip(np.floor(point[..., axis] + 0.5).astype(int), 0, hu.shape[2 - axis] - 1) for axis in range(3))
    return DENSITY[hu[k, j, i].astype(int) + 32768]


def trilinear(hu, point):
    """Partial densities between voxel centres; in the outer half voxel the edge value holds."""
    total = 0.0
    limit = np.array(hu.shape[::-1]) - 1
    point = np.clip(point, 0, limit)
    low = np.floor(point).astype(int)
    part = point - low
    for corner in np.ndindex(2, 2, 2):
        weight = np.prod(np.where(corner, part, 1 - part), axis=-1)
        i, j, k = np.moveaxis(np.minimum(low + corner, limit), -1, 0)
        total = total + weight[..., None] * DENSITY[hu[k, j, i].astype(int) + 32768]
    return total


def areal_densities(hu, index_to_world, pose, size, method, step=0.5):
    """g/cm^2, [material, row, column]."""
    ends = pixels(pose, size).reshape(-1, 3)
    to_index = np.linalg.inv(index_to_world)
    total = np.empty((len(ends), len(MATERIALS)))
    for chunk in range(0, len(ends), CHUNK):
        end = ends[chunk:chunk + CHUNK]
        start = np.broadcast_to(pose[0], end.shape)
        rays = Rays(*(world @ to_index[:3, :3].T + to_index[:3, 3] for world in (start, end)), hu.shape[::-1])
        t, weight = samples(method, rays, step)
        density = (nearest if method == "SIDDON" else trilinear)(hu, rays.point(t))
        millimetres = np.linalg.norm(end - start, axis=1)
        # Densities are per cm^3.
        total[chunk:chunk + CHUNK] = np.einsum("rs,rsm->rm", weight, density) * millimetres[:, None] / 10.0
    return np.moveaxis(total.reshape(size[1], size[0], -1), -1, 0)


def line_integral(areal, photons=None):
    """p of areal densities, [material, ...]."""
    photons = spectrum() if photons is None else photons
    depth = np.tensordot(mass_attenuation(), areal, axes=(0, 0))
    return -np.log(np.tensordot(photons, np.exp(-depth), axes=(0, 0)) / photons.sum())
