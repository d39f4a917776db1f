"""The machine of part VII: a motor turns a table with a payload on it."""

from ..plants.second_order import SecondOrderSystem

__all__ = ["drive", "table"]


def drive(J, k=10):
    """A motor of 0.01 kg m² turns a table of J kg m².

    The shaft between them has k N m/rad.

    z: the angles of motor and load in rad. u: the motor's torque,
    w: a torque on the load, both in N m.

    >>> drive(0.02).n
    2
    """
    return SecondOrderSystem(
        M=[[0.01, 0], [0, J]],
        D=[[0.03, -0.01], [-0.01, 0.01]],
        S=[[k, -k], [-k, k]],
        B=[[1], [0]],
        F=[[0], [1]],
        coordinates=["motor", "load"],
    )


def table(m, r, k=10):
    """A table of 0.01 kg m² with m kg on it, r m from the axis.

    k: as in drive.

    >>> table(2, 0.1).M[1, 1].round(9)
    np.float64(0.03)
    """
    return drive(0.01 + m * r**2, k)
