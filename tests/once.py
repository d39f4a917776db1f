"""What takes long and several files of tests ask for: made by one worker of a run."""

import os
import pickle
from hashlib import sha256

#: The folder of a run, which all of its workers have; None where nothing is kept.
FOLDER = None


def once(name, make):
    """What ``make()`` returns; the other workers of a run read what one has made."""
    if FOLDER is None:
        return make()
    path = FOLDER / f"{sha256(name.encode()).hexdigest()[:20]}.pickle"
    if path.exists():
        return pickle.loads(path.read_bytes())
    made, part = make(), path.with_suffix(f".{os.getpid()}")
    part.write_bytes(pickle.dumps(made))
    part.replace(path)
    return made
