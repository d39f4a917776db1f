"""The mobile inverted pendulum: a body on two wheels with one motor each.

theta is the body's angle from upright, phi the wheels' absolute angle,
both in rad; V is the motors' voltage.
"""

from dataclasses import dataclass

import numpy as np

from ..plants.checks import finite, positive
from ..plants.second_order import SecondOrderSystem

__all__ = ["COORDINATES", "R_G", "V_MAX", "Mip", "accelerated"]

COORDINATES = ("theta", "phi")  # z of every pendulum's plant
V_MAX = 7.4  # V, of the battery
R_G = 35.37  # motor turns per wheel turn


@dataclass(frozen=True)
class Mip:
    r"""A mobile inverted pendulum.

    .. math::
        c \ddot\theta + (b \cos\theta - J) \ddot\varphi
        - d \sin\theta &= -e V + f (\dot\varphi - \dot\theta) \\
        (b \cos\theta - J) \ddot\theta + a \ddot\varphi
        - b \sin\theta\, \dot\theta^2
        &= e V - f (\dot\varphi - \dot\theta)

    Parameters
    ----------
    a : float
        r^2 (M_b + 2 M_w) + 2 I_w, in kg m^2.
    b : float
        M_b l r, in kg m^2.
    c : float
        I_b + M_b l^2, in kg m^2.
    d : float
        M_b g l, in N m.
    e : float
        2 R_g t_m / V_max, in N m / V.
    f : float
        2 R_g^2 C_m, in N m s.
    I_w : float, optional
        Inertia of one geared wheel, in kg m^2: the part of a that the
        wheels' experiment measures. `vertices` needs it.
    J : float
        2 R_g^2 I_a, in kg m^2: the rotors turn against the body, not
        against the ground, which couples theta and phi. The thesis
        leaves it out.

    Raises
    ------
    ValueError
        If the mass matrix isn't positive definite at every theta, or a
        number isn't finite.

    Notes
    -----
    Source: thesis (4.12), with the substitutions above it; J is zero.

    Examples
    --------
    >>> mip = Mip.printed()
    >>> [round(1e3 * x, 4) for x in (mip.a, mip.b, mip.c)]
    [0.4747, 0.3482, 0.9641]
    >>> mip.plant().poles().round(2)
    array([-45.88,  -5.86,   0.  ,   8.1 ])
    """

    a: float
    b: float
    c: float
    d: float
    e: float
    f: float
    I_w: float | None = None
    J: float = 0.0

    def __post_init__(self):
        letters = "abcdefJ" if self.I_w is None else [*"abcdefJ", "I_w"]
        for name in letters:
            object.__setattr__(self, name, finite(name, getattr(self, name)))
        positive("a", self.a)
        positive("c", self.c)
        worst = abs(self.b) + abs(self.J)
        positive("a c - (|b| + |J|)^2", self.a * self.c - worst**2)

    @classmethod
    def from_ratios(
        cls, e_c, f_c, d_c, e_a, *, f_a=None,
        M_b=0.272, l=0.040, r=0.032, M_w=0.027, g=9.8, rotors=False,
    ):  # fmt: skip
        """The pendulum with the ratios that two experiments measure.

        Parameters
        ----------
        e_c, f_c, d_c : float
            e/c, f/c, d/c of the body's experiment (4.18).
        e_a : float
            e/a of the wheels' experiment (4.22), where a = 2 I_w.
        f_a : float, optional
            f/a of the same. The thesis measures it and leaves it out.
            Given, e, f and I_w fit the four ratios best, in the least
            squares of their logarithms.
        M_b, l, r, M_w, g : float
            Masses of body and one wheel, distance of their centres,
            radius, gravity; in SI units. The defaults aren't printed;
            with them every printed digit of a to f follows.
        rotors : bool
            Set J to 2 I_w - M_w r^2, which (4.6) says is 2 R_g^2 I_a.

        Raises
        ------
        ValueError
            If a number isn't positive, or the wheels seem lighter than
            discs and ``rotors`` is asked.

        Notes
        -----
        Source: thesis section 4.2. I_b = c - M_b l^2 isn't needed.

        Examples
        --------
        >>> mip = Mip.from_ratios(30.52, 7.133, 110.6, 208.8)
        >>> mip == Mip.printed()
        True
        >>> round(mip.e, 4), round(mip.f, 4)
        (0.0294, 0.0069)
        """
        asked = dict(e_c=e_c, f_c=f_c, d_c=d_c, e_a=e_a)
        for name, value in (asked | dict(M_b=M_b, l=l, r=r, M_w=M_w, g=g)).items():
            positive(name, value)
        b, d = M_b * l * r, M_b * g * l
        c = d / d_c
        e, f = e_c * c, f_c * c
        double = e / e_a
        if f_a is not None:
            part = (e_a / e_c * f_c / positive("f_a", f_a)) ** 0.25
            e, f = e * part, f / part
            double = np.sqrt(e / e_a * f / f_a)
        a = r**2 * (M_b + 2 * M_w) + double
        J = 0.0
        if rotors:
            J = float(double - M_w * r**2)
            if J <= 0:
                raise ValueError(
                    f"2 I_w - M_w r^2 must be positive, got {J:.3g} kg m^2: the wheels "
                    "seem lighter than discs; check M_b, M_w and r, or leave rotors out"
                )
        return cls(a, b, c, d, e, f, I_w=double / 2, J=J)

    @classmethod
    def printed(cls):
        """The pendulum of (4.25), before the spread of 4 percent.

        Source: thesis (4.20), (4.23). The masses and lengths that give
        the printed digits are `from_ratios`'s; the thesis prints others.
        """
        return cls.from_ratios(30.52, 7.133, 110.6, 208.8)

    def plant(self, F=((1,), (1,))):
        """The linear plant about upright, z = [theta; phi], u = V.

        M = [[c, b - J], [b - J, a]] is symmetric and positive definite,
        and the matrices are affine in a to f and J.

        Parameters
        ----------
        F : (2, p) array_like or None
            Disturbance torques, in N m per unit of w. Without it, one
            w acts on both equations of motion.

        Notes
        -----
        Source: thesis (4.12), linearised by (4.14).

        Examples
        --------
        >>> Mip.printed().plant().B.round(4)
        array([[-0.0294],
               [ 0.0294]])
        """
        a, b, c, d, e, f = self._about_upright()
        return SecondOrderSystem(
            M=[[c, b], [b, a]],
            D=[[f, -f], [-f, f]],
            S=[[-d, 0], [0, 0]],
            B=[[-e], [e]],
            F=F,
            coordinates=COORDINATES,
        )

    def printed_form(self, F=((1,), (1,))):
        """The same plant as (4.15) writes it, M = (a c - b^2) I.

        It is `plant` times the adjugate of its M, so it has the same
        poles and the same responses. The thesis reverses B's sign; (4.25)
        and (4.27) print -D and -S.

        Parameters
        ----------
        F : (2, p) array_like or None
            As (4.25) has it: here w / (a c - b^2) is an acceleration
            of both angles.

        Notes
        -----
        Source: thesis (4.15), (4.25).

        Examples
        --------
        >>> Mip.printed().printed_form().D.round(9)
        array([[ 5.659e-06, -5.659e-06],
               [-9.024e-06,  9.024e-06]])
        """
        a, b, c, d, e, f = self._about_upright()
        return SecondOrderSystem(
            M=np.eye(2) * (a * c - b**2),
            D=[[f * (a + b), -f * (a + b)], [-f * (b + c), f * (b + c)]],
            S=[[-a * d, 0], [b * d, 0]],
            B=[[-e * (a + b)], [e * (b + c)]],
            F=F,
            coordinates=COORDINATES,
        )

    def acceleration(self, z, dz, V):
        """z'' of the nonlinear pendulum, in rad/s^2.

        Parameters
        ----------
        z, dz : (2, ...) array_like
            [theta; phi] and rates; further axes are runs side by side.
        V : float or array_like
            Volts; one number, or one for each run.

        Returns
        -------
        (2, ...) array
            [theta''; phi''] in rad/s^2.

        Notes
        -----
        Source: thesis (4.13), with e V cos(theta) once, not twice.

        Examples
        --------
        >>> Mip.printed().acceleration([0.1, 0], [0, 0], V=0).round(2)
        array([ 14.97, -10.92])
        """
        theta, (dtheta, dphi) = np.asarray(z)[0], np.asarray(dz)
        return np.array(
            accelerated(self, np.sin(theta), np.cos(theta), dtheta, dphi, V)
        )

    def energy(self, z, dz):
        """Kinetic plus potential energy, in J; zero at rest, theta = 90°.

        Parameters
        ----------
        z, dz : (2, ...) array_like
            As for `acceleration`.

        Notes
        -----
        Source: thesis (4.7) and (4.8), mended.

        Examples
        --------
        >>> round(float(Mip.printed().energy([0, 0], [0, 0])), 4)
        0.1066
        """
        theta, (dtheta, dphi) = np.asarray(z)[0], np.asarray(dz)
        cos = np.cos(theta)
        return (
            self.c * dtheta**2 / 2
            + self.a * dphi**2 / 2
            + (self.b * cos - self.J) * dtheta * dphi
            + self.d * cos
        )

    def _about_upright(self):
        """a to f of the linear plant, where J and b are one."""
        return self.a, self.b - self.J, self.c, self.d, self.e, self.f


def accelerated(mip, sin, cos, dtheta, dphi, V, torques=(0.0, 0.0)):
    """theta'' and phi'' of the nonlinear pendulum, of numbers or of arrays.

    ``mip``: the pendulum; or an object with arrays a to f and J, of many; ``sin``,
    ``cos``: those of theta; ``dtheta``, ``dphi``: the rates, in rad/s; ``V``: volts;
    ``torques``, (float, float): what acts besides on the equations of theta and phi, in
    N m.
    """
    both = mip.b * cos - mip.J
    torque = mip.e * V - mip.f * (dphi - dtheta)
    body = mip.d * sin - torque + torques[0]
    wheels = mip.b * sin * (dtheta * dtheta) + torque + torques[1]
    size = mip.a * mip.c - both * both
    return (mip.a * body - both * wheels) / size, (mip.c * wheels - both * body) / size
