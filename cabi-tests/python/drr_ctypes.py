"""drr called from Python by ctypes: a small reference caller.

Structs, constants and functions are those of ../abi.txt, which a test of the library holds to its header; nothing of them is
written down here a second time. DRR_LIBRARY says where the shared library is.
"""

import ctypes
import os
import pathlib
import re

import numpy as np

ABI = pathlib.Path(__file__).parent.parent / "abi.txt"

TYPES = {
    "bool": ctypes.c_bool,
    "double": ctypes.c_double,
    "float": ctypes.c_float,
    "size_t": ctypes.c_size_t,
    "uint32_t": ctypes.c_uint32,
    "uint64_t": ctypes.c_uint64,
    "const char *": ctypes.c_char_p,
    # Of the header's frame.
    "DrrAddress": ctypes.c_uint64,
    "DrrFloat3": ctypes.c_float * 4,
    "DrrFloat4x4": ctypes.c_float * 16,
}
CONSTANTS = {}
STRUCTS = {}


class Error(Exception):
    """A call that failed: its status, and what the library says about it."""

    def __init__(self, status, message):
        super().__init__(message)
        self.status = status


def ctype(text):
    """The type of a declaration of C without its name; pointers are addresses."""
    if text in TYPES:
        return TYPES[text]
    if text.endswith("*"):
        return ctypes.c_void_p
    return STRUCTS[text]


def declared(text):
    """Name and type of a declaration, such as `const float *spectrum` or `double source[3]`."""
    before, name, size = re.fullmatch(r"(.*?)(\w+)(?:\[(\d+)\])?", text).groups()
    kind = ctype(before.strip())
    return name, kind * int(size) if size else kind


def struct(name, size, fields):
    """A struct, whose fields must be where the snapshot says."""
    kind = type(name, (ctypes.Structure,), {})
    members = [declared(text) for _, _, text in fields]
    missing = size - ctypes.sizeof(type("_", (ctypes.Structure,), {"_fields_": members}))
    # What alignment adds at the end, where ctypes knows none.
    kind._fields_ = members + ([("_end", ctypes.c_uint8 * missing)] if missing else [])
    for (offset, length, text), (member, _) in zip(fields, members):
        there = getattr(kind, member)
        if (there.offset, there.size) != (offset, length):
            raise ImportError(f"{name}: {text} is at {there.offset}, {there.size} bytes, not at {offset}, {length} bytes")
    return kind


def read_abi():
    """Fills TYPES, CONSTANTS and STRUCTS; the functions, as result, name and parameters."""
    layouts, functions = {}, []
    for line in ABI.read_text().splitlines():
        word, _, rest = line.partition(" ")
        if word == "alias":
            name, kind = rest.split(" ")
            TYPES[name] = TYPES[kind]
        elif word == "callback":
            TYPES[re.search(r"\(\*(\w+)\)", rest).group(1)] = ctypes.c_void_p
        elif word == "constant":
            name, value = rest.split(" ")
            CONSTANTS[name] = int(value)
        elif word == "struct":
            name, size, _ = rest.split(" ")
            layouts[name] = (int(size), [])
        elif word == "field":
            name, offset, length, text = rest.split(" ", 3)
            layouts[name][1].append((int(offset), int(length), text))
        elif word == "function":
            functions.append(re.fullmatch(r"(.*?)\s*(drr_\w+)\((.*)\)", rest).groups())
    for name, (size, fields) in layouts.items():
        STRUCTS[name] = struct(name, size, fields)
    return functions


def load():
    """The library, every function of it with its types; statuses other than DRR_STATUS_OK are raised."""
    library = ctypes.CDLL(os.environ["DRR_LIBRARY"])

    def check(status, *_):
        if status != CONSTANTS["DRR_STATUS_OK"]:
            raise Error(status, library.drr_last_error_message().decode())

    for returns, name, parameters in read_abi():
        function = getattr(library, name)
        function.restype = ctype(returns)
        function.argtypes = [declared(text)[1] for text in parameters.split(", ") if text != "void"]
        if returns == "DrrStatus":
            function.errcheck = check
    return library


LIB = load()


def defaults(name):
    """A struct as its _init function fills it: `drr_scene_init` that of DrrScene."""
    value = STRUCTS[name]()
    getattr(LIB, re.sub(r"(?<!^)([A-Z])", r"_\1", name).lower() + "_init")(ctypes.byref(value))
    return value


class Owner:
    """A handle, and the function that destroys it."""

    def __init__(self, create, destroy, *arguments):
        self.handle, self._destroy = ctypes.c_void_p(), destroy
        create(*arguments, ctypes.byref(self.handle))

    def __del__(self):
        self._destroy(self.handle)


class Context(Owner):
    """An engine, by the name of its DRR_BACKEND constant."""

    def __init__(self, backend="CPU"):
        options = defaults("DrrContextOptions")
        options.backend = CONSTANTS["DRR_BACKEND_" + backend]
        super().__init__(LIB.drr_context_create, LIB.drr_context_destroy, ctypes.byref(options))


class Volume(Owner):
    """CT numbers, int16: voxel (i, j, k) is hu[k, j, i], and its centre is index_to_world @ (i, j, k, 1)."""

    def __init__(self, context, hu, index_to_world):
        hu = np.ascontiguousarray(hu, np.int16)
        descriptor = defaults("DrrVolumeDescriptor")
        descriptor.dimensions[:] = hu.shape[::-1]
        descriptor.index_to_world[:] = np.asarray(index_to_world, float).flatten(order="F")
        super().__init__(LIB.drr_volume_create, LIB.drr_volume_destroy, context.handle, ctypes.byref(descriptor),
                         hu.ctypes.data, None)


class Projector(Owner):
    """A volume and a scene: 120 kVp, four materials, unless `changes` say otherwise by fields of DrrScene."""

    def __init__(self, volume, size, **changes):
        self.scene = defaults("DrrScene")
        self.scene.detector_width, self.scene.detector_height = self.size = size
        for field, value in changes.items():
            setattr(self.scene, field, value)
        super().__init__(LIB.drr_projector_create, LIB.drr_projector_destroy, volume.handle, ctypes.byref(self.scene))

    def _project(self, call, struct_name, real, poses):
        poses = np.ascontiguousarray(poses, np.float64)
        shape = (len(poses), self.size[1], self.size[0])
        images = {
            "intensity": np.empty(shape, real),
            "line_integral": np.empty(shape, real),
            "areal_density": np.empty((shape[0], self.scene.material_count, *shape[1:]), real),
        }
        outputs = defaults(struct_name)
        for name, image in images.items():
            setattr(outputs, name, image.ctypes.data)
        call(poses.ctypes.data, len(poses), ctypes.byref(outputs))
        return images

    def project(self, poses):
        """Images of poses, of 4 x 3 numbers each: source, first pixel, column step, row step; by name, [view, row, column]."""
        def call(*arguments):
            LIB.drr_projector_project_poses(self.handle, *arguments)
        return self._project(call, "DrrOutputs", np.float32, poses)

    def reference(self, algorithm, poses):
        """The same in float64, by the name of the DRR_ALGORITHM constant."""
        def call(*arguments):
            LIB.drr_reference_project(self.handle, CONSTANTS["DRR_ALGORITHM_" + algorithm], *arguments)
        return self._project(call, "DrrReferenceOutputs", np.float64, poses)


def pose_c_arm(centre, angle_degrees, source_axis_mm, source_detector_mm, pixel_mm, size):
    """A pose as 4 x 3 numbers."""
    pose = np.empty((4, 3))
    LIB.drr_pose_c_arm((ctypes.c_double * 3)(*centre), angle_degrees, source_axis_mm, source_detector_mm, pixel_mm, *size,
                       pose.ctypes.data)
    return pose
