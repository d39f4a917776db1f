"""Files are written here: as a whole or not at all, and over nothing foreign."""

import os
import stat
from secrets import token_hex

from .reading import path_of, read_bytes


def write_file(path, content, over=None):
    """Write a ``content`` (text in UTF-8) so that at any time the old file or the new
    one is at ``path``, which is returned; a device, such as /dev/stdout, is written to.

    ``over``: from the bytes of a file that is there to whether it may be replaced; any
    may without it. FileExistsError where it may not, OSError where there is no room,
    for example: then a file that was there is still there, whole.
    """
    path = path_of(path)
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder: give the name of a file in it")
    may_replace(path, over)
    content = content.encode() if isinstance(content, str) else content
    if path.exists() and not path.is_file():
        path.write_bytes(content)
        return path
    _replace(path.resolve(), content, path)  # a link stays a link
    return path


def may_replace(path, over, cure="give another name, or move it away"):
    """A FileExistsError, with the ``cure``, if ``over`` keeps the file at ``path``."""
    path = path_of(path)
    if over is not None and path.is_file() and not over(read_bytes(path)):
        raise FileExistsError(
            f"{path} is there already and holds something else: {cure}"
        )


def write_texts(folder, texts, replace=False):
    """Write ``texts`` by file name into a ``folder``, which is made: all of them, or
    none.

    A file with another text that is there raises FileExistsError, for a
    ``robot_io.cpp`` may hold its owner's pins, unless ``replace``. Returns the paths.
    """
    files = {path_of(folder) / name: text.encode() for name, text in texts.items()}
    for path, text in files.items():
        if not replace:
            may_replace(
                path,
                lambda old, text=text: old == text,
                "give another folder, or --replace (replace=True)",
            )
    for path in files:
        path.parent.mkdir(parents=True, exist_ok=True)
    return [write_file(path, text) for path, text in files.items()]


def _replace(file, content, path):
    """Write a file beside the final one, and put it in its place."""
    beside = file.with_name(f".{token_hex(8)}.part")
    try:
        try:
            with open(beside, "xb") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
            if file.exists():
                beside.chmod(stat.S_IMODE(file.stat().st_mode))
            os.replace(beside, file)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:  # it speaks of the file beside
        raise type(error)(error.errno, error.strerror, str(path)) from None
