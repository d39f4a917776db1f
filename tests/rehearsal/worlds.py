"""The worlds of a rehearsal: which roundings this machine can produce.

``noise-1``, ``noise-2``, ...  numpy's and scipy's results with seeded noise
``Haswell``, ``Prescott``, ... OpenBLAS's kernels for other processors
``no-avx512``, ``no-simd``     numpy without its wider vector instructions
"""

import json
import os
import subprocess
import sys
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

KINDS = ("noise", "kernels", "simd")
X86 = "Prescott", "Core2", "Nehalem", "Sandybridge", "Haswell", "Zen"
CORES = (*X86, "SkylakeX", "Cooperlake", "Sapphirerapids")
CORES += ("ARMV8", "NEOVERSEN1", "NEOVERSEV1")
PROBE = """
import json, numpy, scipy.linalg, threadpoolctl
A = numpy.random.default_rng(1).normal(size=(70, 70))
scipy.linalg.svd(A @ A), numpy.linalg.eigvals(A), numpy.linalg.cholesky(A @ A.T)
numpy.exp(A), numpy.sin(A), scipy.linalg.schur(A)
from numpy._core import _multiarray_umath as core
print(json.dumps([
    sorted({str(pool.get("architecture")) for pool in threadpoolctl.threadpool_info()
            if pool["user_api"] == "blas"}),
    [name for name in core.__cpu_dispatch__ if core.__cpu_features__[name]]]))
"""


@dataclass(frozen=True)
class World:
    """A name and the environment variables that make it."""

    name: str
    kind: str
    variables: dict = field(hash=False)

    def environment(self):
        """Variables of a process that lives in this world."""
        extra = dict(self.variables)
        if path := os.environ.get("PYTHONPATH") if "PYTHONPATH" in extra else None:
            extra["PYTHONPATH"] += os.pathsep + path
        return os.environ | extra


@cache
def probe(world):
    """BLAS kernels and SIMD features in use there; None if it can't run.

    A machine doesn't change: each world is asked once.
    """
    done = subprocess.run(
        [sys.executable, "-c", PROBE],
        env=world.environment(),
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    return json.loads(done.stdout) if done.returncode == 0 else None


def noise(seeds=(1, 2, 3)):
    """One world for a seed."""
    return [
        World(
            f"noise-{seed}",
            "noise",
            {
                "PYTHONPATH": str(Path(__file__).parent),
                "SOSBOOK_REHEARSAL_NOISE": str(seed),
            },
        )
        for seed in seeds
    ]


def kernels():
    """One world for each kernel that runs here, but for the usual one."""
    seen = [probe(World("usual", "usual", {}))[0]]
    found = []
    for core in CORES:
        world = World(core, "kernels", {"OPENBLAS_CORETYPE": core})
        answer = probe(world)
        if answer and answer[0] not in seen:
            seen.append(answer[0])
            found.append(world)
    return found


def simd():
    """numpy without AVX-512, and without anything above its baseline."""
    features = probe(World("usual", "usual", {}))[1]
    wide = [name for name in features if name.startswith(("AVX512", "X86_V4"))]
    choices = {"no-avx512": wide, "no-simd": features}
    found = []
    for name, names in choices.items():
        world = World(name, "simd", {"NPY_DISABLE_CPU_FEATURES": " ".join(names)})
        answer = names and probe(world)
        if answer and not set(names) & set(answer[1]):
            found.append(world)
    return found


def choose(names=(), seeds=(1, 2, 3)):
    """The worlds of these names or kinds, or all; KeyError for other names."""
    known = noise(seeds)
    if not names or set(names) - {"noise", *(world.name for world in known)}:
        known += [*kernels(), *simd()]
    chosen = [w for w in known if not names or {w.name, w.kind} & set(names)]
    if unknown := set(names) - {*KINDS, *(world.name for world in chosen)}:
        raise KeyError(
            f"no {', '.join(sorted(unknown))} on this machine, only "
            + ", ".join(world.name for world in known)
        )
    return chosen
