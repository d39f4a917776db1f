"""Requests of the package in the words of the page's kernel."""

import numpy as np


def page_request(
    plant,
    U=None,
    region=None,
    gamma=None,
    saturation=None,
    coupling="pairs",
    K_A=None,
    requirements=(),
    **asked,
):
    """Keywords of `design_pid` as the kernel's ``design`` takes them, and more."""
    vertices = [
        {
            name: np.asarray(getattr(v, name)).tolist()
            for name in ("MDSBF" if v.p else "MDSB")
        }
        for v in plant.vertices
    ]
    for name in ("sigma", "theta", "rho"):
        if getattr(region, name, None) is not None:
            asked[name] = getattr(region, name)
    if gamma is not None:
        asked["gamma"] = getattr(gamma, "gamma", gamma)
    if getattr(gamma, "mu", None) is not None:
        asked["mu"] = gamma.mu
    for cost in requirements:
        asked |= {"Q": cost.Q.tolist(), "R": cost.R.tolist(), "noise": cost.noise}
        if cost.bound is not None:
            asked["cost"] = cost.bound
    if saturation is not None:
        asked["x0"] = np.asarray(saturation.x0).tolist()
        if saturation.u_max is not None:
            asked["u_max"] = saturation.u_max
    return {
        "vertices": vertices,
        "U": [] if U is None else np.asarray(U, float).tolist(),
        "K_A": None if K_A is None else np.asarray(K_A, float).tolist(),
        "coupling": coupling,
        "asked": asked,
    }
