"""Drawings of the book's plants, made of the parts in `sketches`."""

from . import sketches
from .style import INK, SKY, VERMILLION

__all__ = ["cart_pendulum", "hand", "row"]

#: Of a row: from wall to body, from body to body, and a body's width.
GAP, BODY = 1.9, 1.2


def row(
    ax,
    bodies,
    links,
    forces=None,
    disturbances=None,
    weightless=(),
    right_wall=False,
    displacements=True,
):
    """Bodies in a row, joined to a wall and to each other.

    ``ax``: where to draw; ``bodies``: what stands in each body, from the left to the
    right; ``links``: what joins each body to the one before, the first to the wall:
    texts of its spring and of its damper. None stands for no such part. One more link
    joins the last body to a wall on the right; ``forces``, ``disturbances``: texts of
    the arrows that push bodies, numbered from 0; ``weightless``: numbers of the bodies
    without a mass; ``right_wall``: whether the last link ends in a wall;
    ``displacements``: whether to draw the arrows z1, z2, ... of the coordinates. Raises
    ValueError if there isn't a link for each body and for the wall on the right.

    >>> import matplotlib.pyplot as plt
    >>> figure, ax = plt.subplots()
    >>> row(ax, ["m"], [("k", None)], forces={0: "u"})
    >>> [text.get_text() for text in ax.texts if text.get_text()]
    ['k', 'm', '$z_1$', 'u']
    >>> plt.close(figure)
    """
    if len(links) != len(bodies) + right_wall:
        raise ValueError(
            f"links has {len(links)} entries for {len(bodies)} bodies: give one for "
            "each body, and one more for a wall on the right"
        )
    step, left, line = GAP + BODY, 0.5, 1.5
    ends = [left + step * k for k in range(len(links) + 1)]
    sketches.canvas(ax, ends[len(bodies)] + (GAP if right_wall else 0) + 0.8, 3.3)
    sketches.wall(ax, (left, 0.7), (left, 2.3))
    if right_wall:
        end = ends[len(bodies)] + GAP
        sketches.wall(ax, (end, 2.3), (end, 0.7))
    for start, (spring, damper) in zip(ends, links):
        only = (spring is None) != (damper is None)
        if spring is not None:
            y = line if only else line + 0.35
            sketches.spring(ax, (start, y), (start + GAP, y), spring)
        if damper is not None:
            y = line if only else line - 0.45
            sketches.damper(ax, (start, y), (start + GAP, y), damper)
    for k, text in enumerate(bodies):
        x = ends[k] + GAP + BODY / 2
        sketches.mass(ax, (x, line), text, (BODY, 1.5), weightless=k in weightless)
        if displacements:
            sketches.displacement(ax, (x - 0.2, 0.35), (0.6, 0), f"$z_{k + 1}$")
        for arrows, colour, shift in (
            (forces, VERMILLION, 0.0),
            (disturbances, INK, 0.4),
        ):
            if k in (arrows or {}):
                tip = (x + BODY / 2, 2.45 + shift)
                sketches.force(ax, tip, (0.9, 0), arrows[k], colour)


def hand(ax):
    """A planar hand: two fingers hold an object by contacts that give way.

    It is drawn on ax, with the object's displacements z1 and z2, the forces u,
    the disturbances w, and the turning force of an asymmetric stiffness.
    """
    sketches.canvas(ax, 10, 5)
    sketches.wall(ax, (3.2, 0.4), (6.8, 0.4))
    sketches.disc(ax, (5, 3.1), (1.05, 0.75), SKY, 2, 0.55, 81)
    ax.text(5, 3.1, "object", **sketches.CENTRED, zorder=3)
    for side in (-1, 1):
        base, elbow, tip = (
            (5 + 0.9 * side, 0.4),
            (5 + 3.0 * side, 1.4),
            (5 + 2.4 * side, 3.1),
        )
        sketches.rod(ax, base, elbow)
        sketches.rod(ax, elbow, tip)
        sketches.rod(ax, (tip[0], 2.8), (tip[0], 3.4))
        sketches.joint(ax, base)
        sketches.joint(ax, elbow)
        edge = 5 + 1.05 * side
        sketches.spring(ax, (tip[0], 3.35), (edge, 3.25), coils=3, width=0.12)
        sketches.damper(ax, (tip[0], 2.85), (edge, 2.95), width=0.12)
    sketches.displacement(ax, (5.1, 4.15), (0.9, 0), "$z_1$")
    sketches.displacement(ax, (5.0, 4.05), (0, 0.55), "$z_2$")
    sketches.force(ax, (4.3, 2.4), (0.4, 0.8), "$u$")
    sketches.force(ax, (5.7, 2.4), (-0.4, 0.8), "$w$", INK)
    sketches.angle(ax, (5, 3.1), 1.55, (118, 62), "", VERMILLION)


def cart_pendulum(ax):
    """A cart with an inverted pendulum on a track.

    It is drawn on ax, with its position p, the angle theta and the motor's
    force u.
    """
    sketches.canvas(ax, 8, 4.6)
    sketches.wall(ax, (0.8, 0.4), (7.2, 0.4))
    for x in (3.2, 4.4):
        sketches.wheel(ax, (x, 0.63))
    sketches.mass(ax, (3.8, 1.2), "", (2.2, 0.7))
    ax.plot([3.8, 3.8], [1.2, 3.9], color=INK, ls=":", lw=1.0)
    tip = (4.7, 3.6)
    sketches.rod(ax, (3.8, 1.2), tip, 4)
    sketches.joint(ax, (3.8, 1.2))
    sketches.disc(ax, tip, (0.28, 0.28), SKY, 2, 0.55, 81)
    sketches.angle(ax, (3.8, 1.2), 1.7, (90, 70), r"$\theta$")
    sketches.displacement(ax, (5.1, 0.95), (0.9, 0), "$p$")
    sketches.force(ax, (2.7, 1.2), (1.0, 0), "$u$")
