"""What tables, sliders, maps and messages call the requirements."""

__all__ = ["BLOCKS", "HARDER_UP", "LABELS", "SYMBOLS", "UNITS"]

HARDER_UP = {"sigma": True, "theta": False, "rho": False, "gamma": False,
             "u_max": False}
LABELS = {"sigma": "Decay rate σ", "theta": "Half-angle θ",
          "rho": "Disk radius ρ", "gamma": "H∞ bound γ",
          "u_max": "Input bound u_max"}
SYMBOLS = {"sigma": "σ", "theta": "θ", "rho": "ρ", "gamma": "γ",
           "u_max": "u_max"}
UNITS = {"sigma": " 1/s", "theta": "°", "rho": " 1/s"}
BLOCKS = {"P": "P > 0", "half-plane": "half-plane σ", "sector": "sector θ",
          "disk": "disk ρ", "hinf": "H∞ bound γ", "x0": "x(0) in the ellipsoid",
          "u_max": "input bound u_max", "stability": "stability",
          "scale": "scale"}
