"""Objects with a known answer, and CTs from files."""

import gzip
import pathlib

import numpy as np

ROOT = pathlib.Path(__file__).parents[2]
#: The CT that the command carries.
SMALL_CT = ROOT / "src/bin/drr/default_ct/lidc_idri_0001_lowres.nii.gz"
#: The whole of it, where there is one.
WHOLE_CT = ROOT.parent / "shared/ct/lidc_idri_0001/lidc_idri_0001.nii.gz"


def centred(shape, spacing):
    """Index to world of a volume of [k, j, i] voxels around the origin."""
    matrix = np.diag([*spacing, 1.0])
    matrix[:3, 3] = -(np.array(shape[::-1]) - 1) / 2 * spacing
    return matrix


def cylinders(shape, spacing, axes, radius, hu):
    """Cylinders along z through the points `axes`, mm, in air: each voxel has the mean of 8 x 8 points in it."""
    matrix = centred(shape, spacing)
    parts = (np.arange(8) + 0.5) / 8 - 0.5
    x, y = ((np.arange(n)[:, None] + parts).ravel() * spacing[axis] + matrix[axis, 3]
            for axis, n in enumerate(shape[:0:-1]))
    inside = np.zeros((y.size, x.size), bool)
    for u, v in axes:
        inside |= (x - u) ** 2 + (y[:, None] - v) ** 2 <= radius**2
    part = inside.reshape(shape[1], 8, shape[2], 8).mean(axis=(1, 3))
    return np.broadcast_to(np.rint(-1000 + part * (hu + 1000)).astype(np.int16), shape), matrix


def chord(pose, end, axis, radius):
    """Length, mm, of the rays from a pose's source to `end` in the cylinder along z through `axis`, without ends."""
    source, way = pose[0], end - pose[0]
    start = source[:2] - axis
    a = (way[..., :2] ** 2).sum(axis=-1)
    b = (way[..., :2] * start).sum(axis=-1)
    root = b**2 - a * ((start**2).sum() - radius**2)
    return 2 * np.sqrt(np.maximum(root, 0)) / a * np.linalg.norm(way, axis=-1)


def read_nifti(path):
    """CT numbers, int16, and index to world of a NIfTI-1 file, little endian, with an sform: no more than these tests need."""
    data = gzip.decompress(path.read_bytes())
    field = lambda kind, offset, count=1: np.frombuffer(data, kind, count, offset)
    assert field("<i4", 0)[0] == 348 and field("<i2", 70)[0] == 4 and field("<i2", 254)[0] > 0
    assert field("<f4", 112)[0] in (0, 1) and field("<f4", 116)[0] == 0
    shape = field("<i2", 42, 3)[::-1]
    voxels = field("<i2", int(field("<f4", 108)[0]), int(np.prod(shape, dtype=int)))
    rows = field("<f4", 280, 12).reshape(3, 4).astype(float)
    return voxels.reshape(shape), np.vstack([rows, [0.0, 0.0, 0.0, 1.0]])
