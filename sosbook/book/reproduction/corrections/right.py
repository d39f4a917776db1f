"""What was checked and found right."""

from dataclasses import dataclass

__all__ = ["CHECKED", "Checked"]


@dataclass(frozen=True)
class Checked:
    """A part of the text that stands.

    Parameters
    ----------
    place, what : str
        Where it stands in the thesis, and what was checked.
    how : str
        How the book checks it.
    chapter : str
        File of the chapter that does.
    """

    place: str
    what: str
    how: str
    chapter: str


#: Formulas of the thesis that were checked and found right.
CHECKED = tuple(
    Checked(*entry)
    for entry in (
        (
            "(2.6), (2.11)",
            "the PIDA law, the descriptor form without integrator",
            "inserted into (2.1); all printed poles follow",
            "02_descriptor_form",
        ),
        (
            "(2.12)",
            "Lemma 2.1, also at the vertices of a polytope",
            "proven, and checked for random plants",
            "08_singular_mass",
        ),
        (
            "(2.15), (2.17)",
            "Theorem 2.1's inequality and its proof",
            "code and formula compared for random matrices; certificates in "
            "exact arithmetic",
            "05_hinf",
        ),
        (
            "(2.18)-(2.20)",
            "half-plane, disk and sector of Theorem 2.2",
            "the same",
            "04_lmi_regions",
        ),
        ("(2.21)", "both inequalities of Lemma 2.2", "the same", "06_saturation"),
        (
            "(2.22), (2.23), (A.18), (A.19)",
            "the functional is positive",
            "derived again from the integrals",
            "20_delay_theorem",
        ),
        (
            "(2.31), (2.35), (2.36), (2.38)",
            "Theorem 2.4 for one plant",
            "its gain is the Riccati equation's",
            "23_lqr",
        ),
        (
            "(2.39), (2.40), (2.44), (2.45)",
            "observer, joint loop, and "
            "Theorem 2.5 at each vertex (the proof of (2.44) apart)",
            "L of Table 4.3 follows to its digits",
            "24_observer",
        ),
        (
            "(4.8), (4.10)-(4.12), (4.14)",
            "equations of motion, and their linear form",
            "derived again with SymPy",
            "25_pendulum_model",
        ),
        (
            "(4.16)-(4.18), (4.20)-(4.22)",
            "the models of both experiments",
            "derived again; (4.20) from (4.19) by equal peaks",
            "26_identification",
        ),
        (
            "(4.29), (4.30)",
            "the reduced controller and its hold at 100 Hz",
            "coefficients compared, within what the rounding of (4.28) allows",
            "27_pendulum_control",
        ),
        (
            "(A.7)-(A.14), (A.17)",
            "LMI regions and their criterion",
            "derived again; poles and LMIs compared for random matrices",
            "04_lmi_regions",
        ),
        (
            "Tables 3.1, 3.2, 3.3",
            "all poles, open and closed loop",
            "computed from the printed matrices and gains",
            "07_grasping_robot",
        ),
        (
            "Examples 1 to 4",
            "the printed gains keep all that was asked",
            "one certificate each, for the whole polytope, in exact arithmetic",
            "11_car_seat",
        ),
        (
            "Example 2 with delay",
            "the printed gains keep the rate 0.1",
            "Theorem A.3 with its errata, in exact arithmetic",
            "21_delay_examples",
        ),
        (
            "Tables 4.1, 4.2, 4.3",
            "all gains stabilise every plant of (4.25)",
            "proven in exact arithmetic",
            "27_pendulum_control",
        ),
    )
)
