"""Files that are broken, foreign or hostile: no reader may take one of them."""

import io
import json
import pickle
import zipfile

import numpy as np
import scipy.io

ESC = "\x1b[2J"
GOOD_PLANT = {name: [[1.0]] for name in "MDSB"}
VALUE = '{"plant": {"M": [[%s]], "D": [[1]], "S": [[1]], "B": [[1]]}}'


class Evil:
    """What a pickle would make of it if anybody opened it."""

    def __reduce__(self):
        return (exec, ("raise SystemExit('a program of the file ran')",))


def npy(array):
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


def promising(*shape):
    """The head of an array that isn't there."""
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"
    text = text.ljust(117) + "\n"
    head = b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little")
    return head + text.encode() + b"\0" * 800


def archive(**parts):
    stream = io.BytesIO()
    # the fastest compression: one holds 300 MB of zeros
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file:
        for name, content in parts.items():
            file.writestr(f"{name}.npy", content)
    return stream.getvalue()


def matlab(**arrays):
    stream = io.BytesIO()
    scipy.io.savemat(stream, arrays)
    return stream.getvalue()


MTX = "%%%%MatrixMarket matrix %s\n%s\n"
ONES = {name: npy(np.eye(1)) for name in "DSB"}

#: From what is wrong to the bytes of the file.
BROKEN = {
    "nothing": b"",
    "zeros": b"\0" * 1000,
    "bytes": bytes(range(128, 256)),
    "UTF-16": '{"M": [[1]]}'.encode("utf-16"),
    "a word": b"mass",
    "a brace": b"{",
    "a list": b"[]",
    "null": b"null",
    "a control character": f'{{"{ESC}": 1}}'.encode(),
    "an escaped one": json.dumps({ESC: 1}).encode(),
    "a key twice": (VALUE % '1]], "M": [[2').encode(),
    "1e400": (VALUE % "1e400").encode(),
    "1e-400": (VALUE % "1e-400").encode(),
    "400 digits": (VALUE % ("7" + "0" * 400)).encode(),
    "20000 digits": (VALUE % ("7" * 20000)).encode(),
    "NaN": (VALUE % "NaN").encode(),
    "Infinity": (VALUE % "-Infinity").encode(),
    "true for a number": b'{"M": [[true, 0], [0, 1]], "D": [[1, 0], [0, 1]], '
    b'"S": [[1, 0], [0, 1]], "B": [[1], [1]]}',
    "1_0": b"t,V\n0,1_0\n1,1\n2,1\n",
    "digits of Arabic": "t,V\n0,١\n1,1\n2,1\n".encode(),
    "too large": b"t,V\n0,1e400\n1,1\n2,1\n",
    "too small": b"t,V\n0,1e-400\n1,1\n2,1\n",
    "a long field": b"t,V\n0," + b"1" * 200_000 + b"\n",
    "an open quotation": b't,V\n"0,1\n' + b"1,2\n" * 50_000,
    "zero between": b"t,V\n0,1\0\n1,1\n2,1\n",
    "lists in lists": b"[" * 100_000 + b"]" * 100_000,
    "300 lists": b'{"M": ' + b"[" * 300 + b"1" + b"]" * 300 + b"}",
    "objects in objects": b'{"a": ' * 50_000 + b"1" + b"}" * 50_000,
    "lists of TOML": b"a = " + b"[" * 50_000 + b"]" * 50_000,
    "400 digits in TOML": b'name = "x"\nlimit = 7' + b"0" * 400,
    "5000 digits in TOML": b'name = "x"\nlimit = 7' + b"0" * 5000,
    "1e400 in TOML": b'name = "x"\nlimit = 1e400',
    "a control character in TOML": b'"\\u001b[2J" = 1\n',
    "a date": b"limit = 1979-05-27\n",
    "a pickle": pickle.dumps(Evil()),
    "the head of an archive": b"PK\x03\x04junk",
    "an archive of nothing": archive(),
    "an archive that was cut": archive(M=npy(np.eye(1)), **ONES)[:-30],
    "an archive of objects": archive(M=npy(np.array([[Evil()]])), **ONES),
    "an archive of a pickle": archive(M=pickle.dumps(Evil()), **ONES),
    "an archive that promises": archive(M=promising(30_000, 30_000), **ONES),
    "an archive that unpacks": archive(M=b"\0" * 300_000_000),
    "an array of objects": npy(np.array([[Evil()]])),
    "an array of names": npy(np.zeros(1, dtype=[("a", float)])),
    "an array that promises": promising(30_000, 30_000),
    "an array of less than nothing": promising(-10, -10),
    "MATLAB without matrices": matlab(x=np.eye(2)),
    "MATLAB's text": matlab(**dict.fromkeys("MDSB", "mass")),
    "MATLAB's cells": matlab(**dict.fromkeys("MDSB", np.array(["x"], dtype=object))),
    "MATLAB's complex numbers": matlab(**dict.fromkeys("MDSB", 1j * np.eye(2))),
    "MATLAB, cut": matlab(**dict.fromkeys("MDSB", np.eye(20)))[:1000],
    "MATLAB's head": b"MATLAB 5.0 MAT-file" + b"\0" * 200,
    "MATLAB 7.3": b"\x89HDF\r\n\x1a\n" + b"\0" * 500,
    "too large a matrix": (
        MTX % ("coordinate real general", "2000000000 2000000000 1\n1 1 1")
    ).encode(),
    "less than no rows": (MTX % ("coordinate real general", "-2 2 1\n1 1 1")).encode(),
    "a pattern": (MTX % ("coordinate pattern general", "1 1 1\n1 1")).encode(),
    "complex numbers": (MTX % ("array complex general", "1 1\n1 1")).encode(),
    "too few numbers": (MTX % ("array real general", "2 2\n1\n2")).encode(),
}
