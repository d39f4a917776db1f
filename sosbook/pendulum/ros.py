"""A node of ROS 2 that drives a robot which balances and steers."""

from .boards import wired
from .c_code import provenance
from .template import fill

__all__ = ["ros_node"]


def ros_node(firmware, robot=None, name="balance"):
    """A Python script that passes cmd_vel on to rc_<name>.

    Parameters
    ----------
    firmware : Firmware
        What balances; its note stands on top.
    robot : Robot, optional
        Its wheels' radius; the thesis's robot without it.
    name : str
        The program is rc_<name>, and the script ros_<name>.py.

    Returns
    -------
    str
        The text of the script. It takes part in no tick: ROS keeps no clock.

    Raises
    ------
    ValueError
        If the robot has another board.

    Examples
    --------
    >>> from sosbook.pendulum import PD_SIGNALS, Firmware, Gain, SampledLaw
    >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
    >>> law = SampledLaw.of_gain(gain, 0.01)
    >>> code = compile(ros_node(Firmware(law)), "ros_balance.py", "exec")
    """
    values = {"NODE": f'"{name}"', "RADIUS": wired(robot).r}
    return fill("ros_balance.py", provenance(firmware), values, name)
