"""Matrices of NumPy, MATLAB, Matrix Market, Nastran and others, within limits.

Nothing in a file is ever executed, and no other file is opened. A reader of a file with
several matrices asks ``wanted`` which of them to read: a function of a dict from each
name to what it is if it is no matrix of numbers ("a struct"), else to "".
"""

import struct
import zipfile
import zlib
from contextlib import contextmanager
from io import BytesIO
from math import prod

import numpy as np

from .harwell import matrix_of_harwell
from .libraries import library
from .op4 import matrices_of_op4
from .punch import matrices_of_punch
from .reading import MOST_BYTES, read_bytes, read_text
from .saying import warn_outside
from .sparse import issparse

MOST_ENTRIES = 20_000_000  # of a matrix in a file; of a full one its zeros, too
FLOAT = 8  # bytes of one; numbers of fewer become floats
NOT_READ = {  # by MATLAB's names of what holds no matrix
    "struct": "a struct",
    "cell": "a cell",
    "opaque": "an object",
    "object": "an object",
    "function": "a function",
}
SHORTEST = 2  # bytes of a number in a text, with what parts it from the next
PACKED = 15  # the kind of what is compressed in a file of MATLAB
HDF5 = b"\x89HDF\r\n\x1a\n"  # begins such a file, and after 512 bytes MATLAB's own


@contextmanager
def _decoded(path, kind):
    """Let whatever a decoder raises name the file at ``path``, and its ``kind``."""
    try:
        yield
    except Exception as error:  # a broken file brings a library to all kinds of ends
        words = str(error) or type(error).__name__
        raise ValueError(f"{path} can't be read as {kind}: {words}") from None


def read_npy(path):
    """The array in a file of NumPy at ``path``; Python's objects are refused."""
    content = read_bytes(path)
    with _decoded(path, "an array of NumPy"):
        return _array(content)


def _array(content):
    """The array in bytes of NumPy's format, whose header is looked at first."""
    stream = BytesIO(content)
    version = np.lib.format.read_magic(stream)
    headers = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }
    if version not in headers:
        raise ValueError(
            f"its version is {version}, and (1, 0) and (2, 0) are read: save it by "
            "numpy.save"
        )
    shape, _, kind = headers[version](stream)
    if kind.hasobject:
        raise ValueError(
            "it holds objects of Python, which are never opened; save a sparse matrix "
            "in a file of its own by scipy.sparse.save_npz"
        )
    if min(shape, default=0) < 0 or prod(shape) * kind.itemsize != len(content) - (
        stream.tell()
    ):
        raise ValueError(f"its head promises an array of {shape}, which isn't there")
    stream.seek(0)
    return np.load(stream, allow_pickle=False)


def read_npz(path, wanted=list):
    """The arrays, ``wanted``, in an archive of NumPy at ``path``; see `read_npy`."""
    content = read_bytes(path)
    with _decoded(path, "an archive of NumPy"):
        archive, parts = zipfile.ZipFile(BytesIO(content)), {}
        for part in archive.infolist():
            name = part.filename.removesuffix(".npy")
            if name in parts:
                raise ValueError(f"{name!r:.80} is there twice")
            parts[name] = part
    names = wanted(dict.fromkeys(parts, ""))
    with _decoded(path, "an archive of NumPy"):
        _check_bytes(parts[name].file_size for name in names)
        return {name: _array(archive.read(parts[name])) for name in names}


def read_sparse(path):
    """The matrix in a file of scipy.sparse.save_npz at ``path``; see `read_npz`."""
    from scipy.sparse import load_npz

    arrays = read_npz(path)
    with _decoded(path, "a sparse matrix of scipy.sparse.save_npz"):
        if not {"format", "shape"} <= arrays.keys():
            raise ValueError(
                f"it holds {', '.join(arrays) or 'nothing'}: save a matrix by save_npz"
            )
        check_size(*arrays["shape"].tolist(), full=False)
        return _sound(load_npz(BytesIO(read_bytes(path))))


def read_mtx(path):
    """The matrix in a Matrix Market file at ``path``, dense or sparse."""
    from scipy.io import mminfo, mmread

    content = read_bytes(path)
    with _decoded(path, "a matrix of Matrix Market"):
        rows, columns, count, form, field, _ = mminfo(BytesIO(content))
        check_size(rows, columns, full=form == "array")
        if field == "pattern":
            raise ValueError(
                "it has a pattern and no numbers: save it with its numbers"
            )
        least = SHORTEST * (1 if form == "array" else 3)
        if (count // 2 if form == "array" else count) * least > len(content):
            raise ValueError(
                f"it promises {count} entries and has {len(content)} bytes"
            )
        found = mmread(BytesIO(content))
        return found if form == "array" else once(found)


def read_harwell(path):
    """The matrix in a Harwell-Boeing or Rutherford-Boeing file at ``path``, sparse."""
    from scipy.sparse import coo_array, csc_array

    text = read_text(path)
    with _decoded(path, "a matrix of Harwell-Boeing"):
        *parts, shape, other, right = matrix_of_harwell(text, check_size)
        half = _sound(csc_array(tuple(parts), shape=shape)).tocoo()
        place = np.flatnonzero(half.row != half.col) if other else []
        rows, columns = half.row, half.col
        data = np.concatenate([half.data, other * half.data[place]])
        both = [rows, columns[place]], [columns, rows[place]]
        whole = once(coo_array((data, [*map(np.concatenate, both)]), shape=shape))
    if right:
        warn_outside(f"{path}: its right-hand sides are left out")
    return whole


def read_mat(path, wanted=list):
    """The arrays, ``wanted``, in a file of MATLAB at ``path``, or of HDF5 by h5py; a
    struct's are called "struct.field".
    """
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import matfile_version

    content = read_bytes(path)
    if HDF5 in (content[:8], content[512:520]):
        return _hdf5(path, content, wanted)
    kind = "a file of MATLAB (save with the option '-v7')"
    with _decoded(path, kind):
        shapes = {
            name: (shape, form)
            for name, shape, form in whosmat(BytesIO(content))
            if any(shape)  # [] stands for none
        }
    structs = [x for x, (_, form) in shapes.items() if form == "struct"]
    with _decoded(path, kind):
        if structs and matfile_version(BytesIO(content))[0]:
            _check_unpacked(content)
        whole = loadmat(BytesIO(content), variable_names=structs) if structs else {}
        fields = dict(x for name in structs for x in _fields(name, whole[name]))
    there = {name: NOT_READ.get(form, "") for name, (_, form) in shapes.items()}
    for name in {x.partition(".")[0] for x in fields}:
        del there[name]
    names = wanted(there | {name: _strange(x) for name, x in fields.items()})
    inner = {name: _sound(fields[name]) for name in names if name in fields}
    names = [name for name in names if name not in fields]
    with _decoded(path, kind):
        kept = [shapes[name] for name in names]
        for shape, form in kept:
            check_size(*shape, full=form != "sparse")
        _check_bytes(prod(x) * FLOAT for x, form in kept if form != "sparse")
        if matfile_version(BytesIO(content))[0]:  # the fourth's never packed
            _check_unpacked(content)
        found = loadmat(BytesIO(content), variable_names=[*names]) if names else {}
        return inner | {name: _sound(found[name]) for name in names}


def _fields(name, value):
    """The ``value`` of MATLAB by its ``name``, or those of its fields by theirs."""
    if getattr(getattr(value, "dtype", None), "names", None) and value.size == 1:
        for field in value.dtype.names:
            yield from _fields(f"{name}.{field}", value[field].item())
    elif "." in name and any(np.shape(value)):
        yield name, value


def _strange(field):
    """The kind of a struct's ``field`` where it is no matrix of numbers; else ""."""
    if issparse(field) or (
        isinstance(field, np.ndarray) and field.dtype.kind in "biufc"
    ):
        return ""
    names = getattr(getattr(field, "dtype", None), "names", None)
    return "a struct" if names else "no matrix of numbers"


def _check_unpacked(content):
    """Raise where a file of MATLAB unpacks to more than `MOST_BYTES`."""
    order, place, size = "<" if content[126:128] == b"IM" else ">", 128, 0
    while place + 8 <= len(content):
        kind, count = struct.unpack_from(order + "2I", content, place)
        place += 8
        if kind == PACKED:
            packed, left = content[place : place + count], MOST_BYTES - size + 1
            size += len(zlib.decompressobj().decompress(packed, left))
        if size > MOST_BYTES:
            raise ValueError(f"it unpacks to more than {MOST_BYTES} bytes")
        place += count


def _hdf5(path, content, wanted):
    """The matrices in bytes of HDF5; those of MATLAB are transposed there."""
    kind = "a file of MATLAB 7.3 or HDF5 (or save with '-v7')"
    with _decoded(path, kind):
        h5py = library("h5py")
        file = h5py.File(BytesIO(content), "r")
    with file:
        with _decoded(path, kind):
            own = {x.replace("/", "."): x for x in _hard(file, h5py, set())}
            groups = [x for x in own if isinstance(file[own[x]], h5py.Group)]
        names = wanted(dict.fromkeys(own, ""))
        with _decoded(path, kind):
            parts = {
                name: {
                    x: _plain(file[own[name]], x, h5py) for x in ("data", "ir", "jc")
                }
                if name in groups
                else {"": _plain(file, own[name], h5py)}
                for name in names
            }
            _check_bytes(
                prod(x.shape) * max(x.dtype.itemsize, FLOAT)
                for several in parts.values()
                for x in several.values()
                if x is not None
            )
            return {x: _of_datasets(file[own[x]], part) for x, part in parts.items()}


def _hard(group, h5py, known):
    """The places of what stands in this very file, in a ``group`` and those within, but
    in none of the ``known`` ones.
    """
    for name in group:
        if name[0] == "#" or not _is_here(group, name, h5py):
            continue  # MATLAB keeps there what its cells have
        item = group[name]
        if not isinstance(item, h5py.Group) or "MATLAB_sparse" in item.attrs:
            yield name
        elif (place := h5py.h5o.get_info(item.id).addr) not in known:
            known.add(place)
            yield from (f"{name}/{x}" for x in _hard(item, h5py, known))


def _is_here(group, name, h5py):
    return isinstance(group.get(name, getlink=True), h5py.HardLink)


def _plain(parent, name, h5py):
    """A dataset of numbers in this very file, or None: no guard stands elsewhere."""
    if not _is_here(parent, name, h5py):
        return None  # it would open another file
    item = parent[name]
    if not isinstance(item, h5py.Dataset) or item.dtype.kind not in "iufcV":
        raise ValueError(f"{name} holds no numbers")
    if item.external or item.is_virtual:
        raise ValueError(f"the numbers of {name} are in another file")
    check_size(*item.shape)
    return item


def _of_datasets(item, parts):
    """A matrix of HDF5, full or sparse, of its datasets."""
    from scipy.sparse import csc_array

    read = {key: [] if x is None else x[()] for key, x in parts.items()}
    if "" in read:
        x = read[""].T if "MATLAB_class" in item.attrs else read[""]
        return x["real"] + 1j * x["imag"] if x.dtype.names else x
    shape = int(item.attrs["MATLAB_sparse"]), len(read["jc"]) - 1
    check_size(*shape, full=False)
    return _sound(csc_array((read["data"], read["ir"], read["jc"]), shape=shape))


def read_op4(path, wanted=list):
    """The matrices, ``wanted``, in a file of Nastran's OUTPUT4 at ``path``."""
    content = read_bytes(path)
    with _decoded(path, "a file of Nastran (OUTPUT4)"):
        found = matrices_of_op4(content, check_size)
    return {name: found[name] for name in wanted(dict.fromkeys(found, ""))}


def read_punch(path, wanted=list):
    """The matrices, ``wanted``, in a punch file of Nastran at ``path``: their entries
    as `read_entries` has them, from DMIG.
    """
    found = matrices_of_punch(read_text(path), path)
    return {name: found[name] for name in wanted(dict.fromkeys(found, ""))}


def _sound(x):
    """A matrix ``x``; of a sparse one no index lies outside, where compiled code would
    read and write.
    """
    if hasattr(x, "check_format"):
        x.check_format(full_check=True)
    if issparse(x):
        once(x.tocoo())
    return x


def once(x):
    """A sparse matrix ``x`` as it is; a ValueError where it has an entry twice, which
    one program adds and another overwrites.
    """
    places = x.row * np.int64(x.shape[1]) + x.col
    order = np.sort(places)
    if (twice := order[1:][order[1:] == order[:-1]]).size:
        row, column = divmod(int(twice[0]), x.shape[1])
        raise ValueError(
            f"the entry in row {row + 1}, column {column + 1} is there twice"
        )
    return x


def _check_bytes(sizes):
    """A ValueError where the matrices of a file take more than `MOST_BYTES` bytes."""
    if (size := sum(sizes)) > MOST_BYTES:
        raise ValueError(f"it unpacks to {size} bytes, more than {MOST_BYTES} bytes")


def check_size(*shape, full=True):
    """A ValueError for a ``shape`` of more than `MOST_ENTRIES`; one that isn't ``full``
    has what the file has, and a number for each row or column.
    """
    if (prod if full else sum)(shape) > MOST_ENTRIES:
        size = " x ".join(map(str, shape))
        raise ValueError(f"it promises a matrix of {size}, too large to read")
