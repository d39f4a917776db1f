"""Matrices of NumPy, MATLAB, Matrix Market, Abaqus, Nastran, within limits.

Nothing in a file is ever executed.
"""

import struct
import zipfile
import zlib
from contextlib import contextmanager
from io import BytesIO
from math import prod

import numpy as np

from .libraries import library
from .op4 import matrices_of_op4
from .reading import MOST_BYTES, number, read_bytes, read_text

MOST_ENTRIES = 20_000_000  # of a matrix in a file; of a full one its zeros, too
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


def read_csv(path):
    """The matrix in the text file at ``path`` of `load_plant`; errors name a line."""
    rows = []
    for place, line in enumerate(read_text(path, bom=True).splitlines(), 1):
        line = line.partition("#")[0].strip()
        if not line:
            continue
        between = next((x for x in ";," if x in line), None)
        try:
            rows.append([number(word.strip()) for word in line.split(between)])
        except ValueError as error:
            raise ValueError(
                f"{path}, line {place}: {error}, and no headings"
            ) from None
        if len(rows[-1]) != len(rows[0]):
            raise ValueError(
                f"{path}, line {place}: {len(rows[-1])} numbers, "
                f"the first line has {len(rows[0])}"
            )
    if not rows:
        raise ValueError(f"{path}: there are no numbers")
    return np.array(rows)


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
        raise ValueError(f"its version is {version}")
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


def read_npz(path):
    """The arrays in an archive of NumPy at ``path``, a dict; see `read_npy`."""
    content = read_bytes(path)
    with _decoded(path, "an archive of NumPy"):
        archive = zipfile.ZipFile(BytesIO(content))
        size = sum(part.file_size for part in archive.infolist())
        if size > MOST_BYTES:
            raise ValueError(f"it unpacks to {size} bytes, more than {MOST_BYTES}")
        arrays = {}
        for part in archive.infolist():
            name = part.filename.removesuffix(".npy")
            if name in arrays:
                raise ValueError(f"{name!r:.80} is there twice")
            arrays[name] = _array(archive.read(part))
        return arrays


def read_sparse(path):
    """The matrix in a file of scipy.sparse.save_npz at ``path``; see `read_npz`."""
    from scipy.sparse import load_npz

    arrays = read_npz(path)
    with _decoded(path, "a sparse matrix of scipy.sparse.save_npz"):
        if not {"format", "shape"} <= arrays.keys():
            raise ValueError(f"it holds {', '.join(arrays) or 'nothing'}")
        check_size(*arrays["shape"].tolist(), full=False)
        return load_npz(BytesIO(read_bytes(path)))


def read_mtx(path):
    """The matrix in a Matrix Market file at ``path``, dense or sparse."""
    from scipy.io import mminfo, mmread

    content = read_bytes(path)
    with _decoded(path, "a matrix of Matrix Market"):
        rows, columns, _, form, field, _ = mminfo(BytesIO(content))
        check_size(rows, columns, full=form == "array")
        if field == "pattern":
            raise ValueError("it has a pattern and no numbers")
        return mmread(BytesIO(content))


def read_entries(path):
    """The entries in a matrix file of Abaqus or CalculiX at ``path``: from ((node,
    dof), (node, dof)) to the value, of both triangles, where the file holds one; None
    of a Matrix Market file. A ValueError has the line that isn't "node, dof, node, dof,
    value".
    """
    entries = {}
    for place, line in enumerate(read_text(path).splitlines(), 1):
        if line.startswith("%%MatrixMarket"):
            return None
        words = [word.strip() for word in line.split(",")]
        if line.startswith("*") or words == [""]:  # keywords, comments
            continue
        where = f"{path}, line {place}"
        if len(words) != 5 or not all(w.isascii() and w.isdigit() for w in words[:4]):
            raise ValueError(
                f"{where}: {line!r:.60} is neither 'node, dof, node, dof, value' of "
                "Abaqus nor has the file Matrix Market's first line, %%MatrixMarket"
            )
        row, column = tuple(map(int, words[:2])), tuple(map(int, words[2:4]))
        if (row, column) in entries:
            raise ValueError(f"{where}: the entry {line!r:.60} is there twice")
        try:
            entries[row, column] = number(words[4])
        except ValueError as error:
            raise ValueError(f"{where}: {error}") from None
    if not any((j, i) in entries for i, j in entries if i != j):
        entries |= {(j, i): value for (i, j), value in entries.items()}
    return entries


def read_mat(path):
    """The arrays in a file of MATLAB at ``path``, a dict; also of HDF5, by h5py."""
    from scipy.io import loadmat, whosmat

    content = read_bytes(path)
    if HDF5 in (content[:8], content[512:520]):
        with _decoded(path, "a file of MATLAB 7.3 or HDF5 (or save with '-v7')"):
            return _hdf5(content)
    with _decoded(path, "a file of MATLAB (save with the option '-v7')"):
        for _, shape, kind in whosmat(BytesIO(content)):
            check_size(*shape, full=kind != "sparse")
        _check_unpacked(content)
        found = loadmat(BytesIO(content))
        return {k: x for k, x in found.items() if not k.startswith("__")}


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


def _hdf5(content):
    """The matrices in bytes of HDF5; those of MATLAB are transposed there."""
    from scipy.sparse import csc_array

    h5py, arrays = library("h5py"), {}
    with h5py.File(BytesIO(content), "r") as file:
        for name in file:
            if not isinstance(file.get(name, getlink=True), h5py.HardLink):
                continue  # it would open another file
            item = file[name]
            matlab = "MATLAB_class" in item.attrs
            if isinstance(item, h5py.Dataset):
                if item.external or item.is_virtual:
                    raise ValueError(f"the numbers of {name} are in another file")
                check_size(*item.shape)
                arrays[name] = item[()].T if matlab else item[()]
            elif "MATLAB_sparse" in item.attrs:
                shape = int(item.attrs["MATLAB_sparse"]), len(item["jc"]) - 1
                check_size(*shape, full=False)
                check_size(len(item["data"]) if "data" in item else 0)
                parts = [item[x][()] if x in item else [] for x in ("data", "ir", "jc")]
                arrays[name] = csc_array(tuple(parts), shape=shape)
    return arrays


def read_op4(path):
    """The matrices in a file of Nastran's OUTPUT4 at ``path``, a dict."""
    content = read_bytes(path)
    with _decoded(path, "a file of Nastran (OUTPUT4)"):
        return matrices_of_op4(content, check_size)


def check_size(*shape, full=True):
    """A ValueError for a ``shape`` of more than `MOST_ENTRIES`; one that isn't ``full``
    has what the file has, and a number for each row or column.
    """
    if (prod if full else sum)(shape) > MOST_ENTRIES:
        size = " x ".join(map(str, shape))
        raise ValueError(f"it promises a matrix of {size}, too large to read")
